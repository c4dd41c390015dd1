"""The assembly procedure: its steps, and their sheet: a table in two columns, and pictures next to it."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from drawings.annotations.annotation import BALLOON
from drawings.annotations.primitives import LINE_PITCH, SMALL_HEIGHT, TEXT_HEIGHT, Primitive, Stroke, Text, rectangle
from drawings.pictures.picture import Picture
from drawings.sheets.assembly import all_balloons
from drawings.sheets.frame import CENTRING, HEIGHT, PAPERS, Paper, TitleBlock, drawing_space
from drawings.sheets.plans import Step
from drawings.sheets.sheet import Sheet, scale_text, wrapped
from drawings.views.view import Box2, view_box
from stagecad.solids.assembly.bill_of_materials import Row

NAME = "procedure"

SCALES = (0.5, 0.25, 0.2, 0.1, 0.05)
"""Scales of the pictures that a title block states as a ratio of whole numbers."""
SIZES: tuple[Paper, ...] = ("A2", "A1")
SIDE, MARGIN, GUTTER = CENTRING + 2.0, 6.0, 8.0
"""Distance of the table from the sides of the frame, beyond the centring marks, from its top; of the columns, mm."""
PAD = 2.0
"""Margin of a text in its cell, mm."""
NUMBER, REQUIRED = 11.0, 86.0
"""Widths of the cells for a step's number, and for its parts, tools and torque, mm."""
HEAD = 8.0
"""Height of the row of headings, mm."""


def procedure_sheet(
    steps: Sequence[Step], title: TitleBlock, pictures: Sequence[Picture] = (), rows: Sequence[Row] = ()
) -> Sheet:
    """The sheet, on the smallest paper that holds the table."""
    for paper in SIZES:
        table = _Table(steps, paper)
        if table.complete:
            placed = _placed(pictures, table.free) if table.free else []
            scale = placed[0].view.scale if placed else 1.0
            return Sheet(
                NAME,
                NAME,
                paper,
                scale,
                replace(title, scale=scale_text(scale) if placed else "-"),
                tuple(one.view for one in placed),
                tuple(all_balloons(placed, rows)),
                (),
                tuple(table.primitives),
            )
    raise ValueError(f"the procedure has {len(steps)} steps, more than a sheet of {SIZES[-1]} holds")


class _Table:
    """The steps in two columns, the second one above the title block."""

    def __init__(self, steps: Sequence[Step], paper: Paper) -> None:
        x0, y0, x1, y1 = drawing_space(paper)
        # The gap between the columns is at the centring mark, in the middle of the paper.
        middle, top = PAPERS[paper][0] / 2, y1 - MARGIN
        second, width = middle + GUTTER / 2, middle - GUTTER / 2 - x0 - SIDE
        left = list(steps)
        self.primitives: list[Primitive] = []
        self.free: Box2 | None = (second, y0 + HEIGHT + MARGIN, x1 - SIDE, y1 - SIDE)
        for start, floor in ((x0 + SIDE, y0 + MARGIN), (second, y0 + HEIGHT + MARGIN)):
            if not left:
                break
            if start == second:
                self.free = None
            height, base = top - HEAD, top - HEAD + (HEAD - TEXT_HEIGHT) / 2
            self.primitives.append(rectangle((start, height, start + width, top), "FRAME"))
            for text, at in (("No.", 0.0), ("Step", NUMBER), ("Parts, tools, torque", width - REQUIRED)):
                self.primitives.append(Text(text, (start + at + PAD, base), TEXT_HEIGHT))
            while left:
                row = _Row(left[0], width)
                if height - row.height < floor:
                    break
                self.primitives += row.primitives(start, height)
                height -= row.height
                left.pop(0)
        self.complete = not left


def _placed(pictures: Sequence[Picture], area: Box2) -> list[Picture]:
    """The pictures one below the other in an area, at the largest scale at which they fit."""
    x0, y0, x1, y1 = area
    for scale in SCALES:
        scaled = [replace(one, view=replace(one.view, scale=scale, place=(0.0, 0.0), label="")) for one in pictures]
        boxes = [view_box(one.view) or (0.0, 0.0, 0.0, 0.0) for one in scaled]
        gap = (y1 - y0 - sum(box[3] - box[1] for box in boxes)) / (len(boxes) + 1)
        if gap < BALLOON or any(box[2] - box[0] + 8 * BALLOON > x1 - x0 for box in boxes):
            continue
        placed, top = [], y1
        for one, box in zip(scaled, boxes, strict=True):
            top -= gap
            at = ((x0 + x1 - box[0] - box[2]) / 2, top - box[3])
            placed.append(replace(one, view=replace(one.view, place=at)))
            top -= box[3] - box[1]
        return placed
    return []


class _Row:
    """A row of the table: one step, its texts in lines."""

    def __init__(self, step: Step, width: float) -> None:
        self._step, self._width = step, width
        # Both cells: lines, each a text and its height.
        wide = width - NUMBER - REQUIRED - 2 * PAD
        sentences = (text for sentence in step.sentences for text in wrapped(sentence, wide, SMALL_HEIGHT))
        self._words = [(step.title, TEXT_HEIGHT), *((text, SMALL_HEIGHT) for text in sentences)]
        required: list[str] = []
        for use in step.parts:
            number = f", {use.part_number}" if use.part_number else ""
            required.append(f"[{use.item}] {use.quantity} x {use.part.replace('_', ' ')}{number}")
        for text in ("; ".join(step.tools), f"Torque {step.torque.text}" if step.torque else ""):
            required += wrapped(text, REQUIRED - 2 * PAD, SMALL_HEIGHT) if text else []
        self._required = [(text, SMALL_HEIGHT) for text in required]

    @property
    def height(self) -> float:
        """Height of the row, mm."""
        return 2 * PAD + max(sum(LINE_PITCH * high for _, high in cell) for cell in (self._words, self._required))

    def primitives(self, left: float, top: float) -> Iterator[Primitive]:
        """Lines and texts of the row, with its upper left corner at a point."""
        right, bottom = left + self._width, top - self.height
        yield rectangle((left, bottom, right, top))
        for x in (left + NUMBER, right - REQUIRED):
            yield Stroke(((x, bottom), (x, top)))
        yield Text(str(self._step.number), (left + NUMBER / 2, top - PAD - TEXT_HEIGHT), TEXT_HEIGHT, "middle")
        for cell, x in ((self._words, left + NUMBER), (self._required, right - REQUIRED)):
            base = top - PAD
            for text, high in cell:
                yield Text(text, (x + PAD, base - high), high)
                base -= LINE_PITCH * high
