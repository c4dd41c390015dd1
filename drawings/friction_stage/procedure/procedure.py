"""The assembly procedure: order of assembly, parts, tools, torques and adjustments, for the sheet and the report.

All numbers are parameters, entries of the parts list or calculated values (`ProcedureValues`).
"""

from __future__ import annotations

import string
from collections.abc import Iterable, Sequence
from typing import Any

from drawings.friction_stage.procedure.figures import ProcedureValues, figures_of
from drawings.friction_stage.procedure.steps import step_templates
from drawings.sheets.procedure import PartUse, Procedure, Step
from stagecad.solids.assembly.bill_of_materials import Row


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
                tuple(_use(listed[part]) for part in template.parts),
                tuple(text.format(**shown) for text in template.tools),
                figures[template.torque] if template.torque else None,
                used,
            )
        )
    return Procedure(tuple(steps))


def _names(text: str) -> Iterable[str]:
    return [name for _, name, _, _ in string.Formatter().parse(text) if name]


def _use(row: Row) -> PartUse:
    return PartUse(row.item, row.part, row.part_number, row.quantity)
