"""Contradictions in the records of an experiment, which make every verdict unreliable, as one-line warnings.

A warning never changes a verdict: it states what is wrong in the records, the noise or the columns, and what to do.

Known quantities that the records contradict are the mass, with the scale of the force, and the stiffness of a spring.
A force F along a measured motion obeys F = m a + f(x, v) for friction and springs of any law without memory. The mass
is estimated with f as hat functions of velocity and position, separately for each direction. Its standard deviation is
that of the sums over blocks of time, since what f lacks is correlated (Liang and Zeger, Biometrika 73 (1986) 13). What
is known is contradicted where the estimate is far from it in standard deviations and in percent, and where the
difference is a notable part of what f leaves unexplained.
"""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from stagecad.parameters.units import format_quantity
from sysid.estimation.misfit import ChannelMisfit
from sysid.experiment.experiment import Experiment, unanswered_questions
from sysid.experiment.quality import OTHER_SCALE, scale_warnings
from sysid.experiment.record import Record
from sysid.noise.autocorrelation import Series
from sysid.noise.estimate import RIDGE, SHARP, hats_of, noise_warnings
from sysid.noise.mains import HARMONICS, MAINS, hum_frequencies
from sysid.prediction.force_balance.measured_motion import motion_warnings
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.problem import Problem
from sysid.signals import filled, runs

BLOCKS = 12
"""Blocks of time of all records together."""
SURE = 6.0
"""Standard deviations of a contradiction: those of `BLOCKS` sums follow Student's t."""
FAR = 0.2
"""Relative difference from which a known quantity is contradicted: a delay or a flexible mode may shift it by less."""
CLEAR = 10.0
"""Power of the force, and of what a known quantity multiplies, over that of its noise, which makes the estimate too
small."""
LEAST_FACTORS = 500
"""Rows from which an estimate is made."""
NOTABLE = 0.1
"""Share of the variance that f leaves, which the difference must explain."""

CLEARLY = 0.5
"""Squared error that another explanation leaves, over that of another quantity, up to which it is the explanation."""


def contradicted_known(problem: Problem) -> list[str]:
    """One line for each known quantity that the records of the fit contradict."""
    rig, found = problem.experiment.rig, []
    force = next((record.force_channel for record in problem.fit_records), "")
    # A scale that is not exactly known is fitted.
    sources = [record.sources[force] for record in problem.experiment.records if force in record.sources]
    scaled = any(term.deviation for source in sources for term in source.terms)
    of_mass = [part for record in problem.fit_records if not scaled and (part := _mass_terms(record))]
    of_spring = [part for record in problem.records if (part := _spring_terms(record.channels))]
    for key, parts, blamed in (
        ("mass", of_mass, f"it is wrong, or the scale of '{force}' is"),
        ("pull_stiffness", of_spring, "it, a unit or a scale is wrong, or lost motion lies behind the spring"),
    ):
        known, quantity = rig.known.get(key), rig.declaration.known.get(key)
        if known is None or quantity is None or (value := _estimate(parts, known.value, known.std or 0.0)) is None:
            continue
        name = "inertia" if key == "mass" and rig.rotary else key
        unit = quantity.si_unit(rig.rotary)
        shown, stated = format_quantity(value, unit, 3), format_quantity(known.value, unit, 4)
        found.append(
            f"the records show {shown} for rig.known.{name}, {value / known.value:.3g} times the stated "
            f"{stated}: {blamed}"
        )
    return found


class Terms(NamedTuple):
    """A force (n,), what the known quantity multiplies (n,), functions of the rest (p, n), standard deviation of the
    noise of what it multiplies, and functions (q, n) of what may act in the place of another quantity."""

    force: np.ndarray
    factor: np.ndarray
    functions: np.ndarray
    noise: float = 0.0
    instead: np.ndarray | None = None


def _mass_terms(record: object) -> Terms | None:
    if not isinstance(record, ForceBalanceRecord) or record.acceleration is None or record.is_free:
        return None
    rows, axis = record.valid[record.force_channel], record.axis
    measured, noise = record.measured[record.force_channel][rows], record.noise[record.force_channel]
    # A force within its noise drives nothing: the motion is a free one, and shows no mass.
    if not np.ptp(axis.velocity[rows]) > 0.0 or np.var(measured) <= CLEAR * noise**2:
        return None
    force = record.inputs.get("spring_force", record.measured[record.force_channel])[rows]
    ahead = axis.direction[rows] > 0.0
    place = hats_of(axis.position[rows])
    functions = np.vstack([hats_of(axis.velocity[rows], SHARP), place * ahead, place * ~ahead])
    return Terms(force, record.acceleration[rows], functions, record.acceleration_noise)


