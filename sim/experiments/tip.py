"""The actuator's tip: two piezos out of phase draw an ellipse (thesis 4.1, Figure 34)."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError, require

FREQUENCY = math.pi
"""rad/s, of the listing; the path does not depend on it."""
STROKES = {"10um": 10e-6, "8.5um": 8.5e-6}
"""Amplitudes, m: the thesis's +-10 um is 20 um, more than its piezo has; +-8.5 um is the whole of its 17 um."""
PHASES = {"pi/1.5": math.pi / 1.5, "pi/2": math.pi / 2, "pi/4": math.pi / 4, "pi/8": math.pi / 8}


@dataclass(frozen=True)
class TipEllipse:
    """Path of the tip about its rest, x along the travel and y up, m, shape (n,); half axes m; tilt rad.

    The tilt is that of the major axis against x, in (-pi/2, pi/2].
    """

    time: np.ndarray
    x: np.ndarray
    y: np.ndarray
    semi_major: float
    semi_minor: float
    tilt: float

    def features(self) -> dict[str, tuple[float, str]]:
        return {"semi_major": (self.semi_major, "m"), "semi_minor": (self.semi_minor, "m"), "tilt": (self.tilt, "rad")}


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


def tip_ellipse(piezo_spacing: float, tip_height: float, stroke: float, phase: float) -> TipEllipse:
    """Piezos d1 = stroke sin(w t), d2 = stroke sin(w t - phase) under a rigid tip.

    Args:
        piezo_spacing: D, m, positive.
        tip_height: h, m, above the line of the piezos' ends.
        stroke: amplitude of each piezo, m.
        phase: lag of the second piezo, rad.

    The half axes and tilt are those of the path's fundamental; its second harmonic (a nanometre at 10 um of stroke,
    from the tip's rotation) is in the path, but not in them.
    """
    if not (piezo_spacing > 0.0 and math.isfinite(piezo_spacing)):
        raise InputError(f"actuator.piezo_spacing = {piezo_spacing:g} m; must be positive")
    require(tip_height > 0.0 and math.isfinite(tip_height), f"actuator.tip_height = {tip_height:g} m; must be positive")
    n = 720
    angle = 2.0 * math.pi * np.arange(n) / n
    first, second = stroke * np.sin(angle), stroke * np.sin(angle - phase)
    x, y = tip_position(first, second, piezo_spacing, tip_height)
    rest_x, rest_y = tip_position(np.zeros(1), np.zeros(1), piezo_spacing, tip_height)
    x, y = x - rest_x, y - rest_y
    # Columns: cosine and sine part of the fundamental. Their singular values are the half axes.
    parts = 2.0 / n * np.array([[x @ np.cos(angle), x @ np.sin(angle)], [y @ np.cos(angle), y @ np.sin(angle)]])
    axes, halves, _ = np.linalg.svd(parts)
    tilt = math.atan2(axes[1, 0], axes[0, 0])
    if tilt > math.pi / 2 + 1e-12:
        tilt -= math.pi
    elif tilt <= -math.pi / 2 + 1e-12:
        tilt += math.pi
    if abs(tilt) < 1e-12:
        tilt = 0.0
    return TipEllipse(angle / FREQUENCY, x, y, float(halves[0]), float(halves[1]), tilt)
