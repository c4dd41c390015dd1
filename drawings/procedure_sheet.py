"""The sheet of the assembly procedure: a table of steps in two columns, in the frame of every other sheet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from drawings.frame import CENTRING, Paper, drawing_space
from drawings.ink import Ink, Stroke, Words, rectangle
from drawings.lettering import LINE_PITCH, SMALL, TEXT, text_width
from drawings.procedure import PartUse, Procedure, Step
from drawings.sheet import Sheet
from drawings.title_block import HEIGHT, TitleBlock
from drawings.view import Box2

NAME = "procedure"

PAPERS: tuple[Paper, ...] = ("A2", "A1")
SIDE, MARGIN, GUTTER = CENTRING + 2.0, 6.0, 8.0
"""From the frame's sides to the table, clear of the centring marks; from its top; between two columns, mm."""
PAD = 2.0
"""From a cell's edge to its text, mm."""
NUMBER, NEEDS = 11.0, 86.0
"""Widths of the cells for a step's number, and for its parts, tools and torque, mm."""
HEAD = 8.0
"""Height of the row of headings, mm."""


@dataclass(frozen=True)
class _Line:
    """One line of a cell."""

    text: str
    height: float = SMALL

    @property
    def pitch(self) -> float:
        return LINE_PITCH * self.height


def procedure_sheet(procedure: Procedure, title: TitleBlock) -> Sheet:
    """The sheet, on the smallest paper that holds the table.

    Args:
        procedure: the steps.
        title: its title block.

    Raises:
        ValueError: the table is too long for the largest paper.
    """
    for paper in PAPERS:
        table = _table(procedure.steps, paper)
        if table is not None:
            return Sheet(NAME, NAME, paper, 1.0, title, (), (), (), tuple(table))
    raise ValueError(f"the procedure has {len(procedure.steps)} steps, more than a sheet of {PAPERS[-1]} holds")


def _table(steps: Sequence[Step], paper: Paper) -> list[Ink] | None:
    """The steps in two columns, the second one above the title block; None where they do not fit."""
    x0, y0, x1, y1 = drawing_space(paper)
    width = (x1 - x0 - 2 * SIDE - GUTTER) / 2
    columns = ((x0 + SIDE, y0 + MARGIN), (x0 + SIDE + width + GUTTER, y0 + HEIGHT + MARGIN))
    inks: list[Ink] = []
    left = list(steps)
    for start, floor in columns:
        if not left:
            break
        top = y1 - MARGIN
        inks += _headings((start, top - HEAD, start + width, top))
        top -= HEAD
        while left:
            row = _Row(left[0], width)
            if top - row.height < floor:
                break
            inks += row.ink(start, top)
            top -= row.height
            left.pop(0)
    return None if left else inks


def _headings(box: Box2) -> Iterator[Ink]:
    x0, y0, x1, y1 = box
    yield rectangle(box, "FRAME")
    base = y0 + (y1 - y0 - TEXT) / 2
    for text, left in (("No.", x0), ("Step", x0 + NUMBER), ("Parts, tools, torque", x1 - NEEDS)):
        yield Words(text, (left + PAD, base), TEXT)


class _Row:
    """One step, its texts broken into lines."""

    def __init__(self, step: Step, width: float) -> None:
        self._step, self._width = step, width
        self._words = [_Line(step.title, TEXT)]
        for sentence in step.sentences:
            self._words += [_Line(text) for text in broken(sentence, width - NUMBER - NEEDS - 2 * PAD, SMALL)]
        self._needs: list[_Line] = [_Line(_part(use)) for use in step.parts]
        for text in ("; ".join(step.tools), f"Torque {step.torque.text}" if step.torque else ""):
            self._needs += [_Line(line) for line in broken(text, NEEDS - 2 * PAD, SMALL)] if text else []

    @property
    def height(self) -> float:
        """Of the row, mm."""
        return 2 * PAD + max(sum(line.pitch for line in cell) for cell in (self._words, self._needs))

    def ink(self, left: float, top: float) -> Iterator[Ink]:
        """The row with its upper left corner there."""
        right, bottom = left + self._width, top - self.height
        yield rectangle((left, bottom, right, top))
        for x in (left + NUMBER, right - NEEDS):
            yield Stroke(((x, bottom), (x, top)))
        yield Words(str(self._step.number), (left + NUMBER / 2, top - PAD - TEXT), TEXT, "middle")
        for cell, x in ((self._words, left + NUMBER), (self._needs, right - NEEDS)):
            base = top - PAD
            for line in cell:
                yield Words(line.text, (x + PAD, base - line.height), line.height)
                base -= line.pitch


def _part(use: PartUse) -> str:
    number = f", {use.part_number}" if use.part_number else ""
    return f"[{use.item}] {use.quantity} x {use.part.replace('_', ' ')}{number}"


def broken(text: str, width: float, height: float) -> list[str]:
    """A text broken at its spaces into lines no wider than a width, mm; a word wider than that stands alone."""
    lines: list[str] = []
    for word in text.split(" "):
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and text_width(longer, height) <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
