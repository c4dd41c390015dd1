"""Velocity and direction of a motion from a noisy position, and statements on how well they are known.

The position is filtered as much as its blur remains hidden in the noise: what is left of the noise acts on friction as
a bias, that of a Stribeck curve or of bristles, and not only as scatter. A slow motion is filtered at least until its
mean speed is `CLEAR_SPEED` standard deviations of the velocity's noise.
"""

from collections.abc import Iterable, Mapping
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from sim.numerics.compilation import compiled
from sysid.noise.estimate import Noise
from sysid.prediction.force_balance.record import REST_SIGMAS, ForceBalanceRecord, VelocityAgreement
from sysid.prediction.force_balance.reversals import KINK_WIDTHS
from sysid.signals import WHITE, GaussianFilter, dilated, filled, runs

CLEAR_SPEED = 2.0 * REST_SIGMAS
"""Mean speed, in standard deviations of the velocity's noise, at which the motion is distinct from rest."""

STAIRCASE = 0.4
"""Width of a filter, in times between two quantisation steps, from which the steps do not show in the velocity: their
fundamental is attenuated by exp(-2 pi^2 0.4^2) = 0.04."""

WIDTH_RATIO = 1.2
"""Ratio of two widths that are tried."""

UNKNOWN_SIGMAS = 2.0
"""A moving row within this many standard deviations of its velocity's noise has an unknown direction."""

UNKNOWN_SHARE = 0.2
"""Share of such rows above which the user is warned."""

CONTRADICTION = 0.05
"""Relative difference of a logged velocity from the derivative of the position above which the user is warned."""

LATE_ROWS = 2.0
"""Lag in rows, between a logged velocity and the derivative of the position, above which the user is warned."""

UNRELATED, FOREIGN, WIDER = 0.5, 0.87, (4.0, 16.0)
"""Part of the derivative that no factor and lag explain, from which neither is stated; that from which the two have
nothing in common (a correlation of 0.5), and the wider filters at which they must not have either."""

UNIT_FACTORS = {
    "degrees and radians": np.pi / 180.0,
    "rpm and rad/s": np.pi / 30.0,
    "turns and radians": 2.0 * np.pi,
    "seconds and minutes": 60.0,
    "inches and millimetres": 25.4,
    "units a thousand times apart": 1e3,
}
"""Factors between units that are confused; a factor within `CONTRADICTION` of one of them, or of its inverse, is
stated with it."""

LONGEST_LAG = 50
"""Part of the record, one over this, up to which such a lag is searched."""


def position_noise(noise: Noise | None) -> float:
    """Standard deviation of a position's noise, its quantisation included, m; zero where none was found."""
    if noise is None:
        return 0.0
    quantum = noise.quantisation_step if noise.without_quantisation is None else None
    return float(np.hypot(noise.value, (quantum or 0.0) / np.sqrt(12.0)))


def motion_filter_width(position: np.ndarray, noise: Noise | None, gap: np.ndarray | None = None) -> float:
    """Width in rows of the filter of a noisy position (n,), at most a fortieth of the record: the largest one that
    blurs the motion nowhere by more than its noise, and at least that at which its differences are clear of the noise;
    where no width is enough for that, the one of the largest ratio of speed to noise. Rows beside a `gap` (n,) are not
    compared."""
    std = position_noise(noise)
    if noise is None or std == 0.0:
        return 0.0
    return max(_clear_width(position, noise, std), unblurred_width(position, noise, gap))


def _widths(rows: int) -> list[float]:
    """Widths in rows that are tried."""
    widths = [0.7]
    while WIDTH_RATIO * widths[-1] <= max(rows / 40.0, 1.0):
        widths.append(WIDTH_RATIO * widths[-1])
    return widths


def _clear_width(position: np.ndarray, noise: Noise, std: float) -> float:
    """Least width in rows at which the mean speed is clear of its noise `std`, and the steps of an encoder do not
    show."""
    quantum = noise.quantisation_step or 0.0
    coarse = quantum if quantum > (noise.without_quantisation or noise.value) else 0.0
    best, clearest = 0.0, 0.0
    for width in (0.0, *_widths(position.size)):
        if width == 0.0:
            speed = float(np.mean(np.abs(np.diff(position))))
            own = std * float(np.sqrt(2.0 * (1.0 - noise.autocorrelation)))
        else:
            smooth = GaussianFilter(width, 1.0, position.size)
            speed, own = float(np.mean(np.abs(smooth(position, 1)))), std * smooth.noise_gain(1, noise.spectrum)
        ratio = speed / own
        if ratio >= CLEAR_SPEED and width * speed >= STAIRCASE * coarse:
            return width
        if ratio > clearest:
            best, clearest = width, ratio
    return best


