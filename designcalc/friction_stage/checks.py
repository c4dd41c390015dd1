"""Checks of the friction stage by subject, with the requirements of the thesis that they trace back to."""

import math
import tomllib
from functools import partial
from pathlib import Path

import numpy as np

from designcalc.bearing.sliding import crown_wear_depth, crown_wear_distance
from designcalc.checks.check import DesignInputs
from designcalc.checks.run import Studies, Subjects
from designcalc.checks.stated import Calculated, stated_checks
from designcalc.friction_stage.calculated import (
    alternatives,
    budget,
    chains,
    drive,
    pads,
    plate,
    position_loop,
    teeth,
    thermal,
    ways,
)
from designcalc.friction_stage.physics.clamp import clamping_shift, screw_preload, wedge
from designcalc.friction_stage.physics.loads import MAGNETS, attraction
from designcalc.friction_stage.physics.pads import heaviest_pad
from designcalc.friction_stage.physics.position_loop import dynamic_budgets
from designcalc.friction_stage.physics.tip_dynamics import PIEZOS, usable_ellipse
from designcalc.friction_stage.quantities import QUANTITIES
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties


def assembly_values(r: DesignInputs) -> dict[str, float | None]:
    """Forces (N), lengths (m) and times (s) of the assembly procedure, by the names of its values.

    Screw preloads, pull of the magnets (None without teeth), lift by the set screw, shift by clamping, and running in
    of the pads at full speed with the number of strokes until half of the film is worn.
    """
    drive, shift = wedge(r), clamping_shift(r)
    distance = 2 * r("stage.travel") * r("bearing.run_in_cycles")
    crown, rate, load = r("pads.crown_radius"), r("bearing.run_in_wear_rate"), heaviest_pad(r)
    half_worn = float(crown_wear_distance(r("bearing.film_thickness") / 2, crown, rate, load))
    return {
        "way_preload": screw_preload(r, "way"),
        "bar_preload": screw_preload(r, "bar"),
        "clamp_force": screw_preload(r, "clamp_long"),
        "magnet_pull": attraction(r) if r.design.teeth.fitted else None,
        "lift_per_turn": float(drive.lift_per_turn),
        "lift_per_degree": float(drive.lift_per_degree),
        "adjustment": float(drive.range) / 2,
        "ellipse_height": usable_ellipse(r)[1],
        "clamp_squeeze": float(shift.squeeze),
        "clamp_drop": float(shift.drop),
        "clamp_sideways": float(shift.sideways),
        "run_in_distance": distance,
        "run_in_time": distance / r("requirements.speed"),
        "run_in_wear": float(crown_wear_depth(distance, crown, rate, load)),
        "film_strokes": half_worn / (2 * r("stage.travel")),
    }


MM3 = 1e-9


MASS_KEYS = ("stage.", "tip.", "teeth.", "tooth_iron.", "magnet.", "actuator.", "pads.", "bearing_way.")
"""Beginnings of the keys that `changed_masses` reads."""


def changed_masses(design: Design, base: Design, masses: BodyMasses) -> BodyMasses:
    """Masses of a design from those of the solids of another one, `base`."""
    moving, tip = masses.moving, masses.tip
    mass = moving.mass + (_moving(design) - _moving(base))
    scale = mass / moving.mass
    lift = (design.derived.drive_surface_height - base.derived.drive_surface_height) * 1e-3
    lift += 0.5e-3 * (design.stage.thickness - base.stage.thickness)
    x, y, z = moving.centre_of_mass
    # The mean squared radii of gyration of the plain plates.
    gyration, before = (d.stage.length**2 + d.stage.width**2 for d in (design, base))
    inertia = np.asarray(moving.inertia) * scale * (gyration / before)
    new = MassProperties(moving.volume * scale, mass, (x, y, z + lift), inertia, moving.bounding_box)
    ratio = _tip_volume(design) / _tip_volume(base) * _density(design, "tip") / _density(base, "tip")
    reach = (design.actuator.piezo_spacing / base.actuator.piezo_spacing) ** 2
    centre = (*tip.centre_of_mass[:2], tip.centre_of_mass[2] * design.actuator.tip_height / base.actuator.tip_height)
    turned = np.asarray(tip.inertia) * ratio * reach
    return BodyMasses(new, MassProperties(tip.volume * ratio, tip.mass * ratio, centre, turned, tip.bounding_box))


def _density(design: Design, part: str) -> float:
    return design.si(f"materials.{design.value(f'{part}.material')}.density")


