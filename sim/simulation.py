"""Integrate a model in time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.drive import Drive
from sim.model import Model
from stagecad.parameters.errors import InputError


class SimulationError(RuntimeError):
    """An integration that could not be carried on: the message says when, in what state, and why."""


@dataclass(frozen=True)
class Simulation:
    """Motion and forces at the instants asked for. SI units; every array is of shape (n,).

    Args:
        time, position, velocity: s, m, m/s.
        bristle: states of the core, shape (n, elements).
        level: friction level, N.
        core_force: force of the core, N.
        friction: core force and the other forces that oppose the motion, N.
        drive: force of the drive on the axis (of the spring, when pulled by one), N.
        core_work, other_work, drive_work: integrals of the forces over the motion since the start, J; empty when the
            energy was not asked for.
        stored: energy in the core's bristles, J; NaN where the core has no energy function.
        kinetic: kinetic energy, J.
        steps, rejected: of the integrator.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    bristle: np.ndarray
    level: np.ndarray
    core_force: np.ndarray
    friction: np.ndarray
    drive: np.ndarray
    core_work: np.ndarray
    other_work: np.ndarray
    drive_work: np.ndarray
    stored: np.ndarray
    kinetic: np.ndarray
    steps: int
    rejected: int


def simulate(
    model: Model,
    drive: Drive,
    time: Any,
    *,
    mass: float = 1.0,
    position: float = 0.0,
    velocity: float | None = None,
    bristle: Any = None,
    load: float = math.nan,
    temperature: float = math.nan,
    memory_length: float | None = None,
    tolerance: float = 1e-8,
    energy: bool = False,
    forces: bool = True,
    longest_step: float = math.inf,
    most_steps: int = 20_000_000,
) -> Simulation:
    """Integrate mass * v' = drive - friction from `time[0]` on.

    The local error of each step is kept below `tolerance` times (scale + value), the scales being 1 mm, 1 mm/s and the
    core's own scale of its state.

    Args:
        model: effects and their values.
        drive: what moves the axis.
        time: instants of the output, s, shape (n,), increasing; the first is the start.
        mass: kg, positive.
        position, velocity: initial, m and m/s (velocity: that of the drive when it imposes the motion, else zero).
        bristle: initial state of the core's elements, shape (elements,); zero by default.
        load, temperature: constant normal load (N) and temperature (degC) for laws that depend on them.
        memory_length: distance over which a contact's age is renewed, m: by default that of the effect which has one,
            else infinite.
        tolerance: relative error per step, 1e-13 to 1e-2.
        energy: integrate the works as well.
        forces: give the forces at the output's instants too; without, their arrays are empty.
        longest_step: s.
        most_steps: give up after so many.

    Raises:
        InputError: an argument out of range, or an effect that cannot be integrated.
        SimulationError: the step became too small, a law gave a number that is not finite, or too many steps.
    """
    from sim import integrator, kernels

    t = np.ascontiguousarray(time, dtype=float)
    if t.ndim != 1 or t.size < 2 or not np.all(np.diff(t) > 0.0):
        raise InputError("simulation: the instants of the output must be two or more, and increase strictly")
    if not (mass > 0.0 and math.isfinite(mass)):
        raise InputError(f"simulation: mass = {mass:g} kg; must be positive")
    if not 1e-13 <= tolerance <= 1e-2:
        raise InputError(f"simulation: tolerance = {tolerance:g}; must lie between 1e-13 and 1e-2")
    acting = list(zip(model.effects, model.values))
    for effect, _ in acting:
        reason = kernels.unsupported(effect)
        if reason:
            raise InputError(f"simulation: effect '{effect.name}' {reason}")

    tables = [np.array(p if len(p) else (0.0,), dtype=float) for _, p in acting]
    parts = [kernels.effect_kernel(effect) for effect, _ in acting]
    core_at = next((i for i, (effect, _) in enumerate(acting) if effect.core is not None), None)
    core_kernel = None
    elements = 0
    scale = 1.0
    if core_at is not None:
        effect, p = acting[core_at]
        core_kernel = kernels.core_kernel(effect)
        elements = int(effect.core.elements(p))
        scale = float(effect.core.scale(p))
    if memory_length is None:
        memory_length = next((p.memory_length for _, p in acting if hasattr(p, "memory_length")), math.inf)
    feedback = 0.0 if drive.prescribes else 1.0
    if velocity is None:
        velocity = drive.initial_velocity
    works = integrator.NWORK if energy else 0
    start = np.zeros(integrator.NHEAD + elements + works)
    start[0], start[1] = position, velocity
    if bristle is not None:
        start[integrator.NHEAD : integrator.NHEAD + elements] = bristle
    absolute = np.full(start.size, math.inf)
    absolute[0], absolute[1] = tolerance * 1e-3, tolerance * 1e-3
    absolute[integrator.NHEAD : integrator.NHEAD + elements] = tolerance * scale
    absolute[integrator.NHEAD + elements :] = tolerance * 1e-3
    if any("travelled" in kernels.carried(effect) for effect, _ in acting):
        absolute[2] = tolerance * 1e-3
    if any("contact_age" in kernels.carried(effect) for effect, _ in acting):
        absolute[3] = tolerance
    states = np.zeros((t.size, start.size))
    found = np.zeros((t.size if forces else 0, 4))
    report = np.zeros(5 + start.size)
    integrator.integrate(
        start,
        t[0],
        t,
        drive.knots,
        drive.values,
        drive.rates,
        np.array(drive.wave, dtype=float),
        np.array([1.0 if drive.prescribes else mass, drive.stiffness, feedback, memory_length]),
        np.array([part.address for part in parts], dtype=np.int64),
        np.array([table.ctypes.data for table in tables], dtype=np.int64),
        core_kernel.address if core_kernel else 0,
        tables[core_at].ctypes.data if core_at is not None else 0,
        elements,
        np.array([load, temperature]),
        tolerance,
        absolute,
        longest_step,
        most_steps,
        states,
        found,
        report,
    )
    if report[0] != integrator.DONE:
        errors = [error for part in [*parts, *([core_kernel] if core_kernel else [])] for error in part.errors]
        _fail(int(report[0]), report, model, errors)
    head = integrator.NHEAD
    bristles = states[:, head : head + elements]
    work = states[:, head + elements :]
    return Simulation(
        time=t,
        position=states[:, 0].copy(),
        velocity=states[:, 1].copy(),
        bristle=bristles.copy(),
        level=found[:, 0].copy(),
        core_force=found[:, 1].copy(),
        friction=found[:, 1] + found[:, 2],
        drive=found[:, 3].copy(),
        core_work=work[:, 0].copy() if energy else np.empty(0),
        other_work=work[:, 1].copy() if energy else np.empty(0),
        drive_work=work[:, 2].copy() if energy else np.empty(0),
        stored=_stored(acting, core_at, bristles, found[:, 0]) if forces else np.empty(0),
        kinetic=0.5 * mass * states[:, 1] ** 2,
        steps=int(report[2]),
        rejected=int(report[3]),
    )


def _stored(acting: list[tuple[Any, Any]], core_at: int | None, bristles: np.ndarray, level: np.ndarray) -> np.ndarray:
    if core_at is None:
        return np.zeros(level.size)
    effect, p = acting[core_at]
    if effect.core.stored is None:
        return np.full(level.size, math.nan)
    return sum(
        (effect.core.stored(k, bristles[:, k], level, p) for k in range(bristles.shape[1])), np.zeros(level.size)
    )


def _fail(outcome: int, report: np.ndarray, model: Model, errors: list[BaseException]) -> None:
    reasons = {
        1: "the step became too small: the model is stiffer or rougher there than can be resolved",
        2: "a law gave a number that is not finite",
        3: "too many steps",
    }
    reason = reasons.get(outcome, "unknown reason")
    if errors:
        reason += f" ({type(errors[0]).__name__}: {' '.join(str(errors[0]).split())})"
    raise SimulationError(
        f"simulation of {', '.join(model.names)} stopped at t = {report[1]:.9g} s, position {report[5]:.6g} m, "
        f"velocity {report[6]:.6g} m/s: {reason}"
    ) from (errors[0] if errors else None)
