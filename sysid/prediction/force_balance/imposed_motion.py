"""The rig kind `velocity-drive`: the motion is imposed, the friction is measured."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from sim.effects.effect import Axis, Effect
from sysid.experiment.experiment import Rig
from sysid.experiment.record import Record
from sysid.noise.estimate import Noise
from sysid.noise.repeats import find_quantisation_step
from sysid.prediction.effect_terms import Values
from sysid.prediction.force_balance import measured_motion
from sysid.prediction.force_balance.predict import predict_balance
from sysid.prediction.force_balance.record import (
    REST_SIGMAS,
    ROUNDING,
    ForceBalanceRecord,
    direction_of,
    distance_since_reversal,
    integral,
    make_axis,
    optional_channel,
    rest_age,
)
from sysid.prediction.prepared_record import PredictsChannels
from sysid.prediction.resampling import ON_ROW, UniformGrid, distance_to_rows, nearest_row, uniform
from sysid.prediction.rig_model import Noises, RigModel
from sysid.signals import WHITE, GaussianFilter, NoiseSpectrum, filled

SIGN_SIGMAS = 6.0
SIGN_STEPS = 2.5
"""Standard deviations of its noise, and quantisation steps, from which a given velocity has a certain sign."""

SLOPE_WIDTHS = (0.7, 1.0, 1.4, 2.0)
"""Widths in steps of the filter by which a velocity is derived from a position whose differences are clear of its
noise: the first one at which the speed is clear of the noise too, since a wider one blurs motions of few samples."""

BESIDE = 2
"""Samples on each side of a reversal that may be interpolated from forces of both directions: the force of a row may be
that of the row before it, and a sample lies between two rows."""


def velocity_drive(
    rig: PredictsChannels, record: Record, noise: Mapping[str, Noise], width: float | None = None
) -> ForceBalanceRecord:
    """A velocity-drive record: the motion is given, the friction force is measured and left unfiltered. The position
    is filtered by `width` in rows, where none is given by the width that its noise requires.

    Friction jumps at a reversal. Where the samples of the uniform grid lie between the rows, those beside a reversal
    have the force and the motion of the nearest row: interpolated, forces would be mixtures of both directions, which
    resemble presliding, and a motion that begins at a row would begin at the row before.
    """
    time, step, channels, hole = uniform(record)
    agreement = measured_motion.velocity_agreement(channels, noise.get("position"), step)
    if _shows_velocity_better(channels, noise, step):
        channels = {name: values for name, values in channels.items() if name != "velocity"}
    prepared = replace(_on_grid(rig, record, (time, step, channels, hole), noise, width), velocity_agreement=agreement)
    distance = distance_to_rows(record, time)
    if np.median(distance) <= ON_ROW * step:
        return prepared
    beside = _beside_reversals(prepared)
    jumping = {c: record.channels[c] for c in ("friction_force", "position", "velocity") if c in channels}
    taken = {name: np.where(beside, nearest_row(record, y, time), channels[name]) for name, y in jumping.items()}
    prepared = _on_grid(rig, record, (time, step, {**channels, **taken}, hole), noise, width)
    timing = float(np.hypot(prepared.timing_uncertainty, np.sqrt(np.mean(distance[~hole] ** 2))))
    sign = prepared.velocity_sign
    if sign is not None and "velocity" not in channels and prepared.half_width_variant is None:
        of_rows = _sign_at_rows(filled(record.channels["position"])[0], prepared.stretch, record.time)
        sign = np.where(beside, nearest_row(record, of_rows, time), sign)
    return replace(prepared, timing_uncertainty=timing, velocity_sign=sign, velocity_agreement=agreement)


def _beside_reversals(record: ForceBalanceRecord) -> np.ndarray:
    """Mask (n,) of the samples beside a change of the direction of motion; at rest it is that of the last motion."""
    moved = np.diff(record.axis.position, prepend=record.axis.position[0])
    sign = np.where(np.abs(moved) > record.stretch, np.sign(moved), 0.0)
    if record.velocity_sign is not None:
        sign = np.sign(record.velocity_sign)
    last = np.maximum.accumulate(np.where(sign != 0.0, np.arange(sign.size), 0))
    reversals = np.flatnonzero(np.diff(sign[last])) + 1
    mask = np.zeros(record.size, bool)
    mask[np.clip(reversals[:, None] + np.arange(-BESIDE, BESIDE + 1), 0, record.size - 1)] = True
    return mask


def _on_grid(
    rig: PredictsChannels, record: Record, grid: UniformGrid, noise: Mapping[str, Noise], width: float | None
) -> ForceBalanceRecord:
    """The record from its channels on a uniform grid."""
    time, step, channels, hole = grid
    force, gap = filled(channels["friction_force"])
    valid = ~(gap | hole | _gaps(channels, "position") | _gaps(channels, "velocity"))
    valid[0] = False
    sensor = noise.get("position")
    if "position" in channels:
        position = filled(channels["position"])[0]
    else:
        position = integral(filled(channels["velocity"])[0], step)
    load, temperature = optional_channel(channels, "normal_load"), optional_channel(channels, "temperature")
    prepared = ForceBalanceRecord(
        name=record.name,
        role=record.role,
        rig=rig,
        step=step,
        axis=make_axis(time, position, np.zeros(time.size), np.zeros(time.size), load, temperature, 0.0),
        measured={"friction_force": force},
        valid={"friction_force": valid},
        noise={"friction_force": noise["friction_force"].value},
        complementary_filter=GaussianFilter(0.0, step, time.size),
        force_channel="friction_force",
        timing_uncertainty=0.5 * step,
        stretch=1e-8 * float(np.ptp(position)),
    )
    if "velocity" not in channels:
        return _without_unknown_directions(_with_filtered_motion(prepared, sensor, width), position, sensor)
    velocity = filled(channels["velocity"])[0]
    given = _with_given_velocity(prepared, velocity, noise.get("velocity"), width)
    return _without_unknown_directions(given, position, sensor, velocity) if "position" in channels else given


def _shows_velocity_better(channels: Mapping[str, np.ndarray], noise: Mapping[str, Noise], step: float) -> bool:
    """Whether the velocity is less noisy as the derivative of the logged position than as it is logged, both filtered
    over a few rows."""
    if not {"position", "velocity"} <= channels.keys() & noise.keys():
        return False
    place, rate = noise["position"], noise["velocity"]
    smooth = GaussianFilter(SLOPE_WIDTHS[-1] * step, step, channels["velocity"].size)
    derived = measured_motion.position_noise(place) * smooth.noise_gain(1, place.spectrum)
    return derived < rate.value * smooth.noise_gain(0, rate.spectrum)


def _with_given_velocity(
    record: ForceBalanceRecord, velocity: np.ndarray, sensor: Noise | None, rows: float | None
) -> ForceBalanceRecord:
    """The record with the motion of a logged velocity (n,), filtered by `rows` or as much as its noise hides."""
    left = 0.0
    if sensor is None:
        rows = 0.0
    elif rows is None:
        rows = measured_motion.unblurred_width(velocity, sensor, ~record.valid[record.force_channel])
    if rows > 0.0 and sensor is not None:
        left = sensor.value * GaussianFilter(rows, 1.0, record.size).noise_gain(0, sensor.spectrum)
    axis = _axis_of_velocity(record.axis, velocity, rows)
    return replace(
        record,
        axis=axis,
        prefilter_samples=rows,
        velocity_noise=left,
        velocity_sign=_certain_sign(axis.velocity, left),
        half_width_variant=partial(_half_of_velocity, record.axis, velocity, rows) if rows > 0.0 else None,
    )


def _axis_of_velocity(axis: Axis, velocity: np.ndarray, rows: float) -> Axis:
    """The axis with a velocity (n,), both filtered by a width in rows."""
    step = float(axis.time[1] - axis.time[0])
    smooth = GaussianFilter(rows * step, step, velocity.size)
    position, rate = smooth(axis.position), smooth(velocity)
    acceleration = smooth(velocity, 1) if rows > 0.0 else np.gradient(velocity, step)
    rest = 1e-9 * float(np.max(np.abs(rate)))
    return make_axis(axis.time, position, rate, acceleration, axis.load, axis.temperature, rest)


def _half_of_velocity(axis: Axis, velocity: np.ndarray, rows: float) -> tuple[Axis, GaussianFilter]:
    """The axis filtered by half the width, and the filter of its force."""
    return _axis_of_velocity(axis, velocity, 0.5 * rows), GaussianFilter(0.0, 1.0, velocity.size)


LEAST_KNOWN = 100
"""Rows whose direction must be known for the others to be left out: enough for the parameters of a friction law,
however long the record rests besides."""


def _without_unknown_directions(
    record: ForceBalanceRecord, position: np.ndarray, sensor: Noise | None, given: np.ndarray | None = None
) -> ForceBalanceRecord:
    """The record without the rows in which neither a noisy position (n,) nor a `given` velocity (n,) shows a direction
    of motion: friction may there be anything up to its level, under any model."""
    std = record.prefiltered_noise or measured_motion.position_noise(sensor)
    assert record.velocity_sign is not None
    path = record.axis.position if record.prefiltered_noise else position
    shown, stop_row = record.velocity_sign, np.arange(record.size)
    if given is not None:
        # The position jitters by the change of what its steps differ from those of the velocity: 20 times the variance.
        steps = np.diff(position) - 0.5 * (given[1:] + given[:-1]) * record.step
        jitter = float(np.median(np.abs(np.diff(steps, 2)))) / 0.6745 / np.sqrt(20.0)
        std = max(std, jitter) if jitter > record.stretch else std
    if std > 0.0:
        shown, stop_row = measured_motion.known_direction(path, std, record.prefilter_samples)
    if given is not None:
        shown = np.where(record.velocity_sign != 0.0, record.velocity_sign, shown)
    valid = {name: rows & (shown != 0.0) for name, rows in record.valid.items()}
    if std == 0.0 or not all(np.count_nonzero(rows) >= LEAST_KNOWN for rows in valid.values()):
        return record
    clear = record.velocity_sign != 0.0
    undirected = record.valid[record.force_channel] & (shown == 0.0)
    sign = np.where(clear, record.velocity_sign, shown)
    # The sign of a velocity that is noise is no direction: laws that have one keep that of the last motion.
    axis = record.axis._replace(direction=direction_of(sign, 0.0))
    resting = ~clear & ((stop_row != np.arange(record.size)) | (shown == 0.0))
    since = distance_since_reversal(axis.position, axis.direction)
    axis = axis._replace(contact_age=rest_age(axis.time, resting), reversal_distance=since)
    return replace(record, axis=axis, valid=valid, velocity_sign=sign, stop_row=stop_row, undirected=undirected)


def _gaps(channels: Mapping[str, np.ndarray], name: str) -> np.ndarray | bool:
    return ~np.isfinite(channels[name]) if name in channels else False


def _with_filtered_motion(record: ForceBalanceRecord, sensor: Noise | None, rows: float | None) -> ForceBalanceRecord:
    """The record with the motion from its position, filtered by `rows` or the width that its noise requires: without a
    filter the differences of the position determine the direction; otherwise the filtered velocity does, and reversals
    are uncertain by its noise in addition to half a step."""
    step, std = record.step, measured_motion.position_noise(sensor)
    spectrum = sensor.spectrum if sensor is not None else WHITE
    if rows is None:
        rows = measured_motion.motion_filter_width(record.axis.position, sensor, ~record.valid[record.force_channel])
    width = rows * step
    axis, velocity_noise = _filtered_axis(record.axis, width, std, spectrum)
    remaining = std * GaussianFilter(width, step, record.size).noise_gain(0, spectrum)
    filtered = replace(
        record,
        axis=axis,
        velocity_noise=velocity_noise,
        prefiltered_noise=remaining,
        prefilter_samples=rows,
        stretch=max(record.stretch, 12.0 * remaining),
    )
    if width == 0.0:
        return replace(filtered, velocity_sign=_sign_at_rows(axis.position, filtered.stretch, axis.time))
    reach = max(SLOPE_WIDTHS[-1], rows)
    direction = measured_motion.direction_from_velocity(
        axis.position, axis.velocity * step, velocity_noise * step, reach
    )
    unchanged = GaussianFilter(0.0, step, record.size)
    return replace(
        filtered,
        velocity_sign=direction.sign,
        timing_uncertainty=float(np.hypot(record.timing_uncertainty, direction.timing * step)),
        half_width_variant=partial(_half_width, record.axis, width, std, spectrum, unchanged),
    )


def _half_width(
    axis: Axis, width: float, std: float, spectrum: NoiseSpectrum, unchanged: GaussianFilter
) -> tuple[Axis, GaussianFilter]:
    """The axis filtered by half the width, and the filter of its force."""
    return _filtered_axis(axis, 0.5 * width, std, spectrum)[0], unchanged


def _filtered_axis(axis: Axis, width: float, std: float, spectrum: NoiseSpectrum) -> tuple[Axis, float]:
    """The axis from its position filtered by `width`, s, and the standard deviation of its velocity."""
    step, n = float(axis.time[1] - axis.time[0]), axis.time.size
    smooth, velocity, noise = GaussianFilter(width, step, n), axis.velocity, 0.0
    slope = smooth
    for least in SLOPE_WIDTHS:
        slope = GaussianFilter(max(width, least * step), step, n)
        velocity, noise = slope(axis.position, 1), std * slope.noise_gain(1, spectrum)
        if width >= SLOPE_WIDTHS[-1] * step or np.mean(np.abs(velocity)) >= REST_SIGMAS * noise:
            break
    position, acceleration = smooth(axis.position), slope(axis.position, 2)
    rest = REST_SIGMAS * noise + 1e-6 * float(np.max(np.abs(velocity)))
    return make_axis(axis.time, position, velocity, acceleration, axis.load, axis.temperature, rest), noise


def _sign_at_rows(position: np.ndarray, stretch: float, time: np.ndarray) -> np.ndarray:
    """Sign (n,) of the velocity at the times (n,) of a position (n,) without notable noise; zero at rest. It is that of
    the parabola through the row and its neighbours, the velocity under a constant acceleration. The difference to the
    row before is a mean over the step: after a turning point between the two rows its sign is late half of the time. A
    row that differs from the one before by `stretch` at most is at rest, also if the next one moves; so is a turning
    point at a row, where the slope is rounding."""
    moved = np.abs(np.diff(position, prepend=position[0])) > stretch
    slope = np.gradient(position, time)
    certain = np.abs(slope) * np.gradient(time) > stretch
    return np.where(moved & certain, np.sign(slope), 0.0)


def _certain_sign(velocity: np.ndarray, left: float) -> np.ndarray:
    """Sign of a given velocity (n,), zero where its own noise, of which a filter has `left` this deviation, or rounding
    could have made the sign."""
    noise = left or float(np.median(np.abs(np.diff(velocity, 2)))) / 0.6745 / np.sqrt(6.0)
    quantisation_step = find_quantisation_step([velocity]) or 0.0
    sure = max(SIGN_SIGMAS * noise, SIGN_STEPS * quantisation_step, 1e-9 * float(np.max(np.abs(velocity))))
    return np.where(np.abs(velocity) > sure, np.sign(velocity), 0.0)


def _sensor_share_of_load(records: Sequence[ForceBalanceRecord]) -> float:
    """Part of the variance of the load's finest differences which friction does not follow: with a coefficient of
    friction mu from their mean values the slope of the friction's differences over the load's is mu times the rest."""
    force, load, level, weight = [], [], 0.0, 0.0
    for record in records:
        friction = record.measured[record.force_channel] * record.axis.direction
        turned = np.abs(np.diff(record.axis.direction, prepend=0.0)) + ~record.valid[record.force_channel]
        steady = np.convolve(turned, np.ones(5), "valid") == 0.0
        force.append(np.diff(friction, 4)[steady])
        load.append(np.diff(record.axis.load, 4)[steady])
        level, weight = level + float(np.sum(friction)), weight + float(np.sum(record.axis.load))
    change = np.concatenate(load)
    square = float(change @ change) * level
    return float(np.clip(1.0 - weight * (np.concatenate(force) @ change) / square, 0.0, 1.0)) if square > 0.0 else 1.0


class VelocityDrive(RigModel):
    """Imposed motion in, friction force out."""

    name = "velocity-drive"
    along_motion = True
    predict = staticmethod(predict_balance)

    def prepare(self, rig: Rig, records: Sequence[Record], noise: Noises, values: Values) -> list[ForceBalanceRecord]:
        return [velocity_drive(self, record, noise) for record in records]

    def prepare_again(
        self, prepared: Sequence[ForceBalanceRecord], rig: Rig, records: Sequence[Record], noise: Noises, values: Values
    ) -> list[ForceBalanceRecord]:
        pairs = zip(records, prepared, strict=True)
        return [velocity_drive(self, record, noise, like.prefilter_samples) for record, like in pairs]

    def with_input_noise(self, records: Sequence[ForceBalanceRecord], noise: Noises) -> Noises:
        load = noise.get("normal_load")
        if load is None or load.source == "given":
            return noise
        share = _sensor_share_of_load(records)
        if float(np.sqrt(share)) * load.value <= ROUNDING * max(float(np.max(np.abs(r.axis.load))) for r in records):
            return {name: one for name, one in noise.items() if name != "normal_load"}
        return {**noise, "normal_load": replace(load, value=float(np.sqrt(share)) * load.value)}

    def shows(self, effect: Effect, records: Sequence[ForceBalanceRecord], channels: set[str]) -> bool:
        # A measured force is too smooth for the course of a signal between the rows to matter.
        if effect.between_rows or effect.acts_on in ("drive", "piezo"):
            return False
        return effect.acts_on != "structure" or effect.opens_gap
