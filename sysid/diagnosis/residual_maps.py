"""Residual maps: mean residual over each coordinate and direction of motion, with explained share and p value.

The predictor of the share is the mean residual in bins of the coordinate, separately for the two directions of motion,
shrunk towards zero in bins of few samples, and common to all records; for time and distance travelled, which do not
recur, one for the records of the fit and one for the held-out ones. With p its prediction of test samples r, the
explained share is the squared correlation

    share = max(0, r'p)^2 / (r'r p'p)

tested on every other sample, and limited by the share of a prediction of each block of time from the others
(cross-validated).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from sim.effects.effect import Effect
from sysid.diagnosis import constants as limits
from sysid.estimation.misfit import ResidualWeights, misfit
from sysid.estimation.reference_fit import ReferenceFit
from sysid.prediction.actuator_tip import TipRecord
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model, predict
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem
from sysid.signals import GaussianFilter


def coordinates_of(record: PreparedRecord) -> dict[str, np.ndarray]:
    """Coordinates (n,) of a record by their public names, except `frequency`."""
    if isinstance(record, TipRecord):
        rate = np.gradient(np.mean(record.drives, axis=0), record.step)
        out = {"time": record.time, "input": np.mean(record.drives, axis=0), "velocity": rate}
        for name, signal in record.measured.items():
            out[f"position@{name}"] = signal
        out["acceleration"] = np.gradient(rate, record.step)
        return out
    assert isinstance(record, ForceBalanceRecord)
    axis = record.axis
    slow = GaussianFilter(record.coordinate_width, record.step, record.size)
    out = {
        "time": axis.time,
        "position": axis.position,
        "velocity": axis.velocity,
        "direction": axis.direction,
        "acceleration": slow(axis.acceleration),
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
    """Edges of the bins of a coordinate, the outer bins unbounded: equidistant, or quantiles for unevenly distributed
    coordinates."""
    if coordinate == "direction":
        return np.array([-np.inf, 0.0, np.inf])
    if coordinate in _BY_RANK:
        inner = np.unique(np.quantile(values, np.linspace(0, 1, bins + 1)[1:-1]))
    else:
        low, high = float(np.min(values)), float(np.max(values))
        inner = np.linspace(low, high, bins + 1)[1:-1]
    return np.concatenate([[-np.inf], inner, [np.inf]])


def cells_of(values: np.ndarray, direction: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Cell of each sample (n,): its bin; for backward motion plus the number of bins."""
    index = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)
    return index + (edges.size - 1) * (direction < 0)


def means_of(cells: np.ndarray, residual: np.ndarray, count: int) -> np.ndarray:
    """Mean residual per cell (count,), shrunk towards zero in cells of few samples."""
    number = np.bincount(cells, minlength=count)
    return np.bincount(cells, residual, minlength=count) / (number + 3.0)


BINS = 12
"""Bins of the explained share, the same for every coordinate: with many bins, time would explain any residual."""

FINE_BINS = 96
"""Bins of a second, cross-validated predictor over the position, for patterns that are periodic in the position."""

PER_RECORD = ("time", "distance_travelled")
"""Coordinates whose values do not recur, within a record or in another."""

CROSS_VALIDATION_RATIO = 1.5
"""Largest ratio of the share to the cross-validated one: a single event is not a dependence on the coordinate."""

DRAWN_BINS = 24
"""Bins of a map, except one of the position in `FINE_BINS`."""

KEPT_BELOW = 0.995
"""Quantile of the absolute residual at which it is clipped."""

BLOCKS = 40

Samples = tuple[Mapping[str, np.ndarray], np.ndarray, np.ndarray]
"""Coordinates by name, residual and block number of the scored samples, each (n,)."""

MONOTONIC_IN_TIME = 0.9
"""Absolute rank correlation with time above which a coordinate is not distinguishable from time."""


