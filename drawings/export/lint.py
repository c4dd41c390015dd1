"""Checks of the readability of a finished sheet, on the DXF document as it appears on paper.

Nothing is taken from the program that placed texts and dimensions (`drawings.export.dxf_reading`). No text touches
another text or a line, everything is within the frame and off the title block, no two dimension lines share a line,
the text of a dimension is what its points measure, and the file passes ezdxf's audit.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from ezdxf.document import Drawing

from drawings.export.dxf_reading import PaperContent, TextBox, entity_points, joined_boxes, visible_entities
from drawings.export.leaders import TOUCH, leader_faults
from drawings.views.bounding_box import bounding_box
from drawings.views.segment_index import SegmentIndex, boxes_overlap, enlarged, line_meets_box, polyline_lines
from drawings.views.view import Box2, Point2

Kind = Literal[
    "text", "line", "leader", "callout", "frame", "title block", "dimensions", "view", "value", "viewport", "file"
]

UNDEFINED = re.compile(r"\b(both ways|each way|typ\.?|approx\.?|as required|or similar)(\s|$)", re.IGNORECASE)
"""Wordings in callouts that no standard defines."""
NEAR = 0.5
"""Distance up to which lines of the part belong to one view, mm on paper: less than between views."""


@dataclass(frozen=True)
class Hit:
    """Something that makes a sheet hard to read or wrong.

    Args:
        kind: of check that failed.
        what: description.
        at: position on the paper, mm from the lower left corner.
    """

    kind: Kind
    what: str
    at: Point2

    def __str__(self) -> str:
        return f"{self.what}, at x {self.at[0]:.0f}, y {self.at[1]:.0f} mm"


def lint(document: Drawing) -> list[Hit]:
    """All violations on a sheet; empty for a good one."""
    content = PaperContent(document)
    return [
        *_cut_off(content),
        *_texts_on_texts(content),
        *_texts_on_lines(content),
        *_symbols_on_parts(content),
        *_leaders(document, content),
        *_callouts(content),
        *_off_the_sheet(document, content),
        *_shared_lines(content),
        *_across_views(document, content),
        *_values(document, content),
        *_audit(document),
    ]


def _cut_off(content: PaperContent) -> Iterator[Hit]:
    for what in content.cut_off:
        yield Hit("viewport", f"{what} is not completely within a viewport", (0.0, 0.0))


def _texts_on_texts(content: PaperContent) -> Iterator[Hit]:
    placed = sorted(((bounding_box(text.corners()), text) for text in content.texts), key=lambda pair: pair[0][0])
    for i, (box, one) in enumerate(placed):
        for below, other in placed[i + 1 :]:
            if below[0] >= box[2]:
                break
            if not boxes_overlap(box, below) or _separated(one, other) or _separated(other, one):
                continue
            yield Hit("text", f"'{one.text}' is over '{other.text}'", one.middle)


def _separated(one: TextBox, other: TextBox) -> bool:
    """Whether a line parallel to a side of `one` separates the two (separating axis theorem)."""
    corners = [one.local(corner) for corner in other.corners()]
    for axis in (0, 1):
        low, high = min(p[axis] for p in corners), max(p[axis] for p in corners)
        if low > one.half[axis] - TOUCH or high < -one.half[axis] + TOUCH:
            return True
    return False


def _texts_on_lines(content: PaperContent) -> Iterator[Hit]:
    lines = SegmentIndex([*content.sheet_lines, *content.view_lines])
    for text in content.texts:
        u, v = text.half[0] - TOUCH, text.half[1] - TOUCH
        near = lines.near(bounding_box(text.corners()))
        if any(line_meets_box((*text.local(line[:2]), *text.local(line[2:])), (-u, -v, u, v)) for line in near):
            yield Hit("line", f"'{text.text}' is over a line", text.middle)


def _symbols_on_parts(content: PaperContent) -> Iterator[Hit]:
    """Symbols, and frames of tolerances and datum letters, on the part."""
    lines = SegmentIndex(content.part_lines)
    for box in content.symbols:
        if lines.count_in((box[0] + TOUCH, box[1] + TOUCH, box[2] - TOUCH, box[3] - TOUCH)):
            yield Hit("line", "a symbol, or the frame of a tolerance or datum, is over the part", box[:2])


def _leaders(document: Drawing, content: PaperContent) -> Iterator[Hit]:
    for what, at in leader_faults(document, content):
        yield Hit("leader", what, at)


def _callouts(content: PaperContent) -> Iterator[Hit]:
    """Wordings that no standard defines."""
    for text in content.view_texts:
        if UNDEFINED.search(text.text):
            yield Hit("callout", f"'{text.text}' is defined by no standard", text.middle)


def _off_the_sheet(document: Drawing, content: PaperContent) -> Iterator[Hit]:
    frames = sorted(_frames(document), key=lambda box: (box[2] - box[0]) * (box[3] - box[1]), reverse=True)
    if not frames:
        yield Hit("frame", "the sheet has no frame", (0.0, 0.0))
        return
    x0, y0, x1, y1 = frames[0]
    for text in content.view_texts:
        if any(not (x0 < x < x1 and y0 < y < y1) for x, y in text.corners()):
            yield Hit("frame", f"'{text.text}' is outside the frame", text.middle)
    lines = SegmentIndex(content.view_lines)
    outside = lines.outside((x0, y0, x1, y1))
    if outside:
        yield Hit("frame", f"{len(outside)} lines are outside the frame", outside[0][:2])
    for title in frames[1:]:
        if lines.count_in(title):
            yield Hit("title block", "lines of a view are over the title block", title[:2])
        for text in content.view_texts:
            if boxes_overlap(bounding_box(text.corners()), title):
                yield Hit("title block", f"'{text.text}' is over the title block", text.middle)


def _frames(document: Drawing) -> Iterator[Box2]:
    """Frame and title block: the closed rectangles on the layer of heavy lines."""
    for entity in document.paperspace().query("LWPOLYLINE[layer=='FRAME']"):
        points = entity_points(entity)
        if len(points) == 5 and math.dist(points[0], points[-1]) < 1e-9:
            yield bounding_box(points)


def _shared_lines(content: PaperContent) -> Iterator[Hit]:
    """Collinear dimension lines that overlap."""
    placed: list[tuple[Point2, Point2, str]] = []
    for dimension in content.dimensions:
        d = dimension.dxf
        if d.dimtype & 7 != 0:
            continue
        angle = math.radians(d.angle)
        u = (math.cos(angle), math.sin(angle))
        viewport = content.viewport_of([(d.defpoint.x, d.defpoint.y)])
        if viewport is None:
            continue
        along = [(p.x - d.defpoint.x) * u[0] + (p.y - d.defpoint.y) * u[1] for p in (d.defpoint2, d.defpoint3)]
        start, end = (
            viewport.to_paper((d.defpoint.x + a * u[0], d.defpoint.y + a * u[1])) for a in (min(along), max(along))
        )
        for other in placed:
            if _on_one_line((start, end), other[:2]):
                yield Hit("dimensions", f"dimension lines of {d.text} and {other[2]} overlap on one line", start)
        placed.append((start, end, d.text))


def _across_views(document: Drawing, content: PaperContent) -> Iterator[Hit]:
    """Lines of a dimension in a view other than the one, or those, in which its points are.

    A view is the box around lines of the part that touch or enclose each other.
    """
    views = joined_boxes(content.part_boxes, NEAR)
    for dimension in content.dimensions:
        d = dimension.dxf
        viewport = content.viewport_of([(d.defpoint.x, d.defpoint.y)])
        if d.dimtype & 7 != 0 or viewport is None:
            continue
        points = [viewport.to_paper((point.x, point.y)) for point in (d.defpoint2, d.defpoint3)]
        others = [view for view in views if not any(_within(point, view, NEAR) for point in points)]
        for entity in visible_entities(document, [dimension]):
            if entity.dxftype() not in ("LINE", "LWPOLYLINE"):
                continue
            for line in polyline_lines(list(map(viewport.to_paper, entity_points(entity)))):
                if any(line_meets_box(line, enlarged(view, TOUCH)) for view in others):
                    yield Hit("view", f"a line of {d.text} crosses another view", line[:2])


def _within(point: Point2, box: Box2, margin: float) -> bool:
    """Whether a point is in a box or nearer to it than a margin."""
    return box[0] - margin < point[0] < box[2] + margin and box[1] - margin < point[1] < box[3] + margin


def _on_one_line(one: tuple[Point2, Point2], other: tuple[Point2, Point2]) -> bool:
    size = math.dist(*one)
    if size < 1e-9:
        return False
    u = ((one[1][0] - one[0][0]) / size, (one[1][1] - one[0][1]) / size)
    off = [(p[0] - one[0][0]) * -u[1] + (p[1] - one[0][1]) * u[0] for p in other]
    at = [(p[0] - one[0][0]) * u[0] + (p[1] - one[0][1]) * u[1] for p in other]
    return max(map(abs, off)) < 1.0 and min(max(at), size) - max(min(at), 0.0) > TOUCH


def _values(document: Drawing, content: PaperContent) -> Iterator[Hit]:
    """Dimensions whose drawn text is not what their points measure."""
    for dimension in content.dimensions:
        measured = dimension.get_measurement()
        if not isinstance(measured, float):
            continue
        decimals = document.dimstyles.get(dimension.dxf.dimstyle).dxf.dimdec
        expected = _decoded(dimension.dxf.text.replace("<>", f"{measured:.{decimals}f}"))
        block = visible_entities(document, [dimension])
        drawn = "".join(entity.plain_text() for entity in block if entity.dxftype() == "TEXT")
        if "<>" not in dimension.dxf.text or expected != _decoded(drawn):
            at = (dimension.dxf.defpoint.x, dimension.dxf.defpoint.y)
            viewport = content.viewport_of([at])
            yield Hit(
                "value", f"'{drawn}' is drawn, '{expected}' is measured", viewport.to_paper(at) if viewport else at
            )


def _decoded(text: str) -> str:
    return text.replace("%%c", "Ø").replace("%%d", "°").replace("%%p", "±").replace("⌀", "Ø")


def _audit(document: Drawing) -> Iterator[Hit]:
    auditor = document.audit()
    for error in (*auditor.errors, *auditor.fixes):
        yield Hit("file", f"DXF audit: {error.message}", (0.0, 0.0))
