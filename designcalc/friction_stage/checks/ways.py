"""Bearing ways on their bolts: stiffness, spacing, and what one nanometre of smoothness allows."""

from dataclasses import replace

from designcalc.bearing.bolted_rail import best_spacing_ratio, joint_stiffness, total_stiffness
from designcalc.bearing.fastener import cone_compliance, screw_waves
from designcalc.checks.check import Check, CheckFunction, DesignInputs
from designcalc.friction_stage.physics.loads import moved_mass
from designcalc.friction_stage.physics.pads import rail
from designcalc.friction_stage.physics.stage_plate import at_feet
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_APPENDIX = "thesis, appendix B; Slocum, Precision Machine Design (1992), section 7.5"


def checks(design: Design) -> list[CheckFunction]:
    """Every check of the bolted ways."""
    return [
        spacing,
        stiffness,
        force_ripple,
        engagement,
        stripping,
        screw_stress,
        edge_margin,
        head,
        heat_of_joint,
        bolt_dimple,
        warp,
    ]


_JOINT = "(bearing_way.bolt_edge/bearing_way.width)^2*(1 + bearing_way.joint_ratio)*stiffness.way_joint"
_STIFFNESS = (
    "bearing_way.length/bearing_way.bolt_spacing"
    f"/(give.of_way_edge/(bearing_way.bolt_spacing - screws.way.diameter) + 1/({_JOINT}))"
)


def spacing(r: DesignInputs) -> Check:
    way = rail(r)
    tau = r("bearing_way.flange_thickness") / way.bolt_diameter
    best = best_spacing_ratio(way, tau)
    given = {"spacing.best": (best, ""), "stiffness.at_best": (float(total_stiffness(way, best, tau)), "N/m")}
    return stated(
        "bolt spacing against its optimum",
        f"{_STIFFNESS}/stiffness.at_best >= 0.95",
        given=given,
        source=_APPENDIX,
        proposal="bolt spacing of {spacing.best*screws.way.diameter}",
        note="optimum at {spacing.best} bolt diameters; the curve is flat about it",
    )(r)


def _steel_stiffness(r: DesignInputs) -> float:
    """Stiffness of the way with way, base and screws of steel, N/m."""
    way, steel = rail(r), r("materials.steel.youngs_modulus")
    sheet = replace(way, rail_modulus=steel, bed_modulus=steel, bolt_modulus=steel, poisson=0.3)
    M, tau = (r(f"bearing_way.{key}") / way.bolt_diameter for key in ("bolt_spacing", "flange_thickness"))
    return float(total_stiffness(sheet, M, tau))


stiffness = stated(
    "bearing way stiffness",
    f"{_STIFFNESS} >= bearing_way.wanted_stiffness",
    given={"stiffness.of_steel": (_steel_stiffness, "N/m")},
    source=_APPENDIX,
    proposal="a stiffer bed, or a thicker way",
    thesis="the sheet takes steel throughout: {stiffness.of_steel}; way, base and screws as specified give "
    "{check.value}",
    note="one-sided cantilever: a lower bound for a way bedded over its width",
)


_RIPPLE = "load.moved_mass*requirements.acceleration_low/drive.friction"


def force_ripple(r: DesignInputs) -> Check:
    feet = at_feet(r, moved_mass(r) * r("requirements.acceleration_low") / r("drive.friction"))
    return stated(
        "smoothness against the tip's own pulsation",
        f"{_RIPPLE} <= requirements.smoothness/(1/(2*{_STIFFNESS}) + motion.of_feet/({_RIPPLE}))",
        given={
            "motion.of_feet": (float((feet.static + feet.vibration).max()), "m"),
            "motion.static": (float(feet.static.max()), "m"),
            "motion.shaken": (float(feet.vibration.max()), "m"),
        },
        source="elastic deflection of ways, pads and stage at the payload by what the tip takes off them each cycle, "
        "and their vibration by its pulses, by the modes of the plate on its pads",
        proposal="press with at most {check.limit} while measuring (hold on the static tip), or take smoothness with "
        "the drive at rest",
        thesis="1 nm smoothness with a tip that pulses with the weight: one way's 150-190 N/um allow 0.15-0.19 N",
        requirement="Table 1: smoothness",
        note="feet moved by {motion.static} and shaken by {motion.shaken}",
    )(r)


