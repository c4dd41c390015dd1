"""Magnetic teeth: ratio and size of their stiffness on the map, and the gap that gives the required preload."""

import math

import numpy as np
from scipy.optimize import root_scalar

from designcalc.checks.check import DesignInputs, Quantities
from designcalc.drive.magnetic_teeth import teeth_field
from designcalc.friction_stage.physics.loads import CIRCUITS, MagnetCircuit, attraction, circuit, magnets, tooth_field


def ratio(r: DesignInputs) -> Quantities:
    pitch, width, gap, depth = (r(f"teeth.{name}") for name in ("pitch", "width", "gap", "groove_depth"))
    widths = {"of_teeth": width, "by_rule": 0.4 * pitch, "of_thin_teeth": 0.2 * pitch}
    return {f"ratio.{name}": (teeth_field(pitch, w, gap, depth).lateral_over_normal, "") for name, w in widths.items()}


def lateral(r: DesignInputs) -> Quantities:
    pitch, gap, depth = r("teeth.pitch"), r("teeth.gap"), r("teeth.groove_depth")
    widths = np.arange(0.10, 0.81, 0.05)
    fields = [teeth_field(pitch, w * pitch, gap, depth, functions=8).lateral_stiffness for w in widths]
    best = int(np.argmax(fields))
    return {
        "stiffness.lateral": (tooth_field(r).lateral_stiffness, "N/m"),
        "stiffness.best_lateral": (fields[best], "N/m"),
        "width.best": (widths[best] * pitch, "m"),
    }


def attraction_beyond_preload(r: DesignInputs) -> Quantities:
    pull, wanted = attraction(r), r("preload.force")
    gap = gap_for(circuit(r), 1.2 * wanted) if r.advise and wanted > 0 and pull > 1.5 * wanted else None
    return {"gap.of_preload": (gap or 0.0, "m"), "share.of_leakage": (magnets(r).leakage, "")}


def gap_for(one: MagnetCircuit, pull: float) -> float | None:
    """Gap at which the magnets pull as much as `pull`, m; none up to five pitches."""

    def excess(logarithm: float) -> float:
        return CIRCUITS * one.forces(0.4, gap=math.exp(logarithm)).attraction / pull - 1

    low, high = math.log(one.section.gap), math.log(5 * one.section.pitch)
    if excess(low) < 0 or excess(high) > 0:
        return None
    # To 1 % of the gap, which suffices for a proposal.
    return math.exp(float(root_scalar(excess, bracket=(low, high), xtol=1e-2).root))