def unblurred_width(channel: np.ndarray, noise: Noise, gap: np.ndarray | None = None) -> float:
    """Largest width in rows up to which what a filter removes of a channel (n,) is noise everywhere but beside a `gap`
    (n,) (O. V. Lepskii, Theory Prob. Appl. 35 (1991) 454): filtered itself, it exceeds nowhere the deviation that noise
    exceeds in one record of 1000."""
    std = position_noise(noise)
    best, unlikely = 0.0, NormalDist().inv_cdf(1.0 - 0.5e-3 / channel.size)
    angle = np.geomspace(1e-6, np.pi, 2000)
    for width in _widths(channel.size):
        smooth = GaussianFilter(width, 1.0, channel.size)
        removed = smooth(channel - smooth(channel))
        if gap is not None:
            removed[dilated(gap, 2 * smooth.half)] = 0.0
        passed = np.exp(-0.5 * (width * angle) ** 2)
        gain = float(np.sqrt(np.trapezoid((passed - passed**2) ** 2 * noise.spectrum.power(angle), angle) / np.pi))
        if np.max(np.abs(removed[smooth.margin : -smooth.margin]), initial=0.0) > unlikely * std * gain:
            break
        best = width
    return best


class Direction(NamedTuple):
    """Sign (n,) of a motion, that of the last motion at rest, 0 before the first one; and standard deviation of the
    times of its reversals, rows."""

    sign: np.ndarray
    timing: float


def direction_from_velocity(position: np.ndarray, velocity: np.ndarray, noise: float, width: float) -> Direction:
    """Direction of a motion from its filtered position (n,) and velocity (n,), per row.

    Between two opposite motions the direction changes at the last zero of the velocity before the second one; after a
    rest, where the line along which the second motion begins meets the position at rest.
    """
    certain = np.where(np.abs(velocity) > REST_SIGMAS * noise, np.sign(velocity), 0.0)
    rows = np.flatnonzero(certain)
    last = np.maximum.accumulate(np.where(certain != 0.0, np.arange(certain.size), -1))
    sign = np.where(last >= 0, certain[np.maximum(last, 0)], 0.0)
    timing, clear = [], int(np.ceil(KINK_WIDTHS * width))
    for k in np.flatnonzero(certain[rows[1:]] != certain[rows[:-1]]).tolist():
        before, after = int(rows[k]), int(rows[k + 1])
        change = before + 1 + int(np.flatnonzero(velocity[before:after] * certain[after] < 0.0)[-1])
        under_way, between = min(after + clear, velocity.size - 1), slice(before + clear, after - clear)
        if after - before > 3 * clear and velocity[under_way] * certain[after] > 0.0:
            # At rest the velocity has no trend; where it passes zero, its halves differ by half of its change.
            halves = np.array_split(velocity[between], 2)
            if abs(np.mean(halves[1]) - np.mean(halves[0])) < 0.5 * REST_SIGMAS * noise:
                rest = float(np.mean(position[between]))
                onset = under_way - (position[under_way] - rest) / velocity[under_way]
                change = int(np.clip(np.ceil(onset), before + clear, after))
        sign[change:after] = certain[after]
        # The time is uncertain by the velocity's noise over its slope, at most by the filter's width.
        timing.append(min(noise * (after - before) / abs(velocity[after] - velocity[before]), width))
    return Direction(sign, float(np.median(timing)) if timing else 0.0)


LEFT_BY = 6.0
"""Standard deviations of the position by which a body has left a turning point when its new direction is certain."""

RESTS_FOR = 10
"""Rows, or widths of the filter, after or before which a body that has moved by less than that distance is at rest."""


