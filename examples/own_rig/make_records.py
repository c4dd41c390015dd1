"""Make fit.csv and validate.csv of this folder again: python make_records.py [FOLDER]."""

import sys
from pathlib import Path

import numpy as np

STEP, ROWS = 0.002, 2000
FORCE_CONSTANT, STIFFNESS, MASS = 8.0, 300.0, 0.5
COULOMB, VISCOUS = 0.4, 3.0
NOISE_POSITION, NOISE_CURRENT = 2e-7, 2e-3


def record(seed: int) -> str:
    """One record as a spreadsheet writes it in German: semicolons, decimal commas, units in the second row."""
    rng = np.random.default_rng(seed)
    time = STEP * np.arange(ROWS)
    speeds, phases = 2.0 * np.pi * rng.uniform(0.3, 2.5, 4), rng.uniform(0.0, 2.0 * np.pi, 4)
    angles = np.outer(time, speeds) + phases
    position, velocity = 1e-3 * np.sin(angles).sum(axis=1), 1e-3 * (speeds * np.cos(angles)).sum(axis=1)
    acceleration = -1e-3 * (speeds**2 * np.sin(angles)).sum(axis=1)
    friction = COULOMB * np.sign(velocity) + VISCOUS * velocity
    current = (MASS * acceleration + friction + STIFFNESS * position) / FORCE_CONSTANT
    position = position + NOISE_POSITION * rng.standard_normal(ROWS)
    current = current + NOISE_CURRENT * rng.standard_normal(ROWS)
    rows = [f"{t:.3f};{1e3 * x:.5f};{1e3 * i:.2f}".replace(".", ",") for t, x, i in zip(time, position, current)]
    return "\n".join(["time;position;i", "s;mm;mA", *rows]) + "\n"


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    for name, seed in (("fit.csv", 1), ("validate.csv", 2)):
        (folder / name).write_text(record(seed), encoding="utf-8")
