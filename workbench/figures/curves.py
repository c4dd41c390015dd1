"""Curves of fitted models over their records, as numbers: for figures, and for the page.

A record of any length is drawn by the minimum and maximum of each pixel column, so a figure stays small and no spike is
lost.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from sysid.diagnosis.residual_maps import ResidualMap
from sysid.documents import channel_unit
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model, PreparedRecord, predict
from sysid.prediction.problem import Problem

COLUMNS = 900
"""Pixel columns a line is drawn in."""
LEAST_SHARE = 0.005
"""Share of the residual's variance from which its dependence on a coordinate is listed and drawn."""
MOST_SAMPLES = 3_000_000
"""Samples of all records up to which models are predicted on every record; above it, on the first of each role."""
USUAL_SHARE = 0.97
"""Share of the samples that the scale of the residual shows: a few next to reversals would hide all others."""

_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_WITH_PREFIX = ("m", "N", "s", "V", "rad", "Hz")


@dataclass(frozen=True)
class Curve:
    """One channel of one record with the predictions to draw over it. Arrays (n,), SI; NaN where nothing is scored."""

    record: str  # names
    channel: str  # names
    unit: str  # SI unit of the channel
    time: np.ndarray  # s
    measured: np.ndarray  # as compared (filtered where the balance is)
    predicted: Mapping[str, np.ndarray]  # by label, in drawing order
    noise: float  # standard deviation that sensor noise leaves in the residual
    # velocity and position, with their SI units; empty where the record has none
    motion: Mapping[str, tuple[np.ndarray, str]] = field(default_factory=dict)
    role: str = "fit"  # `fit` or `validate`

    @property
    def residuals(self) -> dict[str, np.ndarray]:
        """Measured less predicted, by label."""
        return {label: self.measured - values for label, values in self.predicted.items()}

    @property
    def words(self) -> str:
        """The channel in words."""
        return self.channel.replace("_", " ")

    @property
    def largest(self) -> float:
        """The largest measured value, without sign."""
        return quantile(self.measured, 1.0)

    @property
    def usual(self) -> float:
        """Size of the residual of the first model that most samples stay below."""
        return quantile(next(iter(self.residuals.values())), USUAL_SHARE)


def curve_of(problem: Problem, record: PreparedRecord, channel: str, models: Mapping[str, Model]) -> Curve:
    """A record's channel with what each of `models` predicts for it."""
    valid, unit = record.valid[channel], channel_unit(problem, channel)

    def scored(values: np.ndarray) -> np.ndarray:
        return np.where(valid, values, np.nan)

    predicted = {label: scored(predict(record, m.effects, m.values)[channel]) for label, m in models.items()}
    time, motion = record.time - record.time[0], {}
    if isinstance(record, ForceBalanceRecord) and channel == record.force_channel:
        length = "rad" if unit.startswith("N*m") else "m"
        motion = {"velocity": (record.axis.velocity, f"{length}/s"), "position": (record.axis.position, length)}
    measured, role = scored(record.measured[channel]), record.role
    return Curve(record.name, channel, unit, time, measured, predicted, record.noise[channel], motion, role)


def curves(problem: Problem, models: Mapping[str, Model], only: tuple[str, str] | None = None) -> Iterator[Curve]:
    """Measured and predicted signal of each channel of each record; held-out records first."""
    samples = sum(record.size for record in problem.records) * len(models)
    for records in (problem.validate_records, problem.fit_records):
        for record in records if only or samples <= MOST_SAMPLES else records[:1]:
            for channel in record.measured:
                if only in (None, (record.name, channel)):
                    yield curve_of(problem, record, channel, models)


def worst_record(records: Sequence[PreparedRecord], channel: str, model: Model) -> PreparedRecord:
    """The record whose residual in `channel` is largest over its noise, by its rms."""

    def error(record: PreparedRecord) -> float:
        predicted = predict(record, model.effects, model.values)[channel]
        valid = record.valid[channel]
        return float(np.sqrt(np.mean((record.measured[channel] - predicted)[valid] ** 2))) / record.noise[channel]

    return max(records, key=error)


