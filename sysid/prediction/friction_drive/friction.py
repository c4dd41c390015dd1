"""What the pads of a driven stage and its contact with the tip hold, and with what other forces they push.

Levels go by position, load, distance and rest as measured; what goes by the speed is made a curve, which the
prediction looks up at its own speed. The contact's friction has the tip's motion over the stage for its motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sim.library.effect import Axis, Effect
from stagecad.parameters.errors import InputError
from sysid.prediction.effect_terms import Values, axis_force, friction_level, remember, values_of
from sysid.prediction.force_balance.record import ForceBalanceRecord, make_axis
from sysid.prediction.friction_drive.velocity_tables import NO_CURVES, Curves, curves_of, depends_on_velocity_only
from sysid.signals.gaussian_filter import GaussianFilter

CONTACT = "contact."
LIGHT = 4.0
"""Width in steps of the filter through which the motion is seen that sets the levels."""
READ_LOAD_ONLY = ("coulomb", "presliding", "load_dependent_friction")
"""Contact effects that read nothing of how tip and stage move over each other."""

Friction = tuple[np.ndarray, np.ndarray, np.ndarray, Curves]
"""Level at rest (n,), N; by what its extra levels are multiplied (n,); other forces on the stage (n,), N; curves."""


def pads_friction(record: ForceBalanceRecord, effects: Sequence[Effect], values: Values, top: float) -> Friction:
    """Friction of the pads, up to the speed `top`, m/s."""
    swift = [] if any(e.memory is not None for e in effects) else [e for e in effects if depends_on_velocity_only(e)]
    rest = [e for e in effects if e not in swift]
    none, one = np.zeros(record.size), np.ones(record.size)
    level = none + friction_level(record, rest, values) if core_of(rest) is not None else none
    share = one
    for effect in rest if swift else []:
        if effect.factor is not None:
            share = share * effect.factor(record.axis, values_of(effect, values))
    return level, share, -axis_force(record, rest, values), curves_of(swift, values, record.axis, top)


def slipping_contact(
    record: ForceBalanceRecord, effects: Sequence[Effect], values: Values, along: np.ndarray, load: np.ndarray, top:
    float
) -> Friction:  # fmt: skip
    """Friction between tip and stage, up to the speed `top`, m/s."""
    swift = [e for e in effects if depends_on_velocity_only(e)] if core_of(effects) is not None else []
    rest = [e for e in effects if e not in swift]
    level, push = contact_level(record, rest, values, along, load)
    if not swift:
        return level, np.ones(record.size), push, NO_CURVES
    axis = record.axis._replace(load=_carried(record, load))
    share = np.ones(record.size)
    for effect in rest:
        if effect.factor is not None:
            share = share * effect.factor(axis, values_of(effect, values))
    return level, share, push, curves_of(swift, values, axis, top)


def core_of(effects: Sequence[Effect]) -> Effect | None:
    """The effect that turns a level into a force, if there is one."""
    return next((e for e in effects if e.friction_state is not None), None)


def bristles_of(core: Effect | None, values: Values) -> tuple[np.ndarray, np.ndarray]:
    """Stretches at which the bristles of a core slip, m, and the parts of the level they carry; none for `coulomb`.

    Raises:
        InputError: a core whose bristles do not yield at a stretch of their own.
    """
    if core is None or core.friction_state.name == "coulomb":
        return np.empty(0), np.empty(0)
    if core.friction_state.springs is not None:
        return core.friction_state.springs(values_of(core, values))
    raise InputError(
        f"model.effects: '{core.name}' cannot be used on a friction-drive; its cores are 'coulomb' and 'presliding'"
    )


def contact_level(
    record: ForceBalanceRecord, effects: Sequence[Effect], values: Values, along: np.ndarray, load: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Most that the contact holds while it touches (n,), N, infinite where it never slips, and what its other forces
    add to the push (n,), N."""
    push = np.zeros(record.size)
    if core_of(effects) is None:
        return np.full(record.size, np.inf), push
    carried = _carried(record, load)
    moving = any(e.name.removeprefix(CONTACT) not in READ_LOAD_ONLY for e in effects)
    axis = _sliding(record, along, carried) if moving else record.axis._replace(load=carried)
    total: Any = 0.0
    factor: Any = 1.0
    for effect in effects:
        p = values_of(effect, values)
        if effect.level is not None:
            total = total + effect.level(axis, p)
        if effect.factor is not None:
            factor = factor * effect.factor(axis, p)
        if effect.force is not None:
            push = push + np.where(load > 0.0, effect.force(axis, p), 0.0)
    return np.maximum(total * factor, 0.0), push


def _carried(record: ForceBalanceRecord, load: np.ndarray) -> np.ndarray:
    """Load of the contact in units of the pads' recorded one, (n,)."""
    return float(np.mean(record.axis.load)) * np.maximum(load, 0.0)


def _sliding(record: ForceBalanceRecord, along: np.ndarray, load: np.ndarray) -> Axis:
    """The contact's own axis: the tip's motion over the stage, under its own load, in units of the pads' recorded one.

    The stage's motion is the measured one, lightly filtered; the tip's is filtered as much.
    """

    def made() -> Axis:
        light = GaussianFilter(LIGHT * record.step, record.step, record.size)
        speed = light(along, 1) - record.axis.velocity
        still = 1e-3 * float(np.max(np.abs(speed))) + 1e-300
        return make_axis(
            record.axis.time, along - record.axis.position, speed, np.gradient(speed, record.step), load,
            record.axis.temperature, still,
        )  # fmt: skip

    return remember(record.memo, ("sliding", along.tobytes(), load.tobytes()), made)
