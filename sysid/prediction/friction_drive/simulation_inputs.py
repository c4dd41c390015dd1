"""Inputs of the simulations of a driven stage: tip motion, friction limits, velocity tables, stage and nudging.

    friction limit = limit(t) factor(side, s) + factor(t) extra limit(side, s),    other force = force(side, s)

at a speed s = |v| and a side, the sign of the velocity. Laws that depend on the velocity are tabulated, and looked up
at the simulated velocity: a measured one would smooth what happens within a few rows, a slip or a reversal.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.library.effect import Axis, Effect
from sysid.prediction.effect_terms import Values, values_of

TABLE_SIZE = 400
"""Speeds of a velocity table; they grow with the square of their index, so that they are dense near zero."""

VELOCITY_COORDINATES = ("velocity", "direction")
"""Coordinates of the laws that a velocity table takes."""

MOST_PHASE = 30.0
"""rad of the oscillation on the contact in a row, at the most: faster ones have decayed by the next row."""


class VelocityTable(NamedTuple):
    """Velocity-dependent laws of one contact.

    Args:
        values: factor, extra limit (N) and other force (N), each forward and backward, (6, k); (6, 0) for none.
        top: speed of the last value, m/s; beyond it that value holds.
    """

    values: np.ndarray
    top: float


NO_TABLE = VelocityTable(np.empty((6, 0)), 1.0)


class FrictionLimit(NamedTuple):
    """Friction limit of a contact along a record.

    Args:
        at_rest: limit (n,), N, before its dependence on velocity.
        factor: multiplies the extra limits of the table, (n,).
        table: dependence on velocity.
    """

    at_rest: np.ndarray
    factor: np.ndarray
    table: VelocityTable = NO_TABLE


def velocity_independent(limit: np.ndarray) -> FrictionLimit:
    """A friction limit (n,), N, that does not depend on velocity."""
    return FrictionLimit(limit, np.ones(limit.size), NO_TABLE)


class TipMotion(NamedTuple):
    """Motion of the tip along the axis (n,), m, and load of the contact over its mean (n,); above zero it touches."""

    along: np.ndarray
    load: np.ndarray


class DrivenStage(NamedTuple):
    """Contact stiffness, N/m, and damping, N s/m, moving mass, kg, and sampling time of the record, s."""

    stiffness: float
    damping: float
    mass: float
    step: float


class Nudging(NamedTuple):
    """Correction of the simulated state towards a measured position (n,), m, after every row.

    With the gains a and a^2 / (2 - a) of an alpha-beta filter (Kalata, IEEE Trans. AES-20 (1984) 174).
    """

    measured: np.ndarray
    position_gain: float
    velocity_gain: float


def resolved_stage(stage: DrivenStage, guide: float = 0.0) -> DrivenStage:
    """The stage with mass and damping for which its oscillation on the contact is resolved by the rows.

    A slow record would be simulated through oscillations that have decayed long before the next row. A heavier stage,
    with the same damping ratio, oscillates five times a row in their place; its lag is 1 % at the highest frequency
    that rows can show, and falls with the square of the frequency.

    Args:
        stage: with its own mass and damping.
        guide: further stiffness, N/m.
    """
    frequency = np.sqrt((stage.stiffness + guide) / stage.mass)
    heavier = max(frequency * stage.step / MOST_PHASE, 1.0) ** 2
    return stage._replace(mass=heavier * stage.mass, damping=np.sqrt(heavier) * stage.damping)


def depends_on_velocity_only(effect: Effect) -> bool:
    """Whether a friction law depends on the velocity or its sign, and on nothing else that changes."""
    has_law = effect.level is not None or effect.factor is not None or effect.force is not None
    read = set(effect.coordinates)
    stateless = effect.friction_state is None and effect.memory is None
    return has_law and stateless and bool(read) and read <= set(VELOCITY_COORDINATES)


def velocity_table(effects: Sequence[Effect], values: Values, axis: Axis, top: float) -> VelocityTable:
    """The table of effects that depend on the velocity only, up to the speed `top`, m/s.

    Args:
        effects: of one contact.
        values: of their parameters.
        axis: of the record; its means replace the other quantities of a law.
        top: m/s.
    """
    if not effects:
        return NO_TABLE
    speed = top * np.linspace(0.0, 1.0, TABLE_SIZE) ** 2
    out = np.zeros((6, TABLE_SIZE))
    for row, side in enumerate((1.0, -1.0)):
        at: Any = Axis(*[np.full(TABLE_SIZE, float(np.mean(quantity))) for quantity in axis])
        at = at._replace(velocity=side * speed, direction=np.full(TABLE_SIZE, side))
        factor: Any = 1.0
        for effect in effects:
            p = values_of(effect, values)
            if effect.factor is not None:
                factor = factor * effect.factor(at, p)
            if effect.level is not None:
                out[2 + row] += effect.level(at, p)
            if effect.force is not None:
                out[4 + row] += effect.force(at, p)
        out[row] = factor
        out[2 + row] *= factor
    return VelocityTable(out, top)
