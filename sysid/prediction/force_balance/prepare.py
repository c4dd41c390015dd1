"""Force-balance records from records of driven masses, and the width of the filter that their noise requires."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from sim.effects.effect import Axis
from stagecad.parameters.errors import InputError
from sysid.experiment.record import Record
from sysid.noise.estimate import Noise
from sysid.prediction.force_balance.measured_motion import velocity_agreement
from sysid.prediction.force_balance.record import (
    EDGE_WIDTHS,
    PREFILTER_SHARE,
    REST_SIGMAS,
    ForceBalanceRecord,
    integral,
    make_axis,
    optional_channel,
)
from sysid.prediction.force_balance.reversals import (
    ResolvedMotion,
    SlipPhases,
    SmoothedMotion,
    resolve_events,
    restored_kinks,
)
from sysid.prediction.force_balance.stick_phases import StickPhases, find_stick_phases
from sysid.prediction.prepared_record import PredictsChannels
from sysid.prediction.resampling import ON_ROW, distance_to_rows, mean_of_held, uniform
from sysid.signals import GaussianFilter, NoiseSpectrum, dilated, filled, longer_than


class Signal(NamedTuple):
    """A signal (n,) with its gaps bridged, the mask (n,) of the gaps, and size and spectrum of its noise."""

    values: np.ndarray
    gap: np.ndarray
    std: float
    spectrum: NoiseSpectrum


class _Motion(NamedTuple):
    """Inputs of the axis of a driven mass: time, position and its noise, gaps, load and temperature."""

    time: np.ndarray
    position: Signal
    missing: np.ndarray
    load: np.ndarray | None
    temperature: np.ndarray | None


def prepare_driven_mass(
    rig: PredictsChannels,
    record: Record,
    noise: Mapping[str, Noise],
    mass: float,
    pull_stiffness: float | None = None,
    hold: str = "zero",
    width: float | None = None,
    least_width: float = 0.0,
) -> ForceBalanceRecord:
    """A record of a driven mass: the force is balanced against mass times the measured acceleration."""
    time, step, channels, hole = uniform(record)
    if hold == "zero" and "drive_force" in channels and np.median(distance_to_rows(record, time)) > ON_ROW * step:
        held = mean_of_held(record, "drive_force", time, step)
        # A mean over a step passes w^2 h^2/24 less.
        held[1:-1] -= np.diff(held, 2) / 24.0
        held = np.where(np.isfinite(channels["drive_force"]), held, np.nan)
        channels, hold = {**channels, "drive_force": held}, "linear"
    n = time.size
    channel, position, force = _signals(channels, noise, step, pull_stiffness, hold)
    missing = position.gap | hole | force.gap
    if width is None:
        width = max(filter_width(channels, noise, position, force, step, mass), least_width)
    reach = int(np.ceil(EDGE_WIDTHS * width / step))
    _require_motion(record, channel, force, (n, reach), step, width)
    surroundings = (optional_channel(channels, name) for name in ("normal_load", "temperature"))
    motion = _Motion(time, position, missing, *surroundings)
    axis, resolved, slip_phases = _resolved(motion, force.values / mass if mass > 0 else np.zeros(n), width)

    valid = _valid_rows(missing, width / step, reach)
    full = GaussianFilter(width, step, n)
    measured, noises, inputs = _filtered_channels(channel, channels, noise, position, force, full, mass, pull_stiffness)
    prefilter = GaussianFilter(PREFILTER_SHARE * width, step, n)
    own, rate = (position.std * prefilter.noise_gain(order, position.spectrum) for order in (0, 1))
    prepared = ForceBalanceRecord(
        name=record.name,
        role=record.role,
        rig=rig,
        step=step,
        axis=axis,
        measured=measured,
        valid={name: valid.copy() for name in measured},
        noise=noises,
        acceleration=full(position.values, 2),
        mass=mass,
        stick_fraction=resolved.stick_fraction,
        complementary_filter=_complementary(prefilter, width),
        full_filter=full,
        direction=resolved.direction,
        reversals=resolved.reversals,
        slip_phases=slip_phases,
        prefilter_samples=prefilter.width / step,
        force_channel=channel,
        timing_uncertainty=0.15 * step,
        inputs=inputs,
        applied=force.values,
        acceleration_noise=acceleration_noise(position, full),
        position_noise=_noise_over(position, width / step),
        encoder_step=_encoder_step(noise.get("position")),
        prefiltered_noise=own,
        velocity_noise=rate,
        velocity_agreement=velocity_agreement(channels, noise.get("position"), step),
        stretch=12.0 * own,
        pull_stiffness=pull_stiffness or 0.0,
        half_width_variant=partial(_prefiltered, motion, 0.5 * prefilter.width, width),
        raw_position=position.values,
        interpolated=missing,
    )
    return replace(prepared, stick_phases=_stick_phases(prepared, channels, noise, valid, 1.5 * width / step))


def _encoder_step(noise: Noise | None) -> float:
    """Step of the encoder whose rounding is most of a position's noise; else zero."""
    step = 0.0 if noise is None else noise.quantisation_step or 0.0
    return step if noise is not None and step**2 / 12.0 >= 0.5 * noise.value**2 else 0.0


