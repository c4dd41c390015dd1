"""Free curves: nonparametric effects of one coordinate, compared with the named effects.

A free curve is a piecewise linear function of one recorded coordinate s with free values a_k at its knots,

    value(s) = sum_k a_k N_k(s),

taken as a force on the axis, as a friction level, or, for a piezo, as a change of its voltage. It is an ordinary effect
in the model and is fitted with all other values; each a_k has the prior N(0, (`PRIOR_SCALE` x force scale)^2). Where a
free curve explains clearly more than every named effect, the missing law depends on its coordinate and is not in the
library.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from sim.effects.effect import Axis, Coordinate, Effect, Parameter
from sysid.experiment.known import Prior
from sysid.prediction.actuator_tip import TipRecord
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import Model, Scales, with_effect
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem
from sysid.signals import GaussianFilter

PRIOR_SCALE = 2.0
"""Standard deviation of the value at a knot, over the force scale of the records (the range of a voltage)."""

LEAST_KNOTS = 6
"""Distinct knots that a coordinate needs."""

Place = Literal["force", "level", "voltage"]


@dataclass(frozen=True)
class _Curve:
    """Declaration of one free curve."""

    coordinate: Coordinate  # public name
    field: str  # of the `Axis`
    place: Place  # how the curve enters the model
    knots: int  # number
    by_rank: bool = False  # knots at quantiles, for coordinates with uneven distributions


_CURVES = (
    _Curve("position", "position", "force", 13),
    _Curve("position", "position", "level", 13),
    _Curve("velocity", "velocity", "level", 12, True),
    _Curve("velocity", "velocity", "force", 12, True),
    _Curve("acceleration", "acceleration", "force", 8, True),
    _Curve("acceleration", "acceleration", "level", 8, True),
    _Curve("normal_load", "load", "level", 6),
    _Curve("temperature", "temperature", "level", 6),
    _Curve("temperature", "temperature", "force", 6),
    _Curve("distance_since_reversal", "reversal_distance", "level", 10, True),
    _Curve("contact_age", "contact_age", "level", 8, True),
)

_VOLTAGE_CURVES = (_Curve("input", "input", "voltage", 9), _Curve("velocity", "rate", "voltage", 9, True))


def free_curves(problem: Problem) -> list[Effect]:
    """Free curves of every coordinate in which the records vary; none on a rig whose motion is simulated."""
    records = [*problem.fit_records, *problem.validate_records]
    if any(isinstance(r, FrictionDriveRecord) for r in records):
        return []
    rotary = problem.experiment.rig.rotary
    piezo = isinstance(records[0], TipRecord)
    framed = any(e.friction_state is not None for e in problem.start.effects)
    found = []
    smoothing = max((r.coordinate_width for r in records if isinstance(r, ForceBalanceRecord)), default=0.0)
    for curve in _VOLTAGE_CURVES if piezo else _CURVES:
        # Without a friction state model a level has no effect; with one, a force of the velocity repeats the level.
        if (curve.place == "level" and not framed) or (curve.field == "velocity" and curve.place == "force" and framed):
            continue
        width = smoothing if curve.field == "acceleration" else 0.0
        turn = _turn(curve, records, rotary)
        knots = np.linspace(0.0, turn, curve.knots) if turn else _knots(curve, records, width)
        if knots.size >= LEAST_KNOTS:
            found.append(_effect(curve, knots, width, turn))
    return found


VISITS = 3.0
"""Least mean number of visits to each part of the range of a coordinate from which it recurs."""

PARTS = 12


def recurring_coordinates(problem: Problem) -> frozenset[Coordinate]:
    """Coordinates whose values recur on the records of the fit and on the held-out ones.

    On a motion that never returns a function of the position is a function of time: a free curve of such a coordinate
    can represent any error, and decides nothing.
    """
    parts = [records for records in (problem.fit_records, problem.validate_records) if records]
    if any(isinstance(r, FrictionDriveRecord) for r in problem.fit_records):
        return frozenset()
    piezo = isinstance(problem.fit_records[0], TipRecord)
    curves = _VOLTAGE_CURVES if piezo else _CURVES
    rotary = problem.experiment.rig.rotary
    return frozenset(c.coordinate for c in curves if all(_recurs(c, records, rotary) for records in parts))


def _recurs(curve: _Curve, records: Sequence[PreparedRecord], rotary: bool) -> bool:
    signals = [signal for record in records for signal in _values(curve, record, 0.0)]
    if _turn(curve, records, rotary):
        signals = [np.mod(signal, TURN) for signal in signals]
    return _visits(signals, curve.by_rank) >= VISITS


def _visits(signals: Sequence[np.ndarray], by_rank: bool) -> float:
    """Mean number of visits to each of `PARTS` parts of the range of a coordinate, weighted by the samples there. A
    visit ends when the coordinate is more than half a part beyond the ends of the part, so that noise at an end does
    not count."""
    every = np.concatenate(signals)
    if by_rank:
        ranks = np.linspace(0.0, 1.0, 257)
        levels = np.quantile(every, ranks)
        signals = [np.interp(signal, levels, ranks) for signal in signals]
        every = np.concatenate(signals)
    low, width = float(every.min()), float(np.ptp(every)) / PARTS
    if width <= 0.0:
        return 0.0
    total = 0.0
    for part in range(PARTS):
        centre = low + (part + 0.5) * width
        samples = visits = 0
        for signal in signals:
            away = np.abs(signal - centre)
            inside = away <= 0.5 * width
            state = np.where(inside, 1, np.where(away > width, -1, 0))
            state = state[state != 0]
            visits += int(np.sum((state[1:] == 1) & (state[:-1] == -1))) + int(state.size > 0 and state[0] == 1)
            samples += int(inside.sum())
        total += samples * visits / every.size
    return total


def with_curve(model: Model, curve: Effect, scales: Scales) -> Model:
    """The model with a free curve, whose values start at zero with their prior."""
    out = with_effect(model, curve, scales)
    size = PRIOR_SCALE * (scales.input if curve.acts_on == "piezo" else scales.force)
    own = f"{curve.name}."
    unknowns = tuple(
        replace(u, size=0.05 * size, prior=Prior(0.0, size)) if u.key.startswith(own) else u for u in out.unknowns
    )
    return replace(out, unknowns=unknowns)


def _knots(curve: _Curve, records: Sequence[PreparedRecord], width: float) -> np.ndarray:
    """Positions of the knots (k,) over the range of all records, the held-out ones included."""
    values = np.concatenate([part for record in records for part in _values(curve, record, width)])
    low, high = float(np.min(values)), float(np.max(values))
    if not high - low > 1e-9 * max(abs(low), abs(high), 1e-300):
        return np.empty(0)
    if not curve.by_rank:
        return np.linspace(low, high, curve.knots)
    return np.unique(np.quantile(values, np.linspace(0.0, 1.0, curve.knots)))


def _turn(curve: _Curve, records: Sequence[PreparedRecord], rotary: bool) -> float:
    """A full turn, rad, where a curve of the angle of a rotary axis repeats after it; zero otherwise."""
    if not (rotary and curve.field == "position"):
        return 0.0
    reach = max(float(np.ptp(part)) for record in records for part in _values(curve, record, 0.0))
    return TURN if reach > TURN else 0.0


TURN = 2.0 * np.pi


def _values(curve: _Curve, record: PreparedRecord, width: float) -> list[np.ndarray]:
    if isinstance(record, TipRecord):
        return record.drives if curve.field == "input" else [np.gradient(u, record.step) for u in record.drives]
    assert isinstance(record, ForceBalanceRecord)
    return [_smoothed(getattr(record.axis, curve.field), record.axis.time, width)]


def _smoothed(values: np.ndarray, time: np.ndarray, width: float) -> np.ndarray:
    """Values (n,) by a Gaussian filter of a width, s, unchanged where it is zero."""
    if width == 0.0 or time.size < 2:
        return values
    return _filter(width, round(float(time[1] - time[0]), 12), time.size)(values)


_filter = lru_cache(maxsize=16)(GaussianFilter)


def _effect(curve: _Curve, knots: np.ndarray, width: float, turn: float) -> Effect:
    """The effect of a free curve with these knots, of a coordinate smoothed by a filter of a width, s, that repeats
    after a `turn` if it is not zero."""

    def value(at: Any, p: Any) -> Any:
        return np.interp(np.mod(at, turn) if turn else at, knots, np.array(p))

    def law(axis: Axis, p: Any) -> Any:
        return value(_smoothed(getattr(axis, curve.field), axis.time, width), p)

    def signal(voltage: np.ndarray, step: float, p: Any) -> np.ndarray:
        return voltage + value(voltage if curve.field == "input" else np.gradient(voltage, step), p)

    unit = "V" if curve.place == "voltage" else "N"
    kind = {"force": "force", "level": "friction", "voltage": "voltage"}[curve.place]
    return Effect(
        name=f"free_{kind}_of_{curve.coordinate}",
        meaning=f"a {kind} that is any function of {curve.coordinate}",
        parameters=tuple(
            Parameter(f"a{k}", unit, 0.0, -np.inf, np.inf, f"value at knot {k}", "free") for k in range(knots.size)
        ),
        coordinates=(curve.coordinate,),
        acts_on="piezo" if curve.place == "voltage" else "friction" if curve.place == "level" else "axis",
        force=law if curve.place == "force" else None,
        level=law if curve.place == "level" else None,
        signal=signal if curve.place == "voltage" else None,
    )