def _spring_terms(channels: Mapping[str, np.ndarray]) -> Terms | None:
    if not {"spring_force", "pull_position", "position"} <= channels.keys():
        return None
    force, pull, position = (filled(channels[name])[0] for name in ("spring_force", "pull_position", "position"))
    # Behind lost motion the extension is larger by half of its width, either way.
    return Terms(force, pull - position, np.ones((1, force.size)), instead=np.vstack([force > 0.0, force <= 0.0]) * 1.0)


def _estimate(parts: list[Terms], known: float, std: float) -> float | None:
    """The known quantity by the records, where they contradict it."""
    factors, errors, noise, otherwise = [], [], 0.0, np.inf
    for force, factor, functions, deviation, instead in parts:
        both = np.vstack([factor, force - known * factor])
        own, rest = _without(functions, both)
        factors.append(own)
        errors.append(rest)
        noise += deviation**2 * own.size
        if instead is not None:
            otherwise = (0.0 if np.isinf(otherwise) else otherwise) + float(np.sum(_without(instead, both[1:]) ** 2))
    if sum(part.size for part in factors) < LEAST_FACTORS:
        return None
    factor, error = np.concatenate(factors), np.concatenate(errors)
    power = float(factor @ factor)
    if power <= CLEAR * noise or power == 0.0:
        return None
    away = float(factor @ error) / power
    left = error - away * factor
    sums = np.array([block.sum() for block in np.array_split(factor * left, BLOCKS)])
    deviation = float(np.sqrt(sums @ sums * BLOCKS / (BLOCKS - 1.0))) / power
    contradicted = (
        abs(away) > SURE * np.hypot(deviation, std)
        and abs(away) > FAR * abs(known)
        and away**2 * power > NOTABLE * float(error @ error)
        and otherwise > CLEARLY * float(left @ left)
    )
    return known + away if contradicted else None


