"""The kinds of rig by name."""

from __future__ import annotations

from sysid.prediction.actuator_tip import ActuatorTip
from sysid.prediction.force_balance.driven_mass import ForceDrive, SpringPull
from sysid.prediction.force_balance.imposed_motion import VelocityDrive
from sysid.prediction.friction_drive.rig import FrictionDrive
from sysid.prediction.rig_model import RigModel

RIG_MODELS: dict[str, RigModel] = {
    rig.name: rig for rig in (VelocityDrive(), SpringPull(), ForceDrive(), ActuatorTip(), FrictionDrive())
}
