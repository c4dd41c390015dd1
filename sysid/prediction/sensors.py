"""Effects of sensors, and of the lag of a drive, on the channels of a force balance, and their inversion."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from sim.effects.effect import Effect
from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import Experiment
from sysid.experiment.known import Prior, Unknown
from sysid.noise.estimate import Noise
from sysid.prediction.effect_terms import Values, split_channel, values_of
from sysid.prediction.force_balance.record import ForceBalanceRecord


def sensed(
    effects: Sequence[Effect], values: Values, channels: dict[str, np.ndarray], step: float
) -> dict[str, np.ndarray]:
    """The channels as their sensors report them; an effect without a channel in its name acts on every one."""
    for effect in effects:
        if effect.acts_on != "sensor" or effect.signal is None or effect.rounds:
            continue
        wanted = split_channel(effect.name)[1]
        p = values_of(effect, values)
        for channel in channels:
            if channel == "drive_force" or (wanted is not None and wanted != channel):
                continue
            channels[channel] = effect.signal(np.ascontiguousarray(channels[channel]), step, p)
    return channels


def delays_motion(balance: ForceBalanceRecord, effect: Effect) -> bool:
    """Whether an effect delays the logged motion against the logged force: a lag of the drive or the motion sensor."""
    if effect.inverse is None or balance.acceleration is None:
        return False
    channel = split_channel(effect.name)[1]
    if balance.force_channel == "drive_force":
        return channel is None
    every = channel is None and "position" in balance.measured
    return effect.acts_on == "sensor" and (every or channel in ("position", "velocity"))


def delayed_like_motion(
    balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values, signal: np.ndarray, lags: bool = False
) -> np.ndarray:
    """A signal (n,) delayed as the logged motion is, or by `lags` only."""
    for effect in effects:
        if delays_motion(balance, effect) and effect.signal is not None:
            p = values_of(effect, values)
            if not lags or _is_lag(effect, balance.step, p):
                signal = effect.signal(np.ascontiguousarray(signal), balance.step, p)
    return signal


def ahead_of_motion(
    balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values, signal: np.ndarray
) -> np.ndarray:
    """The signal (n,), smooth, whose delay by the logged motion's effects, but for the lags, gives `signal`."""
    for effect in reversed(effects):
        if delays_motion(balance, effect) and effect.inverse is not None:
            p = values_of(effect, values)
            signal = signal if _is_lag(effect, balance.step, p) else effect.inverse(signal, balance.step, p)
    return signal


IMPULSE = np.eye(1, 9, 4)[0]
"""A signal of one row."""


def _is_lag(effect: Effect, step: float, p: Any) -> bool:
    """Whether an effect attenuates as it delays, as a first-order lag does: its inverse amplifies white noise."""
    return effect.inverse is not None and float(np.linalg.norm(effect.inverse(IMPULSE, step, p))) > 1.0


def kept_by_lag(given: np.ndarray, late: np.ndarray) -> float:
    """The part of the standard deviation of a force (n,) that a lag of it keeps."""
    return float(np.std(late) / max(np.std(given), 1e-300))


def sensor_input(
    output: np.ndarray, channel: str, effects: Sequence[Effect], values: Values, step: float, late: bool = True
) -> np.ndarray:
    """Input (n,) of the sensor of a channel, from its `output`: its effects are inverted in reverse order."""
    for effect in reversed(effects):
        if effect.acts_on != "sensor" or split_channel(effect.name)[1] not in (None, channel) or effect.rounds:
            continue
        p = values_of(effect, values)
        if effect.inverse is not None:
            output = effect.inverse(output, step, p) if late else output
        elif effect.signal is not None:
            # A small distortion is inverted to first order.
            output = 2.0 * output - effect.signal(np.ascontiguousarray(output), step, p)
    return output


PREFIX = "rig.scale_"
WIDEST = 1e3
"""Factor by which a scale that is left open may differ from one of its unit."""


def put_scales(
    experiment: Experiment, compared: Iterable[str], values: dict[str, float], unknowns: list[Unknown], notes: list[str]
) -> None:
    """Enter the uncertain scales of the compared channels among the parameters of the rig; a note on each."""
    compared = tuple(compared)
    for channel in dict.fromkeys(name for record in experiment.records for name in record.sources):
        terms = [
            term for record in experiment.records if channel in record.sources for term in record.sources[channel].terms
        ]
        uncertain = [term for term in terms if term.deviation]
        if not uncertain:
            continue
        stated, deviation = uncertain[0].scale, uncertain[0].deviation
        place = f"{experiment.path}: channels.{channel}.scale = '{stated}'"
        # One parameter stands for one column of each record, with the same scale.
        single = len(terms) == len(experiment.records) and {term.scale for term in terms} == {stated}
        if channel in compared and single:
            _put(channel, deviation, values, unknowns)
            nominal = stated.replace("fit", "1", 1) if stated.startswith("fit") else stated
            notes.append(f"the scale of '{channel}' is fitted: {PREFIX}{channel} is its ratio to '{nominal}'")
        elif math.isinf(deviation):
            wanted = f"it can be fitted of {', '.join(compared)}" if channel not in compared else "give all records one"
            raise InputError(f"{place}: {wanted}; write its value, perhaps with an uncertainty")
        else:
            notes.append(
                f"the scale of '{channel}' is known to {100.0 * deviation:.2g} %, and so is every value that is "
                "proportional to it; the intervals do not contain this"
            )


def _put(channel: str, deviation: float, values: dict[str, float], unknowns: list[Unknown]) -> None:
    key = f"{PREFIX}{channel}"
    values[key] = 1.0
    if math.isinf(deviation):
        unknowns.append(Unknown(key, 1.0, 1.0 / WIDEST, WIDEST, 1.0))
    else:
        reach = min(3.0 * deviation, 0.99)
        unknowns.append(Unknown(key, 1.0, 1.0 - reach, 1.0 + 3.0 * deviation, deviation, Prior(1.0, deviation)))


def noise_of_scale(noise: Noise, ratio: float) -> Noise:
    """The noise of a channel whose true scale is `ratio` times that by which it was found."""
    if ratio == 1.0:
        return noise
    other = {name: getattr(noise, name) for name in ("quantisation_step", "without_quantisation")}
    scales = {name: value if value is None else abs(ratio) * value for name, value in other.items()}
    return replace(noise, value=abs(ratio) * noise.value, **scales)


def scale_ratio(values: Mapping[str, float], channel: str) -> float:
    """True scale of a channel over the stated one."""
    return values.get(f"{PREFIX}{channel}", 1.0)


def unscaled(channels: Mapping[str, np.ndarray], values: Mapping[str, float]) -> dict[str, np.ndarray]:
    """Logged channels (n,) by their true scales; the inverse of `scaled`."""
    return {name: logged * scale_ratio(values, name) for name, logged in channels.items()}


def scaled(predicted: dict[str, np.ndarray], values: Mapping[str, float]) -> dict[str, np.ndarray]:
    """Predicted channels (n,) in the units that the stated scales give."""
    ratios = {channel: scale_ratio(values, channel) for channel in predicted}
    if all(ratio == 1.0 for ratio in ratios.values()):
        return predicted
    return {channel: values_there / ratios[channel] for channel, values_there in predicted.items()}
