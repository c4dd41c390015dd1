"""Confidence intervals and correlation of fitted values, robust to correlated residuals, and their identifiability.

Systematic errors do not appear in the scatter of the residuals. Filtering: the motion is filtered before a force law is
evaluated along it, which smooths a nonlinear law (a narrow Stribeck curve, a short pitch). The error is taken as the
change of the prediction at half the filter width.

Skew: the channels of a row are assumed to be simultaneous, which is accurate to a few hundredths of a sampling step.

Each is a change (n,) of the weighted residual by one standard deviation; it shifts the fitted values linearly.

The principal angles between the spans of two sets of sensitivities A and B, base model projected out of both, are

    cos(angle_k) = k-th singular value of Q_A^T Q_B,   Q orthonormal

(Bjorck and Golub, Math. Comp. 27 (1973) 579). Where the angle between the change that one effect makes and the span of
another is small, the other could replace it, to first order.
"""

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.special import stdtrit

from sim.effects.effect import Effect, Parameter
from sysid.estimation.fit import FittedModel
from sysid.estimation.misfit import LOSS_CORNER, at_half_width, blocks, huber_square, weighted_residual
from sysid.estimation.screening import orthonormal, project_out
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import predict
from sysid.prediction.prepared_record import PreparedRecord
from sysid.signals import WHITE, NoiseSpectrum

BLOCKS_PER_RECORD = 40

TWO_SIDED, NORMAL = 0.975, 1.959964
"""Probability below the two-sided 95 % point of a distribution, and that point of the normal one."""

IDENTIFIABLE = 1e-9
"""Eigenvalue of the scaled information matrix, relative to the largest, up to which its direction is not
identifiable."""

WIDEST = 1e3
"""Half-width of an interval over the value, or its typical size, beyond which the value is not identifiable."""

UNKNOWN = 1e12
"""Variance of a relative change that is not identifiable."""

LEAST_EXPONENT = 0.05
"""Exponent of a value, over the largest, below which it is left out of a combination in words."""

LEAST_CORRELATION, MOST_CORRELATION = 0.05, 0.995
"""Least autocorrelation of a residual at a lag of one sample that is not white, and largest coefficient."""


@dataclass(frozen=True)
class Interval:
    """A fitted value with its standard deviation and 95 % interval, which are infinite if it is not identifiable."""

    value: float
    std: float
    low: float
    high: float
    at_bound: bool = False


@dataclass(frozen=True)
class Intervals:
    """Intervals of every fitted value by key; keys in the order of their correlation (p, p), NaN where not
    identifiable; directions in parameter space that are not identifiable, as `a` against `b`; and covariance (p, p) of
    the relative changes of the values, `UNKNOWN` along these directions."""

    by_key: dict[str, Interval]
    keys: tuple[str, ...]
    correlation: np.ndarray
    unidentified: tuple[str, ...]
    relative: np.ndarray | None = None


@dataclass(frozen=True)
class _Information:
    """Information matrix of the free values (f of p) of a fit, each scaled by the length `size` of its column: columns
    of length one (n, f), slope `inner` of Huber's influence (n,), eigenvectors, of which some are identifiable, R of
    the inverse R R^T on these (f, r), and precision of the priors times their standard deviation (f,)."""

    free: np.ndarray
    size: np.ndarray
    columns: np.ndarray
    inner: np.ndarray
    vectors: np.ndarray
    identifiable: np.ndarray
    root: np.ndarray
    prior: np.ndarray


def _information(fitted: FittedModel) -> _Information:
    """H = J^T J within Huber's corner, plus the precision of the priors."""
    fit = fitted.fit
    norms = np.linalg.norm(fit.jacobian, axis=0)
    precision = fit.precision if fit.precision.size == len(fit.keys) else np.zeros(len(fit.keys))
    size = np.where(norms > 0.0, norms, np.sqrt(precision))
    bound = np.array([key in fit.at_bound for key in fit.keys])
    free = (size > 0.0) & ~bound
    columns = fit.jacobian[:, free] / size[free]
    known = precision[free] / size[free] ** 2
    stds = np.array([0.0 if u.prior is None else u.prior.std for u in fitted.model.unknowns])[free] * size[free]
    inner = np.where(fit.weights >= 1.0, 1.0, 0.0)
    values, vectors = np.linalg.eigh(columns.T @ (inner[:, None] * columns) + np.diag(known))
    keep = values > IDENTIFIABLE * max(values.max(initial=0.0), 1e-300)
    root = vectors[:, keep] / np.sqrt(values[keep])
    return _Information(free, size, columns, inner, vectors, keep, root, known * stds)


