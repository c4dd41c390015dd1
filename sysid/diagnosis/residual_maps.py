"""Residual maps: mean residual over each coordinate and direction of motion, with explained share and p value."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from sysid.diagnosis.coordinate_dependence import (
    Samples,
    cells_of,
    common_coordinates,
    edges_of,
    means_of,
    paired_samples,
    predictor_of,
    share_beyond_time,
)
from sysid.estimation.misfit import ResidualWeights
from sysid.prediction.model import Model, predict
from sysid.prediction.prepared_record import PreparedRecord

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


def residual_maps(
    model: Model,
    fit_records: Sequence[PreparedRecord],
    fit_weights: ResidualWeights,
    held_out: Sequence[PreparedRecord],
    held_out_weights: ResidualWeights,
    seed: int = 0,
) -> list[ResidualMap]:
    """Maps of the residual over every coordinate of the records, in the order of `order_maps`.

    Residuals are in standard deviations of the noise, winsorised.
    """
    rng = np.random.default_rng(seed)
    maps: list[ResidualMap] = []
    for channel, learn, judge in paired_samples(model, fit_records, fit_weights, held_out, held_out_weights):
        maps += [_map(name, learn, judge, rng) for name in common_coordinates(learn, judge)]
        maps.append(_spectrum_map(model, held_out or fit_records, channel))
    best: dict[str, ResidualMap] = {}
    for m in maps:
        if m.coordinate not in best or m.share > best[m.coordinate].share:
            best[m.coordinate] = m
    return order_maps(list(best.values()))


def compared_with_time(
    maps: Sequence[ResidualMap],
    model: Model,
    fit_records: Sequence[PreparedRecord],
    fit_weights: ResidualWeights,
    held_out: Sequence[PreparedRecord],
    held_out_weights: ResidualWeights,
) -> list[ResidualMap]:
    """The maps of a residual that no effect explains, compared with time and ordered accordingly."""
    weighed: dict[str, tuple[float, float]] = {}
    for _, learn, judge in paired_samples(model, fit_records, fit_weights, held_out, held_out_weights):
        for name in common_coordinates(learn, judge):
            if name in MOTION_COORDINATES:
                predictor = predictor_of(name, learn, judge)
                weighed[name] = max(weighed.get(name, (-1.0, 0.0)), (predictor.share, share_beyond_time(predictor)))
    beside = [replace(m, beside_time=weighed.get(m.coordinate, (0.0, 0.0))[1]) for m in maps]
    return order_maps(beside, nameless=True)


def order_maps(maps: Sequence[ResidualMap], nameless: bool = False) -> list[ResidualMap]:
    """Maps by decreasing weighted share; a coordinate precedes time if its share is nearly as large.

    Args:
        maps: of one residual.
        nameless: no effect of the library is missing. Then coordinates of the motion with `beside_time` < 0, and the
            distance travelled, follow time.
    """

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
    cells, half = cells_of(predictor.values, predictor.direction, fine), fine.size - 1
    means = means_of(cells, predictor.residual, 2 * half)
    errors = standard_errors(cells, predictor.residual - means[cells], predictor.block, 2 * half)
    return ResidualMap(
        coordinate=name,
        share=predictor.share,
        p_value=p_value,
        centres=np.array([-1.0, 1.0]) if name == "direction" else _centres(fine[1:-1], predictor.values),
        forward=means[:half],
        backward=means[half:],
        forward_error=errors[:half],
        backward_error=errors[half:],
    )


def standard_errors(cells: np.ndarray, deviation: np.ndarray, block: np.ndarray, count: int) -> np.ndarray:
    """Standard error (count,) of the mean of each cell, from the sums of its deviations within blocks of time.

    With d the deviations from the mean and n the number of samples of a cell: sqrt(sum over blocks of (sum d)^2) / n.

    Args:
        cells: number of the cell of each sample, (n,).
        deviation: from the mean of the cell, (n,).
        block: number of the block of time of each sample, (n,).
        count: number of cells.
    """
    _, place = np.unique(block, return_inverse=True)
    sums = np.zeros((int(place.max()) + 1, count))
    np.add.at(sums, (place, cells), deviation)
    return np.sqrt(np.sum(sums**2, axis=0)) / np.maximum(np.bincount(cells, minlength=count), 1)


def _centres(inner: np.ndarray, values: np.ndarray) -> np.ndarray:
    low, high = float(np.min(values)), float(np.max(values))
    full = np.concatenate([[low], inner, [high]])
    return 0.5 * (full[1:] + full[:-1])


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
