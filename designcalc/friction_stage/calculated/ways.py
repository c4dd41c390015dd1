"""Bearing ways on their bolts: best spacing, ways of steel, motion of the feet, give under the heads, waves."""

from dataclasses import replace

from designcalc.bearing.bolted_rail import best_spacing_ratio, joint_stiffness, total_stiffness
from designcalc.bearing.fastener import cone_compliance, screw_waves
from designcalc.checks.check import DesignInputs, Quantities
from designcalc.friction_stage.physics import loads, pads, stage_plate


def spacing(r: DesignInputs) -> Quantities:
    way = pads.rail(r)
    tau = r("bearing_way.flange_thickness") / way.bolt_diameter
    best = best_spacing_ratio(way, tau)
    return {"spacing.best": (best, ""), "stiffness.at_best": (float(total_stiffness(way, best, tau)), "N/m")}


def _steel_stiffness(r: DesignInputs) -> float:
    """Stiffness of the way with way, base and screws of steel, N/m."""
    way, steel = pads.rail(r), r("materials.steel.youngs_modulus")
    sheet = replace(way, rail_modulus=steel, bed_modulus=steel, bolt_modulus=steel, poisson=0.3)
    M, tau = (r(f"bearing_way.{key}") / way.bolt_diameter for key in ("bolt_spacing", "flange_thickness"))
    return float(total_stiffness(sheet, M, tau))


def force_ripple(r: DesignInputs) -> Quantities:
    feet = stage_plate.at_feet(r, loads.moved_mass(r) * r("requirements.acceleration_low") / r("drive.friction"))
    return {
        "motion.of_feet": (float((feet.static + feet.vibration).max()), "m"),
        "motion.static": (float(feet.static.max()), "m"),
        "motion.shaken": (float(feet.vibration.max()), "m"),
    }


def _give_under_head(r: DesignInputs) -> float:
    head, hole = r("screws.way.head_diameter"), r("bearing_way.bolt_hole")
    flange, edge = r("bearing_way.flange_thickness"), 2 * r("bearing_way.bolt_edge")
    return float(cone_compliance(head, hole, flange, edge, pads.rail(r).rail_modulus))


def _sheet_give(r: DesignInputs) -> float:
    way = pads.rail(r)
    tau = r("bearing_way.flange_thickness") / way.bolt_diameter
    return 1 / (float(joint_stiffness(way, tau).flange_compression) * way.bolt_diameter)


def _waves(r: DesignInputs) -> float:
    """Waves of the way's pitch of screws in the running face under the pads by a unit force, m/N."""
    line, way = r("base.way_gap") / 2 + r("bearing_way.width") - r("bearing_way.bolt_edge"), pads.rail(r)
    away = line - r("pads.spacing_across") / 2
    return float(screw_waves(1.0, r("bearing_way.bolt_spacing"), away, way.rail_modulus, way.poisson))


QUANTITIES: Quantities = {
    "stiffness.of_steel": (_steel_stiffness, "N/m"),
    "give.under_head": (_give_under_head, "m/N"),
    "give.of_sheet": (_sheet_give, "m/N"),
    "waves.of_screws": (_waves, "m/N"),
}
