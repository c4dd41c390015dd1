"""A stack's hysteresis and creep as operators evaluated step by step in a simulation.

Prandtl-Ishlinskii:  u = V + s sum_i w_i (play_i(V) - V),  half-widths r_i even over the voltage's half-range.
On the whole sweep 0 to V_max = 2 A a play loses 2 r_i, so u sweeps over V_max - 2 s <r>. At mid-voltage a play is
r_i behind, or A - r_i where it has not moved yet, so the loop there is 2 s <min(r, A - r)> wide. With <.>
the mean by w_i, the catalogue's two numbers, stroke and hysteresis H, fix

    s = H A / (<min(r, A - r)> + H <r>),        gain = stroke/(V_max - 2 s <r>).

Small signals see no play move: their gain is gain (1 - s), the known loss of a stack's small-signal stretch.
Creep: the logarithm of time by a ladder of lags, as the effect `piezo_creep` has it.

Source: Kuhnen, European J. Control 9 (2003) 407; Jung and Gweon, Rev. Sci. Instrum. 71 (2000) 1896.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.stage.machine import Piezo

PLAYS = 8
CREEP_START = 0.1
CREEP_DECADES = 3.0
LAGS = 13


@dataclass(frozen=True)
class PiezoResponse:
    """Numbers of the operators.

    Args:
        gain: stretch per volt of u, m/V.
        strength: s.
        thresholds: r_i, V, shape (8,).
        weights: w_i, shape (8,), summing to 1.
        creep_weights: shape (13,); creep_rates: 1/s, shape (13,).
    """

    gain: float
    strength: float
    thresholds: np.ndarray
    weights: np.ndarray
    creep_weights: np.ndarray
    creep_rates: np.ndarray

    @property
    def small_signal_gain(self) -> float:
        """Stretch per volt of a wave smaller than the least play, m/V."""
        return self.gain * (1.0 - self.strength)


def piezo_response(piezo: Piezo) -> PiezoResponse:
    """The operators that give a stack its catalogue stroke, hysteresis and creep."""
    half = 0.5 * piezo.highest_voltage
    thresholds = half * np.linspace(0.1, 1.0, PLAYS)
    weights = np.full(PLAYS, 1.0 / PLAYS)
    mean = float(weights @ thresholds)
    behind = float(weights @ np.minimum(thresholds, half - thresholds))
    strength = piezo.hysteresis * half / (behind + piezo.hysteresis * mean)
    gain = piezo.stroke / (piezo.highest_voltage - 2.0 * strength * mean)
    times = CREEP_START * 10.0 ** (CREEP_DECADES * np.arange(LAGS) / (LAGS - 1))
    creep = np.full(LAGS, piezo.creep * CREEP_DECADES / (LAGS - 1))
    return PiezoResponse(gain, strength, thresholds, weights, creep, 1.0 / times)
