"""Terms of a model along a prepared record: friction level, and forces other than the friction."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from sim.effects.effect import Axis, Backlash, Effect
from sysid.prediction.force_balance.record import ForceBalanceRecord

Values = Mapping[str, float]
"""Parameter values by key, `effect.parameter`, and the rig's own (`rig.mass`, `rig.gain`, `rig.offset_tip_x`)."""


def split_channel(name: str) -> tuple[str, str | None]:
    """`sensor_lag@position` -> (`sensor_lag`, `position`); (name, None) without a channel."""
    base, _, channel = name.partition("@")
    return base, channel or None


def values_of(effect: Effect, values: Values) -> Any:
    """The effect's parameter values as the named tuple its laws take."""
    return effect.values_type(*[values[f"{effect.name}.{p.name}"] for p in effect.parameters])


MOST_TERMS = 160
"""Terms that are kept of a record."""
_terms: WeakKeyDictionary[Any, dict[tuple[object, ...], Any]] = WeakKeyDictionary()


def kept_term(record: object, key: tuple[object, ...], compute: Callable[[], Any]) -> Any:
    """The term of an effect along a record under `key`, of effect and values, computed where it is not known yet.

    A fit evaluates a model many times with one parameter moved: the terms of all other effects stay the same. The terms
    of a record are dropped with the record, or when there are more than `MOST_TERMS` of them.
    """
    terms = _terms.setdefault(record, {})
    if key not in terms:
        if len(terms) >= MOST_TERMS:
            terms.clear()
        terms[key] = compute()
    return terms[key]


def friction_axis(
    balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values
) -> tuple[Axis, tuple[object, ...]]:
    """The axis as level and core see it, after the effects with memory, and a key that names it.

    The position of a pulled or driven body is measured on the body: what lies between it and the drive does not change
    it.
    """
    axis, key = balance.axis, ()
    for effect in effects:
        if effect.memory is not None and (not effect.opens_gap or balance.acceleration is None):
            p = values_of(effect, values)
            key = (*key, effect.name, p)
            axis = kept_term(balance, ("axis", key), partial(effect.memory, axis, p))
    return axis, key


def lost_motion(effects: Sequence[Effect], values: Values) -> float:
    """Full width of the gap between the drive and the axis, m."""
    realised = [e.time_domain(values_of(e, values)) for e in effects if e.acts_on == "structure" and e.time_domain]
    return sum(found.gap for found in realised if isinstance(found, Backlash))


def friction_level(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> np.ndarray | float:
    """Friction level (n,), N: the sum of every `level` times the product of every `factor`, never below zero."""
    axis, key = friction_axis(balance, effects, values)
    total: Any = 0.0
    factor: Any = 1.0
    for effect in effects:
        if effect.level is not None:
            p = values_of(effect, values)
            total = total + kept_term(balance, ("level", effect.name, p, key), partial(effect.level, axis, p))
        if effect.factor is not None:
            p = values_of(effect, values)
            factor = factor * kept_term(balance, ("factor", effect.name, p, key), partial(effect.factor, axis, p))
    return np.maximum(total * factor, 0.0)


def axis_force(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> np.ndarray:
    """Sum (n,) of the forces that act on the axis in addition to the core, N."""
    total = np.zeros(balance.size)
    # A body behind a gap rests while that is crossed.
    axis, key = friction_axis(balance, [effect for effect in effects if effect.acts_on == "structure"], values)
    for effect in effects:
        if effect.force is not None:
            p = values_of(effect, values)
            total = total + kept_term(balance, ("force", effect.name, p, key), partial(effect.force, axis, p))
        if effect.is_mode and effect.signal is not None and balance.acceleration is not None:
            # The mass of a mode exerts its force also while friction holds the body: an external force.
            p = values_of(effect, values)
            own = balance.axis.acceleration
            ride = partial(effect.signal, np.ascontiguousarray(own), balance.step, p)
            ridden = kept_term(balance, ("ride", effect.name, p[:2]), ride)
            total = total + values.get("rig.mass", 0.0) * getattr(p, "mass_ratio", 1.0) * (ridden - own)
    return total
