"""The stage as a plate that bends: modes, stiffness above the tip, and sag of the drive surface."""

import numpy as np
from scipy.optimize import root_scalar

from designcalc.checks.check import Check, CheckFunction, DesignInputs, show
from designcalc.friction_stage.physics.loads import bare_stage, gravity, load
from designcalc.friction_stage.physics.stage_plate import driven_modes, give_at_tip, give_of_pads_at_tip, sag
from designcalc.friction_stage.physics.tip_dynamics import usable_ellipse
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError

_PLATE = "Kirchhoff plate on its pads by finite elements (Zienkiewicz, Taylor, section 11.3)"
_APART = 1.5
"""Ratio of the frequencies of the drive and of a mode that is not excited."""
_TIP_SHARE = 0.1
"""Part of the largest motion above the tip among the modes, below which the tip hardly excites a mode."""


def checks(design: Design) -> list[CheckFunction]:
    """Resonance with the drive, stiffness against the tip, sag."""
    return [resonances, stiffness, drive_surface_sag]


def _nearest_mode(r: DesignInputs) -> float:
    """Frequency of the mode nearest to the drive among those that move above the tip, Hz.

    Raises:
        InputError: one above those that are computed could be nearer.
    """
    modes, drive = driven_modes(r), r("actuator.frequency")
    moving = np.abs(modes.shapes[0]) > _TIP_SHARE * np.abs(modes.shapes[0]).max()
    apart, nearest = min((max(f, drive) / min(f, drive), f) for f in modes.frequency[moving].tolist())
    highest = float(modes.frequency[-1])
    if _APART * drive > highest and apart >= _APART:
        most = show(highest / _APART, "Hz")
        raise InputError(f"modes are computed to {show(highest, 'Hz')}: the drive may be at {most} at most")
    return nearest


resonances = stated(
    "resonances of the stage on its pads against the drive",
    f"max(mode.nearest, actuator.frequency)/min(mode.nearest, actuator.frequency) >= {_APART}",
    given={
        "mode.nearest": (_nearest_mode, "Hz"),
        "mode.first": (lambda r: float(driven_modes(r).frequency[0]), "Hz"),
        "mode.second": (lambda r: float(driven_modes(r).frequency[1]), "Hz"),
        "mode.third": (lambda r: float(driven_modes(r).frequency[2]), "Hz"),
    },
    source=_PLATE + "; payload on four feet; every mode that moves above the tip",
    proposal="a box section or ribs, which raise the modes, with the drive below them; or a measured mode avoided",
    note="lowest modes {mode.first}, {mode.second}, {mode.third}",
)


def stiffness(r: DesignInputs) -> Check:
    """The stage must not bend away from the force that drives it."""
    rise, give = usable_ellipse(r)[1], give_at_tip(r)
    # Pads do not stiffen with the plate, and a thicker one weighs more.
    thick, pads = r("stage.thickness"), give_of_pads_at_tip(r)
    heavier = gravity(r) * bare_stage(r).mass / thick

    def excess(thickness: float) -> float:
        bent = (give - pads) * (thick / thickness) ** 3 + pads
        return (load(r) + heavier * (thickness - thick)) * bent - 0.2 * rise

    reached = excess(10 * thick) < 0 < excess(thick)
    enough = float(root_scalar(excess, bracket=(thick, 10 * thick)).root) if reached else 0.0
    return stated(
        "bending of the stage above the tip",
        "load.whole*give.above_tip <= 0.2*ellipse.rise",
        ("stage.thickness", "thickness.enough", True),
        given={"thickness.enough": (enough, "m")},
        source=_PLATE + "; weight and preload on plate and pads above the tip; a fifth of the rise left as rule of "
        "thumb",
        proposal="a thicker plate (stiffness grows as the cube), ribs, less preload, or pads nearer to the tip",
        note="{1/give.above_tip} above the tip",
    )(r)


def drive_surface_sag(r: DesignInputs) -> Check:
    """The height at which the tip meets the sagging drive surface depends on the position of the stage."""
    half = r("stage.travel") / 2
    x = np.linspace(-half, half, 21)
    height = sag(r, np.stack([x, np.zeros_like(x)], axis=1))
    return stated(
        "sag of the drive surface over the travel",
        "sag.largest - sag.least <= 0.1*ellipse.rise",
        given={"sag.largest": (float(height.max()), "m"), "sag.least": (float(height.min()), "m")},
        source=_PLATE + "; weight, payload, and the pull of the magnets at their irons; on the tip's line",
        proposal="a thicker plate or ribs, or lap the drive surface under the load",
    )(r)
