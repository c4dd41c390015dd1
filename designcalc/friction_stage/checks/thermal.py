"""Drift by heat, way on base, magnetism, the floor's shake."""

from collections.abc import Callable

from designcalc.checks.check import CheckFunction, DesignInputs, FormulaCheck
from designcalc.drive.friction_drive import resonance
from designcalc.errors.thermal import bow_of_layers, floor_motion
from designcalc.friction_stage.physics.loads import moved_mass
from designcalc.friction_stage.physics.pads import pads_stiffness, rail
from designcalc.friction_stage.physics.tip_dynamics import holding_stiffness
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_THERMAL = "Table 2: low thermal expansion"
_CHANGE = "environment.temperature_change"


def checks(design: Design) -> list[CheckFunction]:
    """Drift of the tip, the way on the base, magnetism, vibration; each also for the base's other material."""
    other = ("invar_36", "Invar 36") if design.value("base.material") == "sus416" else ("sus416", "SUS416")
    return [
        tip_drift(*other),
        way_growth(*other),
        base_expansion,
        *([magnetism(other[1])] if design.teeth.fitted else []),
        bow(*other),
        symmetry,
        vibration_along,
        vibration_normal,
    ]


def tip_drift(key: str, other: str) -> FormulaCheck:
    """Gap between tip and stage: way and pads lift the stage; piezos and tip, in their clamped holder, fill it.

    The clamps take the height pins out of the loop; base and holder together span from the way's foot down to the
    piezos' feet. `key`: of the base's other material.
    """

    def drift(base: str) -> str:
        return (
            "abs(bearing_way.height*bearing_way.material.expansion + pads.height*stage.material.expansion"
            " - actuator.tip_height*tip.material.expansion - piezo.length*piezo.material.expansion"
            f" + (piezo.length + actuator.tip_height - bearing_way.height - pads.height)*{base}.expansion)"
        )

    return stated(
        "drift of the tip against the stage",
        f"{drift('base.material')}*{_CHANGE} <= 0.1*ellipse.rise",
        source="growth of the loop way - pad - stage - tip - piezo - holder - base",
        proposal="a tip and pads of equal thermal growth, or a bias of the piezos that follows the temperature",
        requirement=_THERMAL,
        note=f"{{check.value/{_CHANGE}}}; with a base and holder of {other}: {{{drift(f'materials.{key}')}}}",
    )


def way_growth(key: str, other: str) -> FormulaCheck:
    def growth(base: str) -> str:
        return f"abs(bearing_way.material.expansion - {base}.expansion)*bearing_way.length*{_CHANGE}"

    return stated(
        "slip between way and base",
        f"{growth('base.material')} <= 1 um",
        source="difference of free growth; 1 um, the finish of the joint, is taken up without a ratchet",
        proposal=f"hold the temperature to {{{_CHANGE}*check.limit/check.value}}, or pin the way at its middle and let "
        "it slide",
        requirement=_THERMAL,
        note=f"on a base of {other}: {{{growth(f'materials.{key}')}}}",
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


def _attracted(r: DesignInputs) -> float:
    name = str(r.design.value("base.material"))
    magnetic = r.design.materials[name].magnetic
    return r.given(f"{name} attracted by a magnet", float(magnetic), "", "materials table: 1 is yes")


def magnetism(other: str) -> FormulaCheck:
    """Invar 36 (up to some 230 degC) and SUS416 are both ferromagnetic: flux must not find a way through the base."""
    return stated(
        "flux of the teeth leaking into the base",
        "base.attracted*teeth.gap/(tooth_bar.height - teeth.groove_depth) <= 1/4",
        given={"base.attracted": (_attracted, "")},
        source="the iron below the teeth carries the flux in a section thick compared with the gap, where the base is "
        "ferromagnetic",
        proposal="higher bars, or a non-magnetic liner under them",
        note=f"{other} is ferromagnetic too: both materials of the base are attracted by the magnets",
    )


def bow(key: str, other: str) -> FormulaCheck:
    """Way and base as one bimetal: for a joint that never slips. With screws it slips, and the bow is smaller."""

    def sagitta(r: DesignInputs, base: str | None = None) -> float:
        way, bed = rail(r), f"materials.{base or r.design.value('base.material')}"
        below = r("base.height"), r(f"{bed}.youngs_modulus"), r(f"{bed}.expansion")
        ceramic = r.material("bearing_way", "expansion")
        return float(bow_of_layers(way.length, way.height, way.rail_modulus, ceramic, *below))

    return stated(
        "bow of the way on its base by heat",
        f"bow.of_way*{_CHANGE} <= requirements.straightness",
        given={"bow.of_way": (sagitta, "m/K"), "bow.on_other_base": (lambda r: sagitta(r, key), "m/K")},
        source="Timoshenko (1925), two layers that cannot slip: an upper bound; sagitta = curvature L^2/8",
        proposal=f"hold the temperature to {{{_CHANGE}*check.limit/check.value}}, or a base of silicon carbide or "
        "alumina",
        requirement=_THERMAL,
        note=f"on a base of {other}: {{bow.on_other_base*{_CHANGE}}}",
    )


def _off_middle(r: DesignInputs) -> float:
    off = max(abs(y) for _, y in r.design.derived.fitted_places[:1]) * 1e-3
    return r.given("actuator 1 from the middle plane", off, "m", "layout of the pockets")


# Teeth and ways locate the stage in the middle plane of the base; a tip off that plane drifts from it.
symmetry = stated(
    "sideways drift by asymmetry of the base",
    f"actuator.off_middle*base.material.expansion*{_CHANGE} <= requirements.resolution_coarse",
    given={"actuator.off_middle": (_off_middle, "m")},
    source="growth of the base from its middle plane to the tip",
    proposal="the actuator on the base's middle plane",
    thesis="'designed as asymmetrically as possible for thermal stability' must be symmetrically: with the actuator "
    f"next to a way, {{base.way_gap/2}} off, the tip would wander {{base.way_gap/2*base.material.expansion*{_CHANGE}}}",
    requirement=_THERMAL,
)


def _followed(stiffness: Callable[[DesignInputs], float], damping: str) -> Callable[[DesignInputs], float]:
    """Motion of the stage against the tip over the floor's velocity, s."""
    return lambda r: float(floor_motion(1.0, float(resonance(stiffness(r), moved_mass(r))), r(damping)))


_FLOOR = "base shaken in all third octaves of 8 to 80 Hz, stage and payload held by "
vibration_along = stated(
    "floor vibration between tip and stage, along",
    "environment.floor_velocity*follow.along <= requirements.resolution_coarse",
    given={"follow.along": (_followed(holding_stiffness, "piezo.damping_ratio"), "s")},
    source=_FLOOR + "sway of the stacks, rocking of the tip and shear of its contact",
    proposal="an isolation table, or stacks guided in their bores without play",
    requirement="Table 1: resolution",
    note="held by {stiffness.along}; the finest required resolution, {requirements.resolution}, needs a floor "
    "{max(check.value/requirements.resolution, 1)} times quieter",
)
vibration_normal = stated(
    "floor vibration between tip and stage, normal",
    "environment.floor_velocity*follow.normal <= requirements.smoothness",
    given={"follow.normal": (_followed(lambda r: pads_stiffness(r).normal, "bearing.damping_ratio"), "s")},
    source=_FLOOR + "the pads",
    proposal="an isolation table, or stiffer pads",
    requirement="Table 1: smoothness",
    note="held by {stiffness.pads}",
)
