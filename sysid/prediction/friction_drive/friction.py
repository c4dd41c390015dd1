"""Friction of a driven stage: friction limits of its pads and of the contact with the tip, and their other forces.

Limits depend on position, load, distance and time at rest as measured; laws that depend on the velocity only are
tabulated, and looked up at the simulated velocity. The velocity of the contact's friction is that of the tip over the
stage.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.effects.catalogue import Model
from sim.effects.effect import Axis, Effect
from sim.integration.friction_drive.inputs import FrictionLimit, TipMotion, VelocityTable, velocity_independent
from sim.integration.friction_drive.midpoint import NO_BRISTLES
from sim.numerics.elasto_plastic import Elements
from stagecad.parameters.errors import InputError
from sysid.prediction.effect_terms import Values, axis_force, friction_level, kept_term, values_of
from sysid.prediction.force_balance.record import ForceBalanceRecord, make_axis, rest_age
from sysid.signals import GaussianFilter

CONTACT = "contact."
PREFILTER_STEPS = 4.0
"""Width in steps of the filter of the measured motion along which friction limits are evaluated."""
TABLE_SIZE = 400
"""Speeds of a velocity table; they grow with the square of their index, so that they are dense near zero."""
VELOCITY_COORDINATES = ("velocity", "direction")
"""Coordinates of the laws that a velocity table represents."""


class Friction(NamedTuple):
    """Friction limit of a contact, and its other forces on the stage (n,), N."""

    limit: FrictionLimit
    push: np.ndarray


def pad_friction(
    record: ForceBalanceRecord, effects: Sequence[Effect], values: Values, top: float | None = None
) -> Friction:
    """Friction of the pads, with a velocity table up to the speed `top`, m/s; none: along the measured motion."""
    tabulates = top is not None and all(effect.memory is None for effect in effects)
    tabulated = [effect for effect in effects if tabulates and depends_on_velocity_only(effect)]
    rest = [effect for effect in effects if effect not in tabulated]
    limit = np.zeros(record.size)
    if friction_state_of(rest) is not None:
        limit = limit + friction_level(record, rest, values)
    push = -axis_force(record, rest, values)
    return Friction(_with_table(limit, _model(rest, values), _model(tabulated, values), record.axis, top), push)


def contact_friction(
    record: ForceBalanceRecord, effects: Sequence[Effect], values: Values, tip: TipMotion, top: float | None = None
) -> Friction:
    """Friction between tip and stage while they touch, infinite where it never slips; `top` as in `pad_friction`."""
    if friction_state_of(effects) is None:
        return Friction(velocity_independent(np.full(record.size, np.inf)), np.zeros(record.size))
    tabulated = [effect for effect in effects if top is not None and depends_on_velocity_only(effect)]
    rest = [effect for effect in effects if effect not in tabulated]
    load = float(np.mean(record.axis.load)) * np.maximum(tip.load, 0.0)
    # The level of a friction state model is constant.
    moving = any(e.friction_state is None and set(e.coordinates) != {"normal_load"} for e in rest)
    axis = _contact_axis(record, tip.along, load) if moving else record.axis._replace(load=load)
    model = _model(rest, values)
    limit = np.maximum(model.level(axis), 0.0)
    push = np.where(tip.load > 0.0, model.other_force(axis), 0.0)
    return Friction(_with_table(limit, model, _model(tabulated, values), axis, top), push)


def _model(effects: Sequence[Effect], values: Values) -> Model:
    return Model(tuple(effects), tuple(values_of(effect, values) for effect in effects))


def depends_on_velocity_only(effect: Effect) -> bool:
    """Whether a friction law depends on the velocity or its sign, and on nothing else that changes."""
    has_law = effect.level is not None or effect.factor is not None or effect.force is not None
    read = set(effect.coordinates)
    stateless = effect.friction_state is None and effect.memory is None
    return has_law and stateless and bool(read) and read <= set(VELOCITY_COORDINATES)


def _with_table(limit: np.ndarray, rest: Model, tabulated: Model, axis: Axis, top: float | None) -> FrictionLimit:
    """A friction limit (n,), N, with the velocity table of the laws `tabulated` up to the speed `top`, m/s."""
    if not tabulated.effects or top is None:
        return velocity_independent(limit)
    speed, zero = top * np.linspace(0.0, 1.0, TABLE_SIZE) ** 2, np.zeros(TABLE_SIZE)
    both_ways = [
        Axis(*[zero] * len(Axis._fields))._replace(velocity=side * speed, direction=zero + side) for side in (1.0, -1.0)
    ]
    laws = tabulated.factor, tabulated.level, tabulated.other_force
    rows = np.array([law(at) for law in laws for at in both_ways])
    return FrictionLimit(limit, rest.factor(axis), VelocityTable(rows, top))


def friction_state_of(effects: Sequence[Effect]) -> Effect | None:
    """The effect with the friction state model, which turns a friction level into a force, if there is one."""
    return next((e for e in effects if e.friction_state is not None), None)


def bristles_of(effect: Effect | None, values: Values) -> Elements:
    """The elements of a friction state model; none for `coulomb`."""
    if effect is None or not effect.has_presliding:
        return NO_BRISTLES
    if effect.friction_state.springs is not None:
        return effect.friction_state.springs(values_of(effect, values))
    raise InputError(
        f"model.effects: '{effect.name}' cannot be used on a friction-drive; allowed: 'coulomb' and 'presliding'"
    )


def _contact_axis(record: ForceBalanceRecord, along: np.ndarray, load: np.ndarray) -> Axis:
    """The axis of the contact: the tip's motion over the measured one of the stage, both with the same filter."""

    def computed() -> Axis:
        prefilter = GaussianFilter(PREFILTER_STEPS * record.step, record.step, record.size)
        velocity = prefilter(along, 1) - record.axis.velocity
        acceleration = np.gradient(velocity, record.step)
        rest = 1e-3 * float(np.max(np.abs(velocity))) + 1e-300
        axis = record.axis
        return make_axis(axis.time, along - axis.position, velocity, acceleration, load, axis.temperature, rest)

    return kept_term(record, ("contact axis", along.tobytes(), load.tobytes()), computed)


def simulated_axis(axis: Axis, position: np.ndarray, step: float) -> Axis:
    """The axis along the simulated motion, for what a measured motion blurs.

    A measured motion comes to rest some rows late, and creeps by its noise. A friction level that grows at rest and
    fades over a tenth of a micrometre is evaluated along the simulated motion once there is one, and the simulation is
    repeated. Levels that depend on the velocity history are not: there the iteration does not converge.
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
