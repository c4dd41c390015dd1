"""Derivatives of a simulated motion by the parameters of its model, exact, in one pass beside the simulation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.integration.drive import Drive
from sim.integration.layout import plan_of
from sim.integration.simulate import SimulationError, failure
from sim.library.model import Model
from stagecad.parameters.errors import InputError, nearest


@dataclass(frozen=True)
class Sensitivity:
    """A motion and its derivatives. SI units.

    Args:
        time, position, velocity: s, m, m/s, shape (n,).
        names: the parameters, in the order of the columns.
        position_by, velocity_by: derivatives, shape (n, parameters), m and m/s per unit of the parameter.
        steps, rejected: of the integrator.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    names: tuple[str, ...]
    position_by: np.ndarray
    velocity_by: np.ndarray
    steps: int
    rejected: int


def sensitivity(
    model: Model,
    drive: Drive,
    time: Any,
    parameters: Sequence[str],
    *,
    mass: float = 1.0,
    position: float = 0.0,
    velocity: float | None = None,
    load: float = math.nan,
    temperature: float = math.nan,
    memory_length: float | None = None,
    tolerance: float = 1e-8,
    most_steps: int = 20_000_000,
) -> Sensitivity:
    """Integrate a motion as `sim.simulate` does, and its derivatives by `parameters` with it.

    The derivatives solve the variational equation S' = J S + df/dp along the accepted steps, by a method of order 4 and
    with the laws' own derivatives (`sim.numerics.derivative`); nothing is differenced, save in a user's own laws. Their
    error falls with `tolerance`, though they ask for no steps of their own.

    Args:
        parameters: names such as `stribeck.velocity`; `mass`; `pull_stiffness` of a spring that is pulled.
        others: as for `sim.simulate`.

    Raises:
        InputError: an unknown parameter, or an effect of the drive, the structure or the memory, whose parameters act
            through the history of the motion.
        SimulationError: as `sim.simulate`.
    """
    from sim.integration import integrator

    t = np.ascontiguousarray(time, dtype=float)
    if t.ndim != 1 or t.size < 2 or not np.all(t[1:] > t[:-1]):
        raise InputError("sensitivity: the instants of the output must be two or more, and increase strictly")
    if not (mass > 0.0 and math.isfinite(mass)):
        raise InputError(f"sensitivity: mass = {mass:g} kg; must be positive")
    if not 1e-13 <= tolerance <= 1e-2:
        raise InputError(f"sensitivity: tolerance = {tolerance:g}; must lie between 1e-13 and 1e-2")
    for effect in model.effects:
        if effect.in_time is not None:
            raise InputError(f"sensitivity: effect '{effect.name}' acts through the history of the motion")
    plan = plan_of(model, drive, mass, load, temperature, whole=True).merged(t[0], t[-1], tolerance)
    memory_length = plan.memory_length if memory_length is None else memory_length
    tangent, kept = _tangent(model, drive, plan, parameters, t.size)
    start, absolute = plan.start(
        position, drive.initial_velocity if velocity is None else velocity, None, tolerance, False
    )
    states, report = np.empty((2, t.size)), np.zeros(5 + start.size)
    integrator.integrate(
        start, t, plan.drive.knots, plan.drive.values, plan.drive.rates, np.array(plan.drive.wave, dtype=float),
        plan.body(memory_length), plan.shape(start.size), plan.modes, plan.effects, plan.groups, plan.at_once,
        plan.base, tolerance, absolute, math.inf, most_steps, states, np.empty((0, 4)), report, tangent,
    )  # fmt: skip
    errors = [error for kernel in [*plan.kernels, *kept] for error in kernel.errors]
    if report[0] != integrator.DONE or errors:
        raise failure(int(report[0]), report, model, errors)
    found = tangent[-1]
    if not np.all(np.isfinite(found)):
        raise SimulationError(f"sensitivity of {', '.join(model.names)}: a derivative is not finite")
    return Sensitivity(
        time=t,
        position=states[0],
        velocity=states[1],
        names=tuple(parameters),
        position_by=found[0].T,
        velocity_by=found[1].T,
        steps=int(report[2]),
        rejected=int(report[3]),
    )


def _first_with_memory(model: Model) -> int:
    return next((i for i, p in enumerate(model.values) if hasattr(p, "memory_length")), -1)


def _tangent(model: Model, drive: Drive, plan: Any, parameters: Sequence[str], count: int) -> tuple[Any, list[Any]]:
    """The arrays that `sim.integration.tangent_step.advance` works in, and the kernels to keep alive."""
    from sim.integration import parameter_kernels, tangent_step

    known = [*model.parameters(), "mass", *(["pull_stiffness"] if drive.stiffness > 0.0 else [])]
    # Of each row: kernel, where its derivatives go, which are wanted, and whether it has a factor.
    by_effect = np.zeros((max(plan.effects.shape[0], 1), 4), dtype=np.int64)
    by_group = np.zeros((plan.groups.shape[0], 3), dtype=np.int64)
    for i, row in plan.row_of.items():
        by_effect[row, 3] = model.effects[i].factor is not None
    kept: list[Any] = []
    rows = []
    room = plan.effects.shape[0]
    for name in parameters:
        if name not in known:
            raise InputError(f"sensitivity: no parameter '{name}'{nearest(name, known)}")
        if name in ("mass", "pull_stiffness"):
            rows.append((tangent_step.OF_MASS if name == "mass" else tangent_step.OF_STIFFNESS, -1, -1, 0, 0))
            continue
        owner, _, parameter = name.rpartition(".")
        i = model.names.index(owner)
        effect = model.effects[i]
        if parameter == "memory_length" and plan.head > 2:
            # It is no part of a law, but of the age that the axis carries for all of them.
            if math.isfinite(plan.memory_length) and i == _first_with_memory(model):
                rows.append((tangent_step.OF_MEMORY_LENGTH, -1, -1, 0, 0))
                continue
            raise InputError(f"sensitivity: '{name}' is not the memory length in use")
        own = [p.name for p in effect.parameters]
        row, group = plan.row_of.get(i, -1), plan.group_of.get(i, -1)
        if row >= 0 and by_effect[row, 0] == 0:
            kernel = parameter_kernels.effect_by_parameter(effect)
            kept.append(kernel)
            by_effect[row, :2] = kernel.address, room
            room += 3 * len(own)
        if group >= 0 and by_group[group, 0] == 0:
            kernel = parameter_kernels.core_by_parameter(effect)
            kept.append(kernel)
            by_group[group, :2] = kernel.address, room
            room += 2 * int(plan.groups[group, 3]) * len(own)
        if row >= 0:
            by_effect[row, 2] |= 1 << own.index(parameter)
        if group >= 0:
            by_group[group, 2] |= 1 << own.index(parameter)
        rows.append((tangent_step.OF_EFFECT, row, group, own.index(parameter), len(own)))
    size, q = plan.head + plan.elements, len(rows)
    derived = np.zeros(max(room, 1))
    return (
        np.array(rows, dtype=np.int64).reshape(-1, 5), by_effect, by_group, derived,
        np.zeros((q, size)), np.zeros((q, tangent_step.STAGES, size)), np.zeros((q, 4)), np.zeros(size),
        np.zeros((q, size)), np.empty((2, q, count)),
    ), kept  # fmt: skip