engagement = stated(
    "thread engagement of the way's screws",
    "(screws.way.length - bearing_way.flange_thickness)/screws.way.diameter >= 1",
    source="rule of one diameter in steel-like beds",
    proposal="flange of at most {screws.way.length - screws.way.diameter}",
)


stripping = stated(
    "stripping of the way's threads",
    "force.way_screw <= 0.577*min(base.material.strength*area.bed_thread, screws.way.proof_stress*area.screw_thread)/2",
    source="ASME B1.1 shear areas of the least screw in the largest thread, at 0.577 of the yield; factor 2",
    proposal="torque of at most {check.limit/check.value*screws.way.torque}",
)


screw_stress = stated(
    "preload stress of the way's screws",
    "force.way_screw/area.way_screw <= screws.way.proof_stress/2",
    source="ASME B1.1 stress area; thesis 2.3.2: torque not exceedingly high, so half of yield",
    proposal="less torque",
)


edge_margin = stated(
    "ceramic remaining beside the way's bolt holes",
    "bearing_way.bolt_edge - bearing_way.bolt_hole/2 >= bearing_way.bolt_hole/4",
    source="practice for ceramics: a quarter of the hole at least, compressed by the head",
    proposal="bolt line at {0.75*bearing_way.bolt_hole} or more from the edge",
    thesis="a = 10 mm leaves no room for a counterbore in the SiC: the heads sit on an outer ledge",
)


head = stated(
    "pressure under the screw heads on the way",
    "force.way_screw/(pi/4*(screws.way.head_diameter^2 - bearing_way.bolt_hole^2)) <= bearing_way.material.strength/2",
    source="mean pressure; half the bending strength, far below the compressive strength of the ceramic",
    proposal="a washer, or less torque",
)


heat_of_joint = stated(
    "way's bolt preload in store and transport",
    "environment.storage_change*abs(screws.way.material.expansion - bearing_way.material.expansion)"
    "*bearing_way.flange_thickness/(1/stiffness.way_joint + 1/(bearing_way.joint_ratio*stiffness.way_joint))"
    " <= force.way_screw/5",
    source="springs of bolt and clamped parts in series",
    proposal="longer bolts (more compliance)",
)


def _give_under_head(r: DesignInputs) -> float:
    head, hole = r("screws.way.head_diameter"), r("bearing_way.bolt_hole")
    flange, edge = r("bearing_way.flange_thickness"), 2 * r("bearing_way.bolt_edge")
    return float(cone_compliance(head, hole, flange, edge, rail(r).rail_modulus))


def _sheet_give(r: DesignInputs) -> float:
    way = rail(r)
    tau = r("bearing_way.flange_thickness") / way.bolt_diameter
    return 1 / (float(joint_stiffness(way, tau).flange_compression) * way.bolt_diameter)


bolt_dimple = stated(
    "dimple of the way under its screws",
    "force.way_screw*give.under_head <= bearing.way_straightness",
    given={"give.under_head": (_give_under_head, "m/N"), "give.of_sheet": (_sheet_give, "m/N")},
    source="compression of the flange under the head with its hole, VDI 2230-1, section 5.1.2; less on the lapped face "
    "next to the ledge",
    proposal="torque of at most {check.limit/check.value*screws.way.torque}, and lap the way bolted down",
    thesis="the sheet's cone of 45 degrees, with a hole as wide as the screw: {force.way_screw*give.of_sheet}",
    requirement="Table 1: smoothness",
    note="the same torque on every screw keeps the warp even",
)


def _waves(r: DesignInputs) -> float:
    """Waves of the way's pitch of screws in the running face under the pads by a unit force, m/N."""
    line, way = r("base.way_gap") / 2 + r("bearing_way.width") - r("bearing_way.bolt_edge"), rail(r)
    away = line - r("pads.spacing_across") / 2
    return float(screw_waves(1.0, r("bearing_way.bolt_spacing"), away, way.rail_modulus, way.poisson))


warp = stated(
    "waves of the way's screws under the pads",
    "force.way_screw*waves.of_screws <= requirements.smoothness",
    given={"waves.of_screws": (_waves, "m/N")},
    source="row of forces on a half-space: an upper bound, for the bed beneath takes the same forces "
    "(Boussinesq; Johnson (1985), section 3.2)",
    proposal="torque of {screws.way.torque*check.limit/check.value}, a closer pitch (waves decay sooner), or lap the "
    "way bolted down",
    thesis="a uniform stiffness along the way is required; this is the variation by the screws",
    requirement="Table 1: smoothness",
)
