"""What the sensors report of a simulated motion: the model's sensor effects, on the channels they act on."""

from __future__ import annotations

import numpy as np

from sim.integration.simulate import Simulation
from sim.library.model import Model
from stagecad.parameters.errors import InputError, nearest

CHANNELS = {
    "position": "position",
    "velocity": "velocity",
    "friction_force": "friction",
    "spring_force": "drive",
    "drive_force": "drive",
}
"""Measured channel -> the quantity of a `Simulation` that it reports."""


def measured(run: Simulation, model: Model, channel: str = "position") -> np.ndarray:
    """A channel as its sensor reports it, shape (n,), SI.

    Every sensor effect of the model that names this channel, or none, acts on it, in the order of the model; so lag,
    delay, distortion, drift and quantisation add up as they do in a measurement.

    Args:
        run: a simulation, with an even time step where the model has sensor effects.
        model: the model it was made with.
        channel: one of `CHANNELS`.

    Raises:
        InputError: an unknown channel, or instants that are not evenly spaced.
    """
    if channel not in CHANNELS:
        raise InputError(f"no simulated channel '{channel}'{nearest(channel, CHANNELS)}")
    signal = np.array(getattr(run, CHANNELS[channel]), dtype=float)
    acting = [
        (effect, p)
        for effect, p in zip(model.effects, model.values)
        if effect.acts_on == "sensor" and effect.signal is not None and effect.name.partition("@")[2] in ("", channel)
    ]
    if not acting:
        return signal
    steps = np.diff(run.time)
    step = float(steps.mean())
    if np.abs(steps - step).max() > 1e-6 * step:
        raise InputError(f"channel '{channel}': the sensor effects need instants that are evenly spaced")
    for effect, p in acting:
        assert effect.signal is not None
        signal = np.asarray(effect.signal(np.ascontiguousarray(signal), step, p), dtype=float)
    return signal
