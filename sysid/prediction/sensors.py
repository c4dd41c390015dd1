"""Effects of sensors, and of the lag of a drive, on the channels of a force balance, and their inversion."""

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


def delays_motion(balance: ForceBalanceRecord, effect: Effect) -> bool:
    """Whether an effect delays the logged motion against the logged force: a lag of the drive or the motion sensor."""
    base, channel = split_channel(effect.name)
    if balance.kind == "velocity-drive":
        return False
    if channel is None and balance.kind == "force-drive":
        return base in ("sensor_lag", "sensor_delay", "drive_lag", "drive_delay")
    every = channel is None and "position" in balance.measured
    return base in ("sensor_lag", "sensor_delay") and (every or channel in ("position", "velocity"))


def delayed_like_motion(
    balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values, signal: np.ndarray
) -> np.ndarray:
    """A signal (n,) delayed as the logged motion is."""
    for effect in effects:
        if delays_motion(balance, effect) and effect.signal is not None:
            signal = effect.signal(np.ascontiguousarray(signal), balance.step, values_of(effect, values))
    return signal


def sensor_input(
    output: np.ndarray, channel: str, effects: Sequence[Effect], values: Values, step: float, late: bool = True
) -> np.ndarray:
    """Input (n,) of the sensor of a channel, from its `output`: its effects are inverted in reverse order.

    Args:
        late: invert lags and delays too; else only the nonlinearity.
    """
    for effect in reversed(effects):
        base, own = split_channel(effect.name)
        if effect.acts_on != "sensor" or own not in (None, channel) or base == "sensor_quantisation":
            continue
        p = values_of(effect, values)
        if base == "sensor_lag":
            output = output + p.time_constant * np.gradient(output, step) if late else output
        elif base == "sensor_delay":
            output = _advanced(output, step, p.delay) if late else output
        elif effect.signal is not None:
            # A small distortion is inverted to first order.
            output = 2.0 * output - effect.signal(np.ascontiguousarray(output), step, p)
    return output
