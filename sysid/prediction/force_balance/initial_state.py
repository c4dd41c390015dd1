"""Initial state of a friction state model, from the force in the first rows of a record."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import root_scalar

from sim.effects.effect import Axis, Effect
from sysid.prediction.force_balance.record import ForceBalanceRecord

FIRST_ROWS = 50
"""Rows, filter widths apart, over which the first force is averaged where the record does not begin at rest."""

MOST_ROWS = 400
"""Largest number of rows up to the end of those, as their path is evaluated at every step of the search."""

ACCURACY = 1e-8
"""Relative accuracy of the preceding motion: its error is far below the steps of numerical derivatives."""


def first_rows(balance: ForceBalanceRecord) -> slice:
    """Rows in which the first force is measured: an initial rest, or the first scored rows."""
    valid = balance.valid[balance.force_channel]
    begin = int(np.argmax(valid))
    position = balance.axis.position[begin : begin + MOST_ROWS]
    moved = np.abs(position - position[0]) > balance.stretch
    rest = int(np.argmax(moved)) if moved.any() else position.size
    apart = 1 if balance.full_filter is None else int(np.ceil(balance.full_filter.width / balance.step))
    return slice(begin, min(begin + max(rest, FIRST_ROWS * apart), balance.size, MOST_ROWS))


def friction_from_initial_state(
    balance: ForceBalanceRecord, core: Effect, axis: Axis, level: np.ndarray, p: Any, other: np.ndarray
) -> np.ndarray:
    """Force of a friction state model along a record (n,), N, from its initial state.

    The state follows from the force measured in the first rows. A motion that leads to it is put before the record: in
    one direction until everything slips, beyond the initial position, and back to it.
    """
    assert core.friction_state is not None
    along, rows = core.friction_state.along_record, first_rows(balance)
    if rows.stop <= rows.start:
        return along(axis.position, axis.velocity, axis.time, level, p)
    measured = balance.inputs.get("spring_force", balance.measured[balance.force_channel])
    wanted = measured[rows] - other[rows]

    side = 1.0 if _median(wanted) >= 0.0 else -1.0
    far = 1e3 * max(float(np.ptp(axis.position)), 1e-9)

    def with_motion(size: int) -> Callable[[float], np.ndarray]:
        """Force (size,) in the first rows, by the distance of the preceding motion beyond the start, m."""
        count = 3
        position = np.concatenate([np.full(count, axis.position[0]), axis.position[:size]])
        velocity = np.concatenate([np.zeros(count), axis.velocity[:size]])
        time = np.concatenate([axis.time[0] + balance.step * np.arange(-count, 0), axis.time[:size]])
        levels = np.concatenate([np.full(count, level[0]), level[:size]])

        def force(beyond: float) -> np.ndarray:
            motion = side * np.array([-far, beyond, 0.0])
            position[:count] = axis.position[0] + motion
            # Differences over the rows beside each: those of `numpy.gradient`.
            velocity[:count] = (
                np.array([motion[1] - motion[0], 0.5 * (motion[2] - motion[0]), -motion[1]]) / balance.step
            )
            return along(position, velocity, time, levels, p)[count:]

        return force

    first = with_motion(rows.stop)

    def excess(logarithm: float) -> float:
        """Median force above the measured one; it falls as the reversal lies further beyond the initial position."""
        return _median(side * (first(math.exp(logarithm))[rows] - wanted))

    low, high = math.log(1e-9 * far), math.log(far)
    beyond = 0.0
    if _median(side * (first(0.0)[rows] - wanted)) > 0.0:
        if excess(low) <= 0.0:
            beyond = math.exp(low)
        elif excess(high) > 0.0:
            beyond = far
        else:
            beyond = math.exp(root_scalar(excess, bracket=(low, high), xtol=ACCURACY).root)
    return with_motion(axis.time.size)(beyond)


def _median(values: np.ndarray) -> float:
    """Median of finite values (n,): as `numpy.median`, which takes ten times as long for so few."""
    low, high = (values.size - 1) // 2, values.size // 2
    found = np.partition(values, (low, high))
    return 0.5 * float(found[low] + found[high])
