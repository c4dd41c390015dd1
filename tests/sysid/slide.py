"""A slide driven back and forth for a few seconds, its friction force made up by the test: the smallest experiment."""

from pathlib import Path
from typing import Any

import numpy as np

from sysid.prediction.problem import Problem, load_problem
from tests.experiments import write_rig

NOISE = 0.01
STEP = 1e-3
TIME = np.arange(2500) * STEP
VELOCITY = 0.02 * np.sin(2 * np.pi * TIME) + 0.01 * np.sin(2 * np.pi * 3.1 * TIME)
POSITION = np.cumsum(VELOCITY) * STEP
SIGN = np.sign(VELOCITY)


def slipping_spring(position: np.ndarray, stretch: float, begin: float) -> np.ndarray:
    """Part (n,) of its level that a spring, which slips at `stretch`, m, has along a motion (n,) from `begin`."""
    z, out = begin * stretch, np.empty(position.size)
    for k, dx in enumerate(np.diff(position, prepend=position[0])):
        z = float(np.clip(z + dx, -stretch, stretch))
        out[k] = z / stretch
    return out


def slide(
    folder: Path,
    force: np.ndarray,
    *effects: str,
    parameters: dict[str, Any] | None = None,
    held_out: bool = False,
    noise: np.ndarray | float = NOISE,
    extra: dict[str, np.ndarray] | None = None,
) -> Problem:
    """Write the experiment into `folder` and load it.

    Args:
        folder: made where it is missing.
        force: friction force without noise, N, (n,).
        effects: of the model.
        parameters: `[model.parameters]`.
        held_out: write the same motion with other noise as a held-out record; else the end of the record is held out.
        noise: standard deviation of the noise put on the force, N, (n,) or one number; `NOISE` is what the file says.
        extra: further columns by header, or others in place of `TIME`, `POSITION` and `VELOCITY`.
    """
    rng = np.random.default_rng(3)
    records = {}
    for name in ["fit", "validate"] if held_out else ["fit"]:
        columns = {"time": TIME, "position": POSITION, "velocity": VELOCITY, **(extra or {})}
        records[name] = columns | {"friction_force": force + noise * rng.standard_normal(force.size)}
    stated = {"friction_force": NOISE}
    return load_problem(write_rig(folder, "velocity-drive", records, effects, noise=stated, parameters=parameters))
