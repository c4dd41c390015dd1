"""Integrate a model in time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.effects.model import Model
from sim.integration.drive import Drive
from sim.integration.input_compression import force_at
from sim.integration.layout import plan_of
from stagecad.parameters.errors import InputError


class SimulationError(RuntimeError):
    """An integration that could not be carried on: the message says when, in what state, and why."""


@dataclass(frozen=True)
class Simulation:
    """Motion and forces at the instants asked for. SI units; every array is of shape (n,).

    Args:
        time, position, velocity: s, m, m/s.
        bristle: states of the core and of elements beside it, shape (n, elements); empty when neither forces nor energy
            were asked for.
        level: friction level, N.
        core_force: force of the core, N.
        friction: core force and the other forces that oppose the motion, N.
        drive: force of the drive on the axis (of the spring, when pulled by one), N.
        core_work, other_work, drive_work: integrals of the forces over the motion since the start, J; empty when the
            energy was not asked for.
        stored: energy in the core's bristles, J; NaN where the core has no energy function.
        mass: that moves with the axis itself, kg: all but what rides on a resonance.
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
    mass: float
    steps: int
    rejected: int

    @property
    def kinetic(self) -> np.ndarray:
        """Kinetic energy of `mass`, J."""
        return 0.5 * self.mass * self.velocity**2


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
    from sim.integration import integrator

    t = np.ascontiguousarray(time, dtype=float)
    if t.ndim != 1 or t.size < 2 or not np.all(t[1:] > t[:-1]):
        raise InputError("simulation: the instants of the output must be two or more, and increase strictly")
    if not (mass > 0.0 and math.isfinite(mass)):
        raise InputError(f"simulation: mass = {mass:g} kg; must be positive")
    if not 1e-13 <= tolerance <= 1e-2:
        raise InputError(f"simulation: tolerance = {tolerance:g}; must lie between 1e-13 and 1e-2")
    whole = plan_of(model, drive, mass, load, temperature)
    plan = whole.merged(t[0], t[-1], tolerance)
    if memory_length is None:
        memory_length = plan.memory_length
    if velocity is None:
        velocity = drive.initial_velocity
    start, absolute = plan.start(position, velocity, bristle, tolerance, energy)
    # Without forces and works only the motion is asked for.
    states = np.empty((start.size if forces or energy else 2, t.size))
    found = np.empty((t.size if forces else 0, 4))
    report = np.zeros(5 + start.size)
    integrator.integrate(
        start,
        t,
        plan.drive.knots,
        plan.drive.values,
        plan.drive.rates,
        np.array(plan.drive.wave, dtype=float),
        plan.body(memory_length),
        plan.shape(start.size),
        plan.modes,
        plan.effects,
        plan.groups,
        plan.at_once,
        plan.base,
        tolerance,
        absolute,
        longest_step,
        most_steps,
        states,
        found,
        report,
    )
    if report[0] != integrator.DONE:
        raise failure(int(report[0]), report, model, [error for kernel in plan.kernels for error in kernel.errors])
    if forces and plan.drive is not whole.drive and plan.lag == 0.0:
        # The motion cannot tell the drive as given from the one with pieces joined; the force shown can.
        found[:, 3] += force_at(whole.drive, t) - force_at(plan.drive, t)
    bristles = states[plan.head : plan.head + plan.elements].T
    work = states[-integrator.NWORK :] if energy else np.empty((3, 0))
    return Simulation(
        time=t,
        position=states[0],
        velocity=states[1],
        bristle=bristles,
        level=found[:, 0],
        core_force=found[:, 1],
        friction=found[:, 1] + found[:, 2],
        drive=found[:, 3],
        core_work=work[0],
        other_work=work[1],
        drive_work=work[2],
        stored=_stored(model, bristles, found[:, 0]) if forces else np.empty(0),
        mass=plan.rigid,
        steps=int(report[2]),
        rejected=int(report[3]),
    )


def _stored(model: Model, bristles: np.ndarray, level: np.ndarray) -> np.ndarray:
    stored = np.zeros(level.size)
    if model.state_effect is None:
        return stored
    p = model.values[model.effects.index(model.state_effect)]
    if model.state_effect.friction_state.stored is None:
        return np.full(level.size, math.nan)
    for k in range(int(model.state_effect.friction_state.elements(p))):
        stored += model.state_effect.friction_state.stored(k, bristles[:, k], level, p)
    return stored


def failure(outcome: int, report: np.ndarray, model: Model, errors: list[BaseException]) -> SimulationError:
    """What went wrong in an integration, with the time, the state and the reason."""
    reasons = {
        1: "the step became too small: the model is stiffer or rougher there than can be resolved",
        2: "a law gave a number that is not finite",
        3: "too many steps",
    }
    reason = reasons.get(outcome, "unknown reason")
    if errors:
        reason += f" ({type(errors[0]).__name__}: {' '.join(str(errors[0]).split())})"
    error = SimulationError(
        f"simulation of {', '.join(model.names)} stopped at t = {report[1]:.9g} s, position {report[5]:.6g} m, "
        f"velocity {report[6]:.6g} m/s: {reason}"
    )
    error.__cause__ = errors[0] if errors else None
    return error