def _noise_over(position: Signal, rows: float) -> float:
    """Deviation of the noise of a position (the square root of half its structure function) over a number of rows: a
    slower part is a motion of its zero, which no observer sees."""
    white, memory = position.spectrum.white, position.spectrum.correlation
    return position.std * float(np.sqrt(white + (1.0 - white) * (1.0 - memory**rows)))


def _valid_rows(missing: np.ndarray, width: float, reach: int) -> np.ndarray:
    """Mask (n,) of the rows whose values, filtered over `width` and `reach` rows, no gap (`missing`) or end of the
    record affects; a gap shorter than the filter is interpolated, which changes them little."""
    invalid = missing | dilated(longer_than(missing, width), reach)
    invalid[: reach + 1] = True
    invalid[missing.size - reach :] = True
    return ~invalid


def _filtered_channels(
    channel: str,
    channels: Mapping[str, np.ndarray],
    noise: Mapping[str, Noise],
    position: Signal,
    force: Signal,
    full: GaussianFilter,
    mass: float,
    pull_stiffness: float | None,
) -> tuple[dict[str, np.ndarray], dict[str, float], dict[str, np.ndarray]]:
    """Filtered scored channels, the noise of their residuals, and filtered inputs of a spring-pull rig."""
    own, inertia = force.std * full.noise_gain(0, force.spectrum), mass * acceleration_noise(position, full)
    measured, noises = {channel: full(force.values)}, {channel: float(np.hypot(own, inertia))}
    if "pull_position" not in channels or pull_stiffness is None:
        return measured, noises, {}
    inputs = {"pull_position": full(filled(channels["pull_position"])[0]), "spring_force": full(force.values)}
    own = position.std * full.noise_gain(0, position.spectrum)
    if "pull_position" in noise:
        own = float(np.hypot(own, noise["pull_position"].value * full.noise_gain(0, noise["pull_position"].spectrum)))
    if channel == "position":
        return {channel: full(position.values)}, {channel: float(np.hypot(own, inertia / pull_stiffness))}, inputs
    if "position" in channels:
        measured["position"] = full(position.values)
        noises["position"] = float(np.hypot(own, force.std * full.noise_gain(0, force.spectrum) / pull_stiffness))
    return measured, noises, inputs


def _resolved(motion: _Motion, drive: np.ndarray, width: float) -> tuple[Axis, ResolvedMotion, SlipPhases]:
    """Axis, direction and slip phases of a driven mass, with the kinks of its velocity restored."""
    step, n, prefilter_width = float(motion.time[1] - motion.time[0]), motion.time.size, PREFILTER_SHARE * width
    axis, _ = _prefiltered(motion, prefilter_width, width)
    gain = GaussianFilter(prefilter_width, step, n).noise_gain(1, motion.position.spectrum)
    rest = REST_SIGMAS * (motion.position.std * gain)
    reach = max(6, int(np.ceil(1.5 * width / step)))
    shortest = max(3, int(np.ceil(2.0 * prefilter_width / step)))
    search = min(2.5 * prefilter_width / step + 2.0, reach - 2.0)
    path, drive, resting = motion.position.values, drive * step**2, np.abs(axis.velocity) <= rest
    resolved, slip_phases = resolve_events(path, axis.velocity, drive, resting, reach, search, shortest)
    smoothed = SmoothedMotion(axis.velocity * step, axis.acceleration * step**2, drive, prefilter_width / step)
    return axis._replace(velocity=restored_kinks(smoothed, slip_phases) / step), resolved, slip_phases