def _undetermined(information: _Information, free_keys: Sequence[str]) -> list[list[str]]:
    """Free values that the records determine only together, for each direction that is not identifiable."""
    lost = information.vectors[:, ~information.identifiable].T
    return [[free_keys[int(i)] for i in np.argsort(-np.abs(v)) if abs(v[i]) > 0.3] for v in lost]


def is_determined(fitted: FittedModel, effect: str) -> bool:
    """Whether the records determine every value of an effect, by name, or only some of them together."""
    information = _information(fitted)
    free_keys = [k for k, f in zip(fitted.fit.keys, information.free, strict=True) if f]
    together = itertools.chain.from_iterable(_undetermined(information, free_keys))
    return all(key.rpartition(".")[0] != effect for key in together)


def intervals(fitted: FittedModel, records: Sequence[PreparedRecord]) -> Intervals:
    """95 % intervals from a cluster-robust (sandwich) covariance with blocks of time as clusters.

        cov = H^-1 (sum_b g_b g_b^T + (g_b g_b+1^T + g_b+1 g_b^T)/2) H^-1 * (B - 1)/B
        g_b = (I - H_b H^-1)^-1 sum over a block of J^T w r,   H = sum_b H_b = J^T J within Huber's corner

    with Student's t on 2/3 B - p degrees of freedom. The factor before the sum is the leverage correction CR3 (Bell and
    McCaffrey 2002; Cameron and Miller 2015). The weight 1/2 of the neighbouring block is Bartlett's (Newey and West
    1987) for correlation across the edge of a block; it costs a third of the degrees of freedom. The interval is at
    least that of independent noise, and that of noise with the residual's autocorrelation, with the normal
    distribution, since these are estimated from all samples. Correlation, filtering and uneven noise widen the
    interval; faster sampling does not narrow it. A prior enters as one more observation, and the systematic errors
    (`sysid.estimation.covariance`) as further terms of rank one.
    """
    fit = fitted.fit
    if not fit.keys:
        return Intervals({}, (), np.empty((0, 0)), ())
    information = _information(fitted)
    numbers = blocks(records, fitted.weights, BLOCKS_PER_RECORD)
    count = int(np.unique(numbers).size)
    covariance = _covariance(fitted, records, information, numbers, count)
    free, root = information.free, information.root
    # Lower limits: with few blocks, or noise correlated over a block, the estimate may be smaller.
    limits = [np.diag(covariance), np.diag(root @ root.T), np.diag(_autoregressive(fitted, information))]
    deviations = np.sqrt(np.maximum(limits, 0.0)) / information.size[free]
    std, reach = np.full(len(fit.keys), np.inf), np.full(len(fit.keys), np.inf)
    std[free] = np.max(deviations, axis=0)
    student = stdtrit(max(int(count / 1.5) - int(free.sum()), 1), TWO_SIDED)
    reach[free] = np.max(np.array([[student], [NORMAL], [NORMAL]]) * deviations, axis=0)
    free_keys = [k for k, f in zip(fit.keys, free, strict=True) if f]
    undetermined = _undetermined(information, free_keys)
    unidentified = [" against ".join(strong[:3]) for strong in undetermined]
    for key in itertools.chain.from_iterable(undetermined):
        std[fit.keys.index(key)] = reach[fit.keys.index(key)] = np.inf
    for key in _gap_keys(fitted, records):
        reach[fit.keys.index(key)] = half = _profile_reach(fitted, records, key)
        std[fit.keys.index(key)] = half / NORMAL
    typical = np.array([max(abs(fit.values[u.key]), u.size) for u in fitted.model.unknowns])
    wide = np.isfinite(std) & (reach > WIDEST * typical)
    std[wide] = reach[wide] = np.inf
    if wide.any():
        unidentified.append(" against ".join(key for key, one in zip(fit.keys, wide, strict=True) if one))
    # A value at its bound is not free, and has no finite deviation.
    result = {
        key: Interval(value := fit.values[key], std_of, value - half, value + half, key in fit.at_bound)
        for key, std_of, half in zip(fit.keys, std.tolist(), reach.tolist(), strict=True)
    }
    correlation = np.full((len(fit.keys), len(fit.keys)), np.nan)
    index = np.flatnonzero(free)
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation[np.ix_(index, index)] = covariance / np.outer(scale, scale)
    sizes = information.size[free] * np.array([fit.values[key] or np.inf for key in free_keys])
    lost = information.vectors[:, ~information.identifiable] / sizes[:, None]
    lost = lost / np.maximum(np.linalg.norm(lost, axis=0), 1e-300)
    relative = np.full((len(fit.keys), len(fit.keys)), np.nan)
    relative[np.ix_(index, index)] = covariance / np.outer(sizes, sizes) + UNKNOWN * lost @ lost.T
    return Intervals(result, fit.keys, correlation, tuple(unidentified), relative)


