"""Checks of the readability of a finished sheet, by the rules by which its annotations were placed.

No text touches another text or a line, leaders are unambiguous (`drawings.placement.lint_rules`), everything is within
the frame and off the title block, no dimension reaches into another view. That the DXF file shows the same lines and
texts at the same places, and measures the values of the dimensions, is tested for all sheets.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from drawings.annotations.annotation import (
    Annotation,
    Callout,
    FeatureControlFrame,
    LinearDimension,
    MeasuredDimension,
    label_primitives,
    text_box,
)
from drawings.annotations.primitives import Text
from drawings.placement import lint_rules
from drawings.sheets.frame import drawing_space, frame, title_area, title_primitives
from drawings.sheets.sheet import Sheet
from drawings.views.segment_index import SegmentIndex, boxes_overlap, enlarged, line_box, line_meets_box
from drawings.views.view import Box2, Point2, View, enclosing_box

Kind = Literal["text", "line", "leader", "callout", "frame", "title block", "dimensions", "view"]

TOUCH = 0.05
"""Overlap from which on a text of the frame or of a table touches something, and a line is in another view, mm."""
UNDEFINED = re.compile(r"\b(both ways|each way|typ\.?|approx\.?|as required|or similar)(\s|$)", re.IGNORECASE)
"""Wordings in callouts that no standard defines."""


@dataclass(frozen=True)
class Hit:
    """Something that makes a sheet hard to read or wrong."""

    kind: Kind  # of check that failed
    what: str  # description
    at: Point2  # position on the paper, mm from the lower left corner

    def __str__(self) -> str:
        return f"{self.what}, at x {self.at[0]:.0f}, y {self.at[1]:.0f} mm"


@dataclass(frozen=True)
class _Item:
    """An annotation of a sheet with its view and the area that it occupies."""

    annotation: Annotation
    view: View
    footprint: lint_rules.Footprint

    @property
    def words(self) -> str:
        match self.annotation:
            case Callout():
                return " ".join(self.annotation.lines)
            case FeatureControlFrame():
                return f"{self.annotation.characteristic} {self.annotation.tolerance}"
            case _:
                return getattr(self.annotation, "text", "") or getattr(self.annotation, "letter", "")


def lint(sheet: Sheet) -> list[Hit]:
    """All violations on a sheet; empty for a good one."""
    # Distances first: a leader may continue the dimension line of one, whichever is the earlier on the sheet.
    annotations = sorted(sheet.annotations, key=lambda one: not isinstance(one, LinearDimension))
    views = {view.name: view for view in sheet.views}
    items = [_Item(one, views[one.view], lint_rules.footprint_of(one, views[one.view])) for one in annotations]
    labels = [piece for view in sheet.views for piece in label_primitives(view) if isinstance(piece, Text)]
    return [
        *_conflicts(sheet, items, labels),
        *_on_the_sheet(sheet, items, labels),
        *(
            Hit("callout", f"'{one.words}' is defined by no standard", enclosing_box(one.footprint.boxes)[:2])
            for one in items
            if UNDEFINED.search(one.words)
        ),
        *_off_the_sheet(sheet, items, labels),
        *_across_views(sheet, items),
    ]


def _conflicts(sheet: Sheet, items: Sequence[_Item], labels: Sequence[Text]) -> Iterator[Hit]:
    """Each annotation against the views and the annotations before it."""
    drawn = lint_rules.Occupancy(*sheet.views)
    words: list[str] = []
    for item in items:
        footprint = item.footprint
        for box in footprint.texts:
            yield from _text_hits(item.words, box, drawn, words)
        place = enclosing_box(footprint.boxes)[:2]
        too_near = drawn.near_dimension_lines(footprint)
        if too_near:
            yield Hit("dimensions", f"the dimension line of {item.words} is too near to another one", place)
        if drawn.line_conflicts(footprint) > too_near:
            yield Hit("line", f"a line of '{item.words}' is over a text", place)
        tip = item.annotation.leader_tip(item.view) or place
        aligned = drawn.continues_dimension_line(tip, footprint)
        named = "".join(f"'{name}': " for name in getattr(item.annotation, "names", ())[:1])
        for what in () if aligned else drawn.end_faults(item.annotation, item.view):
            yield Hit("leader", f"{named}{what}", tip)
        for what, number in drawn.leader_conflicts(item.annotation, item.view, footprint):
            if number:
                yield Hit("leader", what, tip)
        drawn.add(item.annotation, item.view, footprint)
        words += [item.words] * len(footprint.texts)
    for label in labels:
        yield from _text_hits(label.text, text_box(label), drawn, words)
    # Tolerances of an axis, in a zone in the shape of a cylinder, are in line with a dimension line (ISO 1101).
    for item in items:
        if isinstance(item.annotation, FeatureControlFrame) and item.annotation.is_axial and item.footprint.leaders:
            tip = item.view.to_paper(item.annotation.at)
            if not drawn.continues_dimension_line(tip, item.footprint):
                what = f"the tolerance {item.annotation.tolerance} of an axis is not in line with a dimension line"
                yield Hit("leader", what, tip)


def _text_hits(text: str, box: Box2, drawn: lint_rules.Occupancy, words: Sequence[str]) -> Iterator[Hit]:
    """Texts, and lines of views and annotations, that a text touches."""
    middle = ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2)
    over = drawn.touched_texts(box, lint_rules.LINE_CLEARANCE)
    for number in over:
        yield Hit("text", f"'{text}' is over '{words[number]}'", middle)
    if drawn.text_conflicts(box, lint_rules.LINE_CLEARANCE) > len(over):
        yield Hit("line", f"'{text}' is over a line", middle)


def _on_the_sheet(sheet: Sheet, items: Sequence[_Item], labels: Sequence[Text]) -> Iterator[Hit]:
    """Texts of the frame, the tables and the notes on each other or on lines, and texts of views on those."""
    # What belongs to no view: frame, title block, tables, notes.
    fixed = [*frame(sheet.paper), *title_primitives(sheet.title, sheet.paper), *sheet.tables]
    fixed += [primitive for note in sheet.notes for primitive in note.primitives()]
    texts = [(piece.text, text_box(piece)) for piece in fixed if isinstance(piece, Text)]
    lines = [line for piece in fixed for line in lint_rules.primitive_lines(piece)]
    viewed = [(item.words, box) for item in items for box in item.footprint.texts]
    viewed += [(label.text, text_box(label)) for label in labels]
    on_sheet, every = SegmentIndex(lines), SegmentIndex(lines)
    every.add([line for view in sheet.views for line in lint_rules.view_lines(view)])
    every.add([line for item in items for line in item.footprint.lines])
    placed = sorted([(box, text) for text, box in texts])
    for number, (box, text) in enumerate(placed):
        if every.count_in(enlarged(box, -TOUCH)):
            yield Hit("line", f"'{text}' is over a line", box[:2])
        for below, other in placed[number + 1 :]:
            if below[0] >= box[2]:
                break
            if boxes_overlap(enlarged(box, -TOUCH), below):
                yield Hit("text", f"'{text}' is over '{other}'", box[:2])
    for text, box in viewed:
        if on_sheet.count_in(enlarged(box, -TOUCH)):
            yield Hit("line", f"'{text}' is over a line", box[:2])
        for other, below in texts:
            if boxes_overlap(enlarged(box, -TOUCH), below):
                yield Hit("text", f"'{text}' is over '{other}'", box[:2])


def _off_the_sheet(sheet: Sheet, items: Sequence[_Item], labels: Sequence[Text]) -> Iterator[Hit]:
    x0, y0, x1, y1 = drawing_space(sheet.paper)
    texts = [(item.words, box) for item in items for box in item.footprint.texts]
    texts += [(label.text, text_box(label)) for label in labels]
    for text, box in texts:
        if not (x0 < box[0] and box[2] < x1 and y0 < box[1] and box[3] < y1):
            yield Hit("frame", f"'{text}' is outside the frame", box[:2])
    lines = SegmentIndex([line for view in sheet.views for line in lint_rules.view_lines(view)])
    lines.add([line for item in items for line in item.footprint.lines])
    outside = lines.outside((x0, y0, x1, y1))
    if outside:
        yield Hit("frame", f"{len(outside)} lines are outside the frame", outside[0][:2])
    title = title_area(sheet.title, sheet.paper)
    if lines.count_in(title):
        yield Hit("title block", "lines of a view are over the title block", title[:2])
    for text, box in texts:
        if boxes_overlap(box, title):
            yield Hit("title block", f"'{text}' is over the title block", box[:2])


def _across_views(sheet: Sheet, items: Sequence[_Item]) -> Iterator[Hit]:
    """Lines of a dimension in the box around another view."""
    boxes = {view.name: enclosing_box([line_box(line) for line in lint_rules.view_lines(view)]) for view in sheet.views}
    for item in items:
        if not isinstance(item.annotation, MeasuredDimension):
            continue
        for name, box in boxes.items():
            if name != item.view.name and any(
                line_meets_box(line, enlarged(box, TOUCH)) for line in item.footprint.lines
            ):
                yield Hit("view", f"a line of '{item.words}' crosses the view '{name}'", item.footprint.lines[0][:2])
