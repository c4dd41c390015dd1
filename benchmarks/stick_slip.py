"""Stick-slip for 20 s: our integrator and its peers on the same equations, at the same accuracy, in the same run.

    python -m benchmarks.stick_slip

Each method is given the loosest tolerance of a ladder that keeps the position within 1e-6 m of a reference at 1 kHz
output; the time is the best of several runs, compilation left out. scipy's LSODA gets the right side both as plain
Python and compiled by numba.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from sim import drive
from sim.model import compose
from sim.simulation import simulate

ACCURACY = 1e-6
A0, A2, FC, FS, VS = 1e5, 0.4, 1.0, 1.5, 1e-3
TIME = np.linspace(0.0, 20.0, 20001)
PULL = drive.pulled_spring([0.0, 20.0], [0.0, 2.0], 2.0)
LADDER = [10.0**-k for k in range(4, 13)]


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


def ours(core: str) -> Callable[[float], np.ndarray]:
    model = compose([core, "stribeck", "viscous"])
    return lambda tolerance: simulate(model, PULL, TIME, tolerance=tolerance, forces=False).position


def scipy_method(method: str, right: Callable[[float, Any], Any]) -> Callable[[float], np.ndarray]:
    def solve(tolerance: float) -> np.ndarray:
        found = solve_ivp(right, (0.0, 20.0), np.zeros(3), method, TIME, rtol=tolerance, atol=1e-3 * tolerance)
        return found.y[0]

    return solve


def casadi_cvodes(core: str) -> Callable[[float], np.ndarray] | None:
    """CasADi's CVODES on the same equations, when CasADi is installed."""
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

    def solve(tolerance: float) -> np.ndarray:
        options = {"reltol": tolerance, "abstol": 1e-3 * tolerance, "max_num_steps": 10_000_000}
        integrator = ca.integrator("stick_slip", "cvodes", system, 0.0, TIME[1:].tolist(), options)
        found = np.array(integrator(x0=[0.0, 0.0, 0.0])["xf"])
        return np.concatenate([[0.0], found[0]])

    return solve


def timed(solve: Callable[[float], np.ndarray], reference: np.ndarray) -> tuple[float, float, float] | None:
    """Tolerance, error and seconds at the loosest tolerance that is accurate enough; None when none is."""
    for tolerance in LADDER:
        try:
            error = float(np.abs(solve(tolerance) - reference).max())
        except (RuntimeError, ValueError):
            continue
        if error <= ACCURACY:
            best = math.inf
            spent = 0.0
            while spent < 1.0:
                begin = time.perf_counter()
                solve(tolerance)
                best = min(best, time.perf_counter() - begin)
                spent += time.perf_counter() - begin
            return tolerance, error, best
    return None


def main() -> None:
    for core in ("lugre", "lugre_undamped", "lugre_causal"):
        model = compose([core, "stribeck", "viscous"])
        run = simulate(model, PULL, TIME, tolerance=1e-12)
        reference = run.position
        right = right_side(core)
        methods = {
            "ours (Rodas5P)": ours(core),
            "scipy LSODA": scipy_method("LSODA", right),
            "scipy LSODA, compiled right side": scipy_method("LSODA", njit(right)),
            "CasADi CVODES": casadi_cvodes(core),
        }
        print(f"\n{core}: 20 s to {ACCURACY:g} m, 1 kHz output")
        base = None
        for name, solve in methods.items():
            found = timed(solve, reference) if solve is not None else None
            if solve is None:
                print(f"  {name:34s} not installed")
            elif found is None:
                print(f"  {name:34s} not accurate enough at any tolerance")
            else:
                base = base or found[2]
                print(
                    f"  {name:34s} {found[2] * 1e3:10.2f} ms   x {found[2] / base:7.1f}"
                    f"   (tolerance {found[0]:.0e}, error {found[1]:.1e} m)"
                )


if __name__ == "__main__":
    main()
