"""Bearing ways on their bolts: stiffness, spacing, and what one nanometre of smoothness allows."""

from dataclasses import replace

from designcalc.bearing.bolted_rail import best_spacing_ratio, joint_stiffness, total_stiffness
from designcalc.bearing.fastener import (
    Thread,
    cone_compliance,
    screw_waves,
)
from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, show
from designcalc.errors.thermal import preload_change
from designcalc.friction_stage.physics.clamp import screw_preload
from designcalc.friction_stage.physics.loads import moved_mass
from designcalc.friction_stage.physics.pads import rail
from designcalc.friction_stage.physics.plate_vibration import at_feet
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


def _ratios(r: DesignInputs) -> tuple[float, float]:
    diameter = r("screws.way.diameter")
    return r("bearing_way.bolt_spacing") / diameter, r("bearing_way.flange_thickness") / diameter


def spacing(r: DesignInputs) -> Check:
    way = rail(r)
    M, tau = _ratios(r)
    best = best_spacing_ratio(way, tau)
    reached = float(total_stiffness(way, M, tau)) / float(total_stiffness(way, best, tau))
    return Check(
        "bolt spacing against its optimum",
        at_least(reached, 0.95, ""),
        source=_APPENDIX,
        formula="K(M)/K(M_best), K = N/[1/K_bs + 1/(J (K_joint + K_bolt))], M = spacing/Db",
        substituted=f"M = {M:.3g}, best {best:.3g} with the real materials",
        proposal=f"bolt spacing of {show(best * way.bolt_diameter, 'm')}",
        note=f"optimum at M = {best:.3g}; the curve is flat about it",
    )


def stiffness(r: DesignInputs) -> Check:
    way = rail(r)
    M, tau = _ratios(r)
    K = float(total_stiffness(way, M, tau))
    steel = r("materials.steel.youngs_modulus")
    sheet = replace(way, rail_modulus=steel, bed_modulus=steel, bolt_modulus=steel, poisson=0.3)
    printed = float(total_stiffness(sheet, M, tau))
    return Check(
        "bearing way stiffness",
        at_least(K, r("bearing_way.wanted_stiffness"), "N/m"),
        source=_APPENDIX,
        formula="K = N/[1/K_bs + 1/(J (K_joint + K_bolt))], N = L/(M Db)",
        substituted=f"M = {M:.3g}, t/Db = {tau:.3g}: {show(K, 'N/m')}; bolt joint "
        f"{show(float(joint_stiffness(way, tau).joint_per_diameter) * way.bolt_diameter, 'N/m')}",
        proposal="a stiffer bed, or a thicker way",
        thesis=f"the sheet takes steel throughout: {show(printed, 'N/m')}; way, base and screws as specified "
        f"give {show(K, 'N/m')}",
        note="one-sided cantilever: a lower bound for a way bedded over its width",
    )


def force_ripple(r: DesignInputs) -> Check:
    way = rail(r)
    M, tau = _ratios(r)
    smooth = r("requirements.smoothness")
    ripple = moved_mass(r) * r("requirements.acceleration_low") / r("drive.friction")
    feet = at_feet(r, ripple)
    moved = float((feet.static + feet.vibration).max())
    K = 1 / (1 / (2 * float(total_stiffness(way, M, tau))) + moved / ripple)
    return Check(
        "smoothness against the tip's own pulsation",
        at_most(ripple, K * smooth, "N"),
        source="elastic deflection of ways, pads and stage at the payload by what the tip takes off them each cycle, "
        "and their vibration by its pulses, by the modes of the plate on its pads",
        formula="m a/mu <= K x 1 nm, 1/K = 1/K_ways + (static deflection + vibration)/(m a/mu)",
        substituted=f"0.2 G needs the tip to press with m a/mu = {show(ripple, 'N')} each cycle; feet moved by "
        f"{show(float(feet.static.max()), 'm')} and shaken by {show(float(feet.vibration.max()), 'm')}; "
        f"{show(K, 'N/m')} x {show(smooth, 'm')} = {show(K * smooth, 'N')}",
        proposal=f"press with at most {show(K * smooth, 'N')} while measuring (hold on the static tip), or take "
        "smoothness with the drive at rest",
        thesis="1 nm smoothness with a tip that pulses with the weight: one way's 150-190 N/um allow 0.15-0.19 N",
        requirement="Table 1: smoothness",
    )


