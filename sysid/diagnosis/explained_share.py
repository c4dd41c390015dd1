"""The coordinates that a residual is held against, and the bins that they are cut into.
How much of a residual a coordinate tells: learned on some samples, judged on others.

A coordinate's table is the mean residual in bins of the coordinate, apart for the two directions of motion, over all
records together: what depends on the coordinate looks the same whenever the axis comes by again, and is foretold by
other moments. Time and distance travelled have a table for each record, since they mean nothing in another. Every
coordinate has the same few bins, and is learned on every other sample and judged on the rest; the position is looked
at in fine ones too.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sysid.estimation.misfit import ResidualWeights, misfit
from sysid.prediction.actuator_tip import TipRecord
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model, PreparedRecord, predict


def coordinates_of(record: PreparedRecord) -> dict[str, np.ndarray]:
    """The coordinates (n,) that a record's residual is held against, by the interface's names; `frequency` aside."""
    if isinstance(record, TipRecord):
        rate = np.gradient(np.mean(record.drives, axis=0), record.step)
        out = {"time": record.time, "input": np.mean(record.drives, axis=0), "velocity": rate}
        for name, signal in record.measured.items():
            out[f"position@{name}"] = signal
        out["acceleration"] = np.gradient(rate, record.step)
        return out
    axis = record.axis
    out = {
        "time": axis.time,
        "position": axis.position,
        "velocity": axis.velocity,
        "direction": axis.direction,
        "acceleration": axis.acceleration,
        "distance_since_reversal": axis.reversal_distance,
        "distance_travelled": axis.travelled,
        "contact_age": axis.contact_age,
    }
    if np.ptp(axis.load) > 0:
        out["normal_load"] = axis.load
    if np.ptp(axis.temperature) > 0:
        out["temperature"] = axis.temperature
    return out


_BY_RANK = ("velocity", "acceleration", "distance_since_reversal", "contact_age")


def edges_of(values: np.ndarray, coordinate: str, bins: int) -> np.ndarray:
    """Edges of a coordinate's bins, the outer ones open: even, or by rank where most samples share a few values."""
    if coordinate == "direction":
        return np.array([-np.inf, 0.0, np.inf])
    if coordinate in _BY_RANK:
        inner = np.unique(np.quantile(values, np.linspace(0, 1, bins + 1)[1:-1]))
    else:
        low, high = float(np.min(values)), float(np.max(values))
        inner = np.linspace(low, high, bins + 1)[1:-1]
    return np.concatenate([[-np.inf], inner, [np.inf]])


def cells_of(values: np.ndarray, direction: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Number of each sample's bin (n,), the bins of motion backwards after those forwards."""
    index = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)
    return index + (edges.size - 1) * (direction < 0)


def means_of(cells: np.ndarray, residual: np.ndarray, count: int) -> np.ndarray:
    """Mean residual per cell, drawn towards zero where a cell holds few samples."""
    number = np.bincount(cells, minlength=count)
    return np.bincount(cells, residual, minlength=count) / (number + 3.0)


BINS = 12
"""Bins on which a coordinate's share is judged, the same for all: with many, anything is a function of time."""

FINE_BINS = 96
"""Bins in which the position is looked at once more: a texture of the way repeats within a fraction of the travel.
There each block of time is foretold by the others, since neighbours in time would be neighbours in so fine a bin."""

OF_ONE_RECORD = ("time", "distance_travelled")
"""Coordinates that mean nothing in another record, and never come by again in their own."""

SEEN_AGAIN = 1.5
"""Most that a share may be of what the map foretells in blocks of time it has not seen: what happened once, while the
axis was at some place or speed, does not follow the place or the speed."""

DRAWN_BINS = 24
KEPT_BELOW = 0.995
"""Quantile of the residual's size at which it is cut, so that no few samples decide."""

BLOCKS = 40


Samples = tuple[Mapping[str, np.ndarray], np.ndarray, np.ndarray]
"""Coordinates by name, residual and block number of the scored samples, each (n,)."""

