"""Where a rigid tip on piezos is."""

from __future__ import annotations

from typing import Any

import numpy as np


def tip_position(first: Any, second: Any, piezo_spacing: float, tip_height: float) -> tuple[Any, Any]:
    """Position of a rigid tip on two piezos, exactly.

        tip = [0, d1] + 1/2 [D, d2 - d1] + h n,    n the unit normal of the line through the piezos' ends

    To first order x = D/2 - h (d2 - d1)/D, y = (d1 + d2)/2 + h.

    Args:
        first, second: extensions d1, d2 of the piezos, m, of any shape.
        piezo_spacing: D, m.
        tip_height: h, m.

    Returns:
        x and y from the foot of the first piezo, m.

    Source: thesis (4.1)-(4.3), with the unit normal that (4.2) leaves out (it lacks the factor h/D, and its listing
    has the mirror image in x).
    """
    rise = np.asarray(second, dtype=float) - np.asarray(first, dtype=float)
    length = np.hypot(piezo_spacing, rise)
    x = 0.5 * piezo_spacing - tip_height * rise / length
    y = 0.5 * (np.asarray(first, dtype=float) + second) + tip_height * piezo_spacing / length
    return x, y
