"""Inputs of the simulations of a driven stage: tip motion, friction limits, velocity tables, stage and nudging.

    friction limit = limit(t) factor(side, s) + factor(t) extra limit(side, s),    other force = force(side, s)

at a speed s = |v| and a side, the sign of the velocity. Laws that depend on the velocity are tabulated, and looked up
at the simulated velocity: a measured one would smooth what happens within a few rows, a slip or a reversal.
"""

from typing import NamedTuple

import numpy as np

MOST_PHASE = 30.0
"""rad of the oscillation on the contact in a row, at the most: faster ones have decayed by the next row."""


class VelocityTable(NamedTuple):
    """Velocity-dependent laws of one contact."""

    # factor, extra limit (N) and other force (N), each forward and backward, at speeds that grow with the square of
    # their index, (6, k); (6, 0) for none
    values: np.ndarray
    top: float  # speed of the last value, m/s; beyond it that value holds


NO_TABLE = VelocityTable(np.empty((6, 0)), 1.0)


class FrictionLimit(NamedTuple):
    """Friction limit of a contact along a record."""

    at_rest: np.ndarray  # limit (n,), N, before its dependence on velocity
    factor: np.ndarray  # multiplies the extra limits of the table, (n,)
    table: VelocityTable = NO_TABLE  # dependence on velocity


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
    """The stage with mass and damping for which its oscillation on the contact is resolved by the rows; `guide`:
    further stiffness, N/m.

    A slow record would be simulated through oscillations that have decayed long before the next row. A heavier stage,
    with the same damping ratio, oscillates five times a row in their place; its lag is 1 % at the highest frequency
    that rows can show, and falls with the square of the frequency.
    """
    frequency = np.sqrt((stage.stiffness + guide) / stage.mass)
    heavier = max(frequency * stage.step / MOST_PHASE, 1.0) ** 2
    return stage._replace(mass=heavier * stage.mass, damping=np.sqrt(heavier) * stage.damping)
