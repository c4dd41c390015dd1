"""Residual and exact Jacobian in all parameters of a logged stick-slip record, beside finite differences through LSODA.

    python -m benchmarks.sensitivities

The record: 200 000 rows at 10 kHz of a mass on a spring whose other end was pulled at an uneven speed, as an encoder
logged it: linear between rows. Ours is one pass, `sim.sensitivity`. The peer solves the same equations in compiled code
by scipy's LSODA, once for the residual and once for each parameter, moved by a millionth. It is told the corners of the
input by a longest step of one row, without which it steps over them, and is given the loosest tolerance that keeps the
position within 1e-6 m. Its one solution is timed, and counted as often as it would be needed. Processor time.
"""

from __future__ import annotations

import math
import statistics
import time

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from sim import compose, drive, simulate
from sim.sensitivity import sensitivity

ROWS = 200_000
STEP = 1e-4
ACCURACY = 1e-6
TIME = STEP * np.arange(ROWS + 1)
STIFFNESS = 2.0
NAMES = (
    *("lugre.force", "lugre.stiffness", "lugre.damping", "stribeck.force", "stribeck.velocity"),
    *("viscous.coefficient", "mass", "pull_stiffness"),
)


def pulled() -> np.ndarray:
    """The pulled end, m: 0.1 m/s with a slow wander and the jitter of a drive, shape (rows,)."""
    random = np.random.default_rng(3)
    jitter = np.cumsum(random.standard_normal(ROWS + 1)) * 1e-8
    return 0.1 * TIME + 2e-3 * np.sin(2.0 * TIME) + jitter


@njit
def right(t, y, pull, step):
    x, v, z = y
    row = min(int(t / step), pull.size - 2)
    end = pull[row] + (pull[row + 1] - pull[row]) * (t / step - row)
    level = 1.0 + 0.5 * math.exp(-((v / 1e-3) ** 2))
    rate = v - 1e5 * abs(v) * z / level
    force = 1e5 * z + math.sqrt(1e5) * rate + 0.4 * v
    return np.array([v, 2.0 * (end - x) - force, rate])


def lsoda(pull: np.ndarray, tolerance: float) -> np.ndarray:
    found = solve_ivp(
        right, (0.0, TIME[-1]), np.zeros(3), "LSODA", TIME, rtol=tolerance, atol=1e-3 * tolerance, max_step=STEP,
        args=(pull, STEP),
    )  # fmt: skip
    return found.y[0]


def main() -> None:
    pull = pulled()
    motion = drive.pulled_spring(TIME, pull, STIFFNESS)
    model = compose(["lugre", "stribeck", "viscous"])
    reference = simulate(model, motion, TIME, tolerance=1e-12, forces=False).position
    sensitivity(model, motion, TIME[:3], NAMES)
    for tolerance in (1e-5, 1e-6, 1e-7):
        run = sensitivity(model, motion, TIME, NAMES, tolerance=tolerance)
        error = float(np.abs(run.position - reference).max())
        if error <= ACCURACY:
            break
    else:
        raise SystemExit("not accurate enough at any tolerance")
    spent = []
    for _ in range(5):
        begin = time.process_time()
        run = sensitivity(model, motion, TIME, NAMES, tolerance=tolerance)
        spent.append(time.process_time() - begin)
    ours = statistics.median(spent)
    print(f"{ROWS} rows, {len(NAMES)} parameters, {run.steps} steps")
    print(f"  ours                            {ours:9.3f} s   (tolerance {tolerance:.0e}, error {error:.1e} m)")
    right(0.0, np.zeros(3), pull, STEP)
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-7):
        begin = time.process_time()
        found = lsoda(pull, tolerance)
        one = time.process_time() - begin
        error = float(np.abs(found - reference).max())
        if error <= ACCURACY:
            break
    whole = one * (1 + len(NAMES))
    print(
        f"  differences through LSODA       {whole:9.3f} s   (tolerance {tolerance:.0e}, error {error:.1e} m; "
        f"one of {1 + len(NAMES)}: {one:.2f} s)"
    )
    print(f"  faster by                       {whole / ours:9.0f}")
    worst = 0.0
    for j, name in enumerate(NAMES):
        difference = _difference(motion, model.parameters(), name)
        worst = max(worst, float(np.abs(run.position_by[::100, j] - difference).max() / np.abs(difference).max()))
    print(f"  columns of the Jacobian against central differences at 1e-12: within {worst:.1e} of their largest value")


def _difference(motion: drive.Drive, known: dict[str, float], name: str) -> np.ndarray:
    """Derivative of the position by one parameter, by central differences of our tight solutions, every 100th row."""
    sides = []
    base = {"mass": 1.0, "pull_stiffness": STIFFNESS}.get(name) or known[name]
    for sign in (1.0, -1.0):
        share = 1.0 + 1e-6 * sign
        values = {**known, name: known[name] * share} if name in known else known
        pull = motion
        if name == "pull_stiffness":
            pull = drive.pulled_spring(TIME, motion.values / STIFFNESS, STIFFNESS * share)
        mass = share if name == "mass" else 1.0
        model = compose(["lugre", "stribeck", "viscous"], values)
        sides.append(simulate(model, pull, TIME[::100], mass=mass, tolerance=1e-12, forces=False).position)
    return (sides[0] - sides[1]) / (2e-6 * base)


if __name__ == "__main__":
    main()
