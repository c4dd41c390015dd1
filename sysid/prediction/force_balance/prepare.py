"""From a record and what is known of its rig to a force balance or a tip record, ready to be compared with a model."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from sim.library.effect import Axis
from stagecad.parameters.errors import InputError
from sysid.experiment.record import Record
from sysid.experiment.resampling import uniform
from sysid.noise.estimate import Noise
from sysid.noise.quantisation import find_quantisation_step
from sysid.prediction.force_balance.record import (
    EDGE_WIDTHS,
    LAW_SHARE,
    ForceBalanceRecord,
    filled,
    filter_width,
    longer_than,
    make_axis,
    spread,
)
from sysid.prediction.force_balance.reversals import sharp_direction
from sysid.prediction.force_balance.stick_phases import find_stick_phases
from sysid.prediction.force_balance.sticking import sharpened
from sysid.signals.gaussian_filter import GaussianFilter

REST_SIGMAS = 5.0
"""A velocity within this many standard deviations of its noise is rest."""

SURE_SIGMAS = 6.0
SURE_STEPS = 2.5
"""A given velocity has a sign from so many deviations of its noise, and steps of its rounding, on."""


def _optional(channels: Mapping[str, np.ndarray], name: str) -> np.ndarray | None:
    values = channels.get(name)
    if values is None or not np.isfinite(values).any():
        return None
    return filled(values)[0]


def velocity_drive(record: Record, noise: Mapping[str, Noise]) -> ForceBalanceRecord:
    """A velocity-drive record: the motion is given, the friction force is measured and left unfiltered."""
    time, step, channels, hole = uniform(record)
    n = time.size
    force = channels["friction_force"]
    force, gap = filled(force)
    position, velocity = channels.get("position"), channels.get("velocity")
    law_width = 0.0
    sigma_position = 0.0
    missing = np.zeros(n, dtype=bool)
    if position is not None:
        position, missing = filled(position)
    if velocity is not None:
        velocity, gap_velocity = filled(velocity)
        missing = missing | gap_velocity
        if position is None:
            position = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * step)])
        acceleration = np.gradient(velocity, step)
        rest = 1e-9 * float(np.max(np.abs(velocity)))
    else:
        assert position is not None
        sigma_position = noise["position"].value if "position" in noise else 0.0
        law_width = 2.0 * step
        light = GaussianFilter(law_width, step, n)
        velocity, acceleration = light(position, 1), light(position, 2)
        rest = REST_SIGMAS * sigma_position * light.noise_gain(1) + 1e-6 * float(np.max(np.abs(velocity)))
    axis = make_axis(
        time, position, velocity, acceleration, _optional(channels, "normal_load"),
        _optional(channels, "temperature"), rest,
    )  # fmt: skip
    valid = ~(gap | hole | missing)
    valid[0] = False
    sigma = noise["friction_force"].value
    velocity_sign = _heading(velocity) if "velocity" in channels else None
    return ForceBalanceRecord(
        name=record.name, role=record.role, kind="velocity-drive", step=step, axis=axis,
        measured={"friction_force": force}, valid={"friction_force": valid}, noise={"friction_force": sigma},
        acceleration=None, stick_fraction=None, complementary_filter=GaussianFilter(0.0, step, n),
        force_channel="friction_force", velocity_sign=velocity_sign, timing_uncertainty=0.5 * step, stretch=max(1e-8 *
        float(np.ptp(position)), 12.0 * sigma_position),
    )  # fmt: skip


def _heading(velocity: np.ndarray) -> np.ndarray:
    """Sign of a velocity (n,) that was given, zero where its own noise or rounding could have made the sign."""
    change = np.abs(np.diff(velocity, 2))
    noise = float(np.median(change)) / 0.6745 / np.sqrt(6.0)
    quantisation_step = find_quantisation_step([velocity]) or 0.0
    sure = max(SURE_SIGMAS * noise, SURE_STEPS * quantisation_step, 1e-9 * float(np.max(np.abs(velocity))))
    return np.where(np.abs(velocity) > sure, np.sign(velocity), 0.0)


def driven_mass(
    record: Record,
    kind: str,
    noise: Mapping[str, Noise],
    mass: float,
    pull_stiffness: float | None = None,
    hold: str = "zero",
    width: float | None = None,
    least_width: float = 0.0,
) -> ForceBalanceRecord:
    """A spring-pull or force-drive record: the force is balanced against mass times the measured acceleration.

    Args:
        record: as read.
        kind: `spring-pull` or `force-drive`.
        noise: by channel.
        mass: known or estimated moving mass, kg; it sets the filter's width, not the fit.
        pull_stiffness: of the pulling spring, N/m.
        hold: `zero` when each row's drive force is held to the next, `linear` when it runs straight to it.
        width: of the filter, s, where it is to be the same as another record's.
        least_width: s, where another record that shares the filter has longer steps.
    """
    time, step, channels, hole = uniform(record)
    n = time.size
    gap_motion = np.zeros(n, dtype=bool)
    if "position" in channels:
        position, gap_motion = filled(channels["position"])
        sigma_position, correlation = noise["position"].value, noise["position"].correlation
        velocity_given = None
    elif "velocity" in channels:
        velocity_given, gap_motion = filled(channels["velocity"])
        position = np.concatenate([[0.0], np.cumsum(0.5 * (velocity_given[1:] + velocity_given[:-1]) * step)])
        sigma_position, correlation = noise["velocity"].value * step, 0.0
    else:
        position, velocity_given, sigma_position, correlation = None, None, 0.0, 0.0

    if kind == "spring-pull":
        assert pull_stiffness is not None
        pull, gap_pull = filled(channels["pull_position"])
        gap_motion = gap_motion | gap_pull
        if position is None:
            # Only the spring force is measured: the stretch gives the position.
            spring, gap_force = filled(channels["spring_force"])
            position = pull - spring / pull_stiffness
            sigma_position = noise["spring_force"].value / pull_stiffness
            correlation = noise["spring_force"].correlation
        if "spring_force" in channels:
            channel = "spring_force"
            force, gap_force = filled(channels["spring_force"])
            sigma_force, force_correlation = noise[channel].value, noise[channel].correlation
        else:
            channel = "position"
            force, gap_force = pull_stiffness * (pull - position), gap_motion
            sigma_force, force_correlation = pull_stiffness * sigma_position, correlation
    else:
        pull = None
        channel = "drive_force"
        force, gap_force = filled(channels["drive_force"])
        if hold == "zero":
            # The force held over the step before and the step after a row: its mean acts at the row.
            force = np.concatenate([force[:1], 0.5 * (force[1:] + force[:-1])])
            gap_force = gap_force | np.concatenate([[False], gap_force[:-1]])
        known = noise.get(channel)
        sigma_force = known.value if known is not None else 0.0
        force_correlation = known.correlation if known is not None else 0.0
        if hold == "zero":
            sigma_force /= np.sqrt(2.0)
    assert position is not None

    scale = float(np.sqrt(np.mean((force - force.mean()) ** 2)))
    if scale == 0.0:
        raise InputError(f"{record.file}: column '{channel}' does not change; nothing drives the axis")
    if width is None:
        target = max(sigma_force, 1e-3 * scale)
        # Steps that a slow motion takes one by one are no noise that a wider filter would lessen: it only blurs more.
        smoothed = sigma_position * _part_under_steps(noise, channels)
        width = max(filter_width(smoothed, step, mass, target, n, correlation), least_width)
    reach = int(np.ceil(EDGE_WIDTHS * width / step))
    if 2 * (reach + 1) >= n:
        raise InputError(
            f"{record.file}: its {n * step:.3g} s are too short for the filter of {width:.3g} s, which the "
            "position's noise and the longest step of all records set; give more, or see that time is in one unit"
        )
    law_width = LAW_SHARE * width
    light, full_filter = GaussianFilter(law_width, step, n), GaussianFilter(width, step, n)
    rest_of = GaussianFilter(float(np.sqrt(width**2 - law_width**2)), step, n)
    velocity = light(position, 1)
    sigma_velocity = sigma_position * light.noise_gain(1, correlation)
    rest = REST_SIGMAS * sigma_velocity
    load, temperature = _optional(channels, "normal_load"), _optional(channels, "temperature")
    axis = make_axis(time, light(position), velocity, light(position, 2), load, temperature, rest)
    missing = gap_motion | hole | gap_force
    axis = axis._replace(acceleration=_past_gaps(axis.acceleration, missing, law_width / step))
    acceleration = full_filter(position, 2)
    reach_event = max(6, int(np.ceil(1.5 * width / step)))
    drive = force / mass * step**2 if mass > 0 else np.zeros(n)
    direction, stick_fraction, reversals, slip_phases = sharp_direction(
        position,
        velocity,
        drive,
        np.abs(velocity) <= rest,
        reach_event,
        min(2.5 * law_width / step + 2.0, reach_event - 2.0),
        max(3, int(np.ceil(2.0 * law_width / step))),
    )
    kinked = sharpened(velocity * step, axis.acceleration * step**2, drive, slip_phases, law_width / step)
    axis = axis._replace(velocity=kinked / step)

    # A line through fewer rows than the filter is wide is as good as what the filter would have made of them.
    bad = missing | spread(longer_than(missing, width / step), reach)
    bad[: reach + 1] = True
    bad[n - reach :] = True
    gain = full_filter.noise_gain(0, force_correlation)
    acceleration_noise = sigma_position * full_filter.noise_gain(2, correlation)
    measured = {channel: full_filter(force)}
    valid = {channel: ~bad}
    floor = {channel: float(np.hypot(sigma_force * gain, mass * acceleration_noise))}
    inputs: dict[str, np.ndarray] = {}
    if kind == "spring-pull":
        assert pull is not None
        inputs["pull_position"] = full_filter(pull)
        inputs["spring_force"] = full_filter(force)
        if channel == "spring_force" and "position" in channels:
            assert pull_stiffness is not None
            measured["position"] = full_filter(position)
            valid["position"] = ~bad
            floor["position"] = float(
                np.hypot(sigma_position * full_filter.noise_gain(0, correlation), sigma_force * gain / pull_stiffness)
            )
    prefiltered_noise = sigma_position * light.noise_gain(0, correlation)
    stick_phases = None
    of_spring = kind == "spring-pull" and not {"position", "velocity"} & channels.keys()
    told_by = noise.get("spring_force" if of_spring else "position")
    # Steps of a coarse sensor are no displacement, and a velocity added up wanders.
    if (
        told_by is not None
        and (told_by.quantisation_step or 0.0) <= told_by.value
        and (of_spring or "position" in channels)
    ):
        stick_phases = find_stick_phases(
            axis.position, full_filter(force), stick_fraction, axis.direction, ~bad, reach_event, prefiltered_noise,
            1.0 / pull_stiffness if of_spring and pull_stiffness else 0.0,
        )  # fmt: skip
    return ForceBalanceRecord(
        name=record.name, role=record.role, kind=kind, step=step, axis=axis, measured=measured, valid=valid,
        noise=floor, acceleration=acceleration, stick_fraction=stick_fraction, complementary_filter=rest_of,
        full_filter=full_filter, direction=direction, reversals=reversals, slip_phases=slip_phases,
        prefilter_samples=law_width / step, force_channel=channel, timing_uncertainty=0.15 * step, inputs=inputs,
        applied=force, acceleration_noise=acceleration_noise, position_noise=sigma_position, stretch=12.0 *
        prefiltered_noise, prefiltered_noise=prefiltered_noise, pull_stiffness=pull_stiffness or 0.0,
        stick_phases=stick_phases, raw_position=position, interpolated=missing,
        half_width_variant=partial(_lightly_filtered, time, position, missing, load, temperature, 0.5 * law_width,
        width,
                      REST_SIGMAS * sigma_position, correlation),
    )  # fmt: skip


def _past_gaps(acceleration: np.ndarray, missing: np.ndarray, width: float) -> np.ndarray:
    """Acceleration (n,) that runs straight across gaps: the line that bridges the position has kinks at its ends, and
    whatever rings would ring with them long after.

    Args:
        acceleration: by a filter of `width` samples, (n,).
        missing: samples (n,) where the motion was made up.
    """
    interpolated = spread(longer_than(missing, width), int(np.ceil(EDGE_WIDTHS * width)))
    return filled(np.where(interpolated, np.nan, acceleration))[0] if interpolated.any() else acceleration


def _lightly_filtered(
    time: np.ndarray,
    position: np.ndarray,
    missing: np.ndarray,
    load: np.ndarray | None,
    temperature: np.ndarray | None,
    law_width: float,
    width: float,
    rest: float,
    correlation: float,
) -> tuple[Axis, GaussianFilter]:
    """The axis from a motion filtered by `law_width` (s), and the filter that makes up the whole `width`."""
    step = float(time[1] - time[0])
    light = GaussianFilter(law_width, step, time.size)
    velocity = light(position, 1)
    axis = make_axis(
        time, light(position), velocity, _past_gaps(light(position, 2), missing, law_width / step), load, temperature,
        rest * light.noise_gain(1, correlation),
    )  # fmt: skip
    return axis, GaussianFilter(float(np.sqrt(width**2 - law_width**2)), step, time.size)


def _part_under_steps(noise: Mapping[str, Noise], channels: Mapping[str, np.ndarray]) -> float:
    """Part of the motion's noise that is none of a grid's steps; 1 where those are not counted as noise."""
    of = next((noise[name] for name in ("position", "velocity", "spring_force") if name in channels), None)
    return 1.0 if of is None or of.without_quantisation is None else of.without_quantisation / of.value
