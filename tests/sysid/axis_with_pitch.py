"""A velocity-drive experiment with two records of a long motion, over many pitches of a periodic effect."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.experiments import write_rig

NOISE = 0.02
ROWS = 4000


def write(folder: Path, force: Callable[[np.ndarray, np.ndarray], np.ndarray], *effects: str) -> Path:
    """Write an experiment whose friction force is `force(position, velocity)`, SI units, plus white noise.

    Args:
        folder: of the experiment.
        force: of position (n,) and velocity (n,).
        effects: of the model; Coulomb and viscous friction where none is given.
    """
    rng = np.random.default_rng(5)
    t, records = 2e-3 * np.arange(ROWS), {}
    for name, rates in (("fit", (0.7, 2.3)), ("validate", (0.5, 3.1))):
        slow, fast = 2 * np.pi * rates[0], 2 * np.pi * rates[1]
        x = 8e-3 * np.sin(slow * t) + 1e-3 * np.sin(fast * t + 0.4)
        v = 8e-3 * slow * np.cos(slow * t) + 1e-3 * fast * np.cos(fast * t + 0.4)
        noisy = force(x, v) + NOISE * rng.normal(size=ROWS)
        records[name] = {"time": t, "position": x, "velocity": v, "friction_force": noisy}
    effects = effects or ("coulomb", "viscous")
    return write_rig(folder, "velocity-drive", records, effects, noise={"friction_force": NOISE})


def uneven(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Friction that depends periodically on the position, and a cable: each alone is a poor explanation."""
    return (1.5 + 0.6 * np.sin(2 * np.pi * x / 6e-3 + 0.3)) * np.sign(v) + 4.0 * v + 90.0 * (x + 1e-3)


def with_cogging(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Coulomb friction, a drag and a periodic force."""
    return 1.5 * np.sign(v) + 9.0 * v + 0.3 * np.sin(2 * np.pi * x / 6e-3 + 0.3)
