"""Hysteresis between the voltage and the extension of a piezo."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Effect, Parameter, Scan
from sim.numerics.record_operators import bouc_wen, play

PLAYS = 15
_THRESHOLDS = np.linspace(0.1, 1.0, 8)


def _with_the_way_to_it(signal: Any, settled: float) -> Any:
    """The signal (n,) after one row more: the voltage at which the piezo rested before it was brought to the first."""
    return np.concatenate([[settled * signal[0]], signal])


def _prandtl_ishlinskii(signal: Any, step: float, p: Any) -> Any:
    weights = _THRESHOLDS**p.shape
    weights = weights / weights.sum()
    path = _with_the_way_to_it(signal, p.settled)
    lost = np.zeros_like(path)
    for threshold, weight in zip(_THRESHOLDS, weights, strict=True):
        # A play less the straight line it would follow, so that the mean gain stays with the base model.
        lost += weight * (play(path, threshold * p.width) - path)
    return signal + p.strength * lost[1:]


def _free_plays(signal: Any, step: float, p: Any) -> Any:
    path = _with_the_way_to_it(signal, p.settled)
    out = np.array(path)
    for k, weight in enumerate(p[:PLAYS]):
        if weight != 0.0:
            out += weight * (play(path, (k + 1) / (PLAYS + 1) * p.width) - path)
    return out[1:]


def _bouc_wen(signal: Any, step: float, p: Any) -> Any:
    return signal - p.strength * bouc_wen(_with_the_way_to_it(signal, p.settled), p.width, p.turning)[1:]


_SETTLED = Parameter(
    "settled",
    "1",
    1.0,
    0.0,
    1.0,
    "voltage at which the piezo rested before the first row, over that of the first row, both from bias",
    "the history before the first row is not recorded",
).shape(Scan("one", 0.0, 1.0, 2, "linear"), natural="both")


_PLAY = Effect(
    name="piezo_hysteresis",
    meaning="rate-independent hysteresis between voltage and extension of a piezo (Prandtl-Ishlinskii)",
    equation="d = u + strength * sum_i w_i (play(u; r_i) - u),  r_i up to width,  w_i ~ r_i^shape",
    shows="extension against voltage is a loop of 10-15 % of the stroke, independent of the frequency",
    source="Kuhnen, European J. Control 9 (2003) 407; Goldfarb and Celanovic, IEEE Control Systems 17 (1997) 69",
    acts_on="piezo",
    coordinates=("input",),
    parameters=(
        Parameter("strength", "1", 0.12, 0.0, 0.9, "part of the stroke that has hysteresis", "10-15 % in soft PZT"),
        Parameter(
            "width", "V", 30.0, 1e-6, 1e5, "largest half-width of a play", "bounded by the voltage's range"
        ).shape(Scan("input", 0.05, 0.8, 5), natural="high"),
        Parameter("shape", "1", 0.0, -2.0, 3.0, "distribution of the thresholds over the width", "0: evenly").shape(
            natural="both"
        ),
        _SETTLED,
    ),
    signal=_prandtl_ishlinskii,
)

_BOUC_WEN = replace(
    _PLAY,
    name="piezo_hysteresis:bouc_wen",
    meaning="hysteresis between voltage and extension of a piezo (Bouc-Wen)",
    equation="d = u - strength * h;  dh = du - (turning |du| h + (1 - turning) du |h|)/width",
    source="Low and Guo, J. Microelectromech. Syst. 4 (1995) 230, beta = turning/width, gamma = (1 - turning)/width; "
    "for Duhem's law Banning et al., Automatica 37 (2001) 1883",
    parameters=(
        *_PLAY.parameters[:2],
        Parameter(
            "turning",
            "1",
            0.5,
            0.5,
            1.5,
            "decay of the hysteresis on unloading",
            "0.5: linear unloading; 1: Duhem's (Dahl's) law, equal decay in both directions; dissipative from 0.5 on",
        ).shape(natural="both"),
        _SETTLED,
    ),
    signal=_bouc_wen,
)

_FREE = replace(
    _PLAY,
    name="piezo_hysteresis:free_plays",
    meaning="hysteresis between voltage and extension of a piezo, by play operators of free weights",
    equation="d = u + sum_k play_k (play(u; r_k) - u),  r_k = k width / 16",
    source="Kuhnen, European J. Control 9 (2003) 407: thresholds given, weights identified",
    parameters=(
        *(
            Parameter(f"play_{k + 1}", "1", 0.02, 0.0, 0.9, f"weight of play {k + 1}", "10-15 % in soft PZT, in all")
            for k in range(PLAYS)
        ),
        replace(
            _PLAY.parameters[1],
            meaning="half-width of a play that no longer moves",
            source="half the range of the voltage",
            role="reference",
            scan=Scan("input", 0.5, 0.5),
        ),
        _SETTLED,
    ),
    signal=_free_plays,
)

EFFECT = replace(_PLAY, variants=(_BOUC_WEN, _FREE))
