"""What sensors, and a drive that is late, do to the channels of a force balance, and how that is undone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.library.effect import Effect
from sysid.prediction.effect_terms import Values, split_channel, values_of
from sysid.prediction.force_balance.record import ForceBalanceRecord


def sensed(
    effects: Sequence[Effect], values: Values, channels: dict[str, np.ndarray], step: float
) -> dict[str, np.ndarray]:
    """The channels as their sensors report them; an effect without a channel in its name acts on every one."""
    for effect in effects:
        if effect.acts_on != "sensor" or effect.signal is None:
            continue
        base, wanted = split_channel(effect.name)
        if base == "sensor_quantisation":
            continue
        p = values_of(effect, values)
        for channel in channels:
            if channel == "drive_force" or (wanted is not None and wanted != channel):
                continue
            channels[channel] = effect.signal(np.ascontiguousarray(channels[channel]), step, p)
    return channels


def _advanced(signal: np.ndarray, step: float, ahead: float) -> np.ndarray:
    index = np.arange(signal.size)
    return np.interp(index + ahead / step, index, signal)


def makes_motion_late(balance: ForceBalanceRecord, effect: Effect) -> bool:
    """Whether an effect sets the logged motion behind the logged force: the drive's lag, or the motion sensor's."""
    base, channel = split_channel(effect.name)
    if balance.kind == "velocity-drive":
        return False
    if channel is None and balance.kind == "force-drive":
        return base in ("sensor_lag", "sensor_delay", "drive_lag", "drive_delay")
    every = channel is None and "position" in balance.measured
    return base in ("sensor_lag", "sensor_delay") and (every or channel in ("position", "velocity"))


def as_late_as_the_motion(
    balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values, signal: np.ndarray
) -> np.ndarray:
    """A signal (n,) set back by as much as the logged motion is."""
    for effect in effects:
        if makes_motion_late(balance, effect) and effect.signal is not None:
            signal = effect.signal(np.ascontiguousarray(signal), balance.step, values_of(effect, values))
    return signal


def before_the_sensor(
    said: np.ndarray, channel: str, effects: Sequence[Effect], values: Values, step: float, late: bool = True
) -> np.ndarray:
    """What the sensor of a channel was given (n,), from what it `said`: what its effects did, undone from the last on.

    Args:
        late: lags and delays too; else only what bends the scale.
    """
    for effect in reversed(effects):
        base, own = split_channel(effect.name)
        if effect.acts_on != "sensor" or own not in (None, channel) or base == "sensor_quantisation":
            continue
        p = values_of(effect, values)
        if base == "sensor_lag":
            said = said + p.time_constant * np.gradient(said, step) if late else said
        elif base == "sensor_delay":
            said = _advanced(said, step, p.delay) if late else said
        elif effect.signal is not None:
            # A small distortion is undone, to first order, by taking it away again.
            said = 2.0 * said - effect.signal(np.ascontiguousarray(said), step, p)
    return said