def _moving(design: Design) -> float:
    """Mass of plain plate, irons and magnets, kg."""
    stage = design.stage
    found = stage.length * stage.width * stage.thickness * _density(design, "stage")
    if design.teeth.fitted:
        iron, magnet, teeth = design.tooth_iron, design.magnet, design.teeth
        grooves = teeth.per_iron * (teeth.pitch - teeth.width) * teeth.groove_depth
        section = design.derived.iron_width * iron.height - grooves
        found += 2 * design.derived.magnets * iron.length * section * _density(design, "tooth_iron")
        found += design.derived.magnets * magnet.length * magnet.thickness * magnet.height * _density(design, "magnet")
    return found * MM3


def _tip_volume(design: Design) -> float:
    """Volume of hub, arms, feet and cone of the tip less seats and relief, mm^3."""
    tip, height = design.tip, design.actuator.tip_height
    circle = design.derived.piezo_circle

    def disc(diameter: float) -> float:
        return math.pi / 4 * diameter**2

    arms = 3 * tip.arm_width * max(circle - (tip.hub_diameter + tip.foot_diameter) / 2, 0.0) * tip.arm_thickness
    plates = (disc(tip.hub_diameter) + 3 * disc(tip.foot_diameter)) * tip.arm_thickness
    tall = max(height - tip.arm_thickness + tip.seat_depth, 0.0)
    cone = math.pi / 12 * tall * (tip.cone_diameter**2 + tip.cone_diameter * tip.nose_diameter + tip.nose_diameter**2)
    whole = arms + plates + cone
    return whole - 3 * disc(tip.seat_diameter) * tip.seat_depth - disc(tip.relief_diameter) * tip.relief_depth


def _words(design: Design) -> dict[str, str]:
    """Words of the checks that follow from the design, or that its calculations share."""
    coating = f"materials.{design.value('tip.coating_material')}"
    shared = {"magnets": MAGNETS, "piezos": str(PIEZOS), "apart": str(plate.APART)}
    return {**shared, "coating": coating, **thermal.other_base(design)}


_STATED = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
_REQUIREMENTS: dict[str, str] = _STATED.pop("requirements")
_CHECKS = stated_checks(
    _STATED,
    Calculated(
        quantities={
            **QUANTITIES,
            **ways.QUANTITIES,
            **plate.QUANTITIES,
            **thermal.QUANTITIES,
            **alternatives.QUANTITIES,
            **position_loop.QUANTITIES,
        },
        words=_words,
        groups={**alternatives.OF_BALLS, **position_loop.OF_SENSORS},
        given={
            "bearing ways.spacing": ways.spacing,
            "bearing ways.force_ripple": ways.force_ripple,
            "magnetic teeth.ratio": teeth.ratio,
            "magnetic teeth.lateral": teeth.lateral,
            "magnetic teeth.attraction_beyond_preload": teeth.attraction_beyond_preload,
            "friction drive.tip_over": drive.tip_over,
            "sliding bearing.pressure": pads.pressure,
            "sliding bearing.pv": pads.pv,
            "stage plate.stiffness": plate.stiffness,
            "stage plate.drive_surface_sag": plate.drive_surface_sag,
            "smoothness.ridden": pads.ridden,
            "height adjustment.wedge_contact": chains.wedge_contact,
            "candidates.earnshaw": alternatives.earnshaw,
            **{f"tolerance chains.{key}": partial(chains.chain_numbers, one) for key, one in chains.OF_CHECKS.items()},
        },
        written={
            "friction drive.stopping": [drive.stopping],
            "sensors.contactless": [position_loop.contactless],
            "error budget.totals": budget.CHECKS,
            "dynamic error budget.totals": position_loop.CHECKS,
        },
    ),
)
"""Checks by subject, in the order of the report."""


def _figures(design: Design) -> tuple[str, ...]:
    teeth = ("teeth",) if design.teeth.fitted else ()
    return ("rail", *teeth, "speed", "travel", "profile", "budget", "dynamic_budget")


SUBJECTS = Subjects(
    checks=_CHECKS,
    chains=chains.chains,
    changed_masses=changed_masses,
    mass_keys=MASS_KEYS,
    requirements=_REQUIREMENTS,
    not_made=("candidates",),
    studies=lambda r: Studies(alternatives.ranking(r), budget.budgets(r), dynamic_budgets(r)),
    procedure_values=assembly_values,
    figures=_figures,
    experiments=("tip", "presliding", "hysteresis", "stick-slip"),
)