def has_size(known: Intervals, effect: Effect) -> bool:
    """Whether the intervals of an effect exclude zero for one of its free amplitudes or levels, and for one of its free
    scales, such as a velocity or a length: a law of no width acts in no row. True of an effect without any."""
    values = [(p, known.by_key.get(f"{effect.name}.{p.name}")) for p in effect.parameters]
    free = [(p, one.low > 0.0 or one.high < 0.0) for p, one in values if one is not None and not one.at_bound]
    amplitudes = [differs for p, differs in free if p.role in ("amplitude", "level")]
    scales = [differs for p, differs in free if p.role == "shape" and p.low > 0.0]
    return all(any(some) for some in (amplitudes, scales) if some)


def _gap_keys(fitted: FittedModel, records: Sequence[PreparedRecord]) -> list[str]:
    """Keys of the fitted widths of gaps behind an imposed motion: a row is all or nothing as such a gap closes, so that
    they have no derivative."""
    if not all(isinstance(record, ForceBalanceRecord) and record.acceleration is None for record in records):
        return []
    gaps = {effect.name for effect in fitted.model.effects if effect.opens_gap}
    return [key for key in fitted.fit.keys if key.rpartition(".")[0] in gaps and key not in fitted.fit.at_bound]


FIRST_STEP, STEP_FACTOR, LONGEST_STEP = 1e-5, 1.4, 1.0
"""First distance from a fitted value, over the value, at which its loss is evaluated, the factor of the next, and the
distance from which the value has no interval."""


def _profile_reach(fitted: FittedModel, records: Sequence[PreparedRecord], key: str) -> float:
    """Half-width of the 95 % interval of the likelihood ratio of one value, the others fixed: the loss rises there by
    half of the 95 % point of chi squared with one degree of freedom, NORMAL^2 / 2."""
    value = fitted.fit.values[key]

    def loss(at: float) -> float:
        moved = {**fitted.model.values, key: at}
        return 0.5 * float(np.sum(huber_square(weighted_residual(fitted.model, records, fitted.weights, moved))))

    base, reaches = loss(value), []
    for side in (-1.0, 1.0):
        step = FIRST_STEP
        while step < LONGEST_STEP and loss(value * (1.0 + side * step)) - base < 0.5 * NORMAL**2:
            step *= STEP_FACTOR
        reaches.append(step * value if step < LONGEST_STEP else np.inf)
    return max(reaches)


def _covariance(
    fitted: FittedModel, records: Sequence[PreparedRecord], information: _Information, numbers: np.ndarray, count: int
) -> np.ndarray:
    """Covariance (f, f) of the scaled free values; `numbers` (n,) of the `count` blocks of time."""
    root, columns, inner = information.root, information.columns, information.inner
    scores = block_scores(columns @ root, inner, fitted.fit.weights * fitted.fit.residual, numbers)
    crossed = scores[:-1].T @ scores[1:]
    for last in range(BLOCKS_PER_RECORD, scores.shape[0], BLOCKS_PER_RECORD):
        # The last block of a record has no neighbour in the next record.
        crossed -= np.outer(scores[last - 1], scores[last])
    meat = (scores.T @ scores + 0.5 * (crossed + crossed.T)) * (count - 1) / count
    covariance = root @ (meat + root.T @ np.diag(information.prior**2) @ root) @ root.T
    for change in systematic_errors(fitted, records):
        shift = root @ (root.T @ (columns.T @ (inner * change)))
        covariance += np.outer(shift, shift)
    return covariance


