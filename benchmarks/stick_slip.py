"""Stick-slip for 20 s: our integrator and its peers on the same equations, at the same accuracy, in the same run.

    python -m benchmarks.stick_slip

Each method is given the loosest tolerance of one ladder (1, 2 and 5 to the decade) that keeps the position within
1e-6 m of a reference at 1 kHz output, and so does every tighter one down to a tenth of it: a lucky hit counts for
nobody. The time is the processor's, the median of several runs taken in turn, compilation left out. scipy's LSODA gets
the right side both as plain Python and compiled by numba.
"""

import math
import statistics
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from sim.effects.catalogue import compose
from sim.integration import drive
from sim.integration.simulate import simulate

ACCURACY = 1e-6
A0, A2, FC, FS, VS = 1e5, 0.4, 1.0, 1.5, 1e-3
TIME = np.linspace(0.0, 20.0, 20001)
PULL = drive.pulled_spring([0.0, 20.0], [0.0, 2.0], 2.0)
LADDER = [part * 10.0**-k for k in range(4, 13) for part in (1.0, 0.5, 0.2)]
DECADE = 3
"""Rungs of the ladder to a tenth of a tolerance."""

Method = Callable[[float], np.ndarray]


def right_side(core: str) -> Callable[[float, Any], Any]:
    """The thesis's equations for one model, in plain Python."""
    a1 = math.sqrt(A0)

    def right(t, y):
        x, v, z = y[0], y[1], y[2]
        level = FC + (FS - FC) * math.exp(-((v / VS) ** 2))
        rate = v - A0 * abs(v) * z / level
        if core == "lugre_causal":
            rate = rate / (1.0 + a1 * abs(v) / level)
        force = A0 * z + A2 * v
        if core != "lugre_undamped":
            force += a1 * rate
        return np.array([v, 2.0 * (0.1 * t - x) - force, rate])

    return right


def ours(core: str) -> Method:
    model = compose([core, "stribeck", "viscous"])
    return lambda tolerance: simulate(model, PULL, TIME, tolerance=tolerance, forces=False).position


def scipy_method(method: str, right: Callable[[float, Any], Any]) -> Method:
    def solve(tolerance: float) -> np.ndarray:
        found = solve_ivp(right, (0.0, 20.0), np.zeros(3), method, TIME, rtol=tolerance, atol=1e-3 * tolerance)
        return found.y[0]

    return solve


def casadi_cvodes(core: str) -> Method | None:
    """CasADi's CVODES on the same equations, when CasADi is installed; made once for each tolerance, as it would be."""
    try:
        import casadi as ca
    except ImportError:
        return None
    a1 = math.sqrt(A0)
    x, v, z, t = ca.SX.sym("x"), ca.SX.sym("v"), ca.SX.sym("z"), ca.SX.sym("t")
    level = FC + (FS - FC) * ca.exp(-((v / VS) ** 2))
    rate = v - A0 * ca.fabs(v) * z / level
    if core == "lugre_causal":
        rate = rate / (1.0 + a1 * ca.fabs(v) / level)
    force = A0 * z + A2 * v + (a1 * rate if core != "lugre_undamped" else 0.0)
    right = ca.vertcat(v, 2.0 * (0.1 * t - x) - force, rate)
    system = {"x": ca.vertcat(x, v, z), "t": t, "ode": right}
    made: dict[float, Any] = {}

    def solve(tolerance: float) -> np.ndarray:
        if tolerance not in made:
            options = {"reltol": tolerance, "abstol": 1e-3 * tolerance, "max_num_steps": 10_000_000}
            made[tolerance] = ca.integrator("stick_slip", "cvodes", system, 0.0, TIME[1:].tolist(), options)
        found = np.array(made[tolerance](x0=[0.0, 0.0, 0.0])["xf"])
        return np.concatenate([[0.0], found[0]])

    return solve


class Aim(NamedTuple):
    """Largest error of a position, m, tolerances to try, and how many tighter ones must keep it."""

    accuracy: float = ACCURACY
    ladder: Sequence[float] = LADDER
    tighter: int = DECADE


def loosest(solve: Method, reference: np.ndarray, aim: Aim = Aim()) -> tuple[float, float] | None:  # noqa: B008
    """Loosest tolerance from which on the error stays small enough for a decade, and the error there; None if none."""
    good: list[tuple[float, float]] = []
    for tolerance in aim.ladder:
        try:
            error = float(np.abs(solve(tolerance) - reference).max())
        except (RuntimeError, ValueError):
            error = math.inf
        good = [*good, (tolerance, error)] if error <= aim.accuracy else []
        if len(good) > aim.tighter:
            return good[0]
    return None


def processor_time(solve: Method, tolerance: float) -> float:
    begin = time.process_time()
    solve(tolerance)
    return time.process_time() - begin


def print_times(methods: dict[str, Method | None], reference: np.ndarray, aim: Aim = Aim()) -> None:  # noqa: B008
    """Processor time of each method at the loosest tolerance that is accurate enough, and over that of the first."""
    chosen = {name: loosest(solve, reference, aim) for name, solve in methods.items() if solve is not None}
    spent: dict[str, list[float]] = {name: [] for name, found in chosen.items() if found is not None}
    first = next(iter(methods))
    for _ in range(7):
        for name, times in spent.items():
            solve, found = methods[name], chosen[name]
            assert solve is not None and found is not None
            times += [processor_time(solve, found[0]) for _ in range(20 if name == first else 1)]
    base = statistics.median(spent[first])
    for name, solve in methods.items():
        found = chosen.get(name)
        if found is None:
            print(f"  {name:34s} {'not installed' if solve is None else 'not accurate enough at any tolerance'}")
        else:
            middle = statistics.median(spent[name])
            print(
                f"  {name:34s} {middle * 1e3:10.2f} ms   x {middle / base:7.1f}"
                f"   (tolerance {found[0]:.0e}, error {found[1]:.1e} m)"
            )


def main() -> None:
    for core in ("lugre", "lugre_undamped", "lugre_causal"):
        model = compose([core, "stribeck", "viscous"])
        reference = simulate(model, PULL, TIME, tolerance=1e-12).position
        right = right_side(core)
        print(f"\n{core}: 20 s to {ACCURACY:g} m, 1 kHz output")
        methods = {
            "ours (Rodas5P)": ours(core),
            "scipy LSODA": scipy_method("LSODA", right),
            "scipy LSODA, compiled right side": scipy_method("LSODA", njit(right)),
            "CasADi CVODES": casadi_cvodes(core),
        }
        print_times(methods, reference)


if __name__ == "__main__":
    main()
