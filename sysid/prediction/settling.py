"""Rows at the start of a record whose prediction depends on a state that was not recorded.

Stretched bristles, plays and creep begin in a state that the motion before the first row has left. It is forgotten once
the motion has reversed, or once a driven mass has slid, which takes it far beyond the stretch of bristles. These rows
are left out of every comparison, the same for all models.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sysid.prediction.actuator_tip import TipRecord
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.friction_drive.record import FrictionDriveRecord

LONGEST_START = 0.1
"""Largest part of a record that is left out."""

STROKE_START = 0.05
"""Part of its travel that is left out of the record of a driven mass, or of a record without a reversal."""


def settled_rows(record: ForceBalanceRecord | TipRecord) -> np.ndarray:
    """Rows (n,) after the first reversal of the motion, or of every voltage of a tip; all rows of a stage that is
    simulated from rest.

    A driven mass and a record of one stroke are scored after a part of their travel at the latest. At most a tenth of
    the rows is left out.
    """
    if isinstance(record, FrictionDriveRecord):
        first = 0
    elif isinstance(record, TipRecord):
        first = max((_first_turn(drive) for drive in record.drives), default=0)
    else:
        turns = np.flatnonzero(np.diff(record.axis.direction))
        slid = int(np.searchsorted(record.axis.travelled, STROKE_START * np.ptp(record.axis.position)))
        first = int(turns[0]) + 1 if turns.size else slid
        first = min(first, slid) if record.stick_fraction is not None else first
    return np.arange(record.size) >= min(first, int(LONGEST_START * record.size))


def _first_turn(drive: np.ndarray) -> int:
    """First row at which a signal (n,) changes its direction; its size where it does not."""
    changes = np.flatnonzero(np.diff(drive))
    signs = np.sign(np.diff(drive)[changes])
    turns = np.flatnonzero(signs[1:] != signs[:-1])
    return int(changes[turns[0] + 1]) if turns.size else (0 if changes.size == 0 else drive.size)


def without_start(record: ForceBalanceRecord | TipRecord) -> ForceBalanceRecord | TipRecord:
    """The record whose start is not scored."""
    rows = settled_rows(record)
    valid = {channel: scored & rows for channel, scored in record.valid.items()}
    phases = record.stick_phases if isinstance(record, ForceBalanceRecord) else None
    if phases is None:
        return replace(record, valid=valid)
    phases = replace(phases, scored=phases.scored & rows)
    return replace(record, valid=valid, stick_phases=replace(phases, displacement=phases.centred(phases.displacement)))
