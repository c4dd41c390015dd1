"""A record of a stage driven by its tip, slipping and walking: our simulation and scipy's on the same equations.

    python -m benchmarks.driven_stage [--against COMMIT [STUDY ...]]

    m x'' = T - P sign(x'),    T = q + c (u' - x'), cut at +-L,    q' = k (u' - x'), q cut at +-L

The tip moves linearly from row to row, as the voltages of a record do. The reference is a semi-implicit Euler method
with steps of 0.1 us, which knows nothing of events. scipy's methods get a right side compiled by numba, with friction
of the pads P tanh(x'/v): a solver of differential equations has no other way to hold a stage at rest. Each is given the
loosest tolerance that keeps the position within a noise of 2 nm, also where a tighter one does not (of a tenth of it
LSODA comes to no end). With a commit: processor times of `simulate stage`, its studies or those named, here and
there in alternation, with the caches full.
"""

import argparse
import resource
import statistics
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from benchmarks.snapshot import Program
from benchmarks.stick_slip import Aim, Method, print_times
from sim.integration.friction_drive.event_driven import simulate_event_driven
from sim.integration.friction_drive.inputs import DrivenStage, TipMotion, velocity_independent

STAGE = DrivenStage(stiffness=8e6, damping=800.0, mass=3.0, step=5e-4)
PADS, LIMIT = 0.8, 6.0
ROWS, PERIOD = 200, 40
ACCURACY = 2e-9
LADDER = (1e-4, 5e-5, 2e-5, 1e-5)
CREEP = 1e-8
"""m/s, v of the regularised pads: at half of their limit a stage creeps by 0.5 nm in the 0.1 s of the record."""
FINE = 5000
"""Steps of the reference in a row."""


def sawtooth() -> np.ndarray:
    """Position (n,) of the tip: it takes the stage along, and slips as it returns."""
    part = (np.arange(ROWS) % PERIOD) / PERIOD
    return 4e-6 * np.minimum(part / 0.9, (1.0 - part) / 0.1)


@njit
def euler(tip: np.ndarray, stage: DrivenStage, pads: float, limit: float, fine: int) -> np.ndarray:
    """Position (n,) by semi-implicit Euler steps, `fine` of them in a row; rigid pads take what speed they can."""
    h = stage.step / fine
    x, v, q, out = 0.0, 0.0, 0.0, np.zeros(tip.size)
    for i in range(1, tip.size):
        speed = (tip[i] - tip[i - 1]) / stage.step
        for _ in range(fine):
            sliding = speed - v
            q += stage.stiffness * sliding * h
            force = min(max(q + stage.damping * sliding, -limit), limit)
            q = min(max(q, -limit), limit)
            free, lost = v + h * force / stage.mass, h * pads / stage.mass
            v = free - lost if free > lost else (free + lost if free < -lost else 0.0)
            x += v * h
        out[i] = x
    return out


def right_side(tip: np.ndarray) -> Callable[[float, Any], Any]:
    """The equations for a solver, compiled: position in um, velocity in mm/s, force of the spring in N."""
    step, k, c, m = STAGE.step, STAGE.stiffness, STAGE.damping, STAGE.mass

    @njit
    def right(t, y):
        i = min(int(t / step), tip.size - 2)
        v, q = 1e-3 * y[1], y[2]
        sliding = (tip[i + 1] - tip[i]) / step - v
        force = min(max(q + c * sliding, -LIMIT), LIMIT)
        rate = k * sliding
        if (q >= LIMIT and rate > 0.0) or (q <= -LIMIT and rate < 0.0):
            rate = 0.0
        return np.array([1e6 * v, 1e3 * (force - PADS * np.tanh(v / CREEP)) / m, rate])

    return right


def ours(tip: np.ndarray) -> Method:
    motion = TipMotion(tip, np.ones(tip.size))
    contact, pads = (velocity_independent(np.full(tip.size, limit)) for limit in (LIMIT, PADS))
    return lambda _: simulate_event_driven(motion, 0.0 * tip, contact, pads, STAGE)


def scipy_method(method: str, tip: np.ndarray) -> Method:
    right, time = right_side(tip), STAGE.step * np.arange(tip.size)

    def solve(tolerance: float) -> np.ndarray:
        # The tip's speed jumps at the rows: a longer step would miss strokes.
        found = solve_ivp(
            right, (0.0, time[-1]), np.zeros(3), method, time, rtol=tolerance, atol=tolerance, max_step=STAGE.step
        )
        if not found.success:
            raise RuntimeError(found.message)
        return 1e-6 * found.y[0]

    return solve


def compare_times(commit: str, studies: list[str], runs: int = 3) -> None:
    """Print the processor times of `simulate stage` here and at a commit, and their ratio."""
    here, words = Path(__file__).resolve().parents[1], [word for study in studies for word in ("--study", study)]
    with tempfile.TemporaryDirectory() as scratch:
        folders = [Path(scratch, name).resolve() for name in ("here", "there", "checkout")]
        git = ["git", "-C", str(here), "worktree"]
        subprocess.run([*git, "add", "--detach", str(folders[2]), commit], check=True, capture_output=True)
        try:
            programs = [Program(code, folder, 1) for code, folder in zip((here, folders[2]), folders, strict=False)]
            times: list[list[float]] = [[], []]
            for _ in range(runs + 1):
                for program, spent in zip(programs, times, strict=True):
                    program.scratch.mkdir(exist_ok=True)
                    before = resource.getrusage(resource.RUSAGE_CHILDREN)
                    program.run(["simulate", "stage", "--no-figures", "--format", "none", *words])
                    after = resource.getrusage(resource.RUSAGE_CHILDREN)
                    spent.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        finally:
            subprocess.run([*git, "remove", "--force", str(folders[2])], check=True)
    now, then = (statistics.median(spent[1:]) for spent in times)
    print(f"simulate stage: {now:.1f} s, at {commit} {then:.1f} s: {now / then:.2f} times")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", nargs="+", metavar=("COMMIT", "STUDY"))
    given = parser.parse_args().against
    if given:
        compare_times(given[0], given[1:])
        return
    tip = sawtooth()
    print(f"{ROWS} rows, {ROWS // PERIOD} slips, to {1e9 * ACCURACY:g} nm")
    methods: dict[str, Method | None] = {
        "ours (event-driven)": ours(tip),
        "scipy LSODA, compiled right side": scipy_method("LSODA", tip),
        "scipy Radau, compiled right side": scipy_method("Radau", tip),
        "scipy BDF, compiled right side": scipy_method("BDF", tip),
    }
    print_times(methods, euler(tip, STAGE, PADS, LIMIT, FINE), Aim(ACCURACY, LADDER, 0))


if __name__ == "__main__":
    main()
