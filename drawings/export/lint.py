"""Whether a finished sheet can be read: looks at the DXF document itself, as a reader would see it on paper.

Nothing is taken from the program that placed things. Model space is seen through the viewports; dimensions are their
blocks. A text must touch no other text and no line, everything must be within the frame and off the title block, no
two dimension lines may share a line, a dimension must say what its points measure, and the file must be sound.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

from ezdxf.document import Drawing
from ezdxf.tools.text_size import text_size

from drawings.annotations.font import prepare
from drawings.export.windows import Window, drawn, of_type, windows
from drawings.views.segment_index import Line, SegmentIndex, arc_points, polyline_lines
from drawings.views.view import Arc, Box2, Point2

Kind = Literal["text", "line", "frame", "title block", "dimensions", "value", "viewport", "file"]

PART = ("VISIBLE", "HIDDEN", "CENTRE", "HATCH", "PHANTOM")
"""Layers of the part's own lines."""
SYMBOL = 6.0
"""Closed or bent lines beside the views that are smaller than this are symbols, mm on paper."""
TOUCH = 0.05
"""By how much a text must go into something to touch it, mm on paper."""


@dataclass(frozen=True)
class Hit:
    """Something that makes a sheet hard to read or wrong.

    Args:
        kind: what was violated.
        what: in plain words.
        at: where on the paper, mm from the lower left corner.
    """

    kind: Kind
    what: str
    at: Point2

    def __str__(self) -> str:
        return f"{self.what}, at x {self.at[0]:.0f}, y {self.at[1]:.0f} mm"


@dataclass(frozen=True)
class _Text:
    """A text on the paper: middle, half width and half height along its own direction."""

    words: str
    middle: Point2
    half: Point2
    turn: float

    def corners(self) -> list[Point2]:
        c, s = math.cos(self.turn), math.sin(self.turn)
        return [
            (self.middle[0] + a * c - b * s, self.middle[1] + a * s + b * c)
            for a, b in (
                (-self.half[0], -self.half[1]),
                (self.half[0], -self.half[1]),
                (self.half[0], self.half[1]),
                (-self.half[0], self.half[1]),
            )
        ]

    def seen_from(self, point: Point2) -> Point2:
        """A point in the text's own frame."""
        x, y = point[0] - self.middle[0], point[1] - self.middle[1]
        c, s = math.cos(self.turn), math.sin(self.turn)
        return (x * c + y * s, -x * s + y * c)


class _Ink:
    """All texts and lines of the sheet on the paper, with the numbers of what belongs together."""

    def __init__(self, document: Drawing) -> None:
        prepare()
        self.texts: list[_Text] = []
        self.sheet_lines: list[Line] = []
        self.view_lines: list[Line] = []
        self.view_texts: list[_Text] = []
        self.part_lines: list[Line] = []
        self.symbols: list[Box2] = []
        self.lost: list[str] = []
        paper = document.paperspace()
        self.windows = list(windows(paper))
        for entity in paper:
            if entity.dxftype() == "TEXT":
                self.texts.append(_text(entity, None))
            elif entity.dxftype() != "VIEWPORT":
                self.sheet_lines += polyline_lines(_points(entity))
        self.dimensions = list(of_type(document.modelspace(), "DIMENSION"))
        for entity in drawn(document, document.modelspace()):
            self._from_model(entity)

    def _from_model(self, entity: Any) -> None:
        points = _points(entity)
        window = next((w for w in self.windows if points and w.shows_all(points)), None)
        if window is None:
            self.lost.append(f"{entity.dxftype()} on layer {entity.dxf.layer}")
        elif entity.dxftype() == "TEXT":
            text = _text(entity, window)
            self.texts.append(text)
            self.view_texts.append(text)
        else:
            points = window.on_paper(points)
            lines = polyline_lines(points)
            self.view_lines += lines
            if entity.dxf.layer in PART:
                self.part_lines += lines
            elif entity.dxftype() in ("LWPOLYLINE", "CIRCLE"):
                box = _box(points)
                framed = len(points) == 5 and math.dist(points[0], points[4]) < 1e-9
                if framed or max(box[2] - box[0], box[3] - box[1]) < SYMBOL:
                    self.symbols.append(box)


def lint(document: Drawing) -> list[Hit]:
    """Everything on a sheet that is in the way of reading it; empty for a good one."""
    ink = _Ink(document)
    return [
        *_lost(ink),
        *_texts_on_texts(ink),
        *_texts_on_lines(ink),
        *_symbols_on_parts(ink),
        *_off_the_sheet(document, ink),
        *_shared_lines(ink),
        *_values(document, ink),
        *_unsound(document),
    ]


