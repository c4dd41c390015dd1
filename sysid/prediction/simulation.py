"""Channels of a rig as a model simulates them from the inputs of a record; the model class of each rig."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sim.effects.effect import Effect
from sysid.experiment.experiment import Rig
from sysid.experiment.record import Record
from sysid.prediction.actuator_tip import ActuatorTip
from sysid.prediction.effect_terms import Values
from sysid.prediction.force_balance.driven_mass import ForceDrive, SpringPull
from sysid.prediction.force_balance.imposed_motion import VelocityDrive
from sysid.prediction.friction_drive.record import FrictionDrive
from sysid.prediction.resampling import uniform
from sysid.prediction.rig_model import RigModel, Start
from sysid.signals import filled

RIG_MODELS: dict[str, RigModel] = {
    rig.name: rig for rig in (VelocityDrive(), SpringPull(), ForceDrive(), ActuatorTip(), FrictionDrive())
}


def simulated_channels(
    rig: Rig, record: Record, effects: Sequence[Effect], values: Values, start: Start | None = None
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time (n,), s, from zero at a uniform step, and the inputs and measured channels of a rig, each (n,), SI."""
    time, _, inputs = uniform_inputs(rig, record)
    at_rows = replace(record, time=time, channels=inputs, step=float(time[1] - time[0]), uniform=True)
    return time, {**inputs, **RIG_MODELS[rig.kind].simulate(rig, at_rows, effects, values, start)}


def uniform_inputs(rig: Rig, record: Record) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Time (n,), s, from zero at a uniform step; every channel there, (n,); and the inputs with their gaps filled."""
    time, _, channels, _ = uniform(record)
    used = ("normal_load", "temperature", *rig.declaration.input_channels)
    return time, channels, {name: filled(channels[name])[0] for name in used if name in channels}
