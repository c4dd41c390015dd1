"""Initial state of a friction state model, from the force in the first rows of a record."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.library.effect import Axis, Effect
from sysid.prediction.force_balance.record import ForceBalanceRecord

FIRST_ROWS = 50
"""Rows, filter widths apart, over which the first force is averaged where the record does not begin at rest."""

MOST_ROWS = 400
"""Largest number of rows up to the end of those, as their path is evaluated at every step of the bisection."""

BISECTIONS = 28
"""Steps of the bisection for the preceding motion."""


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

    Args:
        balance: the record.
        core: the effect with the friction state model.
        axis: after the effects with memory.
        level: friction level, N, (n,).
        p: its parameter values.
        other: other forces, inertia included, N, (n,).
    """
    assert core.friction_state is not None
    along, rows = core.friction_state.along_record, first_rows(balance)
    if rows.stop <= rows.start:
        return along(axis.position, axis.velocity, axis.time, level, p)
    measured = balance.inputs.get("spring_force", balance.measured[balance.force_channel])
    wanted = measured[rows] - other[rows]

    def preceded(before: np.ndarray, size: int) -> np.ndarray:
        """Force (size,) in the first rows after a motion `before` them (k,), m from the first position."""
        count = before.size
        return along(
            np.concatenate([axis.position[0] + before, axis.position[:size]]),
            np.concatenate([np.gradient(before, balance.step), axis.velocity[:size]]),
            np.concatenate([axis.time[0] + balance.step * np.arange(-count, 0), axis.time[:size]]),
            np.concatenate([np.full(count, level[0]), level[:size]]),
            p,
        )[count:]

    side = 1.0 if float(np.median(wanted)) >= 0.0 else -1.0
    far = 1e3 * max(float(np.ptp(axis.position)), 1e-9)
    low, high = 1e-9 * far, far

    def motion(beyond: float) -> np.ndarray:
        return side * np.array([-far, beyond, 0.0])

    def too_high(beyond: float) -> bool:
        return float(np.median(side * (preceded(motion(beyond), rows.stop)[rows] - wanted))) > 0.0

    # The force falls as the reversal lies further beyond the initial position.
    if too_high(0.0):
        for _ in range(BISECTIONS):
            middle = float(np.sqrt(low * high))
            low, high = (middle, high) if too_high(middle) else (low, middle)
        return preceded(motion(high), axis.time.size)
    return preceded(motion(0.0), axis.time.size)
