"""Leaders and dimension lines of a finished sheet, read from its DXF document, and whether the leaders are unambiguous.

A leader ends on a line of the part, alone, clear of datum triangles, dimension lines and other leaders; that of a
diameter or radius on an arc of this radius. A tolerance zone in the shape of a cylinder applies to an axis: its leader
is in line with the dimension line of the diameter (ISO 1101).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

from ezdxf.document import Drawing

from drawings.export.dxf_reading import PaperContent, entity_points, visible_entities
from drawings.views.bounding_box import bounding_box
from drawings.views.segment_index import Line, SegmentIndex, enlarged, points_beside, polyline_lines
from drawings.views.view import Point2

LEADER_END = 0.6
"""Half side of the box about the end of a leader in which a line of the part must lie, mm on paper."""
TOUCH = 0.05
"""Overlap from which on something touches something else, mm on paper."""
ONE_POINT = 0.5
"""Distance below which two leaders end at one point, and a leader ends on a dimension line, mm on paper."""
ALONG = 0.7
"""Distance below which the line under a text runs along another line, mm on paper."""
ON_ARC = 0.35
"""Greatest distance of a drawn line from the arc on which the leader of a radius ends, mm on paper."""
CYLINDRICAL = re.compile(r"^[Ø⌀]\d+(\.\d+)?( CZ)?$")
"""Tolerance of an axis in a control frame."""


@dataclass(frozen=True)
class Leader:
    """A leader, or the stem and triangle of a datum symbol, in paper coordinates.

    Args:
        points: from its end on the feature.
        sides: of the triangle of a datum.
        centre: of the arc of a diameter or radius.
    """

    points: tuple[Point2, ...]
    sides: tuple[Line, ...] = ()
    centre: Point2 | None = None

    @property
    def tip(self) -> Point2:
        return self.points[0]

    @property
    def lines(self) -> tuple[Line, ...]:
        return (*polyline_lines(self.points), *self.sides)


@dataclass(frozen=True)
class DimensionLine:
    """The dimension line of a distance, and its extension lines, in paper coordinates."""

    text: str
    line: Line
    extensions: tuple[Line, ...]


def leader_faults(document: Drawing, content: PaperContent) -> Iterator[tuple[str, Point2]]:
    """Descriptions and places of ambiguous leaders."""
    leaders = [*_of_annotations(document, content), *_of_radii(document, content)]
    distances = [*dimension_lines(document, content), *sight_lines(document, content)]
    part, edges = SegmentIndex(content.part_lines), SegmentIndex(content.edges)
    for leader in leaders:
        yield from _end(leader, part, distances, content)
        yield from _over_dimension_lines(leader, distances)
        yield from _along_lines(leader, edges, distances)
    for number, leader in enumerate(leaders):
        for other in leaders[:number]:
            if not (leader.sides or other.sides) and math.dist(leader.tip, other.tip) < ONE_POINT:
                yield "two leaders end at one point", leader.tip
            index = SegmentIndex(other.lines)
            arrows = [one.tip for one in (leader, other) if not one.sides]
            if any(_is_on(tip, triangle) for tip in arrows for triangle in content.triangles):
                continue
            if any(index.count_crossing(line) for line in leader.lines):
                yield "two leaders cross, or one crosses a datum symbol", leader.tip
    yield from _axial_tolerances(content, leaders, distances)


def dimension_lines(document: Drawing, content: PaperContent) -> Iterator[DimensionLine]:
    """The dimension lines of all distances."""
    for dimension in content.dimensions:
        d = dimension.dxf
        viewport = content.viewport_of([(d.defpoint.x, d.defpoint.y)])
        if d.dimtype & 7 != 0 or viewport is None:
            continue
        turn, foot = math.radians(d.angle), viewport.to_paper((d.defpoint.x, d.defpoint.y))
        lines: list[Line] = []
        for entity in visible_entities(document, [dimension]):
            if entity.dxftype() == "LINE":
                lines += polyline_lines([viewport.to_paper(point) for point in entity_points(entity)])
        along = [line for line in lines if _off(foot, line[:2], turn) < TOUCH and _off(foot, line[2:], turn) < TOUCH]
        rest = tuple(line for line in lines if line not in along)
        for line in along:
            yield DimensionLine(d.text, line, rest)


def sight_lines(document: Drawing, content: PaperContent) -> Iterator[DimensionLine]:
    """Cutting lines, and arrows in the direction of sight: no leader may cross them or end on them."""
    for entity in document.modelspace().query("LINE"):
        points = entity_points(entity)
        viewport = content.viewport_of(points)
        if viewport is None:
            continue
        start, end = map(viewport.to_paper, points)
        arrow = any(math.dist(end, tip) < TOUCH for tip in content.sight_arrows)
        if arrow or entity.dxf.layer == "SECTION":
            yield DimensionLine("", (*start, *end), ())


def _off(foot: Point2, point: Point2, turn: float) -> float:
    return abs((point[1] - foot[1]) * math.cos(turn) - (point[0] - foot[0]) * math.sin(turn))


def _of_annotations(document: Drawing, content: PaperContent) -> Iterator[Leader]:
    """Leaders of callouts and control frames, and datum symbols: lines that begin at an arrow or at a triangle."""
    for entity in document.modelspace():
        if entity.dxftype() not in ("LINE", "LWPOLYLINE") or entity.dxf.layer != "DIMENSION":
            continue
        points = entity_points(entity)
        viewport = content.viewport_of(points)
        if viewport is None:
            continue
        paper = tuple(map(viewport.to_paper, points))
        if any(math.dist(paper[0], tip) < TOUCH for tip in content.leaders):
            yield Leader(paper)
        for triangle in content.triangles:
            base = [corner for corner in triangle if math.dist(corner, paper[0]) > TOUCH]
            if len(base) == 2:
                foot = ((base[0][0] + base[1][0]) / 2, (base[0][1] + base[1][1]) / 2)
                sides = tuple((*paper[0], *corner) for corner in base)
                yield Leader((foot, *paper), sides)


def _of_radii(document: Drawing, content: PaperContent) -> Iterator[Leader]:
    for dimension in content.dimensions:
        d = dimension.dxf
        if d.dimtype & 7 not in (3, 4):
            continue
        ends = [(d.defpoint4.x, d.defpoint4.y), (d.defpoint.x, d.defpoint.y)]
        viewport = content.viewport_of(ends[:1])
        if viewport is None:
            continue
        tip, other = map(viewport.to_paper, ends)
        centre = ((tip[0] + other[0]) / 2, (tip[1] + other[1]) / 2) if d.dimtype & 7 == 3 else other
        for entity in visible_entities(document, [dimension]):
            if entity.dxftype() == "LWPOLYLINE" and len(points := entity_points(entity)) == 3:
                yield Leader(tuple(map(viewport.to_paper, points)), centre=centre)


def _end(
    leader: Leader, part: SegmentIndex, distances: list[DimensionLine], content: PaperContent
) -> Iterator[tuple[str, Point2]]:
    tip = leader.tip
    aligned = any(_in_line(leader, one.line) for one in distances)
    if not aligned and any(_distance(tip, one.line) < ONE_POINT for one in distances):
        yield "a leader ends on a dimension line, or on the line or arrow of a section", tip
    if leader.sides:
        return
    if not aligned and not part.count_in(enlarged((*tip, *tip), LEADER_END)):
        yield "a leader ends where no line of the part is", tip
    for triangle in content.triangles:
        if not aligned and _is_on(tip, triangle):
            yield "a leader ends on the triangle of a datum", tip
    if leader.centre:
        beside = points_beside(tip, leader.centre)
        if not all(part.count_in(enlarged((*point, *point), ON_ARC)) for point in beside):
            yield "the leader of a diameter or radius ends beside its arc", tip


def _is_on(point: Point2, triangle: tuple[Point2, ...]) -> bool:
    x0, y0, x1, y1 = enlarged(bounding_box(triangle), TOUCH)
    return x0 < point[0] < x1 and y0 < point[1] < y1


def _over_dimension_lines(leader: Leader, distances: list[DimensionLine]) -> Iterator[tuple[str, Point2]]:
    for one in distances:
        index = SegmentIndex([_with_arrows(one.line)])
        if any(index.count_crossing(line) for line in leader.lines):
            crossed = f"dimension line of {one.text}" if one.text else "line or arrow of a section or view"
            yield f"a leader crosses the {crossed}", leader.tip


def _with_arrows(line: Line) -> Line:
    """A dimension line with half the width of its arrow heads at its ends."""
    length = max(math.dist(line[:2], line[2:]), 1e-9)
    u, v = ONE_POINT * (line[2] - line[0]) / length, ONE_POINT * (line[3] - line[1]) / length
    return (line[0] - u, line[1] - v, line[2] + u, line[3] + v)


def _along_lines(leader: Leader, edges: SegmentIndex, distances: list[DimensionLine]) -> Iterator[tuple[str, Point2]]:
    """A leader along an edge of the part; the line next to its text along a line of the part or of a dimension."""
    if not leader.sides and edges.count_parallel((*leader.points[0], *leader.points[1]), ALONG):
        yield "a leader runs along an edge of the part", leader.tip
    if len(leader.points) != 3 or leader.sides:
        return
    shelf: Line = (*leader.points[1], *leader.points[2])
    others = SegmentIndex([line for one in distances for line in (one.line, *one.extensions)])
    if edges.count_parallel(shelf, ALONG) or others.count_parallel(shelf, ALONG):
        yield "the line of a leader next to its text runs along another line", leader.points[1]


def _axial_tolerances(
    content: PaperContent, leaders: list[Leader], distances: list[DimensionLine]
) -> Iterator[tuple[str, Point2]]:
    """Tolerances of an axis on a leader that is not in line with a dimension line."""
    for text in content.view_texts:
        if not CYLINDRICAL.match(text.text):
            continue
        frames = [
            box for box in content.symbols if box[0] < text.middle[0] < box[2] and box[1] < text.middle[1] < box[3]
        ]
        for x0, y0, x1, y1 in frames:
            # The first compartment, with the sign of the characteristic, is next to it.
            whole = enlarged((x0 - 2 * (y1 - y0), y0, x1 + (y1 - y0), y1), TOUCH)
            for leader in leaders:
                x, y = leader.points[-1]
                own = len(leader.points) == 2 and whole[0] < x < whole[2] and whole[1] < y < whole[3]
                if own and not any(_in_line(leader, one.line) for one in distances):
                    yield f"the tolerance {text.text} of an axis is not in line with a dimension line", leader.tip


def _in_line(leader: Leader, line: Line) -> bool:
    """Whether a leader continues a dimension line."""
    length = math.dist(line[:2], line[2:])
    if length < 1e-9 or _distance(leader.tip, line) > ONE_POINT:
        return False
    turn = math.atan2(line[3] - line[1], line[2] - line[0])
    return all(_off(line[:2], point, turn) < TOUCH for point in leader.points[:2])


def _distance(point: Point2, line: Line) -> float:
    """Distance of a point from a straight line between two ends."""
    (x0, y0), (x1, y1) = line[:2], line[2:]
    size = (x1 - x0) ** 2 + (y1 - y0) ** 2
    t = max(0.0, min(1.0, ((point[0] - x0) * (x1 - x0) + (point[1] - y0) * (y1 - y0)) / size)) if size else 0.0
    return math.dist(point, (x0 + t * (x1 - x0), y0 + t * (y1 - y0)))
