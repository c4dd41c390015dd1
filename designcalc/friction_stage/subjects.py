"""Checks of the friction stage by subject, with the requirements of the thesis that they trace back to."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from designcalc.checks.check import CheckFunction
from designcalc.checks.inputs import DesignInputs
from designcalc.checks.subjects import Studies, Subjects
from designcalc.friction_stage.changed_masses import MASS_KEYS, changed_masses
from designcalc.friction_stage.checks import (
    actuator,
    alternatives,
    budget,
    chains,
    clamp,
    contact,
    drive,
    height,
    layout,
    position_loop,
    sensing,
    teeth,
    thermal,
)
from designcalc.friction_stage.checks.bearing import pads, plate, smoothness, ways, wear
from designcalc.friction_stage.physics.assembly_values import assembly_values
from designcalc.friction_stage.physics.position_loop import dynamic_budgets
from designcalc.friction_stage.physics.tolerance_chains import chains as tolerance_chains
from stagecad.parameters.mass_properties import BodyMasses, MassProperties

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

_CHECKS: dict[str, Callable[[Design], list[CheckFunction]]] = {
    "tip on stage": contact.checks,
    "bearing ways": ways.checks,
    "magnetic teeth": teeth.checks,
    "friction drive": drive.checks,
    "piezo actuator": actuator.checks,
    "sliding bearing": pads.checks,
    "stage plate": plate.checks,
    "smoothness": smoothness.checks,
    "wear and heat of the pads": wear.checks,
    "heat and surroundings": thermal.checks,
    "sensors": sensing.checks,
    "height adjustment": height.checks,
    "clamp": clamp.checks,
    "tolerance chains": chains.checks,
    "layout": layout.checks,
    "candidates": alternatives.checks,
    "error budget": budget.checks,
    "dynamic error budget": position_loop.checks,
}
"""Checks by subject, in the order of the report."""

_REQUIREMENTS: dict[str, str] = {
    "Table 1: resolution": "0.1 to 10 nm",
    "Table 1: travel": "200 mm",
    "Table 1: speed": "200 mm/s",
    "Table 1: acceleration": "0.2 to 1 G",
    "Table 1: smoothness": "1 nm normal to the plane of motion",
    "Table 2: actuator": "piezoelectric, as a cheap way to drive a stage",
    "Table 2: sensor range": "that of the system, 200 mm",
    "Table 2: sensor resolution": "that of the system or better, 10 to 0.1 nm",
    "Table 2: sensor without contact": "desirable for two axes",
    "Table 2: low thermal expansion": "materials for thermal stability",
    "Table 2: friction layer": "at the interface with the actuator",
    "Section 2.2: access to payload and adjustments": "ergonomics",
    "Section 2.2: modular": "easy to assemble, components easy to replace",
    "Section 2.2: open to two axes": "adaptable to motion in two axes",
    "Section 2.3.2: straightness (Table 1 has none)": "similar bearings reach 5 to 10 um, submicron when hand finished",
    "Section 2.3.2: repeatability (Table 1 has none)": "similar bearings reach 0.1 to 1 um",
}
"""The thesis's requirements: the name that checks refer to, and the text."""


def scaled_masses(design: Design, base: Design, masses: BodyMasses) -> BodyMasses:
    """Masses of a design that differs by tolerances, without building its solids.

    The base design's body with the mass of the plain plate's change added: exact for a longer, wider or thicker plate
    but for the features cut through it, a tenth of a change that is itself a hundredth of the mass.
    """
    change, body = _plate(design) - _plate(base), masses.moving
    scale = (body.mass + change) / body.mass
    inertia = np.asarray(body.inertia, float) * scale
    moving = MassProperties(body.volume * scale, body.mass + change, body.centre_of_mass, inertia, body.bounding_box)
    return BodyMasses(moving, masses.tip)


def _plate(design: Design) -> float:
    """Mass of the stage's plate without its features, kg."""
    volume = design.si("stage.length") * design.si("stage.width") * design.si("stage.thickness")
    return volume * design.si(f"materials.{design.value('stage.material')}.density")


def _studies(r: DesignInputs) -> Studies:
    return Studies(alternatives.ranking(r), budget.budgets(r), dynamic_budgets(r))


def _figures(design: Design) -> tuple[str, ...]:
    teeth = ("teeth",) if design.teeth.fitted else ()
    return ("rail", *teeth, "speed", "travel", "profile", "budget", "dynamic_budget")


SUBJECTS = Subjects(
    checks=_CHECKS,
    chains=tolerance_chains,
    scaled_masses=scaled_masses,
    changed_masses=changed_masses,
    mass_keys=MASS_KEYS,
    requirements=_REQUIREMENTS,
    not_made=("candidates",),
    studies=_studies,
    procedure_values=assembly_values,
    figures=_figures,
    experiments=("tip", "presliding", "hysteresis", "stick-slip"),
)
