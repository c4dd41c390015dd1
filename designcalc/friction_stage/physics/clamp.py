"""The clamp of the actuator in its pocket: what its finger closes, presses with and bears; its screws."""

import math
from dataclasses import dataclass

from designcalc.bearing.fastener import preload_of_torque
from designcalc.checks.check import DesignInputs, remembered
from designcalc.drive.clamp import ClampFinger
from designcalc.drive.height_adjustment import ClampShift, WedgeDrive, clamp_shift, wedge_drive
from stagecad.parameters.errors import InputError


def screw_preload(r: DesignInputs, screw: str) -> float:
    """Force of one screw at its torque, N; `screw` is a table of `screws`."""
    return float(preload_of_torque(*(r(f"screws.{screw}.{name}") for name in ("torque", "diameter", "nut_factor"))))


def wedge(r: DesignInputs) -> WedgeDrive:
    """The set screw that moves height pin 1 under height pin 2."""
    return wedge_drive(r("set_screw.pitch"), r("height_pin_1.slope"), r("height_pin_1.stroke"))


PRESSED = math.radians(10.0)
"""Angle of the pocket's wall beside the gap slot on which a finger presses."""


def press_angle(r: DesignInputs) -> float:
    """Angle from the screw's direction to the middle of the pressed wall in pocket 1, rad.

    Raises:
        InputError: the gap slot does not cross the pocket.
    """
    slot, radius = r("base.clamp_slot_1"), r("base.pocket_diameter") / 2
    if slot >= radius:
        raise InputError("clamp: base.clamp_slot_1: the gap slot must cross the pocket")
    return math.acos(slot / radius) + PRESSED / 2


@remembered
def clamp_finger(r: DesignInputs) -> ClampFinger:
    """One of the two fingers at pocket 1."""
    slot, half, lug = r("base.clamp_slot_1"), r("base.clamp_slot_width") / 2, r("base.clamp_lug")
    radius, neck, offset = r("base.pocket_diameter") / 2, r("base.clamp_neck"), r("base.clamp_screw_offset")
    pressed, angle = press_angle(r), r("base.clamp_neck_angle_1")
    if angle <= pressed:
        raise InputError("clamp: base.clamp_neck_angle_1: the neck must lie beyond the gap slot")
    middle = radius + neck / 2
    width = lug - 2 * half
    inner = slot - half - width / 2
    return ClampFinger(
        neck=neck,
        relief_radius=r("base.clamp_relief_hole") / 2,
        pocket_radius=radius,
        depth=r("base.height"),
        screw_lever=offset - middle * math.sin(angle),
        press_lever=middle * math.sin(angle - pressed),
        screw_depth=r("base.clamp_screw_depth"),
        press_depth=min(r("base.pocket_depth") - r("base.pocket_clearance"), r("holder.height")),
        lug_width=width,
        lug_thickness=r("base.clamp_reach") - half - math.sqrt(radius**2 - inner**2),
        wedge_angle=math.acos(slot / radius),
        press_length=PRESSED * radius,
        neck_angle=angle,
        press_angle=pressed,
        modulus=r.material("base", "youngs_modulus"),
        poisson=r.material("base", "poisson_ratio"),
    )


@dataclass(frozen=True)
class Grip:
    """Two fingers, alike, on the actuator in pocket 1."""

    screw: float  # force of each clamp screw, N
    gap: float  # that each finger closes while it pushes the actuator to the far wall, m
    closure: float  # of the free finger at the screw's force, m
    press: float  # force of each finger on the actuator, N
    hold: float  # frictional force of both fingers and the far wall in any direction, N
    stress: float  # of the neck, Pa
    free_stress: float  # without an actuator in the pocket, Pa
    rim: float  # sum of the normal forces on the actuator's rim, N


def clamp_gap(r: DesignInputs, tolerance: float = 0.0) -> float:
    """Way of each finger until it grips, m: ``c (1 + cos phi)``, c the radial play and phi the angle it presses at.

    The fingers push the actuator along the screws' direction to the far wall. `tolerance`, m, is added to the play.
    """
    play = r("base.pocket_diameter") - r("holder.diameter") + tolerance
    return play / 2 * (1 + math.cos(press_angle(r)))


@remembered
def grip(r: DesignInputs, tolerance: float = 0.0) -> Grip:
    """The clamp at its torque, with a play larger than nominal by `tolerance`, m."""
    finger, force, gap = clamp_finger(r), screw_preload(r, "clamp_long"), clamp_gap(r, tolerance)
    press = finger.press_force(force, gap)
    rim = 2 * press * (1 + math.cos(press_angle(r)))
    return Grip(
        screw=force,
        gap=gap,
        closure=finger.closure * force,
        press=press,
        hold=r("base.clamp_friction") * rim,
        stress=finger.stress(force, press),
        free_stress=finger.stress(force),
        rim=rim,
    )


def clamping_shift(r: DesignInputs) -> ClampShift:
    """Shift of the tip by tightening the clamp on the actuator."""
    return clamp_shift(
        rim_force=grip(r).rim,
        holder_diameter=r("holder.diameter"),
        holder_height=r("holder.height"),
        play=r("base.pocket_diameter") - r("holder.diameter"),
        apex_height=r("holder.floor") + r("piezo.length") + r("actuator.tip_height"),
        modulus=r.material("holder", "youngs_modulus"),
        poisson=r.material("holder", "poisson_ratio"),
    )
