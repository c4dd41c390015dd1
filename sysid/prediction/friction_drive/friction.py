"""Friction of a driven stage: friction limits of its pads and of the contact with the tip, and their other forces.

Limits depend on position, load, distance and time at rest as measured; laws that depend on the velocity only are
tabulated, and looked up at the simulated velocity. The velocity of the contact's friction is that of the tip over the
stage.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.library.effect import Axis, Effect
from stagecad.parameters.errors import InputError
from sysid.prediction.effect_terms import TERMS, Values, axis_force, friction_level, values_of
from sysid.prediction.force_balance.record import ForceBalanceRecord, make_axis, rest_age
from sysid.prediction.friction_drive.midpoint import NO_BRISTLES
from sysid.prediction.friction_drive.simulation_inputs import (
    FrictionLimit,
    TipMotion,
    depends_on_velocity_only,
    velocity_independent,
    velocity_table,
)
from sysid.signals.gaussian_filter import GaussianFilter

CONTACT = "contact."
PREFILTER_STEPS = 4.0
"""Width in steps of the filter of the measured motion along which friction limits are evaluated."""
LOAD_ONLY = ("coulomb", "presliding", "load_dependent_friction")
"""Contact effects that do not depend on the motion of the tip over the stage."""


class Friction(NamedTuple):
    """Friction limit of a contact, and its other forces on the stage (n,), N."""

    limit: FrictionLimit
    push: np.ndarray


def pad_friction(record: ForceBalanceRecord, effects: Sequence[Effect], values: Values, top: float) -> Friction:
    """Friction of the pads, up to the speed `top`, m/s."""
    tabulated = []
    if all(effect.memory is None for effect in effects):
        tabulated = [effect for effect in effects if depends_on_velocity_only(effect)]
    rest = [effect for effect in effects if effect not in tabulated]
    limit = np.zeros(record.size)
    if friction_state_of(rest) is not None:
        limit = limit + friction_level(record, rest, values)
    factor = _product_of_factors(rest, values, record.axis) if tabulated else np.ones(record.size)
    table = velocity_table(tabulated, values, record.axis, top)
    return Friction(FrictionLimit(limit, factor, table), -axis_force(record, rest, values))


def contact_friction(
    record: ForceBalanceRecord, effects: Sequence[Effect], values: Values, tip: TipMotion, top: float
) -> Friction:
    """Friction between tip and stage, up to the speed `top`, m/s."""
    tabulated = []
    if friction_state_of(effects) is not None:
        tabulated = [effect for effect in effects if depends_on_velocity_only(effect)]
    rest = [effect for effect in effects if effect not in tabulated]
    limit, push = contact_limit(record, rest, values, tip)
    if not tabulated:
        return Friction(velocity_independent(limit), push)
    axis = record.axis._replace(load=_contact_load(record, tip.load))
    factor = _product_of_factors(rest, values, axis)
    return Friction(FrictionLimit(limit, factor, velocity_table(tabulated, values, axis, top)), push)


def _product_of_factors(effects: Sequence[Effect], values: Values, axis: Axis) -> np.ndarray:
    factor = np.ones(axis.time.size)
    for effect in effects:
        if effect.factor is not None:
            factor = factor * effect.factor(axis, values_of(effect, values))
    return factor


def friction_state_of(effects: Sequence[Effect]) -> Effect | None:
    """The effect with the friction state model, which turns a friction level into a force, if there is one."""
    return next((e for e in effects if e.friction_state is not None), None)


def bristles_of(effect: Effect | None, values: Values) -> tuple[np.ndarray, np.ndarray]:
    """Stretches at which the bristles of a friction state model yield, m, and their weights; none for `coulomb`.

    Raises:
        InputError: a model whose bristles do not yield at a stretch of their own.
    """
    if effect is None or effect.friction_state.name == "coulomb":
        return NO_BRISTLES, NO_BRISTLES
    if effect.friction_state.springs is not None:
        return effect.friction_state.springs(values_of(effect, values))
    raise InputError(
        f"model.effects: '{effect.name}' cannot be used on a friction-drive; allowed: 'coulomb' and 'presliding'"
    )


def contact_limit(
    record: ForceBalanceRecord, effects: Sequence[Effect], values: Values, tip: TipMotion
) -> tuple[np.ndarray, np.ndarray]:
    """Friction limit of the contact while it touches (n,), N, infinite where it never slips, and its other forces on
    the stage (n,), N."""
    push = np.zeros(record.size)
    if friction_state_of(effects) is None:
        return np.full(record.size, np.inf), push
    load = _contact_load(record, tip.load)
    moving = any(e.name.removeprefix(CONTACT) not in LOAD_ONLY for e in effects)
    axis = _contact_axis(record, tip.along, load) if moving else record.axis._replace(load=load)
    total: Any = 0.0
    factor: Any = 1.0
    for effect in effects:
        p = values_of(effect, values)
        if effect.level is not None:
            total = total + effect.level(axis, p)
        if effect.factor is not None:
            factor = factor * effect.factor(axis, p)
        if effect.force is not None:
            push = push + np.where(tip.load > 0.0, effect.force(axis, p), 0.0)
    return np.maximum(total * factor, 0.0), push


def _contact_load(record: ForceBalanceRecord, load: np.ndarray) -> np.ndarray:
    """Load of the contact in units of the pads' recorded load, (n,)."""
    return float(np.mean(record.axis.load)) * np.maximum(load, 0.0)


def _contact_axis(record: ForceBalanceRecord, along: np.ndarray, load: np.ndarray) -> Axis:
    """The axis of the contact: the tip's motion over the measured one of the stage, both with the same filter."""

    def computed() -> Axis:
        prefilter = GaussianFilter(PREFILTER_STEPS * record.step, record.step, record.size)
        velocity = prefilter(along, 1) - record.axis.velocity
        acceleration = np.gradient(velocity, record.step)
        rest = 1e-3 * float(np.max(np.abs(velocity))) + 1e-300
        axis = record.axis
        return make_axis(axis.time, along - axis.position, velocity, acceleration, load, axis.temperature, rest)

    return TERMS.get(record, ("contact axis", along.tobytes(), load.tobytes()), computed)


def depends_on_time_at_rest(effects: Sequence[Effect]) -> bool:
    """Whether some friction level depends on the time at rest."""
    return any(e.level is not None and "contact_age" in e.coordinates for e in effects)


def simulated_axis(axis: Axis, position: np.ndarray, step: float) -> Axis:
    """The axis along the simulated motion, for what a measured motion blurs.

    A measured motion comes to rest some rows late, and creeps by its noise. A friction level that grows at rest and
    fades over a tenth of a micrometre is evaluated along the simulated motion once there is one, and the simulation is
    repeated. Levels that depend on the velocity history are not: there the iteration does not converge.

    Args:
        axis: as measured; its load and temperature stay.
        position: simulated, m from rest at the first row, (n,).
        step: of the record, s.
    """
    gone: Any = np.concatenate([[0.0], np.diff(position)])
    velocity = np.gradient(position, step)
    return axis._replace(
        position=position + axis.position[0],
        velocity=velocity,
        acceleration=np.gradient(velocity, step),
        contact_age=rest_age(axis.time, gone == 0.0),
        travelled=np.cumsum(np.abs(gone)),
    )
