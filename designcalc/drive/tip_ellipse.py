"""Motion of a tip on two piezos: the ellipse of its apex, and the speed of the stage that it drives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import require

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TipEllipse:
    """Path of the tip on two piezos, peak to peak."""

    along: Array  # travel along the stage X, m
    normal: Array  # travel towards the stage Y, m


def tip_ellipse(amplitude: ArrayLike, phase: ArrayLike, piezo_spacing: ArrayLike, tip_height: ArrayLike) -> TipEllipse:
    """Peak-to-peak travel of the tip for strokes ``A sin(wt)`` and ``A sin(wt - phi)``.

    ``X = 4 A (h/D) sin(phi/2)``, ``Y = 2 A cos(phi/2)``, from x = -h (d2-d1)/D, y = (d1+d2)/2.

    Args:
        amplitude: A, half of the peak-to-peak stroke of a piezo, m.
        phase: phi, rad.
        piezo_spacing: D, m, > 0.
        tip_height: h, m, > 0.

    Returns:
        `TipEllipse`.

    Source: thesis, section 4.1 (rigid tip, first order in the strokes).
    """
    A, phi, D, h = (np.asarray(v, float) for v in (amplitude, phase, piezo_spacing, tip_height))
    require(np.all(D > 0) and np.all(h > 0), "tip ellipse: piezo spacing and tip height must be above 0 m")
    return TipEllipse(along=4 * A * h / D * np.abs(np.sin(phi / 2)), normal=2 * A * np.abs(np.cos(phi / 2)))


def speed_of(travel: ArrayLike, frequency: ArrayLike) -> dict[str, Array]:
    """Mean speed of the stage, m/s, by three laws: 'stopping' X f, 'coasting' 2 X f, 'apex' pi X f.

    Stopping: the stage rests while the tip returns. Coasting: it continues at the tip's mean speed, ``2 X f``. Apex:
    contact only at the top of the ellipse, where the tip's speed is ``pi X f``, its largest value.

    Args:
        travel: X, peak-to-peak travel along the stage, m.
        frequency: f, Hz.
    """
    X, f = np.asarray(travel, float), np.asarray(frequency, float)
    require(np.all(X > 0) and np.all(f >= 0), "tip ellipse: travel of the tip must be above 0, the frequency 0 or more")
    base = X * f
    return {"stopping": base, "coasting": 2 * base, "apex": np.pi * base}


def frequency_for(speed: ArrayLike, travel: ArrayLike) -> dict[str, Array]:
    """Drive frequency, Hz, that each law of `speed_of` needs for a speed (m/s) and a travel X (m)."""
    v, X = np.asarray(speed, float), np.asarray(travel, float)
    require(np.all(v >= 0) and np.all(X > 0), "tip ellipse: travel of the tip must be above 0, the speed 0 or more")
    base = v / X
    return {"stopping": base, "coasting": base / 2, "apex": base / np.pi}