def _lost(ink: _Ink) -> Iterator[Hit]:
    for what in ink.lost:
        yield Hit("viewport", f"{what} is cut by its viewport, or in none", (0.0, 0.0))


def _texts_on_texts(ink: _Ink) -> Iterator[Hit]:
    placed = sorted(((_box(text.corners()), text) for text in ink.texts), key=lambda pair: pair[0][0])
    for i, (box, one) in enumerate(placed):
        for below, other in placed[i + 1 :]:
            if below[0] >= box[2]:
                break
            if below[1] >= box[3] or below[3] <= box[1] or _apart(one, other) or _apart(other, one):
                continue
            yield Hit("text", f"'{one.words}' is over '{other.words}'", one.middle)


def _apart(one: _Text, other: _Text) -> bool:
    """Whether one text's own frame has a straight line between the two."""
    seen = [one.seen_from(corner) for corner in other.corners()]
    for axis in (0, 1):
        low, high = min(p[axis] for p in seen), max(p[axis] for p in seen)
        if low > one.half[axis] - TOUCH or high < -one.half[axis] + TOUCH:
            return True
    return False


def _texts_on_lines(ink: _Ink) -> Iterator[Hit]:
    lines = SegmentIndex()
    lines.add([*ink.sheet_lines, *ink.view_lines])
    for text in ink.texts:
        near = lines.near(_box(text.corners()))
        for line in near:
            (x0, y0), (x1, y1) = text.seen_from(line[:2]), text.seen_from(line[2:])
            half = (text.half[0] - TOUCH, text.half[1] - TOUCH)
            if _reaches((x0, y0, x1, y1), half):
                yield Hit("line", f"'{text.words}' is over a line", text.middle)
                break


def _symbols_on_parts(ink: _Ink) -> Iterator[Hit]:
    """Symbols, and frames of tolerances and datum letters, that stand on the part."""
    lines = SegmentIndex()
    lines.add(ink.part_lines)
    for box in ink.symbols:
        if lines.count_in((box[0] + TOUCH, box[1] + TOUCH, box[2] - TOUCH, box[3] - TOUCH)):
            yield Hit("line", "a symbol, or the frame of a tolerance or datum, is over the part", box[:2])


def _reaches(line: Line, half: Point2) -> bool:
    """Whether a line reaches into the box about the origin with these half sides."""
    x0, y0, x1, y1 = line
    if max(x0, x1) <= -half[0] or min(x0, x1) >= half[0] or max(y0, y1) <= -half[1] or min(y0, y1) >= half[1]:
        return False
    dx, dy = x1 - x0, y1 - y0
    return abs(dy * x0 - dx * y0) < abs(dx) * half[1] + abs(dy) * half[0]


def _off_the_sheet(document: Drawing, ink: _Ink) -> Iterator[Hit]:
    frames = sorted(_frames(document), key=_area, reverse=True)
    if not frames:
        yield Hit("frame", "the sheet has no frame", (0.0, 0.0))
        return
    x0, y0, x1, y1 = frames[0]
    for text in ink.view_texts:
        if any(not (x0 < x < x1 and y0 < y < y1) for x, y in text.corners()):
            yield Hit("frame", f"'{text.words}' is outside the frame", text.middle)
    lines = SegmentIndex()
    lines.add(ink.view_lines)
    outside = lines.outside((x0, y0, x1, y1))
    if outside:
        yield Hit("frame", f"{len(outside)} lines are outside the frame", outside[0][:2])
    for title in frames[1:]:
        if lines.count_in(title):
            yield Hit("title block", "lines of a view are over the title block", title[:2])
        for text in ink.view_texts:
            box = _box(text.corners())
            if box[0] < title[2] and title[0] < box[2] and box[1] < title[3] and title[1] < box[3]:
                yield Hit("title block", f"'{text.words}' is over the title block", text.middle)


def _frames(document: Drawing) -> Iterator[Box2]:
    """Frame and title block: the closed rectangles in the heavy line."""
    for entity in document.paperspace():
        if entity.dxftype() == "LWPOLYLINE" and entity.dxf.layer == "FRAME":
            points = _points(entity)
            if len(points) == 5 and math.dist(points[0], points[-1]) < 1e-9:
                yield _box(points)