def drawn_maps(maps: Sequence[ResidualMap], most: int) -> list[ResidualMap]:
    """The strongest residual maps, at least three where there are; none of them on a single point."""
    # An axis that never rests has one age of contact: nothing to draw it against.
    drawable = [m for m in maps if m.centres.size > 1 and np.ptp(m.centres) > 0.0]
    return [m for m in drawable if m.share > LEAST_SHARE][:most] or drawable[:3]


def coordinate_unit(problem: Problem, coordinate: str) -> str:
    """SI unit of a coordinate of the residual maps."""
    length = "rad" if problem.experiment.rig.rotary else "m"
    if problem.kind == "actuator-tip":
        length = {"velocity": "V", "acceleration": "V"}.get(coordinate, length)
    units = {"frequency": "Hz", "normal_load": "N", "temperature": "degC", "input": "V"}
    units |= dict.fromkeys(("time", "contact_age"), "s")
    units |= dict.fromkeys(("position", "distance_since_reversal", "distance_travelled"), length)
    units |= {"velocity": f"{length}/s", "acceleration": f"{length}/s^2"}
    return units.get(coordinate, "1")


def axis_scale(values: np.ndarray, unit: str) -> tuple[float, str]:
    """Factor that brings SI values into a readable range, and the unit they then have, for a label."""
    largest = quantile(values, 1.0)
    shown = unit.replace("*", "·").replace("degC", "°C").replace("^2", "²").replace("^3", "³")
    head = shown.replace("/", "·").split("·")[0]
    if head not in _WITH_PREFIX or largest == 0.0:
        return 1.0, "" if unit == "1" else shown
    size, prefix = next(((s, p) for s, p in _PREFIXES if largest >= s), _PREFIXES[-1])
    return 1.0 / size, prefix + shown


def quantile(values: np.ndarray, share: float) -> float:
    """Quantile of the absolute values; 0 without any number."""
    sizes = np.abs(values[np.isfinite(values)])
    return float(np.quantile(sizes, share)) if sizes.size else 0.0


def decimate(time: np.ndarray, values: np.ndarray, columns: int = COLUMNS) -> tuple[np.ndarray, np.ndarray]:
    """The least and the largest of `values` (n,) in each of `columns` equal stretches, in the order they occur.

    A stretch without any number stays a gap. With two samples a column or fewer, the line itself.
    """
    n = values.size
    if n <= 2 * columns:
        return time, values
    edges = np.linspace(0, n, columns + 1).astype(int)[:-1]
    number = np.isfinite(values)
    column = np.searchsorted(edges, np.arange(n), side="right") - 1
    low = np.minimum.reduceat(np.where(number, values, np.inf), edges)
    high = np.maximum.reduceat(np.where(number, values, -np.inf), edges)

    def first_at(extreme: np.ndarray) -> np.ndarray:
        hits = np.flatnonzero(number & (values == extreme[column]))
        where = edges.copy()
        # Written backwards, so the first hit of a column is the one that stays.
        where[column[hits[::-1]]] = hits[::-1]
        return where

    pair = np.sort(np.stack([first_at(low), first_at(high)], axis=1), axis=1).ravel()
    return time[pair], values[pair]


def worst_stretch(residual: np.ndarray, least: int = 150) -> slice:
    """The stretch of about a twenty-fifth of the record where the residual (n,) is worst, single spikes aside."""
    n = residual.size
    length = min(n, max(least, n // 25))
    size = np.abs(np.nan_to_num(residual))
    ceiling = 6.0 * (float(np.median(size)) or 1.0)
    total = np.concatenate([[0.0], np.cumsum(np.minimum(size, ceiling) ** 2)])
    start = int(np.argmax(total[length:] - total[:-length])) if n > length else 0
    return slice(start, start + length)