LEAST_SAMPLES = 3
"""Samples of a channel that have autocorrelations at lags of one and two samples."""


def _autoregressive(fitted: FittedModel, information: _Information) -> np.ndarray:
    """Covariance (f, f) of the scaled free values for noise of unit variance with the autocorrelation of the residual:
    white noise plus an autoregression of coefficient c = r2/r1 and variance r1/c, from the lags of one and two
    samples."""
    root, total, start = information.root, np.diag(information.prior**2), 0
    columns = information.columns * information.inner[:, None]
    for samples in fitted.weights.samples:
        for pick in samples.values():
            part = slice(start, start + pick.size)
            start += pick.size
            if pick.size < LEAST_SAMPLES:
                continue
            r = np.clip(fitted.fit.residual[part], -LOSS_CORNER, LOSS_CORNER)
            one, two = (float(r[lag:] @ r[: r.size - lag]) / max(float(r @ r), 1e-300) for lag in (1, 2))
            c = min(max(two / one, 0.0), MOST_CORRELATION) if one > LEAST_CORRELATION else 0.0
            spectrum = NoiseSpectrum(c, 1.0 - min(one / c, 1.0)) if c > 0.0 else WHITE
            transformed = np.fft.rfft(columns[part], 2 * pick.size, axis=0)
            power = np.full(transformed.shape[0], 2.0) * spectrum.power(np.linspace(0.0, np.pi, transformed.shape[0]))
            power[[0, -1]] *= 0.5
            total = total + np.real(transformed.conj().T @ (power[:, None] * transformed)) / (2 * pick.size)
    return root @ (root.T @ total @ root) @ root.T


MOST_LEVERAGE = 0.98
"""Upper limit of the leverage of one block in the correction."""