def _shared_lines(ink: _Ink) -> Iterator[Hit]:
    """Dimension lines that run on top of one another."""
    placed: list[tuple[Point2, Point2, str]] = []
    for dimension in ink.dimensions:
        d = dimension.dxf
        if d.dimtype & 7 != 0:
            continue
        turn = math.radians(d.angle)
        u = (math.cos(turn), math.sin(turn))
        window = next((w for w in ink.windows if w.shows((d.defpoint.x, d.defpoint.y))), None)
        if window is None:
            continue
        reach = [(p.x - d.defpoint.x) * u[0] + (p.y - d.defpoint.y) * u[1] for p in (d.defpoint2, d.defpoint3)]
        start, end = (
            window.to_paper((d.defpoint.x + r * u[0], d.defpoint.y + r * u[1])) for r in (min(reach), max(reach))
        )
        for other in placed:
            if _on_one_line((start, end), other[:2]):
                yield Hit("dimensions", f"dimension lines of {d.text} and {other[2]} run on one line", start)
        placed.append((start, end, d.text))


def _on_one_line(one: tuple[Point2, Point2], other: tuple[Point2, Point2]) -> bool:
    size = math.dist(*one)
    if size < 1e-9:
        return False
    u = ((one[1][0] - one[0][0]) / size, (one[1][1] - one[0][1]) / size)
    off = [(p[0] - one[0][0]) * -u[1] + (p[1] - one[0][1]) * u[0] for p in other]
    at = [(p[0] - one[0][0]) * u[0] + (p[1] - one[0][1]) * u[1] for p in other]
    return max(map(abs, off)) < 1.0 and min(max(at), size) - max(min(at), 0.0) > TOUCH


def _values(document: Drawing, ink: _Ink) -> Iterator[Hit]:
    """Dimensions whose picture does not say what their points measure."""
    for dimension in ink.dimensions:
        measured = dimension.get_measurement()
        if not isinstance(measured, float):
            continue
        decimals = document.dimstyles.get(dimension.dxf.dimstyle).dxf.dimdec
        said = _decoded(dimension.dxf.text.replace("<>", f"{measured:.{decimals}f}"))
        shown = "".join(part.plain_text() for part in drawn(document, [dimension]) if part.dxftype() == "TEXT")
        if "<>" not in dimension.dxf.text or _decoded(said) != _decoded(shown):
            at = (dimension.dxf.defpoint.x, dimension.dxf.defpoint.y)
            window = next((w for w in ink.windows if w.shows(at)), None)
            yield Hit("value", f"'{shown}' is drawn, '{said}' is measured", window.to_paper(at) if window else at)


def _decoded(text: str) -> str:
    return text.replace("%%c", "Ø").replace("%%d", "°").replace("%%p", "±").replace("⌀", "Ø")


def _unsound(document: Drawing) -> Iterator[Hit]:
    auditor = document.audit()
    for error in (*auditor.errors, *auditor.fixes):
        yield Hit("file", f"DXF audit: {error.message}", (0.0, 0.0))


def _text(entity: Any, window: Window | None) -> _Text:
    size = text_size(entity)
    scale = window.scale if window else 1.0
    turn = math.radians(entity.dxf.rotation)
    align, first, second = entity.get_placement()
    at = (second or first) if align.name != "LEFT" else first
    shift = {"LEFT": 0.5, "CENTER": 0.0, "RIGHT": -0.5}[align.name] * size.width
    c, s = math.cos(turn), math.sin(turn)
    up = size.cap_height / 2
    middle = (at.x + shift * c - up * s, at.y + shift * s + up * c)
    if window:
        middle = window.to_paper(middle)
    return _Text(entity.plain_text(), middle, (size.width * scale / 2, size.cap_height * scale / 2), turn)


def _points(entity: Any) -> list[Point2]:
    """Points along an entity, in its own space."""
    d = entity.dxf
    match entity.dxftype():
        case "LINE":
            return [(d.start.x, d.start.y), (d.end.x, d.end.y)]
        case "LWPOLYLINE":
            return [(x, y) for x, y, *_ in entity.lwpoints]
        case "CIRCLE":
            return arc_points(Arc((d.center.x, d.center.y), d.radius))
        case "ARC":
            return arc_points(Arc((d.center.x, d.center.y), d.radius, d.start_angle, d.end_angle))
        case "SOLID":
            corners = [(p.x, p.y) for p in (d.vtx0, d.vtx1, d.vtx3, d.vtx2)]
            return [*corners, corners[0]]
        case "HATCH":
            return [(x, y) for path in entity.paths for x, y, *_ in path.vertices]
        case "TEXT":
            return [(d.insert.x, d.insert.y)]
        case kind:
            raise ValueError(f"a sheet has no {kind}")


def _box(points: Iterable[Point2]) -> Box2:
    xs, ys = zip(*points)
    return (min(xs), min(ys), max(xs), max(ys))


def _area(box: Box2) -> float:
    return (box[2] - box[0]) * (box[3] - box[1])