engagement = stated(
    "thread engagement of the way's screws",
    "(screws.way.length - bearing_way.flange_thickness)/screws.way.diameter >= 1",
    source="rule of one diameter in steel-like beds",
    proposal="flange of at most {screws.way.length - screws.way.diameter}",
)


def _thread(r: DesignInputs) -> Thread:
    return Thread(r("screws.way.diameter"), r("screws.way.pitch"))


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


def heat_of_joint(r: DesignInputs) -> Check:
    way = rail(r)
    _, tau = _ratios(r)
    flange = r("bearing_way.flange_thickness")
    joint = float(joint_stiffness(way, tau).joint_per_diameter) * way.bolt_diameter
    change = abs(
        preload_change(
            flange,
            r.material("screws.way", "expansion"),
            r.material("bearing_way", "expansion"),
            joint,
            way.joint_ratio * joint,
        )
    )
    force, span = screw_preload(r, "way"), r("environment.storage_change")
    return Check(
        "way's bolt preload in store and transport",
        at_most(span * change, 0.2 * force, "N"),
        source="springs of bolt and clamped parts in series",
        formula="(alpha_bolt - alpha_way) t dT/(1/k_b + 1/k_j) <= F/5",
        substituted=f"{span:.3g} K: {show(span * change, 'N')} of {show(force, 'N')}",
        proposal="longer bolts (more compliance)",
    )


def bolt_dimple(r: DesignInputs) -> Check:
    way, force = rail(r), screw_preload(r, "way")
    _, tau = _ratios(r)
    head, hole = r("screws.way.head_diameter"), r("bearing_way.bolt_hole")
    flange, edge = r("bearing_way.flange_thickness"), 2 * r("bearing_way.bolt_edge")
    dimple = force * float(cone_compliance(head, hole, flange, edge, way.rail_modulus))
    sheet = force / (float(joint_stiffness(way, tau).flange_compression) * way.bolt_diameter)
    limit = r("bearing.way_straightness")
    return Check(
        "dimple of the way under its screws",
        at_most(dimple, limit, "m"),
        source="compression of the flange under the head with its hole, VDI 2230-1, section 5.1.2",
        formula="F ln[(D+d)(D+2 t tan(phi)-d)/((D-d)(D+2 t tan(phi)+d))]/(E pi d tan(phi)) <= straightness",
        substituted=f"{show(force, 'N')}: {show(dimple, 'm')} at the ledge, less on the lapped face next to it",
        proposal=f"torque of at most {show(limit / dimple * r('screws.way.torque'), 'N*m')}, and lap the way bolted "
        "down",
        thesis=f"the sheet's cone of 45 degrees, with a hole as wide as the screw: {show(sheet, 'm')}",
        requirement="Table 1: smoothness",
        note="the same torque on every screw keeps the warp even",
    )


def warp(r: DesignInputs) -> Check:
    """The row of screws causes waves of its pitch in the running face under the pads."""
    way, force = rail(r), screw_preload(r, "way")
    pitch = r("bearing_way.bolt_spacing")
    line = r("base.way_gap") / 2 + r("bearing_way.width") - r("bearing_way.bolt_edge")
    away = line - r("pads.spacing_across") / 2
    wave = float(screw_waves(force, pitch, away, way.rail_modulus, way.poisson))
    limit = r("requirements.smoothness")
    return Check(
        "waves of the way's screws under the pads",
        at_most(wave, limit, "m"),
        source="row of forces on a half-space: an upper bound, for the bed beneath takes the same forces (Boussinesq; "
        "Johnson (1985), section 3.2)",
        formula="4 F (1 - nu^2)/(pi E p) K0(2 pi d/p) <= 1 nm",
        substituted=f"F = {show(force, 'N')}, p = {show(pitch, 'm')}, d = {show(away, 'm')}: {show(wave, 'm')}",
        proposal=f"torque of {show(r('screws.way.torque') * limit / wave, 'N*m')}, a closer pitch (waves decay "
        "sooner), or lap the way bolted down",
        thesis="a uniform stiffness along the way is required; this is the variation by the screws",
        requirement="Table 1: smoothness",
    )
