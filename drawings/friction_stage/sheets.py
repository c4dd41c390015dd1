"""Sheets of the friction stage: plans of its parts, views of the whole, procedure."""

from __future__ import annotations

import string
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from drawings.friction_stage.procedure.figures import ProcedureValues, figures_of
from drawings.friction_stage.procedure.steps import step_templates
from drawings.friction_stage.sheet_plans import sheet_plans
from drawings.pictures.machine import MachineViews
from drawings.sheets.plans import Sheets
from drawings.sheets.procedure import PartUse, Procedure, Step
from drawings.views.view import Cut
from stagecad.friction_stage.assembly import CARRIED, MOVING
from stagecad.friction_stage.construction import CAP_SCREWS
from stagecad.solids.assembly.bill_of_materials import Row

if TYPE_CHECKING:
    from drawings.sheets.procedure import Procedure
    from stagecad.solids.artefacts.part import BuiltPart
    from stagecad.solids.assembly.bill_of_materials import Row
    from stagecad.solids.modelling.part import Instance


def procedure(design: Any, rows: Sequence[Row], values: ProcedureValues) -> Procedure:
    """The assembly procedure of a design."""
    figures = figures_of(design, rows, values)
    listed = {row.part: row for row in rows}
    steps = []
    for number, template in enumerate(step_templates(design, values), start=1):
        used = {
            name: figures[name]
            for text in (*template.tools, *template.sentences, f"{{{template.torque}}}")
            for name in _names(text)
        }
        shown = {name: figure.text for name, figure in used.items()}
        steps.append(
            Step(
                number,
                template.title,
                tuple(text.format(**shown) for text in template.sentences),
                tuple(
                    PartUse(row.item, row.part, row.part_number, row.quantity)
                    for row in (listed[part] for part in template.parts)
                ),
                tuple(text.format(**shown) for text in template.tools),
                figures[template.torque] if template.torque else None,
                used,
            )
        )
    return Procedure(tuple(steps))


def _names(text: str) -> Iterable[str]:
    return [name for _, name, _, _ in string.Formatter().parse(text) if name]


ALONG = Cut((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), "A")
ACROSS = Cut((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), "B")
"""Through the axis of actuator 1 along the travel; and across it, through ways, a pad, teeth and bars."""
NOT_CUT = (*CAP_SCREWS, "set_screw", "height_pin_1", "height_pin_2", "piezo", "spring", "interferometer")
"""Parts that a section shows whole."""

VIEWS = MachineViews(
    {"section A-A": (ALONG, "front"), "section B-B": (ACROSS, "right")},
    NOT_CUT,
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


def _travel(design: Any) -> float:
    return design.stage.travel


SHEETS = Sheets(
    plans=sheet_plans,
    # Titles of the thesis.
    titles={"tip": "actuator tip", "holder": "piezo holder"},
    views=_views,
    procedure=lambda design, rows, values: procedure(design, rows, ProcedureValues(**values)),
    travel=_travel,
    modules=(__name__,),
)
