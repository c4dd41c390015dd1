"""Integrate a model in time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from sim.effects.catalogue import Model
from sim.integration.drive import Drive, force_at
from stagecad.parameters.errors import InputError, require

if TYPE_CHECKING:
    from sim.integration.integrator import Plan
    from sim.integration.problem import Output, Problem, Tolerance


ABSOLUTE_ZERO = -273.15
"""degC."""


class SimulationError(RuntimeError):
    """An integration that could not be continued: the message has the time, the state and the reason."""


@dataclass(frozen=True)
class Settings:
    """Conditions, outputs and accuracy of a simulation.

    Raises:
        InputError: a mass, tolerance, load or temperature out of range.
    """

    mass: float = 1.0  # kg, positive
    # position, velocity: initial, m and m/s (velocity: that of the drive where it imposes the motion, else zero)
    position: float = 0.0
    velocity: float | None = None
    bristle: Any = None  # initial state of the friction elements, (elements,); zero by default
    # travelled, contact_age: initial distance travelled, m, and age of the contact, s
    travelled: float = 0.0
    contact_age: float = 0.0
    # load, temperature: normal load (N) and temperature (degC) for laws that depend on them: constant, or at evenly
    # spaced instants from the start to the end, (m,) each, linear between them
    load: Any = math.nan
    temperature: Any = math.nan
    # distance over which a contact's age is renewed, m: by default that of the effect which has one, else infinite
    memory_length: float | None = None
    tolerance: float = 1e-8  # relative error per step, 1e-13 to 1e-2
    energy: bool = False  # integrate the works too
    forces: bool = True  # give the forces at the output's instants too; without, their arrays are empty
    longest_step: float = math.inf  # s
    most_steps: int = 20_000_000  # attempts after which the integration fails

    def __post_init__(self) -> None:
        require(self.mass > 0.0 and math.isfinite(self.mass), f"simulation: mass = {self.mass:g} kg; must be positive")
        if not 1e-13 <= self.tolerance <= 1e-2:
            raise InputError(f"simulation: tolerance = {self.tolerance:g}; must lie between 1e-13 and 1e-2")
        for name, unit, low in (("load", "N", 0.0), ("temperature", "degC", ABSOLUTE_ZERO)):
            values = np.atleast_1d(np.asarray(getattr(self, name), dtype=float))
            # NaN is a quantity that is not given.
            wrong = values[(values < low) | np.isinf(values)]
            if wrong.size:
                raise InputError(f"simulation: {name} = {wrong[0]:g} {unit}; must be finite and {low:g} {unit} or more")


@dataclass(frozen=True)
class Simulation:
    """Motion and forces at the instants of the output. SI units; every array is of shape (n,)."""

    # time, position, velocity: s, m, m/s
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    # states of all friction elements, those of the friction state model first, shape (n, elements); empty when neither
    # forces nor energy were computed
    bristle: np.ndarray
    level: np.ndarray  # friction level, N
    core_force: np.ndarray  # force of the friction state model, N
    friction: np.ndarray  # that and the other forces that oppose the motion, N
    drive: np.ndarray  # force of the drive on the axis (of the spring, when pulled by one), N
    # core_work, other_work, drive_work: integrals of the forces over the motion since the start, J; empty without
    # `energy`
    core_work: np.ndarray
    other_work: np.ndarray
    drive_work: np.ndarray
    stored: np.ndarray  # energy stored by the friction state model, J; NaN where it has no energy function
    mass: float  # that moves with the axis itself, kg: all but that of added oscillators
    # steps, rejected: accepted steps and rejected attempts of the integrator
    steps: int
    rejected: int

    @property
    def kinetic(self) -> np.ndarray:
        """Kinetic energy of `mass`, J."""
        return 0.5 * self.mass * self.velocity**2


def simulate(model: Model, drive: Drive, time: Any, **settings: Any) -> Simulation:
    """Integrate mass * v' = drive - friction from `time[0]` on.

    The local error of each step is kept below `tolerance` times (scale + value), the scales being 1 mm, 1 mm/s and the
    friction state model's own scale of its state.

    Args:
        model: effects and their values.
        drive: input that moves the axis.
        time: instants of the output, s, shape (n,), increasing; the first is the start.
        settings: fields of `Settings`, such as `mass=2.0, tolerance=1e-9`.

    Raises:
        InputError: an argument out of range, or an effect that cannot be integrated.
        SimulationError: the step became too small, a law gave a number that is not finite, or too many steps.
    """
    from sim.integration.integrator import DONE, Surroundings, begin_compilation, integrate, plan_of
    from sim.integration.problem import WORKS

    chosen = Settings(**settings)
    t = np.ascontiguousarray(time, dtype=float)
    if t.ndim != 1 or t.size < 2 or not np.all(t[1:] > t[:-1]):
        raise InputError("simulation: the instants of the output must be two or more, and increase strictly")
    table = np.column_stack(np.broadcast_arrays(np.atleast_1d(chosen.load), np.atleast_1d(chosen.temperature)))
    table = np.ascontiguousarray(table, dtype=float)
    surroundings = Surroundings(table, float(t[0]), float(t[-1] - t[0]) / max(table.shape[0] - 1, 1))
    begin_compilation(lambda: _arguments(plan_of(Model((), ()), drive, chosen.mass, surroundings), t, chosen))
    given = plan_of(model, drive, chosen.mass, surroundings)
    plan = given.compressed(t[0], t[-1], chosen.tolerance)
    problem, tolerance, output = _arguments(plan, t, chosen)
    layout = problem.layout
    velocity = drive.initial_velocity if chosen.velocity is None else chosen.velocity
    start = plan.start(layout, chosen.position, velocity, chosen.bristle)
    if layout.head > 2:
        start[2], start[3] = chosen.travelled, chosen.contact_age
    integrate(problem, start, tolerance, output)
    states, forces, report = output.states, output.forces, output.report
    if report[0] != DONE:
        raise _failure(report, model, [error for kernel in plan.kernels for error in kernel.errors])
    if chosen.forces and plan.drive is not given.drive and plan.axis.lag == 0.0:
        # The compressed drive gives the same motion; the force shown is that of the drive as given.
        forces[:, 3] += force_at(given.drive, t) - force_at(plan.drive, t)
    bristle = states[plan.head : plan.head + plan.elements].T
    work = states[-WORKS:] if chosen.energy else np.empty((WORKS, 0))
    return Simulation(
        time=t,
        position=states[0],
        velocity=states[1],
        bristle=bristle,
        level=forces[:, 0],
        core_force=forces[:, 1],
        friction=forces[:, 1] + forces[:, 2],
        drive=forces[:, 3],
        core_work=work[0],
        other_work=work[1],
        drive_work=work[2],
        stored=_stored(model, bristle, forces[:, 0]) if chosen.forces else np.empty(0),
        mass=plan.axis.mass,
        steps=int(report[2]),
        rejected=int(report[3]),
    )


def _arguments(plan: Plan, t: np.ndarray, chosen: Settings) -> tuple[Problem, Tolerance, Output]:
    """Arguments of the integrator, without the initial state."""
    from sim.integration.integrator import REPORT_HEAD
    from sim.integration.problem import Output

    problem = plan.problem(plan.memory_length if chosen.memory_length is None else chosen.memory_length, chosen.energy)
    size = problem.layout.size
    tolerance = plan.tolerance(problem.layout, chosen.tolerance, chosen.longest_step, chosen.most_steps)
    output = Output(
        time=t,
        states=np.empty((size if chosen.forces or chosen.energy else 2, t.size)),
        forces=np.empty((t.size if chosen.forces else 0, 4)),
        report=np.zeros(REPORT_HEAD + size),
    )
    return problem, tolerance, output


def _stored(model: Model, bristle: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Energy stored by the friction state model, J, (n,)."""
    stored = np.zeros(level.size)
    effect = model.state_effect
    if effect is None:
        return stored
    if effect.friction_state.stored is None:
        return np.full(level.size, math.nan)
    p = model.values[model.effects.index(effect)]
    for k in range(int(effect.friction_state.elements(p))):
        stored += effect.friction_state.stored(k, bristle[:, k], level, p)
    return stored


def _failure(report: np.ndarray, model: Model, errors: list[BaseException]) -> SimulationError:
    """The error of an integration that stopped, with the time, the state and the reason."""
    reason = {
        1: "the step became too small: the model is stiffer or rougher there than can be resolved",
        2: "a law gave a number that is not finite",
        3: "too many steps",
    }[int(report[0])]
    if errors:
        reason += f" ({type(errors[0]).__name__}: {' '.join(str(errors[0]).split())})"
    error = SimulationError(
        f"simulation of {', '.join(model.names)} stopped at t = {report[1]:.9g} s, position {report[4]:.6g} m, "
        f"velocity {report[5]:.6g} m/s: {reason}"
    )
    error.__cause__ = errors[0] if errors else None
    return error