def known_direction(position: np.ndarray, std: float, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Direction (n,) of a motion from a noisy position (n,), filtered by `width` rows: 1, -1, or 0 where not known; and
    the row (n,) whose friction level holds: the row itself, or at rest the first row of the rest.

    A direction holds from where the body has left the last turning point by `LEFT_BY` standard deviations `std` up to
    half of that distance before the next one. A body that rests has that of its last motion, whose friction remains, up
    to where the next motion may have begun; before its first motion friction may be anything up to its level.
    """
    band = LEFT_BY * std
    turns = _turning_rows(np.ascontiguousarray(position, dtype=float), band)
    stroke = np.clip(np.searchsorted(turns, np.arange(position.size), side="right"), 1, turns.size - 1)
    left, ahead = position[turns[stroke - 1]], position[turns[stroke]]
    sign = np.sign(ahead - left)
    known = (np.abs(position - left) >= band) & (np.abs(position - ahead) >= 0.5 * band)
    reach = int(RESTS_FOR * max(1.0, width))
    padded = np.pad(position, reach, mode="edge")
    after, before = np.abs(padded[2 * reach :] - position), np.abs(position - padded[: -2 * reach])
    beside = (padded[2:] - padded[:-2])[reach - 1 : reach - 1 + position.size]
    rests = (np.abs(beside) < band) & ((after < band) | (before < band))
    found, rows = np.where(known & ~rests, sign, 0.0), np.arange(position.size)
    for start, stop in runs(found == 0.0):
        means = [float(np.mean(part)) for part in np.array_split(position[start:stop], 4) if part.size]
        # On a slow turn the quarters of such a stretch differ by 3.7 standard deviations.
        if start > 0 and stop - start > 4 * reach and np.ptp(means) < std:
            moves = max(reach, _onset(position, stop, band)) if stop < position.size else 0
            rest = slice(start, max(start, stop - moves))
            found[rest], rows[rest] = found[start - 1], start
    return found, rows


def _onset(position: np.ndarray, row: int, band: float) -> int:
    """Rows by which a motion out of a rest may have begun before the `row` where it has left the rest by a band.

    With t rows from there until it has left by four bands it began t rows before under constant acceleration (x ~ T^2),
    and t / (4^(1/3) - 1) rows before under constant jerk (x ~ T^3), which is the longer time.
    """
    further = np.abs(position[row:] - position[row]) >= 3.0 * band
    rows = int(np.argmax(further)) if further.any() else position.size - row
    return int(np.ceil(rows / (4.0 ** (1.0 / 3.0) - 1.0)))


@compiled
def _turning_rows(position: np.ndarray, band: float) -> np.ndarray:
    """Rows at which a motion turns by more than a band, (k,), the first and the last row included."""
    turns = np.zeros(position.size + 2, dtype=np.int64)
    count, way, low, high = 1, 0, 0, 0
    for k in range(position.size):
        low = k if position[k] < position[low] else low
        high = k if position[k] > position[high] else high
        turned = -1
        if way >= 0 and position[k] < position[high] - band:
            turned, way = high, -1
        elif way <= 0 and position[k] > position[low] + band:
            turned, way = low, 1
        if turned >= 0:
            turns[count] = turned
            count += 1
            low, high = k, k
    turns[count] = position.size - 1
    return turns[: count + 1]


def unknown_direction(record: ForceBalanceRecord) -> float:
    """Share of the rows that move with a velocity within `UNKNOWN_SIGMAS` of its noise.

    A stretch within `REST_SIGMAS` of the noise is a rest, where friction has no direction of motion, unless its mean
    velocity is at least half of the noise of one row.
    """
    if record.velocity_noise == 0.0:
        return 0.0
    speed, position = np.abs(record.axis.velocity), record.axis.position
    unknown = speed <= UNKNOWN_SIGMAS * record.velocity_noise
    for start, stop in runs(speed <= REST_SIGMAS * record.velocity_noise):
        way = abs(position[min(stop, position.size - 1)] - position[start])
        if way < 0.5 * record.velocity_noise * record.step * (stop - start):
            unknown[start:stop] = False
    return float(np.mean(unknown))


class _Lagged(NamedTuple):
    """Derivative (m,) of a filtered position, the filtered velocity (m,) `late` rows after it, the least-squares factor
    between them, and the part of the derivative that it leaves."""

    rate: np.ndarray
    velocity: np.ndarray
    late: int
    factor: float
    part: float


def velocity_agreement(
    channels: Mapping[str, np.ndarray], noise: Noise | None, step: float
) -> VelocityAgreement | None:
    """Contradiction of a logged velocity (n,) and the derivative of the logged position (n,); none where they agree
    within `CONTRADICTION` and `LATE_ROWS`, or within the noise, or where one of them is not logged.

    The lag is that of the largest correlation, the factor the least-squares one at that lag.
    """
    if not {"position", "velocity"} <= channels.keys():
        return None
    position, velocity = filled(channels["position"])[0], filled(channels["velocity"])[0] * step
    width = max(2.0, motion_filter_width(position, noise))
    found = _lagged(position, velocity, noise, width)
    if found is None:
        return None
    if found.part > UNRELATED:
        # At a larger width the noise of either hides less of the motion.
        others = (found, *(_lagged(position, velocity, noise, wider * width) for wider in WIDER))
        return VelocityAgreement(0.0, np.nan) if all(one and one.part > FOREIGN for one in others) else None
    # Filtered rows are correlated over the width of the filter.
    error = 3.0 * found.part * float(np.std(found.rate)) * np.sqrt(4.0 * width)
    size, slope = (float(np.linalg.norm(values)) for values in (found.velocity, np.gradient(found.velocity)))
    uncertain = error / (abs(found.factor) * slope) if found.factor != 0.0 and slope > 0.0 else np.inf
    wrong_factor = abs(found.factor - 1.0) > CONTRADICTION + error / size
    wrong_time = abs(found.late) > LATE_ROWS + uncertain and abs(found.late) * slope > CONTRADICTION * size
    return VelocityAgreement(found.factor, float(found.late)) if wrong_factor or wrong_time else None


def _lagged(position: np.ndarray, velocity: np.ndarray, noise: Noise | None, width: float) -> _Lagged | None:
    """Both at the lag of the largest correlation; none in a record that is too short or shows no motion."""
    smooth = GaussianFilter(width, 1.0, position.size)
    reach = position.size // LONGEST_LAG
    inside = slice(smooth.margin + reach, position.size - smooth.margin - reach)
    rate, own = smooth(position, 1)[inside], smooth(velocity)
    noise_of_rate = position_noise(noise) * smooth.noise_gain(1, noise.spectrum if noise is not None else WHITE)
    if rate.size < 2 or np.std(rate) <= REST_SIGMAS * noise_of_rate or not own[inside].any():
        return None
    around = own[smooth.margin : position.size - smooth.margin]
    spectrum = np.fft.rfft(around) * np.conj(np.fft.rfft(rate, around.size))
    energy = np.cumsum(np.pad(around, (1, 0)) ** 2)
    # A lag at which hardly anything moves has no correlation.
    norms = np.sqrt(np.maximum(energy[rate.size :] - energy[: -rate.size], 1e-9 * energy[-1]))
    late = int(np.argmax(np.abs(np.fft.irfft(spectrum, around.size)[: norms.size]) / norms))
    moved = around[late : late + rate.size]
    factor = float(rate @ moved / (moved @ moved))
    part = float(np.linalg.norm(rate - factor * moved) / np.linalg.norm(rate))
    return _Lagged(rate, moved, late - reach, factor, part)


def motion_warnings(records: Iterable[object]) -> list[str]:
    """One line for each prepared record whose direction of motion is unknown in many rows, or whose logged velocity
    contradicts its position."""
    found = []
    for record in records:
        if not isinstance(record, ForceBalanceRecord):
            continue
        share, other = unknown_direction(record), record.velocity_agreement
        if share > UNKNOWN_SHARE:
            found.append(
                f"{record.name}: the direction of motion is not known in {share:.0%} of the rows, where the velocity "
                "is within its noise; give a velocity or a position with less noise"
            )
        if other is not None and np.isnan(other.late):
            found.append(f"{record.name}: 'position' does not follow 'velocity'; one of the two columns is wrong")
        elif other is not None:
            found.append(
                f"{record.name}: the derivative of 'position' is {other.factor:.3g} times 'velocity', which is "
                f"{other.late * record.step:.2g} s late; one of the two columns is wrong{_unit_factor(other.factor)}"
            )
    return found


def _unit_factor(factor: float) -> str:
    """End of a message that names the units between which a factor is; empty if there are none."""
    for units, known in UNIT_FACTORS.items():
        if factor != 0.0 and abs(abs(np.log(abs(factor))) - abs(np.log(known))) < CONTRADICTION:
            return f" ({known:.3g} is the factor of {units})"
    return ""