def _without(functions: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (k, n) less their least-squares sum of functions (p, n)."""
    inner = functions @ functions.T
    # The hat functions of one coordinate add to one: they depend on each other.
    inner += RIDGE * np.trace(inner) * np.eye(inner.shape[0])
    return values - np.linalg.solve(inner, functions @ values.T).T @ functions


OUTLIER_FACTOR, OUTLIER_ROWS, MOST_OUTLIERS = 100.0, 3, 0.03
"""Distance from the median over that of the other values from which a few rows in a row are outliers, and the largest
share of such rows."""

ROWS_PER_PERIOD = 4
"""Rows per period from which central differences give the velocity of a sinusoid within a third."""

MOST_ROWS, LEAST_ROWS = 16_000, 64
"""Rows of a record whose spectrum is looked at, and the least number of them."""

REACTIONS = ("friction_force", "spring_force", "normal_load", "temperature")
"""Channels that are neither a motion nor a drive."""

LINE = 20.0
"""Power over the median power from which a frequency is a line: exceeded by noise once in a million frequencies."""

OPPOSITE = -0.5
"""Correlation from which two signals that should have the same sign have opposite signs."""

EXCHANGED = 0.9
"""Correlation with the other column's signal from which two columns are exchanged, if that with its own is lower than
one minus this value."""

EXCHANGED_ERROR = 0.05
"""Relative error up to which the integral of a velocity is the position."""


def consistency_warnings(problem: Problem, errors: Mapping[str, ChannelMisfit]) -> list[str]:
    """One line for each contradiction."""
    found = motion_warnings([*problem.fit_records, *problem.validate_records])
    found += contradicted_known(problem)
    found += noise_warnings(
        problem.noise, {c: (m.over_sensor_noise or m.over_noise, m.size) for c, m in errors.items()}
    )
    return [*found, *_extrapolated(problem), *record_warnings(problem.experiment, problem.records)]


BEYOND, MOST_BEYOND = 1.5, 0.05
"""Ratio to the highest speed of the fit from which a speed is extrapolated, and share of such rows from which the user
is warned."""


def _extrapolated(problem: Problem) -> list[str]:
    """Held-out records that are faster than those to which the model is fitted."""
    fitted = [np.abs(r.axis.velocity) for r in problem.fit_records if isinstance(r, ForceBalanceRecord)]
    highest = max((float(np.quantile(speed, 0.999)) for speed in fitted), default=0.0)
    unit, found = "rad/s" if problem.experiment.rig.rotary else "m/s", []
    for record in problem.validate_records:
        if highest > 0.0 and isinstance(record, ForceBalanceRecord) and not problem.crossed:
            share = float(np.mean(np.abs(record.axis.velocity) > BEYOND * highest))
            if share > MOST_BEYOND:
                found.append(
                    f"{record.name}: {share:.0%} of the rows are faster than {BEYOND:g} times the highest speed of the "
                    f"records of the fit, {format_quantity(highest, unit, 2)}: the model is extrapolated there; give "
                    "the role 'fit' to a record with all speeds"
                )
    return found


def _other_time_scale(records: Sequence[Record]) -> list[str]:
    """Records whose rows are much further apart than those of another, as with a time in another unit."""
    first, *_, last = sorted([*records, *records], key=lambda record: record.step)
    if last.step < OTHER_SCALE * first.step:
        return []
    far, near = (format_quantity(record.step, "s", 3) for record in (last, first))
    return [
        f"rows are {far} apart in '{last.name}' and {near} in '{first.name}', {last.step / first.step:.3g} times as "
        "much: is the unit of the time of one wrong?"
    ]


def record_warnings(experiment: Experiment, records: Sequence[Record]) -> list[str]:
    """One line for each contradiction that the records show by themselves, before any fit."""
    measured = experiment.rig.declaration.measured_channels
    found = _identical_records(records)
    found += scale_warnings([(record.name, record.channels, record.units) for record in records])
    found += _other_time_scale(records)
    # The parts of a record have its faults in common.
    named: dict[tuple[str, str], str] = {}
    for record in records:
        for fault in record.faults:
            named.setdefault((fault.text, record.sha256), record.name)
    found += [f"{name}: {text}" for (text, _), name in named.items()]
    found += unanswered_questions(experiment.text)
    for record in records:
        recorded = [channel for channel in measured if channel in record.channels]
        for check in (_constant_channels, _outliers, _coarse_sampling):
            found += check(record, recorded)
        for check in (_opposite_signs, _exchanged_tip, _exchanged_force):
            found += check(record)
    return found


def _coarse_sampling(record: Record, measured: Sequence[str]) -> list[str]:
    """Sinusoids with fewer than `ROWS_PER_PERIOD` rows per period, and hum above half the sampling rate."""
    found, rate = [], 1.0 / record.step
    rows = slice(0, 2 * (min(record.size, MOST_ROWS) // 2))
    for channel, values in record.channels.items():
        bridged = filled(values[rows])[0]
        power = np.abs(np.fft.rfft(np.hanning(bridged.size) * (bridged - np.mean(bridged)))) ** 2
        # The power of noise has an exponential distribution: a bin of it is hardly ever so far above the median.
        lines = np.where(power > LINE * np.median(power), power, 0.0)
        lines[: 2 * lines.size // ROWS_PER_PERIOD] = 0.0
        if channel not in REACTIONS and bridged.size >= LEAST_ROWS and lines.sum() > 0.5 * power.sum():
            frequency = float(np.argmax(lines)) * rate / bridged.size
            found.append(
                f"{record.name}: '{channel}' has {rate / frequency:.2g} rows per period of its strongest motion, at "
                f"{frequency:.3g} Hz; one at {rate - frequency:.3g} Hz would look the same: record more rows per second"
            )
        if channel in measured and record.uniform and rate < 2.0 * MAINS[-1] * HARMONICS[-1]:
            series = Series(record.time[rows], values[rows], record.step)
            for line in hum_frequencies(series):
                if line > 0.5 * rate:
                    found.append(
                        f"{record.name}: the hum of the mains at {line:.4g} Hz is above half the sampling rate of "
                        f"{rate:.4g} Hz, and appears in '{channel}' as a motion at "
                        f"{abs(line - rate * round(line / rate)):.3g} Hz; filter it before sampling"
                    )
    return found


def _identical_records(records: Sequence[Record]) -> list[str]:
    """Records of the fit that are held out as well: the same columns of a file, in windows that overlap."""

    def same_rows(one: Record, other: Record) -> bool:
        common, first, second = np.intersect1d(one.time, other.time, return_indices=True)
        shared = [(one.channels[name][first], other.channels[name][second]) for name in one.channels]
        return common.size > 1 and all(np.array_equal(a, b, equal_nan=True) for a, b in shared)

    fit, held_out = ([r for r in records if r.role == role] for role in ("fit", "validate"))
    return [
        f"the held-out record '{other.name}' contains the same rows as '{one.name}', to which the model is fitted: its "
        "errors are errors of the fit; hold out another record, or windows ('from', 'to') that do not overlap"
        for one, other in product(fit, held_out)
        if one.sha256 == other.sha256 and one.channels.keys() == other.channels.keys() and same_rows(one, other)
    ]


def _constant_channels(record: Record, measured: Sequence[str]) -> list[str]:
    return [
        f"{record.name}: '{channel}' is {values[0]:.4g} {record.units[channel]} in every row; the sensor or the column "
        "is wrong"
        for channel in measured
        if (values := record.channels[channel][np.isfinite(record.channels[channel])]).size and np.ptp(values) == 0.0
    ]


def _outliers(record: Record, measured: Sequence[str]) -> list[str]:
    """Single rows that are larger than the others by orders of magnitude."""
    found = []
    for channel in measured:
        values = record.channels[channel]
        distance = np.abs(values - np.nanmedian(values))
        usual = float(np.nanquantile(distance, 1.0 - MOST_OUTLIERS))
        large = distance > OUTLIER_FACTOR * usual
        count = int(large.sum())
        if usual > 0.0 and count > 0:
            first = int(np.flatnonzero(large)[0])
            if all(stop - start <= OUTLIER_ROWS for start, stop in runs(large)):
                rows = "row has a value" if count == 1 else "rows have values"
                found.append(
                    f"{record.name}: {count} {rows} of '{channel}' more than {OUTLIER_FACTOR:.0f} times as far from "
                    f"the median as {1.0 - MOST_OUTLIERS:.0%} of the others (first {values[first]:.3g} "
                    f"{record.units[channel]} at {record.time[first]:.6g} s); leave such cells empty"
                )
    return found


def _opposite_signs(record: Record) -> list[str]:
    """A load below zero, a friction force against the velocity, a spring force against the extension of the spring."""
    channels, found = record.channels, []
    if np.nanmax(channels.get("normal_load", np.zeros(1))) < 0.0:
        found.append(f"{record.name}: 'normal_load' is below zero in every row; write sign = {{normal_load = -1}}")
    motion = next((name for name in ("velocity", "position") if name in channels), None)
    if "friction_force" in channels and motion is not None:
        values, rates = filled(channels[motion])[0], motion == "velocity"
        velocity, position = (values, np.cumsum(values)) if rates else (np.gradient(values, record.time), values)
        parts = [_without_cubic(part, position) for part in (channels["friction_force"], np.sign(velocity))]
        if _correlation(*parts) < OPPOSITE:
            found.append(
                f"{record.name}: 'friction_force' has the sign opposite to the velocity; write sign = "
                "{friction_force = -1} if the sensor measures the reaction"
            )
    if {"spring_force", "position", "pull_position"} <= channels.keys():
        extension = channels["pull_position"] - channels["position"]
        if _correlation(channels["spring_force"], extension) < OPPOSITE:
            found.append(
                f"{record.name}: 'spring_force' falls with pull_position - position; the two positions are exchanged, "
                "or a sign is wrong"
            )
    return found


def _exchanged_tip(record: Record) -> list[str]:
    """Columns of the tip's two displacements that are exchanged: tip_x follows V2 - V1, tip_y follows V1 + V2."""
    channels = record.channels
    if not {"tip_x", "tip_y", "voltage_1", "voltage_2"} <= channels.keys():
        return []
    difference = channels["voltage_2"] - channels["voltage_1"]
    total = channels["voltage_1"] + channels["voltage_2"]
    own = (_correlation(channels["tip_x"], difference), _correlation(channels["tip_y"], total))
    other = (_correlation(channels["tip_x"], total), _correlation(channels["tip_y"], difference))
    if min(map(abs, other)) > EXCHANGED and max(map(abs, own)) < 1.0 - EXCHANGED:
        return [
            f"{record.name}: 'tip_x' follows voltage_1 + voltage_2, and 'tip_y' their difference: exchanged columns"
        ]
    return []


def _exchanged_force(record: Record) -> list[str]:
    """Columns of velocity and force that are exchanged: the integral of the 'force' is the position."""
    channels = record.channels
    force = next((name for name in ("friction_force", "drive_force") if name in channels), None)
    if force is None or not {"position", "velocity"} <= channels.keys():
        return []
    position = _centred(channels["position"])
    steps = np.diff(record.time, prepend=record.time[0])
    own, other = (_centred(np.cumsum(filled(channels[name])[0] * steps)) for name in ("velocity", force))

    def is_position(integral: np.ndarray) -> bool:
        return bool(np.linalg.norm(integral - position) < EXCHANGED_ERROR * np.linalg.norm(position))

    if is_position(other) and not is_position(own):
        return [f"{record.name}: 'position' is the integral of '{force}', not of 'velocity': exchanged columns"]
    return []


def _without_cubic(values: np.ndarray, position: np.ndarray) -> np.ndarray:
    """`values` (n,) without their least-squares cubic in the position (n,): forces that depend on position alone are
    removed. A remainder of the size of rounding errors is set to zero."""
    centred = _centred(position)
    powers = np.vander(centred / max(float(np.max(np.abs(centred))), 1e-300), 4)
    values = filled(values)[0]
    rest = values - powers @ np.linalg.lstsq(powers, values, rcond=None)[0]
    return rest if np.linalg.norm(rest) > 1e-9 * np.linalg.norm(values) else np.zeros_like(values)


def _centred(values: np.ndarray) -> np.ndarray:
    values = filled(values)[0]
    return values - np.mean(values)


def _correlation(one: np.ndarray, other: np.ndarray) -> float:
    """Pearson correlation of two signals (n,); 0 where one of them is constant."""
    one, other = _centred(one), _centred(other)
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(one @ other) / size if size > 0.0 else 0.0
