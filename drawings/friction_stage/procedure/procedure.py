"""The assembly procedure: order of assembly, parts, tools, torques and adjustments, for the sheet and the report.

All numbers are parameters, entries of the parts list or calculated values (`ProcedureValues`).
"""

from __future__ import annotations

import string
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from drawings.friction_stage.procedure.figures import Figure, ProcedureValues, figures_of
from drawings.friction_stage.procedure.steps import step_templates
from stagecad.solids.assembly.bill_of_materials import Row


@dataclass(frozen=True)
class PartUse:
    """A row of the parts list that is put in by a step.

    Args:
        item: number in the parts list and of the balloon.
        part, part_number: name, and number in the catalogue or of the drawing.
        quantity: number of parts.
    """

    item: int
    part: str
    part_number: str
    quantity: int


@dataclass(frozen=True)
class Step:
    """One step.

    Args:
        number: from 1, in the order of assembly.
        sentences: instructions.
        tools: and materials that are not in the parts list.
        torque: of the screws of this step.
        figures: all numbers of the step, by name.
    """

    number: int
    title: str
    sentences: tuple[str, ...]
    parts: tuple[PartUse, ...]
    tools: tuple[str, ...]
    torque: Figure | None
    figures: dict[str, Figure]


@dataclass(frozen=True)
class Procedure:
    """The steps in their order."""

    steps: tuple[Step, ...]


def procedure(design: Any, rows: Sequence[Row], values: ProcedureValues) -> Procedure:
    """The assembly procedure of a design.

    Args:
        rows: of its parts list; each part is put in by exactly one step.
        values: calculated values.
    """
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
