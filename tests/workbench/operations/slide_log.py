"""The log of a slide with a Stribeck curve, written without the library."""

from typing import Any

import numpy as np

NOISE = 0.02


def slide_log(seed: int, rows: int = 1000, extra: Any = None) -> dict[str, np.ndarray]:
    """Friction force 4 + 2 exp(-(v/vs)^2) N in the direction of motion, and 8 N*s/m: written without the library."""
    t = np.arange(rows) * 0.005
    phase = 2.0 * np.pi * 0.4 * t + 0.3 * seed
    x = 0.03 * np.sin(phase) + 0.004 * np.sin(7.3 * phase)
    v = 0.03 * 2.0 * np.pi * 0.4 * np.cos(phase) + 0.004 * 7.3 * 2.0 * np.pi * 0.4 * np.cos(7.3 * phase)
    force = (4.0 + 2.0 * np.exp(-((v / 0.02) ** 2))) * np.sign(v) + 8.0 * v
    if extra is not None:
        force = force + extra(x, v)
    force = force + NOISE * np.random.default_rng(seed).standard_normal(rows)
    return {"time [s]": t, "position [mm]": 1e3 * x, "velocity [mm/s]": 1e3 * v, "friction_force [N]": force}
