"""Sheets of the friction stage: plans of its parts, views of the whole, procedure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from drawings.friction_stage.procedure.figures import ProcedureValues
from drawings.friction_stage.procedure.procedure import procedure
from drawings.friction_stage.sheet_plans import sheet_plans
from drawings.pictures.machine import MachineViews
from drawings.sheets.machine_sheets import Sheets
from drawings.views.view import Cut
from stagecad.friction_stage.assembly.bodies import CARRIED, MOVING
from stagecad.friction_stage.construction import CAP_SCREWS

if TYPE_CHECKING:
    from drawings.sheets.procedure import Procedure
    from stagecad.solids.artefacts.part import BuiltPart
    from stagecad.solids.assembly.bill_of_materials import Row
    from stagecad.solids.modelling.instance import Instance

ALONG = Cut((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), "A")
ACROSS = Cut((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), "B")
"""Through the axis of actuator 1 along the travel; and across it, through ways, a pad, teeth and bars."""
NOT_CUT = (*CAP_SCREWS, "set_screw", "height_pin_1", "height_pin_2", "piezo", "spring", "interferometer")
"""Parts that a section shows whole."""

VIEWS = MachineViews(
    {"section A-A": (ALONG, "front"), "section B-B": (ACROSS, "right")},
    frozenset(NOT_CUT),
    MOVING,
    CARRIED,
    notes=(
        "- Shown at the middle of travel and of height adjustment.",
        "- Order, torques and settings: see the procedure.",
        "- Fasteners, pins, piezos, spring and interferometer are not cut.",
    ),
)


def _views(design: Any, instances: Sequence[Instance], parts: Mapping[str, BuiltPart]) -> MachineViews:
    return VIEWS


def _procedure(design: Any, rows: Sequence[Row], values: Mapping[str, Any]) -> Procedure:
    return procedure(design, rows, ProcedureValues(**values))


def _travel(design: Any) -> float:
    return design.stage.travel


SHEETS = Sheets(
    plans=sheet_plans,
    # Titles of the thesis.
    titles={"tip": "actuator tip", "holder": "piezo holder"},
    views=_views,
    procedure=_procedure,
    travel=_travel,
    modules=(__name__,),
)
