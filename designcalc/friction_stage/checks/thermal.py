"""Drift by heat, way on base, magnetism, the floor's shake."""

from functools import partial

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_most, ratio, show
from designcalc.drive.friction_drive import resonance
from designcalc.errors.thermal import bow_of_layers, differential_growth, floor_motion, loop_drift
from designcalc.friction_stage.physics.loads import moved_mass
from designcalc.friction_stage.physics.pads import pads_stiffness, rail
from designcalc.friction_stage.physics.tip_dynamics import holding_stiffness, usable_ellipse
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design


def checks(design: Design) -> list[CheckFunction]:
    """Drift of the tip, the way on the base, magnetism, vibration; each also for the base's other material."""
    return [
        tip_drift,
        way_growth,
        base_expansion,
        *([magnetism] if design.teeth.fitted else []),
        bow,
        symmetry,
        partial(vibration, direction="along"),
        partial(vibration, direction="normal"),
    ]


def _alternative_base(r: DesignInputs) -> tuple[str, str]:
    """Key and name of the other material of Invar 36 and SUS416, of which the base is not made."""
    return ("invar_36", "Invar 36") if r.design.value("base.material") == "sus416" else ("sus416", "SUS416")


def tip_drift(r: DesignInputs) -> Check:
    """Gap between tip and stage: way and pads lift the stage; piezos and tip, in their clamped holder, fill it.

    The clamps take the height pins out of the loop; base and holder together span from the way's foot down to the
    piezos' feet.
    """
    piezo_plane = r("bearing_way.height") + r("pads.height") - r("actuator.tip_height")
    members = [
        (r("bearing_way.height"), r.material("bearing_way", "expansion")),
        (r("pads.height"), r.material("stage", "expansion")),
        (-r("actuator.tip_height"), r.material("tip", "expansion")),
        (-r("piezo.length"), r.material("piezo", "expansion")),
    ]
    below = r("piezo.length") - piezo_plane
    key, other = _alternative_base(r)

    def drift(expansion: float) -> float:
        return abs(float(loop_drift([m[0] for m in members] + [below], [m[1] for m in members] + [expansion])))

    here, other_base = drift(r.material("base", "expansion")), drift(r(f"materials.{key}.expansion"))
    rise = usable_ellipse(r)[1]
    change = r("environment.temperature_change")
    return Check(
        "drift of the tip against the stage",
        at_most(here * change, 0.1 * rise, "m"),
        source="growth of the loop way - pad - stage - tip - piezo - holder - base",
        formula="|sum(alpha_i L_i)| dT <= Y/10",
        substituted=f"{show(here, 'm')} per kelvin x {change:.3g} K; rise of the ellipse {show(rise, 'm')}",
        proposal="a tip and pads of equal thermal growth, or a bias of the piezos that follows the temperature",
        requirement="Table 2: low thermal expansion",
        note=f"with a base and holder of {other}: {show(other_base, 'm')} per kelvin",
    )


def way_growth(r: DesignInputs) -> Check:
    length, change = r("bearing_way.length"), r("environment.temperature_change")
    ceramic = r.material("bearing_way", "expansion")
    key, other = _alternative_base(r)
    growth = float(differential_growth(length, ceramic, r.material("base", "expansion"))) * change
    other_base = float(differential_growth(length, ceramic, r(f"materials.{key}.expansion"))) * change
    return Check(
        "slip between way and base",
        at_most(growth, 1e-6, "m"),
        source="difference of free growth; 1 um, the finish of the joint, is taken up without a ratchet",
        formula="|alpha_way - alpha_base| L dT <= 1 um",
        substituted=f"{show(growth, 'm')} over {show(length, 'm')} and {change:.3g} K",
        proposal=f"hold the temperature to {ratio(change * 1e-6, growth):.2g} K, or pin the way at its middle and let "
        "it slide",
        requirement="Table 2: low thermal expansion",
        note=f"on a base of {other}: {show(other_base, 'm')}",
    )


base_expansion = stated(
    "expansion of the base's material",
    "base.material.expansion <= requirements.repeatability/(stage.travel/2*environment.temperature_change)",
    ("environment.temperature_change", "requirements.repeatability/(stage.travel/2*base.material.expansion)", False),
    source="growth of the base from its middle to the end of the travel within the repeatability",
    proposal="Invar 36 where it is not, and a temperature held closer",
    thesis="'INVAR SUS416': SUS416 is a martensitic stainless steel of {materials.sus416.expansion}, "
    "{materials.sus416.expansion/materials.invar_36.expansion} times Invar's",
    requirement="Table 2: low thermal expansion",
)


