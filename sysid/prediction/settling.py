"""Rows at the start of a record whose prediction depends on a state that was not recorded.

Stretched bristles, plays and creep begin in a state that the motion before the first row has left. It is forgotten once
the motion has reversed, or once a driven mass has slid, which takes it far beyond the stretch of bristles. These rows
are left out of every comparison, the same for all models.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sysid.prediction.model import PreparedRecord

LONGEST_START = 0.1
"""Largest part of a record that is left out."""


def settled_rows(record: PreparedRecord) -> np.ndarray:
    """Rows (n,) from the first one whose prediction does not depend on the state at the start; at most a tenth of the
    rows is left out."""
    return np.arange(record.size) >= min(record.settled_from, int(LONGEST_START * record.size))


def without_start(record: PreparedRecord) -> PreparedRecord:
    """The record whose start is not scored."""
    rows = settled_rows(record)
    valid = {channel: scored & rows for channel, scored in record.valid.items()}
    phases = record.stick_phases
    if phases is None:
        return replace(record, valid=valid)
    phases = replace(phases, scored=phases.scored & rows)
    return replace(record, valid=valid, stick_phases=replace(phases, displacement=phases.centred(phases.displacement)))
