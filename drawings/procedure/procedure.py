"""The assembly procedure: what goes where in which order, with which tool and torque, and what is set on the way.

Plain data, for a sheet and for the report. Every number in it is read from the parameter file or from the list of
parts, or handed in by whoever has calculators (`ProcedureValues`); the sentences themselves hold none, but name their
figures in braces, and each figure knows its origin.
"""

from __future__ import annotations

import string
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from drawings.procedure.figures import Figure, ProcedureValues, figures_of
from drawings.procedure.steps import drafts
from stagecad.solids.assembly.bill_of_materials import Row


@dataclass(frozen=True)
class PartUse:
    """Parts that a step puts in.

    Args:
        item: number in the list of parts, as in the balloons.
        part, part_number: name, and number in the catalogue or of the drawing.
        quantity: that this step takes.
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
        title: what is done.
        sentences: how; each an order or what is seen when it is right.
        parts: from the list of parts.
        tools: and what else is needed that is not in the list.
        torque: of the screws of this step.
        figures: all numbers in it, by name.
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
    """The assembly of one design.

    Args:
        design: the design.
        rows: its list of parts; every part in it is put in by exactly one step.
        values: what has to be calculated.
    """
    figures = figures_of(design, rows, values)
    listed = {row.part: row for row in rows}
    steps = []
    for number, draft in enumerate(drafts(design, values), start=1):
        used = {
            name: figures[name]
            for text in (*draft.tools, *draft.sentences, f"{{{draft.torque}}}")
            for name in _names(text)
        }
        shown = {name: figure.text for name, figure in used.items()}
        steps.append(
            Step(
                number,
                draft.title,
                tuple(text.format(**shown) for text in draft.sentences),
                tuple(_use(listed[part]) for part in draft.parts),
                tuple(text.format(**shown) for text in draft.tools),
                figures[draft.torque] if draft.torque else None,
                used,
            )
        )
    return Procedure(tuple(steps))


def _names(text: str) -> Iterable[str]:
    return [name for _, name, _, _ in string.Formatter().parse(text) if name]


def _use(row: Row) -> PartUse:
    return PartUse(row.item, row.part, row.part_number, row.quantity)
