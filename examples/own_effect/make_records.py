"""Make fit.csv and validate.csv of this folder again: python make_records.py [FOLDER]."""

import sys
from pathlib import Path

import numpy as np

STEP, ROWS, NOISE = 0.01, 2500, 0.02
COULOMB, VISCOUS, STRENGTH = 1.2, 6.0, 3.5e4


def record(seed: int) -> str:
    """One record as CSV text: a band-limited random motion within +-45 mm, and the force it takes."""
    rng = np.random.default_rng(seed)
    time = STEP * np.arange(ROWS)
    # Eight incommensurate sines of random phase, slow enough that 100 Hz resolves every reversal.
    speeds = 2.0 * np.pi * rng.uniform(0.05, 0.6, 8)
    phases = rng.uniform(0.0, 2.0 * np.pi, 8)
    angles = np.outer(time, speeds) + phases
    position, velocity = np.sin(angles).sum(axis=1), (speeds * np.cos(angles)).sum(axis=1)
    scale = 0.045 / np.max(np.abs(position))
    position, velocity = scale * position, scale * velocity
    force = COULOMB * np.sign(velocity) + VISCOUS * velocity + STRENGTH * position**3
    force += NOISE * rng.standard_normal(ROWS)
    rows = [f"{t:.2f},{1e3 * x:.4f},{1e3 * v:.4f},{f:.4f}" for t, x, v, f in zip(time, position, velocity, force)]
    return "\n".join(["time [s],position [mm],velocity [mm/s],friction_force [N]", *rows]) + "\n"


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    for name, seed in (("fit.csv", 1), ("validate.csv", 2)):
        (folder / name).write_text(record(seed), encoding="utf-8")
