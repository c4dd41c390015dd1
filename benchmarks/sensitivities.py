"""Residual and exact Jacobian in all parameters of a logged stick-slip record, beside finite differences through LSODA.

    python -m benchmarks.sensitivities

The record: 200 000 rows at 10 kHz of a mass on a spring whose other end was pulled at an uneven speed, as an encoder
logged it: linear between rows. Ours is one pass, `sim.integration.sensitivity`. The peer solves the same equations in
compiled code by scipy's LSODA, once for the residual and once for each parameter, moved by a millionth. Both are given
what suits them best of one ladder of tolerances (1, 2 and 5 to the decade) that keeps the position within 1e-6 m; the
peer also the best longest step: one row, so that it meets every corner of the input, or more, or none. Its one solution
is timed, and counted as often as it would be needed. Processor time, the median of several runs taken in turn.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from sim import compose, simulate
from sim.integration import drive
from sim.integration.sensitivity import sensitivity

ROWS = 200_000
STEP = 1e-4
ACCURACY = 1e-6
TARGET = 150
LADDER = [part * 10.0**-k for k in range(4, 10) for part in (1.0, 0.5, 0.2)]
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


def lsoda(pull: np.ndarray, tolerance: float, longest: float) -> np.ndarray:
    found = solve_ivp(
        right, (0.0, TIME[-1]), np.zeros(3), "LSODA", TIME, rtol=tolerance, atol=1e-3 * tolerance, max_step=longest,
        args=(pull, STEP),
    )  # fmt: skip
    return found.y[0]


def timed(reference: np.ndarray, solve: Callable[..., np.ndarray], *arguments: Any) -> tuple[float, float]:
    """Processor time of a solution, s, and its error, m."""
    begin = time.process_time()
    found = solve(*arguments)
    spent = time.process_time() - begin
    return spent, float(np.abs(found - reference).max())


def main() -> None:
    pull = pulled()
    motion = drive.pulled_spring(TIME, pull, STIFFNESS)
    model = compose(["lugre", "stribeck", "viscous"])
    reference = simulate(model, motion, TIME, tolerance=1e-12, forces=False).position
    sensitivity(model, motion, TIME[:3], NAMES)

    def ours(tolerance: float) -> np.ndarray:
        return sensitivity(model, motion, TIME, NAMES, tolerance=tolerance).position

    tolerance, error = next((x, e) for x in LADDER if (e := timed(reference, ours, x)[1]) <= ACCURACY)
    right(0.0, np.zeros(3), pull, STEP)
    tried: list[tuple[float, float, float, float]] = []
    for longest in (math.inf, 1e-2, 1e-3, STEP):
        for loose in LADDER:
            spent, off = timed(reference, lsoda, pull, loose, longest)
            if off <= ACCURACY:
                tried.append((spent, loose, longest, off))
                break
    _, loose, longest, off = min(tried)
    mine, theirs = [], []
    for _ in range(5):
        mine += [timed(reference, ours, tolerance)[0] for _ in range(5)]
        theirs.append(timed(reference, lsoda, pull, loose, longest)[0])
    one, whole = statistics.median(theirs), statistics.median(theirs) * (1 + len(NAMES))
    spent = statistics.median(mine)
    run = sensitivity(model, motion, TIME, NAMES, tolerance=tolerance)
    print(f"{ROWS} rows, {len(NAMES)} parameters, {run.steps} steps")
    print(f"  ours                            {spent * 1e3:9.1f} ms   (tolerance {tolerance:.0e}, error {error:.1e} m)")
    print(
        f"  differences through LSODA       {whole * 1e3:9.1f} ms   (tolerance {loose:.0e}, error {off:.1e} m, "
        f"longest step {longest:g} s; one of {1 + len(NAMES)}: {one * 1e3:.1f} ms)"
    )
    print(f"  faster by                       {whole / spent:9.0f}   (target {TARGET})")
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
