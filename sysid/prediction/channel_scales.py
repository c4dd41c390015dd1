"""Scales of channels as parameters of the fit: `[channels]` gives a scale with its uncertainty, or leaves it open.

A channel is compared in the unit that its stated scale gives. With a true scale of g times the stated one, the model's
channel is divided by g; g is `rig.scale_CHANNEL`, with the stated uncertainty as its prior.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import Experiment
from sysid.experiment.unknowns import Prior, Unknown
from sysid.noise.estimate import Noise

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
            notes.append(f"the scale of '{channel}' is fitted: {PREFIX}{channel} is its ratio to '{_nominal(stated)}'")
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


def _nominal(stated: str) -> str:
    return stated.replace("fit", "1", 1) if stated.startswith("fit") else stated


def is_scale(key: str) -> bool:
    """Whether a parameter is the scale of a channel."""
    return key.startswith(PREFIX)


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