def block_scores(columns: np.ndarray, inner: np.ndarray, influence: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Score (B, p) of each block of time, corrected for the leverage of the block."""
    scores = np.zeros((int(numbers.max()) + 1, columns.shape[1]))
    np.add.at(scores, numbers, columns * influence[:, None])
    order = np.argsort(numbers, kind="stable")
    edges = np.searchsorted(numbers[order], np.arange(scores.shape[0] + 1))
    for b in range(scores.shape[0]):
        own = columns[order[edges[b] : edges[b + 1]]] * inner[order[edges[b] : edges[b + 1]], None]
        leverage, axes = np.linalg.eigh(own.T @ own)
        scores[b] = axes @ ((axes.T @ scores[b]) / (1.0 - np.minimum(leverage, MOST_LEVERAGE)))
    return scores


CHANNEL_SKEW = 0.06
"""Inter-channel skew: standard deviation of the sampling time of a channel in its row, in sampling steps (assumed)."""


def systematic_errors(fitted: FittedModel, records: Sequence[PreparedRecord]) -> list[np.ndarray]:
    """Changes (n,) of the weighted residual, each by one standard deviation of a systematic error.

    The order of samples is that of `sysid.estimation.misfit.weighted_residual`. Empty for an actuator tip: its voltages
    are not filtered, and its channels change little within a step.
    """
    if not any(isinstance(record, ForceBalanceRecord) for record in records):
        return []
    channels = list(records[0].measured)
    skewed: dict[str, list[np.ndarray]] = {channel: [] for channel in channels}
    filtered: list[np.ndarray] = []
    for record, scales, samples in zip(records, fitted.weights.scored_std, fitted.weights.samples, strict=True):
        assert isinstance(record, ForceBalanceRecord)
        predicted = predict(record, fitted.model.effects, fitted.model.values)
        for channel, pick in samples.items():
            late = CHANNEL_SKEW * np.gradient(predicted[channel])[pick] / scales[channel]
            for other in channels:
                skewed[other].append(late if other == channel else np.zeros(pick.size))
            finer = at_half_width(fitted.model, record, channel)
            filtered.append((predicted[channel] if finer is None else finer)[pick] / scales[channel])
            filtered[-1] -= predicted[channel][pick] / scales[channel]
    changes = [np.concatenate(parts) for parts in (*skewed.values(), filtered)]
    return [change for change in changes if np.isfinite(change).all() and change.any()]


STRONG_CORRELATION = 0.9
"""Absolute correlation from which two fitted values are reported as strongly correlated."""

LEAST_OWN = 1e-4
"""Norm of the part of a sensitivity orthogonal to the base model, relative to the total, below which it is taken as
linearly dependent."""


def identifiability_report(fitted: FittedModel, known: Intervals) -> list[str]:
    """Sentences on values that are not identifiable or strongly correlated."""
    hidden = fitted.model.nuisances
    inactive, at_bound = ([k for k in keys if k not in hidden] for keys in (fitted.fit.inactive, fitted.fit.at_bound))
    inactive = [key for key in inactive if key not in known.by_key or not np.isfinite(known.by_key[key].std)]
    words = [f"{public_key(key)} has no influence in these records." for key in inactive]
    if at_bound:
        *others, last = map(public_key, at_bound)
        several = f"{', '.join(others)} and {last} are at their bounds; they have no intervals."
        words.append(several if others else f"{last} is at its bound; it has no interval.")
    words += [
        "Only a combination is identifiable from these records, not each value alone: "
        + " against ".join(public_key(k) for k in text.split(" against "))
        + f".{known_combination(known, text.split(' against '))}"
        for text in known.unidentified
        if " against " in text
    ]
    words += [
        f"{public_key(key)} is not identifiable from these records: its interval is wider than a factor of 1000."
        for key in known.unidentified
        if " against " not in key and key not in hidden
    ]
    strong = np.abs(np.nan_to_num(known.correlation)) > STRONG_CORRELATION
    count, label = connected_components(strong, directed=False) if known.keys else (0, np.empty(0))
    shown = [k for k, key in enumerate(known.keys) if key not in hidden]
    groups = ([k for k in shown if label[k] == group] for group in range(count))
    words += [_correlated(group, known) for group in groups if len(group) > 1]
    if not fitted.fit.converged:
        words.append(
            "The fit stopped before it converged: values and intervals are approximate; state known values, or "
            "better start values, in [model.parameters]."
        )
    return words


def known_combination(known: Intervals, keys: Sequence[str]) -> str:
    """The product of powers of fitted values that is known best, as a sentence; empty where none is known to a factor.

    With C the covariance of the relative changes d of the values, the relative change of prod_k value_k^u_k is u . d,
    to first order: of unit vectors u the eigenvector of the smallest eigenvalue of C has the smallest variance.
    """
    places = [known.keys.index(key) for key in keys]
    matrix = np.full((1, 1), np.nan) if known.relative is None else known.relative[np.ix_(places, places)]
    if not np.isfinite(matrix).all():
        return ""
    variances, vectors = np.linalg.eigh(matrix)
    largest = vectors[np.argmax(np.abs(vectors[:, 0])), 0]
    powers, spread = vectors[:, 0] / largest, NORMAL * float(np.sqrt(max(variances[0], 0.0)) / abs(largest))
    parts = [(public_key(k), f"{u:.2g}") for k, u in zip(keys, powers, strict=True) if abs(u) >= LEAST_EXPONENT]
    text = " * ".join(key if power == "1" else f"{key}^{power}" for key, power in parts)
    return f" Known is {text}, to {100.0 * spread:.2g} %." if len(parts) > 1 and spread < 1.0 else ""


def _correlated(group: list[int], known: Intervals) -> str:
    names = [public_key(known.keys[k]) for k in group]
    if len(group) == 2:
        r = float(known.correlation[group[0], group[1]])
        return f"{names[0]} and {names[1]} are strongly correlated ({r:+.2f})."
    largest = float(np.max(np.abs(known.correlation[np.ix_(group, group)][np.triu_indices(len(group), 1)])))
    return (
        f"{', '.join(names[:-1])} and {names[-1]} are strongly correlated (up to {min(largest, 0.999):.3g}): "
        "a change of one is compensated by the others."
    )


def correlation_json(known: Intervals) -> dict[str, Any]:
    """Correlations of the fitted values: `keys`, and `matrix` with null for a value that is not identifiable."""
    matrix = [[None if not np.isfinite(v) else round(float(v), 4) for v in row] for row in known.correlation]
    return {"keys": [public_key(key) for key in known.keys], "matrix": matrix}


def public_key(key: str) -> str:
    """A parameter key under the public name of its effect: `stribeck:rational.velocity` -> `stribeck.velocity`."""
    effect, _, name = key.rpartition(".")
    return f"{effect.partition(':')[0]}.{name}" if ":" in effect else key


def principal_angles(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Angles (min(p, q),), rad, rising, between the spans of orthonormal bases (n, p) and (n, q)."""
    cosines = np.linalg.svd(one.T @ other, compute_uv=False)
    # The arc cosine loses half its digits near one: small angles are taken from their sines.
    small, large = (one, other) if one.shape[1] <= other.shape[1] else (other, one)
    sines = np.linalg.svd(project_out(small, large), compute_uv=False)[::-1]
    angles = np.arccos(np.clip(cosines, -1.0, 1.0))
    return np.where(angles < 0.1, np.arcsin(np.clip(sines[: angles.size], 0.0, 1.0)), angles)


def orthogonal_sensitivities(fitted: FittedModel, base: FittedModel) -> np.ndarray:
    """Orthonormal basis (n, p) of the sensitivities to the added values, orthogonal to those of the base model.

    Both fits score the same samples with the same standard deviations.
    """
    new = np.array([key not in base.fit.keys for key in fitted.fit.keys], dtype=bool)
    columns = fitted.fit.jacobian[:, new]
    norms = np.linalg.norm(columns, axis=0)
    active = norms > 0.0
    free = project_out(columns[:, active] / norms[active], orthonormal(base.fit.jacobian))
    return orthonormal(free[:, np.linalg.norm(free, axis=0) > LEAST_OWN])


def substitution_angle(effect: FittedModel, other: FittedModel, base: FittedModel) -> float | None:
    """Angle, rad, between the change of the residual by one effect and the span of another; none without a change.

    The angle is not symmetric: of two effects with different numbers of values, one may be able to replace the other
    and not the reverse. The span of `other` includes the change that its own fit makes, which at large values (a long
    lag) differs from its sensitivities.
    """
    basis = orthonormal(base.fit.jacobian)

    def change(grown: FittedModel) -> np.ndarray | None:
        whole = base.fit.residual - grown.fit.residual
        free = project_out(whole, basis)
        size = float(np.linalg.norm(free))
        return None if size <= LEAST_OWN * float(np.linalg.norm(whole)) else free / size

    wanted, made = change(effect), change(other)
    span = orthogonal_sensitivities(other, base)
    if made is not None:
        span = orthonormal(np.column_stack([span, made]))
    if wanted is None or span.shape[1] == 0:
        return None
    return float(principal_angles(wanted[:, None], span)[0])


def rig_values_at_bound(fitted: FittedModel, base: FittedModel) -> list[str]:
    """Keys of the rig's values that are at a bound, and are not in the fit without the effects, `base`."""
    return [key for key in fitted.fit.at_bound if key.startswith("rig.") and key not in base.fit.at_bound]


def implausible(fitted: FittedModel, added: Collection[str]) -> str | None:
    """Reason why a fitted model explains nothing although its error is low, in words; None if there is none.

    A value at an end of its range means that the fit wants to leave the range: the effect stands for something else.
    Ends that are a limit of the law itself (`Parameter.natural`) are excepted, and so is zero.
    """
    parameters = {f"{e.name}.{p.name}": p for e in fitted.model.effects if e.name in added for p in e.parameters}
    for unknown in fitted.model.unknowns:
        key = unknown.key
        if key not in fitted.fit.at_bound:
            continue
        upper = fitted.fit.values[key] >= unknown.high
        if key in parameters and not _natural(parameters[key], upper):
            end = unknown.high if upper else unknown.low
            unit = parameters[key].unit if parameters[key].unit in ("s", "Hz") else ""
            return f"{key} is at its {'upper' if upper else 'lower'} bound, {end:.3g} {unit}".strip()
    return None


def _natural(parameter: Parameter, upper: bool) -> bool:
    if parameter.role == "phase" or parameter.natural in ("both", "high" if upper else "low"):
        return True
    return not upper and parameter.low == 0.0 and parameter.scan is None