WALK = 0.99
"""Correlation from row to row of the noise of an integrated velocity."""


def _position(channels: Mapping[str, np.ndarray], noise: Mapping[str, Noise], step: float) -> Signal | None:
    """The measured position, or the integral of the measured velocity; none where neither is recorded."""
    if "position" in channels:
        return Signal(*filled(channels["position"]), noise["position"].value, noise["position"].spectrum)
    if "velocity" in channels:
        velocity, gap = filled(channels["velocity"])
        # The integral of white noise is a random walk, which over the width of a filter is an autoregression.
        std = noise["velocity"].value * step / np.sqrt(1.0 - WALK**2)
        return Signal(integral(velocity, step), gap, float(std), NoiseSpectrum(WALK, 0.0, averaged=True))
    return None


def _drive_force(channels: Mapping[str, np.ndarray], noise: Mapping[str, Noise], hold: str) -> Signal:
    """The drive force at the rows."""
    force, gap = filled(channels["drive_force"])
    known = noise.get("drive_force")
    std, spectrum = (known.value, known.spectrum) if known is not None else (0.0, NoiseSpectrum())
    if hold == "zero":
        # The force is held over the step before a row and over that after it: its mean acts at the row. The means pass
        # the frequency w by cos(w h/2), the held force by sin(w h/2)/(w h/2), which is w^2 h^2/12 more.
        force = np.concatenate([force[:1], 0.5 * (force[1:] + force[:-1])])
        force[1:-1] -= np.diff(force, 2) / 12.0
        gap = gap | np.concatenate([[False], gap[:-1]])
        spectrum = spectrum._replace(averaged=True)
    return Signal(force, gap, std, spectrum)


def _signals(
    channels: Mapping[str, np.ndarray], noise: Mapping[str, Noise], step: float, stiffness: float | None, hold: str
) -> tuple[str, Signal, Signal]:
    """Name of the scored channel, position and force of a driven body; of a body pulled by a spring, the position or
    the force may give the other."""
    position = _position(channels, noise, step)
    if stiffness is None:
        assert position is not None
        return "drive_force", position, _drive_force(channels, noise, hold)
    pull, gap_pull = filled(channels["pull_position"])
    of_pull = noise["pull_position"].value if "pull_position" in noise else 0.0
    if position is not None:
        position = position._replace(gap=position.gap | gap_pull)
    if "spring_force" not in channels:
        assert position is not None
        force = position._replace(
            values=stiffness * (pull - position.values), std=stiffness * float(np.hypot(position.std, of_pull))
        )
        return "position", position, force
    spring = noise["spring_force"]
    force = Signal(*filled(channels["spring_force"]), spring.value, spring.spectrum)
    if position is None:
        std = float(np.hypot(spring.value / stiffness, of_pull))
        position = Signal(pull - force.values / stiffness, gap_pull, std, spring.spectrum)
    return "spring_force", position, force


def _require_motion(
    record: Record, channel: str, force: Signal, rows: tuple[int, int], step: float, width: float
) -> None:
    """Refuse a spring that never pulls, and a record without rows between the ends that the filter needs."""
    if float(np.std(force.values)) == 0.0 and channel != "drive_force":
        raise InputError(f"{record.file}: column '{channel}' does not change; nothing drives the axis")
    if 2 * (rows[1] + 1) >= rows[0]:
        raise InputError(
            f"{record.file}: its {rows[0] * step:.3g} s are too short for the filter of {width:.3g} s, which the "
            "position's noise and the longest step of all records set; give more, or see that time is in one unit"
        )


def _prefiltered(motion: _Motion, width: float, full_width: float) -> tuple[Axis, GaussianFilter]:
    """The axis from a motion filtered by `width` (s), and the filter that complements it to the `full_width`."""
    position = motion.position
    step, n = float(motion.time[1] - motion.time[0]), motion.time.size
    prefilter = GaussianFilter(width, step, n)
    axis = make_axis(
        motion.time,
        prefilter(position.values),
        prefilter(position.values, 1),
        _across_gaps(prefilter(position.values, 2), motion.missing, width / step),
        motion.load,
        motion.temperature,
        REST_SIGMAS * (position.std * prefilter.noise_gain(1, position.spectrum)),
    )
    return axis, _complementary(prefilter, full_width)