def paired_samples(model: Model, problem: Problem, base: ReferenceFit) -> Iterator[tuple[str, Samples, Samples]]:
    """Each channel whose misfit over noise is at least half the largest, with samples of the fit and held-out ones."""
    held_out = problem.validate_records
    over = {channel: m.over_noise for channel, m in misfit(model, [*problem.fit_records, *held_out]).items()}
    for channel in [channel for channel, value in over.items() if value >= 0.5 * max(over.values())]:
        learn = _samples(model, problem.fit_records, base.fitted.weights, channel)
        judge = _samples(model, held_out, base.weights, channel) if held_out else learn
        if learn is not None and judge is not None:
            yield channel, learn, judge


def common_coordinates(learn: Samples, judge: Samples) -> list[str]:
    """Names of the coordinates in both sets of samples."""
    return [name for name in learn[0] if name != "_direction" and name in judge[0]]


def _samples(
    model: Model, records: Sequence[PreparedRecord], weights: ResidualWeights, channel: str
) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray] | None:
    """Coordinates, residual (n,) and block number (n,) at the scored samples of all records with the channel."""
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
class Predictor:
    """Binned predictor of a residual by one coordinate, with the samples (n,) of all records."""

    # values, time, direction: coordinate, time and direction of motion of the samples
    values: np.ndarray
    time: np.ndarray
    direction: np.ndarray
    residual: np.ndarray  # of the samples, in standard deviations
    # block, record: numbers of the block of time and of the set of records
    block: np.ndarray
    record: np.ndarray
    cells: np.ndarray  # of the samples
    prediction: np.ndarray  # cross-validated prediction of the residual
    drawn: int  # number of bins of the map
    share: float  # explained share, limited by the cross-validated one


def predictor_of(name: str, learn: Samples, judge: Samples) -> Predictor:
    """The predictor of a residual by one coordinate; per set of records for time and distance travelled."""
    together = [learn] if judge is learn else [learn, judge]
    values = np.concatenate([s[0][name] for s in together])
    time, direction = (np.concatenate([s[0][other] for s in together]) for other in ("time", "_direction"))
    residual = np.concatenate([s[1] for s in together])
    block = np.concatenate([s[2] + k * BLOCKS * 100 for k, s in enumerate(together)])
    record = np.concatenate([np.full(s[1].size, k) for k, s in enumerate(together)])
    edges = edges_of(values, name, BINS)
    cells = cells_of(values, direction, edges)
    if name in PER_RECORD:
        cells = cells + 2 * (edges.size - 1) * record
    half = np.arange(residual.size) % 2 == 0
    table = means_of(cells[half], residual[half], int(cells.max()) + 1)
    predicted, r = table[cells[~half]], residual[~half]
    share = _share(r, predicted)
    prediction, drawn = _cross_validated(cells, residual, block), DRAWN_BINS
    if name not in PER_RECORD:
        share = min(share, CROSS_VALIDATION_RATIO * _share(residual, prediction))
    if name == "position":
        fine = _cross_validated(cells_of(values, direction, edges_of(values, name, FINE_BINS)), residual, block)
        if _share(residual, fine) > share:
            prediction, share, drawn = fine, _share(residual, fine), FINE_BINS
    if name not in PER_RECORD and all(_monotonic_in_time(s[0], name) for s in together):
        share *= 0.5
    return Predictor(values, time, direction, residual, block, record, cells, prediction, drawn, share)


def share_beyond_time(predictor: Predictor) -> float:
    """Share explained by a coordinate after removal of the time dependence, minus the share explained by time after
    removal of the dependence on the coordinate."""
    residual = predictor.residual
    in_time = cells_of(predictor.time, predictor.direction, edges_of(predictor.time, "time", BINS))
    in_time = in_time + 2 * BINS * predictor.record

    def by_place(r: np.ndarray) -> np.ndarray:
        return _remainder(r, _cross_validated(predictor.cells, r, predictor.block))

    def by_time(r: np.ndarray) -> np.ndarray:
        odd = np.arange(r.size) % 2 == 1
        count = int(in_time.max()) + 1
        learned = [means_of(in_time[half], r[half], count) for half in (odd, ~odd)]
        return _remainder(r, np.where(odd, learned[1][in_time], learned[0][in_time]))

    place, time = by_place(residual), by_time(residual)
    both = [float(r @ r) for r in (time, by_place(time), place, by_time(place))]
    return ((both[0] - both[1]) - (both[2] - both[3])) / max(float(residual @ residual), 1e-300)


