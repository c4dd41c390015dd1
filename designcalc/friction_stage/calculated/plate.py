"""The stage as a plate that bends: modes near the drive, thickness that is stiff enough, sag of the drive surface."""

import numpy as np
from scipy.optimize import root_scalar

from designcalc.checks.check import DesignInputs, Quantities, show
from designcalc.friction_stage.physics import loads, stage_plate, tip_dynamics
from stagecad.parameters.errors import InputError

APART = 1.5
"""Ratio of the frequencies of the drive and of a mode that is not excited."""
_TIP_SHARE = 0.1
"""Part of the largest motion above the tip among the modes, below which the tip hardly excites a mode."""


def _nearest_mode(r: DesignInputs) -> float:
    """Frequency of the mode nearest to the drive among those that move above the tip, Hz.

    Raises:
        InputError: one above those that are computed could be nearer.
    """
    modes, drive = stage_plate.driven_modes(r), r("actuator.frequency")
    moving = np.abs(modes.shapes[0]) > _TIP_SHARE * np.abs(modes.shapes[0]).max()
    apart, nearest = min((max(f, drive) / min(f, drive), f) for f in modes.frequency[moving].tolist())
    highest = float(modes.frequency[-1])
    if APART * drive > highest and apart >= APART:
        most = show(highest / APART, "Hz")
        raise InputError(f"modes are computed to {show(highest, 'Hz')}: the drive may be at {most} at most")
    return nearest


def stiffness(r: DesignInputs) -> Quantities:
    rise, give = tip_dynamics.usable_ellipse(r)[1], stage_plate.give_at_tip(r)
    # Pads do not stiffen with the plate, and a thicker one weighs more.
    thick, pads = r("stage.thickness"), stage_plate.give_of_pads_at_tip(r)
    heavier = loads.gravity(r) * loads.bare_stage(r).mass / thick

    def excess(thickness: float) -> float:
        bent = (give - pads) * (thick / thickness) ** 3 + pads
        return (loads.load(r) + heavier * (thickness - thick)) * bent - 0.2 * rise

    reached = excess(10 * thick) < 0 < excess(thick)
    enough = float(root_scalar(excess, bracket=(thick, 10 * thick)).root) if reached else 0.0
    return {"thickness.enough": (enough, "m")}


def drive_surface_sag(r: DesignInputs) -> Quantities:
    half = r("stage.travel") / 2
    x = np.linspace(-half, half, 21)
    height = stage_plate.sag(r, np.stack([x, np.zeros_like(x)], axis=1))
    return {"sag.largest": (float(height.max()), "m"), "sag.least": (float(height.min()), "m")}


QUANTITIES: Quantities = {
    "mode.nearest": (_nearest_mode, "Hz"),
    "mode.first": (lambda r: float(stage_plate.driven_modes(r).frequency[0]), "Hz"),
    "mode.second": (lambda r: float(stage_plate.driven_modes(r).frequency[1]), "Hz"),
    "mode.third": (lambda r: float(stage_plate.driven_modes(r).frequency[2]), "Hz"),
}
