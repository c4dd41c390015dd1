"""Wedge and clamp of the height adjustment, and the preload of the machine's screws."""

from __future__ import annotations

import math

from designcalc.bearing.fastener import preload_of_torque
from designcalc.drive.height_adjustment import ClampShift, WedgeDrive, clamp_shift, wedge_drive
from designcalc.machine.inputs import DesignInputs
from stagecad.parameters.errors import InputError


def screw_preload(r: DesignInputs, screw: str) -> float:
    """Force of one screw at its torque, N; `screw` is a table of `screws`."""
    return float(preload_of_torque(*(r(f"screws.{screw}.{name}") for name in ("torque", "diameter", "nut_factor"))))


def wedge(r: DesignInputs) -> WedgeDrive:
    """The set screw that moves height pin 1 under height pin 2."""
    return wedge_drive(r("set_screw.pitch"), r("height_pin_1.slope"), r("height_pin_1.stroke"))


def clamp_wrap(r: DesignInputs) -> float:
    """Angle over which the clamp's band touches the holder, rad.

    Raises:
        InputError: the gap slot does not cross the pocket.
    """
    slot, radius = r("base.clamp_slot_1"), r("base.pocket_diameter") / 2
    if slot >= radius:
        raise InputError("height adjustment: base.clamp_slot_1: the gap slot must cross the pocket")
    return r("base.clamp_neck_angle_1") - math.acos(slot / radius)


def clamping_shift(r: DesignInputs) -> ClampShift:
    """Shift of the tip by tightening the clamp around the holder."""
    return clamp_shift(
        screw_force=screw_preload(r, "clamp_long"),
        wrap=clamp_wrap(r),
        holder_diameter=r("holder.diameter"),
        holder_height=r("holder.height"),
        play=r("base.pocket_diameter") - r("holder.diameter"),
        apex_height=r("holder.floor") + r("piezo.length") + r("actuator.tip_height"),
        modulus=r.material("holder", "youngs_modulus"),
        poisson=r.material("holder", "poisson_ratio"),
    )
