"""Noise of each channel of an experiment: what the file gives, else what the records show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from sysid.experiment.experiment import Experiment
from sysid.experiment.record import Record
from sysid.noise.estimate import Noise, estimate_noise


def measured_channels(experiment: Experiment, records: Sequence[Record]) -> list[str]:
    """Channels of the records that a sensor's noise enters on this kind of rig."""
    rig = experiment.rig
    names = list(rig.declaration.measured_channels)
    if rig.kind == "force-drive":
        names.append("drive_force")
    if rig.kind == "velocity-drive":
        names.append("position")
    present = set().union(*(r.channels for r in records))
    return [n for n in dict.fromkeys(names) if n in present]


def noise_by_channel(experiment: Experiment, records: Sequence[Record]) -> tuple[dict[str, Noise], list[str]]:
    """Noise of each measured channel, given or estimated, and notes for the user."""
    noise, notes = {}, []
    for channel in measured_channels(experiment, records):
        given = experiment.noise.get(channel)
        per_record = [r.noise[channel] for r in records if channel in r.noise]
        if given is None and per_record:
            given = float(np.sqrt(np.mean(np.square(per_record))))
        # A known input: only its smoothness matters, and only where the velocity has to be taken from it.
        imposed = channel == "position" and experiment.rig.kind == "velocity-drive" and given is None
        if imposed and any("velocity" in r.channels for r in records):
            continue
        found = estimate_noise(records, channel, given)
        noise[channel] = found
        if found.note:
            notes.append(f"noise of {channel}: {found.note}")
    return noise, notes


def with_quantisation(noise: Mapping[str, Noise], names: Sequence[str]) -> dict[str, Noise]:
    """Noise with step/sqrt(12) added in the channels that the named `sensor_quantisation` effects act on."""
    out = dict(noise)
    for name in names:
        wanted = name.partition("@")[2]
        for channel, found in noise.items():
            if found.quantisation_step is None or (wanted and wanted != channel):
                continue
            step = found.quantisation_step / np.sqrt(12.0)
            # Steps well above the noise come and go with the motion, not from sample to sample: as good as white.
            value = float(np.hypot(found.value, step))
            out[channel] = replace(found, value=value, correlation=0.0, without_quantisation=found.value)
    return out