def _remainder(residual: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """A residual (n,) minus its prediction times the least-squares factor >= 0."""
    own = float(predicted @ predicted)
    size = max(0.0, float(residual @ predicted)) / own if own > 0.0 else 0.0
    return residual - size * predicted


def _monotonic_in_time(coordinates: Mapping[str, np.ndarray], name: str) -> bool:
    """Whether Spearman's rank correlation of a coordinate with time is large."""
    values, time = coordinates[name], coordinates["time"]
    ranks = np.array([np.argsort(np.argsort(v)) for v in (values, time)])
    varies = np.ptp(values) > 0.0 and np.ptp(time) > 0.0
    return bool(varies and abs(np.corrcoef(ranks).ravel()[1]) > MONOTONIC_IN_TIME)


def _cross_validated(cells: np.ndarray, residual: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Prediction (n,) of each sample by all blocks of time except its own and the two adjacent ones."""
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
    """Share of the squared residual (n,) that a prediction times any factor >= 0 explains."""
    total, own = float(residual @ residual), float(predicted @ predicted)
    if total <= 0.0 or own <= 0.0:
        return 0.0
    return max(0.0, float(residual @ predicted)) ** 2 / (total * own)


def explained_variance(
    change: np.ndarray, records: Sequence[PreparedRecord], weights: ResidualWeights, effect: Effect
) -> float:
    """Largest share of the square of a change (n,) of the residual that is a force, or, of an effect that multiplies
    the friction, a friction level, that is a function of one of the effect's coordinates."""
    known = [coordinates_of(record) for record in records]

    def scored(name: str) -> np.ndarray:
        return np.concatenate([of[name][pick] for of, s in zip(known, weights.samples) for pick in s.values()])

    if effect.factor is not None:
        change = np.where(scored("direction") < 0.0, -change, change)
    total, best = float(change @ change), 0.0
    for name in effect.coordinates:
        if total <= 0.0 or not all(name in of_record for of_record in known):
            continue
        values = scored(name)
        edges = edges_of(values, name, DRAWN_BINS)
        cells = cells_of(values, np.ones(values.size), edges)
        count = np.maximum(np.bincount(cells, minlength=edges.size - 1), 1)
        sums = np.bincount(cells, change, minlength=edges.size - 1)
        best = max(best, float(np.sum(sums**2 / count)) / total)
    return best


def is_local(change: np.ndarray, records: Sequence[PreparedRecord], weights: ResidualWeights) -> bool:
    """Whether a change (n,) of the residual is next to nothing in most parts of the travel."""
    known = [coordinates_of(record) for record in records]
    if not all("position" in of_record for of_record in known):
        return False
    parts = [of["position"][pick] for of, s in zip(known, weights.samples, strict=True) for pick in s.values()]
    position = np.concatenate(parts)
    place = cells_of(position, np.ones(position.size), edges_of(position, "position", limits.PLACES))
    rows = np.bincount(place, minlength=limits.PLACES)
    power = np.bincount(place, change**2, minlength=limits.PLACES)[rows > 0] / rows[rows > 0]
    return bool(np.median(power) < limits.LOCAL_POWER * np.mean(power))


PERMUTATIONS = 500


@dataclass(frozen=True)
class ResidualMap:
    """Residual over one coordinate."""

    coordinate: str  # its name
    share: float  # cross-validated share of the residual's variance that the coordinate explains, in [0, 1]
    p_value: float  # of the cross-validated prediction, by a sign-flip test over blocks of time
    centres: np.ndarray  # of the bins, (k,), in the coordinate's SI unit
    # forward, backward: mean residual in each bin for either direction of motion, in noise deviations, (k,)
    forward: np.ndarray
    backward: np.ndarray
    # share explained by the coordinate after removal of the time dependence, minus the share explained by time after
    # removal of the dependence on the coordinate
    beside_time: float = 0.0
    # forward_error, backward_error: their standard errors from the scatter of blocks of time, (k,); empty for a
    # spectrum
    forward_error: np.ndarray = field(default_factory=lambda: np.empty(0))
    backward_error: np.ndarray = field(default_factory=lambda: np.empty(0))


def residual_maps(model: Model, problem: Problem, base: ReferenceFit) -> list[ResidualMap]:
    """Maps of the residual of a model, winsorised, in standard deviations of the noise with the weights of `base`, over
    every coordinate of the records, in the order of `order_maps`."""
    rng = np.random.default_rng(0)
    maps: list[ResidualMap] = []
    for channel, learn, judge in paired_samples(model, problem, base):
        maps += [_map(name, learn, judge, rng) for name in common_coordinates(learn, judge)]
        maps.append(_spectrum_map(model, problem.validate_records or problem.fit_records, channel))
    best: dict[str, ResidualMap] = {}
    for m in maps:
        if m.coordinate not in best or m.share > best[m.coordinate].share:
            best[m.coordinate] = m
    return order_maps(list(best.values()))


def compared_with_time(
    maps: Sequence[ResidualMap], model: Model, problem: Problem, base: ReferenceFit
) -> list[ResidualMap]:
    """The maps of a residual that no effect explains, compared with time and ordered accordingly."""
    weighed: dict[str, tuple[float, float]] = {}
    for _, learn, judge in paired_samples(model, problem, base):
        for name in common_coordinates(learn, judge):
            if name in MOTION_COORDINATES:
                predictor = predictor_of(name, learn, judge)
                weighed[name] = max(weighed.get(name, (-1.0, 0.0)), (predictor.share, share_beyond_time(predictor)))
    beside = [replace(m, beside_time=weighed.get(m.coordinate, (0.0, 0.0))[1]) for m in maps]
    return order_maps(beside, nameless=True)


def order_maps(maps: Sequence[ResidualMap], nameless: bool = False) -> list[ResidualMap]:
    """Maps by decreasing weighted share; a coordinate precedes time if its share is nearly as large. Where a `nameless`
    effect is missing, coordinates of the motion with `beside_time` < 0, and the distance travelled, follow time."""

    def weight(m: ResidualMap) -> float:
        return m.share * _SHARE_WEIGHT.get(m.coordinate, 1.0)

    time = max((weight(m) for m in maps if m.coordinate == "time"), default=0.0)

    def place(m: ResidualMap) -> tuple[float, bool]:
        no_more = m.coordinate == "distance_travelled" or (m.coordinate in MOTION_COORDINATES and m.beside_time < 0.0)
        yields = nameless and no_more and time > 0.0
        return (-min(weight(m), time), True) if yields else (-weight(m), False)

    return sorted(maps, key=place)


MOTION_COORDINATES = ("velocity", "direction", "acceleration", "distance_since_reversal", "contact_age", "input")
"""Coordinates of the motion or its input."""

_SHARE_WEIGHT = {"time": 0.85, "distance_travelled": 0.5, "frequency": 0.8}
"""Weight of a share whose predictor is fitted per set of records, or that is the largest of many spectral lines."""


def _map(name: str, learn: Samples, judge: Samples, rng: np.random.Generator) -> ResidualMap:
    """Map of one coordinate, in finer bins than those of its share."""
    predictor = predictor_of(name, learn, judge)
    p_value = _p_value(predictor.residual, predictor.prediction, predictor.block, rng)
    fine = edges_of(predictor.values, name, predictor.drawn)
    ends = np.concatenate([[np.min(predictor.values)], fine[1:-1], [np.max(predictor.values)]])
    cells, half = cells_of(predictor.values, predictor.direction, fine), fine.size - 1
    means = means_of(cells, predictor.residual, 2 * half)
    errors = standard_errors(cells, predictor.residual - means[cells], predictor.block, 2 * half)
    return ResidualMap(
        coordinate=name,
        share=predictor.share,
        p_value=p_value,
        centres=np.array([-1.0, 1.0]) if name == "direction" else 0.5 * (ends[1:] + ends[:-1]),
        forward=means[:half],
        backward=means[half:],
        forward_error=errors[:half],
        backward_error=errors[half:],
    )


def standard_errors(cells: np.ndarray, deviation: np.ndarray, block: np.ndarray, count: int) -> np.ndarray:
    """Standard error (count,) of the mean of each cell, from the sums of its deviations within blocks of time.

    With d the deviations from the mean and n the number of samples of a cell: sqrt(sum over blocks of (sum d)^2) / n.
    Number of the cell, deviation and number of the block are those of each sample, (n,).
    """
    _, place = np.unique(block, return_inverse=True)
    sums = np.zeros((int(place.max()) + 1, count))
    np.add.at(sums, (place, cells), deviation)
    return np.sqrt(np.sum(sums**2, axis=0)) / np.maximum(np.bincount(cells, minlength=count), 1)


def _p_value(residual: np.ndarray, predicted: np.ndarray, block: np.ndarray, rng: np.random.Generator) -> float:
    """p value of a prediction: sign-flip test over blocks of time."""
    inner = np.bincount(block, residual * predicted)
    inner = inner[np.bincount(block) > 0]
    if inner.sum() <= 0.0:
        return 1.0
    signs = rng.choice([-1.0, 1.0], size=(PERMUTATIONS, inner.size))
    return float((1 + np.sum(signs @ inner >= inner.sum())) / (1 + PERMUTATIONS))


def _spectrum_map(model: Model, records: Sequence[PreparedRecord], channel: str) -> ResidualMap:
    """Share of the residual in its strongest narrow band (three spectral lines), with the spectrum as the map."""
    best = ResidualMap("frequency", 0.0, 1.0, np.empty(0), np.empty(0), np.empty(0))
    for record in records:
        if channel not in record.measured or record.size < 2 * (8 + 1):
            continue
        predicted = predict(record, model.effects, model.values)
        y = record.measured[channel]
        r = np.where(record.valid[channel], y - predicted[channel], 0.0) / record.noise[channel]
        corner = 5.0 * max(1.4826 * float(np.median(np.abs(r))), 1.0)
        r = np.clip(r - r.mean(), -corner, corner)
        power = np.abs(np.fft.rfft(r * np.hanning(r.size))) ** 2
        frequency = np.fft.rfftfreq(r.size, record.step)
        total = float(power.sum()) or 1.0
        band = np.convolve(power, np.ones(3), mode="same")
        # Below eight cycles per record a line is a drift.
        k = 8 + int(np.argmax(band[8:]))
        share = float(band[k] / total)
        # Null hypothesis: maximum of n exponentials, P(max > x) = 1 - (1 - exp(-x))^n; conservative for coloured noise.
        local = float(np.median(power[max(8, k // 2) : 2 * k + 9])) / np.log(2.0) + 1e-300
        p = float(min(1.0, power.size * np.exp(-min(power[k] / local, 700.0))))
        if share > best.share:
            rough = min(96, frequency.size)
            edges = np.linspace(0, frequency.size, rough + 1).astype(int)
            mean = np.array([power[a:b].max() for a, b in pairwise(edges)])
            centre = 0.5 * (frequency[edges[:-1]] + frequency[np.minimum(edges[1:], frequency.size - 1)])
            best = ResidualMap("frequency", share, p, centre, np.sqrt(mean / r.size), np.zeros(rough))
    return best