ALIAS = 0.9
"""Rank correlation with time from which a coordinate says no more than time does."""


def compared(
    model: Model,
    fit_records: Sequence[PreparedRecord],
    fit_weights: ResidualWeights,
    held_out: Sequence[PreparedRecord],
    held_out_weights: ResidualWeights,
) -> Iterator[tuple[str, Samples, Samples]]:
    """Each of the worst channels, with its samples in the records of the fit and in the held-out ones."""
    for channel in _worst_channels(model, [*fit_records, *held_out]):
        learn = _samples(model, fit_records, fit_weights, channel)
        judge = _samples(model, held_out, held_out_weights, channel) if held_out else learn
        if learn is not None and judge is not None:
            yield channel, learn, judge


def shared(learn: Samples, judge: Samples) -> list[str]:
    """Names of the coordinates that both have."""
    return [name for name in learn[0] if name != "_direction" and name in judge[0]]


def _worst_channels(model: Model, records: Sequence[PreparedRecord]) -> list[str]:
    """Channels whose misfit, over their noise, is at least half the worst one's."""
    over = {channel: m.over_noise for channel, m in misfit(model, records).items()}
    return [channel for channel, value in over.items() if value >= 0.5 * max(over.values())]


def _samples(
    model: Model, records: Sequence[PreparedRecord], weights: ResidualWeights, channel: str
) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray] | None:
    """Coordinates, residual (n,) and block number (n,) at the scored samples of all records that hold the channel."""
    coordinates: dict[str, list[np.ndarray]] = {}
    residuals, block_numbers, start = [], [], 0
    for record, std, samples in zip(records, weights.std, weights.samples, strict=True):
        pick = samples.get(channel)
        if pick is None:
            continue
        predicted = predict(record, model.effects, model.values)
        of_record = coordinates_of(record)
        residuals.append((record.measured[channel][pick] - predicted[channel][pick]) / std[channel][pick])
        block_numbers.append(start + (pick * BLOCKS) // record.size)
        for name, values in of_record.items():
            base, _, only = name.partition("@")
            if not only or only == channel:
                coordinates.setdefault(base, []).append(values[pick])
        direction = record.axis.direction if isinstance(record, ForceBalanceRecord) else np.ones(record.size)
        coordinates.setdefault("_direction", []).append(direction[pick])
        start += BLOCKS
    if not residuals:
        return None
    residual = np.concatenate(residuals)
    corner = float(np.quantile(np.abs(residual), KEPT_BELOW))
    merged = {name: np.concatenate(parts) for name, parts in coordinates.items()}
    merged = {name: values for name, values in merged.items() if values.size == residual.size}
    return merged, np.clip(residual, -corner, corner), np.concatenate(block_numbers)


@dataclass(frozen=True)
class Told:
    """What a coordinate says of a residual: its samples, all records together (n,), and its `share` and `pattern`.

    `foretold` is the residual as other blocks of time foretell it, in `drawn` bins.
    """

    values: np.ndarray
    time: np.ndarray
    direction: np.ndarray
    residual: np.ndarray
    block: np.ndarray
    record: np.ndarray
    cells: np.ndarray
    foretold: np.ndarray
    drawn: int
    share: float
    split_share: float


def told_by(name: str, learn: Samples, judge: Samples) -> Told:
    """What a coordinate says over all records together; time and distance travelled, record by record."""
    together = [learn] if judge is learn else [learn, judge]
    values = np.concatenate([s[0][name] for s in together])
    time, direction = (np.concatenate([s[0][other] for s in together]) for other in ("time", "_direction"))
    residual = np.concatenate([s[1] for s in together])
    block = np.concatenate([s[2] + k * BLOCKS * 100 for k, s in enumerate(together)])
    record = np.concatenate([np.full(s[1].size, k) for k, s in enumerate(together)])
    edges = edges_of(values, name, BINS)
    cells = cells_of(values, direction, edges)
    if name in OF_ONE_RECORD:
        cells = cells + 2 * (edges.size - 1) * record
    half = np.arange(residual.size) % 2 == 0
    table = means_of(cells[half], residual[half], int(cells.max()) + 1)
    predicted, r = table[cells[~half]], residual[~half]
    pattern = share = _share(r, predicted)
    foretold, drawn = _foretold(cells, residual, block), DRAWN_BINS
    if name not in OF_ONE_RECORD:
        share = min(share, SEEN_AGAIN * _share(residual, foretold))
    if name == "position":
        close = _foretold(cells_of(values, direction, edges_of(values, name, FINE_BINS)), residual, block)
        if _share(residual, close) > share:
            foretold, share, drawn = close, _share(residual, close), FINE_BINS
        pattern = max(pattern, share)
    if name not in OF_ONE_RECORD and all(_runs_with_time(s[0], name) for s in together):
        share, pattern = 0.5 * share, 0.5 * pattern
    return Told(values, time, direction, residual, block, record, cells, foretold, drawn, share, pattern)


def share_beyond_time(told: Told) -> float:
    """What a coordinate explains of what time leaves, less what time explains of what the coordinate leaves; shares of
    the residual's square."""
    residual = told.residual
    in_time = cells_of(told.time, told.direction, edges_of(told.time, "time", BINS)) + 2 * BINS * told.record

    def by_place(r: np.ndarray) -> np.ndarray:
        return _less(r, _foretold(told.cells, r, told.block))

    def by_time(r: np.ndarray) -> np.ndarray:
        odd = np.arange(r.size) % 2 == 1
        count = int(in_time.max()) + 1
        learned = [means_of(in_time[half], r[half], count) for half in (odd, ~odd)]
        return _less(r, np.where(odd, learned[1][in_time], learned[0][in_time]))

    place, time = by_place(residual), by_time(residual)
    both = [float(r @ r) for r in (time, by_place(time), place, by_time(place))]
    return ((both[0] - both[1]) - (both[2] - both[3])) / max(float(residual @ residual), 1e-300)


def _less(residual: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """A residual (n,) less what is predicted of it, that no larger and no smaller than it helps."""
    own = float(predicted @ predicted)
    size = max(0.0, float(residual @ predicted)) / own if own > 0.0 else 0.0
    return residual - size * predicted


def _runs_with_time(coordinates: Mapping[str, np.ndarray], name: str) -> bool:
    return abs(_rank_correlation(coordinates[name], coordinates["time"])) > ALIAS


def _rank_correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Spearman's rank correlation of two coordinates (n,)."""
    ranks = [np.argsort(np.argsort(v)).astype(float) for v in (a, b)]
    if np.ptp(a) == 0 or np.ptp(b) == 0:
        return 0.0
    return float(np.corrcoef(ranks[0], ranks[1])[0, 1])


def _foretold(cells: np.ndarray, residual: np.ndarray, block: np.ndarray) -> np.ndarray:
    """The map's prediction (n,) of each sample, learned on all blocks of time but its own and the two beside it:
    neighbours share their noise, and would foretell each other."""
    _, place = np.unique(block, return_inverse=True)
    shape = (int(place.max()) + 1, int(cells.max()) + 1)
    flat = place * shape[1] + cells
    number = np.bincount(flat, minlength=shape[0] * shape[1]).reshape(shape).astype(float)
    total = np.bincount(flat, residual, minlength=shape[0] * shape[1]).reshape(shape)
    for table in (number, total):
        near = table.copy()
        near[1:] += table[:-1]
        near[:-1] += table[1:]
        table[:] = table.sum(axis=0) - near
    return (total / (number + 3.0))[place, cells]


def _share(residual: np.ndarray, predicted: np.ndarray) -> float:
    """Share of the squared residual that the map explains, its size free but not its sign."""
    total, own = float(residual @ residual), float(predicted @ predicted)
    if total <= 0.0 or own <= 0.0:
        return 0.0
    return max(0.0, float(residual @ predicted)) ** 2 / (total * own)
