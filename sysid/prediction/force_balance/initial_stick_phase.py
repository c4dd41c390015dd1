"""A record that begins at rest, its contact still loaded by the motion before: bristles begin stretched.

How far is read off the force that is measured while nothing moves yet. The motion that left it so is put before the
record: far enough one way that everything slips, on past the place of rest, and back to it until the force is right.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.library.effect import Axis, Effect
from sysid.prediction.force_balance.record import ForceBalanceRecord

LEAST_ROWS = 3
"""Rows at rest from which a record is said to begin there."""

HALVINGS = 40


def rest_rows(balance: ForceBalanceRecord) -> int:
    """Rows before the first motion of a velocity drive; 0 where it begins in motion, or another kind of rig."""
    if balance.kind != "velocity-drive":
        return 0
    position = balance.axis.position
    moved = np.abs(position - position[0]) > balance.stretch
    rows = int(np.argmax(moved)) if moved.any() else position.size
    return rows if rows >= LEAST_ROWS else 0


def along_from_rest(
    balance: ForceBalanceRecord, core: Effect, axis: Axis, level: np.ndarray, p: Any, other: np.ndarray
) -> np.ndarray:
    """Force of a core along a record (n,), from the stretch that its first rest shows.

    Args:
        balance: the record.
        core: the effect with the core.
        axis: as level and core see it.
        level: friction level, N, (n,).
        p: values of the core.
        other: forces beside the core, N, (n,).
    """
    assert core.friction_state is not None
    rows = rest_rows(balance)
    if rows == 0:
        return core.friction_state.along_record(axis.position, axis.velocity, axis.time, level, p)
    wanted = float(np.median(balance.measured[balance.force_channel][:rows] - other[:rows]))
    before = _way_there(core, p, float(level[0]), wanted, float(np.ptp(axis.position)))
    count = before.size
    time = np.concatenate([axis.time[0] + balance.step * np.arange(-count, 0), axis.time])
    position = np.concatenate([axis.position[0] + before, axis.position])
    velocity = np.concatenate([np.gradient(before, balance.step), axis.velocity])
    levels = np.concatenate([np.full(count, level[0]), level])
    return core.friction_state.along_record(position, velocity, time, levels, p)[count:]


def _way_there(core: Effect, p: Any, level: float, wanted: float, span: float) -> np.ndarray:
    """Places (k,) before the first one, relative to it, that leave the core with the force `wanted`, or near it."""
    along = core.friction_state.along_record if core.friction_state is not None else None
    assert along is not None
    side = 1.0 if wanted >= 0.0 else -1.0
    far = 1e3 * max(span, 1e-9)

    def force(beyond: float) -> float:
        path = side * np.array([-far, beyond, 0.0])
        still = np.zeros(3)
        return side * float(along(path, still, np.arange(3.0), np.full(3, level), p)[-1])

    if abs(wanted) >= force(0.0) or level <= 0.0:
        return side * np.array([-far, 0.0])
    # The force at rest falls as the contact came back from further beyond.
    low, high = 1e-12 * far, far
    for _ in range(HALVINGS):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if force(middle) > abs(wanted) else (low, middle)
    return side * np.array([-far, high])
