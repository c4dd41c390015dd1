"""How fast a tip slides over its stage, before anything is fitted: the size of what goes by that speed."""

from __future__ import annotations

import numpy as np

from sysid.prediction.friction_drive.record import FrictionDriveRecord

LEANS = 0.02
"""Part of the quickest lean from which a row tells how far the stage goes with the tip."""


def sliding_speed(record: FrictionDriveRecord) -> float:
    """Largest speed of the tip over the stage, m/s, from above: both at their quickest, against each other.

    While the contact sticks, in most rows, the stage goes as fast as the tip: the median of its speed over that of the
    lean, in volts, is the gain.
    """
    lean = record.lever * np.abs(np.diff(record.drives[1] - record.drives[0])) / record.step
    quickest = float(np.max(lean))
    speed = np.abs(record.axis.velocity)
    if quickest == 0.0:
        return float(np.max(speed))
    leans = lean > LEANS * quickest
    gain = float(np.median(speed[1:][leans] / lean[leans]))
    return gain * quickest + float(np.max(speed))