def magnetism(r: DesignInputs) -> Check:
    """Invar 36 (up to some 230 degC) and SUS416 are both ferromagnetic: flux must not find a way through the base."""
    name = str(r.design.value("base.material"))
    attracted = r.given(
        f"{name} attracted by a magnet", float(r.design.materials[name].magnetic), "", "materials table: 1 is yes"
    )
    gap, clear = r("teeth.gap"), r("tooth_bar.height") - r("teeth.groove_depth")
    _, other = _alternative_base(r)
    return Check(
        "flux of the teeth leaking into the base",
        at_most(attracted * gap / clear, 0.25, ""),
        source="the iron below the teeth carries the flux in a section thick compared with the gap",
        formula="gap/(bar height - groove) <= 1/4 where the base is ferromagnetic",
        substituted=f"{show(gap, 'm')}/{show(clear, 'm')}",
        proposal="higher bars, or a non-magnetic liner under them",
        note=f"{other} is ferromagnetic too: both materials of the base are attracted by the magnets",
    )


def bow(r: DesignInputs) -> Check:
    """Way and base as one bimetal: for a joint that never slips. With screws it slips, and the bow is smaller."""
    way, change = rail(r), r("environment.temperature_change")
    key, other = _alternative_base(r)

    def sagitta(modulus: float, expansion: float) -> float:
        ceramic, below = r.material("bearing_way", "expansion"), r("base.height")
        bow = bow_of_layers(way.length, way.height, way.rail_modulus, ceramic, below, modulus, expansion)
        return change * float(bow)

    here = sagitta(way.bed_modulus, r.material("base", "expansion"))
    other_base = sagitta(r(f"materials.{key}.youngs_modulus"), r(f"materials.{key}.expansion"))
    limit = r("requirements.straightness")
    return Check(
        "bow of the way on its base by heat",
        at_most(here, limit, "m"),
        source="Timoshenko (1925), two layers that cannot slip: an upper bound",
        formula="sagitta = curvature L^2/8 <= straightness",
        substituted=f"{show(here, 'm')} over {show(way.length, 'm')} and {change:.3g} K",
        proposal=f"hold the temperature to {ratio(change * limit, here):.2g} K, or a base of silicon carbide or "
        "alumina",
        requirement="Table 2: low thermal expansion",
        note=f"on a base of {other}: {show(other_base, 'm')}",
    )


def symmetry(r: DesignInputs) -> Check:
    """Teeth and ways locate the stage in the middle plane of the base; a tip off that plane drifts from it."""
    off = max(abs(y) for _, y in r.design.derived.fitted_places[:1]) * 1e-3
    off = r.given("actuator 1 from the middle plane", off, "m", "layout of the pockets")
    change, alpha = r("environment.temperature_change"), r.material("base", "expansion")
    half = r("base.way_gap") / 2
    return Check(
        "sideways drift by asymmetry of the base",
        at_most(off * alpha * change, r("requirements.resolution_coarse"), "m"),
        source="growth of the base from its middle plane to the tip",
        formula="alpha_base y dT <= 10 nm",
        substituted=f"y = {show(off, 'm')}: {show(off * alpha * change, 'm')}",
        proposal="the actuator on the base's middle plane",
        thesis="'designed as asymmetrically as possible for thermal stability' must be symmetrically: with the "
        f"actuator next to a way, {show(half, 'm')} off, the tip would wander {show(half * alpha * change, 'm')}",
        requirement="Table 2: low thermal expansion",
    )


def vibration(r: DesignInputs, direction: str) -> Check:
    """Relative motion of tip and stage by floor vibration."""
    velocity = r("environment.floor_velocity")
    if direction == "along":
        stiffness, holder = holding_stiffness(r), "sway of the stacks, rocking of the tip and shear of its contact"
        damping = r("piezo.damping_ratio")
        limit, requirement = r("requirements.resolution_coarse"), "Table 1: resolution"
    else:
        stiffness, holder = pads_stiffness(r).normal, "the pads"
        damping = r("bearing.damping_ratio")
        limit, requirement = r("requirements.smoothness"), "Table 1: smoothness"
    first = float(resonance(stiffness, moved_mass(r)))
    motion = float(floor_motion(velocity, first, damping))
    return Check(
        f"floor vibration between tip and stage, {direction}",
        at_most(motion, limit, "m"),
        source=f"base shaken in all third octaves of 8 to 80 Hz, stage and payload held by {holder}",
        formula="x^2 = sum over third octaves of (v/(2 pi f))^2 |r^2/(1 - r^2 + 2 i zeta r)|^2, r = f/f_1",
        substituted=f"{show(velocity, 'm/s')} in each, K = {show(stiffness, 'N/m')}, f_1 = {show(first, 'Hz')}, zeta = "
        f"{damping:.3g}: {show(motion, 'm')} rms",
        proposal="an isolation table"
        + (", or stacks guided in their bores without play" if direction == "along" else ", or stiffer pads"),
        requirement=requirement,
        note=(
            f"the finest required resolution, {show(r('requirements.resolution'), 'm')}, needs a floor "
            f"{max(motion / r('requirements.resolution'), 1):.3g} times quieter"
            if direction == "along"
            else ""
        ),
    )