def _complementary(prefilter: GaussianFilter, full_width: float) -> GaussianFilter:
    """The filter that, after the prefilter, makes up the full width (s)."""
    width = float(np.sqrt(full_width**2 - prefilter.width**2))
    return GaussianFilter(width, prefilter.step, prefilter.size)


def _across_gaps(acceleration: np.ndarray, missing: np.ndarray, width: float) -> np.ndarray:
    """Acceleration (n,) with linear interpolation across gaps: the line that bridges the position has kinks at its
    ends, and a structural mode would ring with them long after."""
    interpolated = dilated(longer_than(missing, width), int(np.ceil(EDGE_WIDTHS * width)))
    return filled(np.where(interpolated, np.nan, acceleration))[0] if interpolated.any() else acceleration


def _stick_phases(
    record: ForceBalanceRecord,
    channels: Mapping[str, np.ndarray],
    noise: Mapping[str, Noise],
    usable: np.ndarray,
    edge: float,
) -> StickPhases | None:
    """Stick phases of a driven mass, without `edge` rows at each end, where its displacement was measured, or follows
    from the spring's force: steps of a coarse sensor are none, and an integrated velocity drifts."""
    by_spring = not {"position", "velocity"} & channels.keys()
    sensor = noise.get("spring_force" if by_spring else "position")
    if sensor is None or (sensor.quantisation_step or 0.0) > (sensor.without_quantisation or sensor.value):
        return None
    if not by_spring and "position" not in channels:
        return None
    assert record.full_filter is not None and record.applied is not None and record.stick_fraction is not None
    return find_stick_phases(
        record.axis.position,
        record.full_filter(record.applied),
        record.stick_fraction,
        record.axis.direction,
        usable,
        max(6, int(np.ceil(edge))),
        record.prefiltered_noise,
        1.0 / record.pull_stiffness if by_spring and record.pull_stiffness else 0.0,
    )


def acceleration_noise(position: Signal, full: GaussianFilter) -> float:
    """Noise of the filtered acceleration that the measured position leaves, m/s^2."""
    return position.std * full.noise_gain(2, position.spectrum)


def filter_width(
    channels: Mapping[str, np.ndarray],
    noise: Mapping[str, Noise],
    position: Signal,
    force: Signal,
    step: float,
    mass: float,
) -> float:
    """Width of the filter, s, from the noise of position and force."""
    of = next((noise[name] for name in ("position", "velocity", "spring_force") if name in channels), None)
    # Quantisation steps of a slow motion are no noise that a wider filter would reduce: it only blurs more.
    unquantised = 1.0 if of is None or of.without_quantisation is None else of.without_quantisation / of.value
    if float(np.std(force.values)) == 0.0:
        return _free_motion_width(position, step)
    # The least width at which mass times acceleration is no noisier than the force.
    allowed = max(force.std, 1e-3 * float(np.std(force.values)))
    width, longest = step, position.values.size * step / 40.0
    while width < longest:
        gain = GaussianFilter(width, step, position.values.size).noise_gain(2, position.spectrum)
        if mass * (position.std * unquantised) * gain <= allowed:
            return width
        width *= 1.15
    return longest


FREE_MOTION = 1e-2
"""Noise of the acceleration over its rms that the filter of a free motion leaves: it has no force to compare with."""


def _free_motion_width(position: Signal, step: float) -> float:
    """Width of the filter of a coast-down or a free oscillation, s: the least at which the acceleration's noise is a
    hundredth of its rms, else that of the least ratio, up to a fortieth of the record."""
    n, best, least = position.values.size, step, np.inf
    for width in step * np.geomspace(1.0, max(1.0, n / 40.0), 30):
        smooth = GaussianFilter(width, step, n)
        inside = slice(smooth.margin, n - smooth.margin)
        own = position.std * smooth.noise_gain(2, position.spectrum)
        ratio = own / max(float(np.std(smooth(position.values, 2)[inside])), 1e-300)
        if ratio < least:
            best, least = float(width), ratio
        if ratio <= FREE_MOTION:
            break
    return best
