"""Static friction that rises with the time of contact."""

from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect, Parameter, Scan
from sim.numerics.record_operators import ageing_strength, contact_age


def _memory(axis: Axis, p: Any) -> Axis:
    """The axis with the age of its contacts, which in a simulation is a state of the axis by the same law."""
    return axis._replace(contact_age=contact_age(axis.time, _without_rests(axis), p.memory_length))


def _without_rests(axis: Axis) -> Any:
    """Distance slid (n,), without the changes by noise of the position while the body rests, m."""
    gone = np.abs(np.diff(axis.position))
    gone[(axis.contact_age[1:] > 0.0) & (axis.contact_age[:-1] > 0.0)] = 0.0
    return np.concatenate([[0.0], np.cumsum(gone)])


def _fading(axis: Axis, p: Any) -> Any:
    if np.ndim(axis.position) == 0:
        raise ValueError("this law is defined along a whole record only")
    time, rested = (np.ascontiguousarray(a, dtype=float) for a in (axis.time, axis.contact_age))
    return p.force * ageing_strength(time, _without_rests(axis), rested, p.cut_off, p.memory_length)


def _logarithmic(axis: Axis, p: Any) -> Any:
    # Half the run time of log1p; the rounding error is 1e-16 of the force.
    return p.force * np.log(1.0 + axis.contact_age / p.cut_off)


def _logarithmic_by_age(axis: Axis, p: Any) -> Any:
    return p.force / (p.cut_off + axis.contact_age)


_YOUNGEST = 1e-12
"""Age in s that a contact has from the start: Kato's power has no slope at zero, which an integration needs."""


def _kato(axis: Axis, p: Any) -> Any:
    aged = (np.abs(axis.contact_age) + _YOUNGEST) ** p.exponent - _YOUNGEST**p.exponent
    return p.force * -np.expm1(-p.rate * aged)


def _kato_by_age(axis: Axis, p: Any) -> Any:
    age = np.abs(axis.contact_age) + _YOUNGEST
    aged = age**p.exponent - _YOUNGEST**p.exponent
    return p.force * np.exp(-p.rate * aged) * p.rate * p.exponent * age ** (p.exponent - 1.0)


MEMORY_LENGTH = Parameter(
    "memory_length",
    "m",
    1e-5,
    1e-9,
    1e3,
    "sliding distance that renews the contacts",
    "1-100 um in metals: Dieterich 1979",
).shape(Scan("position", 1e-4, 0.1, 8), natural="low")

_LOGARITHMIC = Effect(
    name="dwell_strengthening",
    meaning="static friction rises with the logarithm of the time of contact",
    equation="level + force * ln(1 + age / cut_off);  age' = 1 - |v| age / memory_length",
    shows="the break-away force after a rest rises with its duration, and decays over a short slide",
    source="Dieterich, J. Geophys. Res. 84 (1979) 2161; Ruina, J. Geophys. Res. 88 (1983) 10359",
    acts_on="friction",
    coordinates=("contact_age", "velocity"),
    parameters=(
        Parameter("force", "N", 0.05, 0.0, 1e9, "rise of the level per e-fold of contact time", "ageing strengthens"),
        Parameter(
            "cut_off",
            "s",
            0.05,
            1e-6,
            1e4,
            "contact time from which the rise is logarithmic",
            "less than the longest rest: below it the rise is linear in time",
        ).shape(Scan("rest", 0.01, 0.5, 5), natural="both"),
        MEMORY_LENGTH,
    ),
    level=_logarithmic,
    slopes={"level.contact_age": _logarithmic_by_age},
    memory=_memory,
)

_KATO = replace(
    _LOGARITHMIC,
    name="dwell_strengthening:kato",
    meaning="static friction rises with the time of contact towards an upper limit (Kato)",
    equation="level + force * (1 - exp(-rate * age^exponent));  age' = 1 - |v| age / memory_length",
    source="Kato, Sato, Matsubayashi, J. Lubrication Technology 94 (1972) 34: rate 0.04-1.66, exponent 0.36-0.67",
    parameters=(
        Parameter(
            "force",
            "N",
            0.1,
            0.0,
            1e9,
            "upper limit of the rise above the level of a fresh contact",
            "ageing strengthens",
        ),
        Parameter("rate", "1", 1.66, 1e-3, 1e3, "gamma of Kato's law, in s^-exponent", "Kato 1972: 1.66 on ways").shape(
            Scan("one", 0.3, 8.0, 4), natural="both"
        ),
        Parameter("exponent", "1", 0.65, 0.2, 1.0, "m of Kato's law", "Kato 1972: 0.65", role="reference"),
        MEMORY_LENGTH,
    ),
    level=_kato,
    slopes={"level.contact_age": _kato_by_age},
)

_FADING = replace(
    _LOGARITHMIC,
    name="dwell_strengthening:fading",
    meaning="static friction rises with the logarithm of the time at rest; the rise decays with the distance slid",
    equation="level + h;  at rest h = force * ln(1 + time / cut_off);  in motion dh = -h |dx| / memory_length",
    source="Rabinowicz, Proc. Phys. Soc. 71 (1958) 668; Heslot et al., Phys. Rev. E 49 (1994) 4973",
    level=_fading,
    slopes={},
    memory=None,
)

EFFECT = replace(_LOGARITHMIC, variants=(_KATO, _FADING))
