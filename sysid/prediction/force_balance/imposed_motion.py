"""Force-balance records from records of the rig kind `velocity-drive`: the motion is imposed, the friction measured."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sysid.experiment.record import Record
from sysid.noise.estimate import Noise
from sysid.noise.quantisation import find_quantisation_step
from sysid.prediction.force_balance.record import (
    REST_SIGMAS,
    ForceBalanceRecord,
    integral,
    make_axis,
    optional_channel,
)
from sysid.signals.gaussian_filter import GaussianFilter
from sysid.signals.masks import filled
from sysid.signals.resampling import uniform

SIGN_SIGMAS = 6.0
SIGN_STEPS = 2.5
"""Standard deviations of its noise, and quantisation steps, from which a given velocity has a certain sign."""


def velocity_drive(record: Record, noise: Mapping[str, Noise]) -> ForceBalanceRecord:
    """A velocity-drive record: the motion is given, the friction force is measured and left unfiltered."""
    time, step, channels, hole = uniform(record)
    n = time.size
    force, gap = filled(channels["friction_force"])
    position, velocity = channels.get("position"), channels.get("velocity")
    position_std = 0.0
    missing = np.zeros(n, dtype=bool)
    if position is not None:
        position, missing = filled(position)
    if velocity is not None:
        velocity, gap_velocity = filled(velocity)
        missing = missing | gap_velocity
        position = integral(velocity, step) if position is None else position
        acceleration = np.gradient(velocity, step)
        rest = 1e-9 * float(np.max(np.abs(velocity)))
    else:
        assert position is not None
        position_std = noise["position"].value if "position" in noise else 0.0
        prefilter = GaussianFilter(2.0 * step, step, n)
        velocity, acceleration = prefilter(position, 1), prefilter(position, 2)
        rest = REST_SIGMAS * position_std * prefilter.noise_gain(1) + 1e-6 * float(np.max(np.abs(velocity)))
    load, temperature = optional_channel(channels, "normal_load"), optional_channel(channels, "temperature")
    valid = ~(gap | hole | missing)
    valid[0] = False
    return ForceBalanceRecord(
        name=record.name,
        role=record.role,
        kind="velocity-drive",
        step=step,
        axis=make_axis(time, position, velocity, acceleration, load, temperature, rest),
        measured={"friction_force": force},
        valid={"friction_force": valid},
        noise={"friction_force": noise["friction_force"].value},
        acceleration=None,
        stick_fraction=None,
        complementary_filter=GaussianFilter(0.0, step, n),
        force_channel="friction_force",
        velocity_sign=_certain_sign(velocity) if "velocity" in channels else None,
        timing_uncertainty=0.5 * step,
        stretch=max(1e-8 * float(np.ptp(position)), 12.0 * position_std),
    )


def _certain_sign(velocity: np.ndarray) -> np.ndarray:
    """Sign of a given velocity (n,), zero where its own noise or rounding could have made the sign."""
    change = np.abs(np.diff(velocity, 2))
    noise = float(np.median(change)) / 0.6745 / np.sqrt(6.0)
    quantisation_step = find_quantisation_step([velocity]) or 0.0
    sure = max(SIGN_SIGMAS * noise, SIGN_STEPS * quantisation_step, 1e-9 * float(np.max(np.abs(velocity))))
    return np.where(np.abs(velocity) > sure, np.sign(velocity), 0.0)
