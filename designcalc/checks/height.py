"""The set screw, wedge and spring of the height adjustment."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from designcalc.bearing.fastener import preload_of_torque
from designcalc.checks.check import Check
from designcalc.checks.inputs import Reading, show
from designcalc.checks.machine import stroke_ellipse
from designcalc.drive.height_adjustment import WedgeDrive, clamp_shift, wedge_drive
from stagecad.parameters.errors import InputError


def checks(r: Reading) -> Iterator[partial[Check]]:
    """The set screw and wedge."""
    yield partial(sensitivity, r)
    yield partial(self_locking, r)
    yield partial(adjustment_range, r)
    yield partial(shim, r)
    yield partial(thickest_shim, r)
    yield partial(return_spring, r)
    yield partial(clamping, r)


def _wedge(r: Reading) -> WedgeDrive:
    return wedge_drive(r("set_screw.pitch"), r("height_pin_1.slope"), r("height_pin_1.stroke"))


def sensitivity(r: Reading) -> Check:
    drive = _wedge(r)
    rise = float(stroke_ellipse(r).normal)
    key = math.degrees(r("actuator.key_angle"))
    return r.check(
        "height adjustment within the ellipse",
        key * drive.lift_per_degree,
        rise / 2,
        "m",
        "at most",
        "wedge on a set screw, turned by hand",
        "key angle x P s/360 <= Y/2",
        f"{show(drive.lift_per_turn, 'm')} a turn, {show(drive.lift_per_degree, 'm')} a degree; Y = {show(rise, 'm')}",
        "a finer slope, or a fine-pitch screw",
        thesis="the tip height is to be set within the 1-10 um of its ellipse",
        requirement="Section 2.2: access to payload and adjustments",
    )


def self_locking(r: Reading) -> Check:
    drive = _wedge(r)
    friction = r("height_pin_1.friction")
    return r.check(
        "self-locking of the wedge",
        friction,
        1.5 * drive.locking_friction,
        "",
        "at least",
        "friction angles of both faces of the wedge",
        "mu >= 1.5 tan(atan(s)/2)",
        f"{friction:.3g} against {drive.locking_friction:.3g}",
        "a flatter slope",
    )


def adjustment_range(r: Reading) -> Check:
    drive = _wedge(r)
    chain = [r("drawing.tolerance_x_x")] * 4 + [r("drawing.tolerance_x_xx")] * 2
    stack = sum(chain)
    return r.check(
        "range of the height adjustment",
        drive.range / 2,
        stack,
        "m",
        "at least",
        "worst case of the height chain: holder, piezo, two pins at X.X; way and pad at X.XX",
        "s stroke/2 >= sum of tolerances",
        f"+-{show(drive.range / 2, 'm')} against +-{show(stack, 'm')}",
        f"a stroke of {show(2 * stack / r('height_pin_1.slope'), 'm')}, or tighter pins",
    )


def shim(r: Reading) -> Check:
    thinnest = r("shim.thinnest")
    rise = float(stroke_ellipse(r).normal)
    return r.check(
        "thinnest shim against the ellipse",
        thinnest,
        rise,
        "m",
        "at most",
        "thesis 2.3.3: a shim sets the gap between tip and stage",
        "thinnest shim <= Y",
        f"{show(thinnest, 'm')} against {show(rise, 'm')}",
        f"touch off by the piezos' own signal, or turn the screw {show(thinnest / _wedge(r).lift_per_degree, '')} "
        "degrees after the shim is out",
    )


def thickest_shim(r: Reading) -> Check:
    """Lowered by half its range, the tip must leave the thickest shim room to be drawn out."""
    drive = _wedge(r)
    thickest = r("shim.thickest")
    return r.check(
        "range of the adjustment against the thickest shim",
        drive.range / 2,
        thickest,
        "m",
        "at least",
        "thesis 2.3.3: gap of 0.0005 to 0.030 in held by a shim",
        "s stroke/2 >= thickest shim",
        f"{show(drive.range / 2, 'm')} below the middle against {show(thickest, 'm')}",
        f"shims of at most {show(drive.range / 2, 'm')}, or a stroke of "
        f"{show(2 * thickest / r('height_pin_1.slope'), 'm')}",
    )


def return_spring(r: Reading) -> Check:
    """The spring must push pin 1 back against what it carries: holder, piezos, tip, and pin 2 by its friction."""
    holder = math.pi / 4 * r("holder.diameter") ** 2 * r("holder.height") * r.material("holder", "density")
    stacks = 3 * math.pi / 4 * r("piezo.diameter") ** 2 * r("piezo.length") * r.material("piezo", "density")
    load = (holder + stacks + r("tip.mass_limit")) * r("environment.gravity")
    friction = r("height_pin_1.friction_dry")
    needed = 2 * friction * load  # both faces of the wedge
    squeeze = r("spring.free_length") - r("spring.installed_length") - r("height_pin_1.stroke") / 2
    force = r("spring.rate") * squeeze
    return r.check(
        "spring that returns the height pin",
        force,
        2 * needed,
        "N",
        "at least",
        "Coulomb friction on both faces of the wedge under holder, piezos and tip; factor 2",
        "k (L0 - L - stroke/2) >= 2 x 2 mu m g",
        f"{show(force, 'N')} against {show(needed, 'N')} of friction (plain volumes, {show(load, 'N')})",
        f"{show((2 * needed - force) / r('spring.rate'), 'm')} more compression at the far end of the stroke, by a "
        "longer spring or a shorter stroke",
    )


def clamping(r: Reading) -> Check:
    """After the height is set the clamp is tightened: how far the tip goes then."""
    force = preload_of_torque(
        r("screws.clamp_long.torque"), r("screws.clamp_long.diameter"), r("screws.clamp_long.nut_factor")
    )
    slot, radius = r("base.clamp_slot_1"), r("base.pocket_diameter") / 2
    if slot >= radius:
        raise InputError("height adjustment: base.clamp_slot_1: the gap slot must cross the pocket")
    start = math.acos(slot / radius)
    wrap = r("base.clamp_neck_angle_1") - start
    shift = clamp_shift(
        screw_force=force,
        wrap=wrap,
        holder_diameter=r("holder.diameter"),
        holder_height=r("holder.height"),
        play=r("base.pocket_diameter") - r("holder.diameter"),
        apex_height=r("holder.floor") + r("piezo.length") + r("actuator.tip_height"),
        modulus=r.material("holder", "youngs_modulus"),
        poisson=r.material("holder", "poisson_ratio"),
    )
    moved = shift.squeeze + shift.drop
    rise = float(stroke_ellipse(r).normal)
    return r.check(
        "shift of the tip's height by clamping",
        moved,
        0.1 * rise,
        "m",
        "at most",
        "band round a cylinder, mean growth by Poisson's ratio; tilt within the pocket's play",
        "nu S/(pi R E) + h (1 - cos(play/H)) <= Y/10, S = T (theta + 2 sin(theta/2))",
        f"T = {show(force, 'N')} over {math.degrees(wrap):.3g} deg: up {show(shift.squeeze, 'm')}, down at most "
        f"{show(shift.drop, 'm')}; Y = {show(rise, 'm')}",
        "less torque, or a closer fit of the holder; set the height again after clamping",
        note=f"sideways the tip may go by {show(shift.sideways, 'm')}: set its place after clamping",
        requirement="Section 2.2: access to payload and adjustments",
    )
