"""Initial state of a friction state model, from the force in an initial stick phase of the record."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.library.effect import Axis, Effect
from sysid.prediction.force_balance.record import ForceBalanceRecord

LEAST_INITIAL_ROWS = 3
"""Least number of rows of an initial stick phase."""

BISECTIONS = 40
"""Steps of the bisection for the preceding motion."""


def initial_stick_rows(balance: ForceBalanceRecord) -> int:
    """Rows before the first motion of a velocity drive; 0 where it begins in motion, and on other kinds of rig."""
    if balance.kind != "velocity-drive":
        return 0
    position = balance.axis.position
    moved = np.abs(position - position[0]) > balance.stretch
    rows = int(np.argmax(moved)) if moved.any() else position.size
    return rows if rows >= LEAST_INITIAL_ROWS else 0


def friction_from_initial_state(
    balance: ForceBalanceRecord, core: Effect, axis: Axis, level: np.ndarray, p: Any, other: np.ndarray
) -> np.ndarray:
    """Force of a friction state model along a record (n,), N, from its initial state in the first stick phase.

    The state follows from the force measured before the first motion. A motion that leads to it is put before the
    record: in one direction until everything slips, beyond the initial position, and back to it.

    Args:
        balance: the record.
        core: the effect with the friction state model.
        axis: after the effects with memory.
        level: friction level, N, (n,).
        p: its parameter values.
        other: other forces, N, (n,).
    """
    assert core.friction_state is not None
    rows = initial_stick_rows(balance)
    if rows == 0:
        return core.friction_state.along_record(axis.position, axis.velocity, axis.time, level, p)
    wanted = float(np.median(balance.measured[balance.force_channel][:rows] - other[:rows]))
    before = _initial_motion(core, p, float(level[0]), wanted, float(np.ptp(axis.position)))
    count = before.size
    time = np.concatenate([axis.time[0] + balance.step * np.arange(-count, 0), axis.time])
    position = np.concatenate([axis.position[0] + before, axis.position])
    velocity = np.concatenate([np.gradient(before, balance.step), axis.velocity])
    levels = np.concatenate([np.full(count, level[0]), level])
    return core.friction_state.along_record(position, velocity, time, levels, p)[count:]


def _initial_motion(core: Effect, p: Any, level: float, wanted: float, span: float) -> np.ndarray:
    """Positions (k,) before the first one, m, relative to it, after which the force is `wanted`, N, or close to it."""
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
    # The force at rest falls as the reversal lies further beyond the initial position.
    low, high = 1e-12 * far, far
    for _ in range(BISECTIONS):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if force(middle) > abs(wanted) else (low, middle)
    return side * np.array([-far, high])
