"""The stage as a plate that bends: modes, stiffness above the tip, and sag of the drive surface."""

import numpy as np
from scipy.optimize import root_scalar

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, change, show
from designcalc.friction_stage.physics.body import bare_stage
from designcalc.friction_stage.physics.loads import gravity, load, preload
from designcalc.friction_stage.physics.plate_vibration import driven_modes
from designcalc.friction_stage.physics.stage_plate import give_at_tip, give_of_pads_at_tip, sag
from designcalc.friction_stage.physics.tip_dynamics import usable_ellipse
from stagecad.parameters.design import Design

_PLATE = "Kirchhoff plate on its pads by finite elements (Zienkiewicz, Taylor, section 11.3)"
_APART = 1.5
"""Ratio of the frequencies of the drive and of a mode that is not excited."""
_TIP_SHARE = 0.1
"""Part of the largest motion above the tip among the modes, below which the tip hardly excites a mode."""


def checks(design: Design) -> list[CheckFunction]:
    """Resonance with the drive, stiffness against the tip, sag."""
    return [resonances, stiffness, drive_surface_sag]


def resonances(r: DesignInputs) -> Check:
    drive = r("actuator.frequency")
    modes = driven_modes(r)
    moving = np.abs(modes.shapes[0]) > _TIP_SHARE * np.abs(modes.shapes[0]).max()
    excited = modes.frequency[moving]
    ratios = np.maximum(excited, drive) / np.minimum(excited, drive)
    nearest = float(excited[int(np.argmin(ratios))])
    lowest = ", ".join(show(float(f), "Hz") for f in modes.frequency[:5])
    # A mode above those that are computed could be nearer.
    highest = float(modes.frequency[-1])
    beyond = _APART * drive > highest and ratios.min() >= _APART
    return Check(
        "resonances of the stage on its pads against the drive",
        at_least(None if beyond else float(ratios.min()), _APART, ""),
        source=_PLATE + "; payload on four feet",
        formula="larger over smaller of f_mode and f_drive >= 1.5 for every mode that moves above the tip",
        trouble="out_of_range" if beyond else "",
        note=f"modes are computed to {show(highest, 'Hz')}: the drive may be at {show(highest / _APART, 'Hz')} at most"
        if beyond
        else "",
        substituted=f"lowest modes {lowest}; nearest to the drive {show(nearest, 'Hz')}; drive {show(drive, 'Hz')}",
        proposal="a box section or ribs, which raise the modes, with the drive below them; or a measured mode avoided",
    )


def stiffness(r: DesignInputs) -> Check:
    """The stage must not bend away from the force that drives it."""
    rise, give = usable_ellipse(r)[1], give_at_tip(r)
    lost = load(r) * give
    # Pads do not stiffen with the plate, and a thicker one weighs more.
    thick, pads = r("stage.thickness"), give_of_pads_at_tip(r)
    heavier = gravity(r) * bare_stage(r).mass / thick

    def excess(thickness: float) -> float:
        bent = (give - pads) * (thick / thickness) ** 3 + pads
        return (load(r) + heavier * (thickness - thick)) * bent - 0.2 * rise

    enough = (
        float(root_scalar(excess, bracket=(thick, 10 * thick)).root)
        if excess(10 * thick) < 0 < excess(thick)
        else np.inf
    )
    return Check(
        "bending of the stage above the tip",
        at_most(lost, 0.2 * rise, "m"),
        source=_PLATE + "; a fifth of the rise left as rule of thumb",
        formula="F/K <= 0.2 Y, F weight and preload, K of plate and pads above the tip",
        substituted=f"{show(load(r), 'N')}/{show(1 / give, 'N/m')} = {show(lost, 'm')}, Y = {show(rise, 'm')}",
        proposal="a thicker plate (stiffness grows as the cube), ribs, less preload, or pads nearer to the tip",
        changes=change("stage.thickness", enough, "m", up=True),
    )


def drive_surface_sag(r: DesignInputs) -> Check:
    """The height at which the tip meets the sagging drive surface depends on the position of the stage."""
    half = r("stage.travel") / 2
    x = np.linspace(-half, half, 21)
    height = sag(r, np.stack([x, np.zeros_like(x)], axis=1))
    change, rise = float(np.ptp(height)), usable_ellipse(r)[1]
    return Check(
        "sag of the drive surface over the travel",
        at_most(change, 0.1 * rise, "m"),
        source=_PLATE + "; weight, payload, and the pull of the magnets at their irons",
        formula="largest less smallest deflection on the tip's line over the travel <= Y/10",
        substituted=f"{show(float(height.min()), 'm')} to {show(float(height.max()), 'm')} with "
        f"{show(preload(r), 'N')} of preload; Y = {show(rise, 'm')}",
        proposal="a thicker plate or ribs, or lap the drive surface under the load",
    )
