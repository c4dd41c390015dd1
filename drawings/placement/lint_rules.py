"""Occupancy of the paper around views, and the conflicts of an annotation with what is drawn there already.

A text must not touch anything; a line must not pass through a text; lines may cross lines at a cost. A leader ends on a
line of the part, alone, clear of datum triangles, dimension lines and other leaders; that of a diameter or radius on an
arc of this radius. Placement asks for the conflicts of each candidate while the sheet grows, lint for those of a
finished sheet (`drawings.lint`).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from drawings.annotations.annotation import (
    TARGET,
    Annotation,
    Callout,
    DatumSymbol,
    DatumTarget,
    DetailMark,
    FeatureControlFrame,
    LinearDimension,
    RadialDimension,
    ReferenceArrow,
    SectionMark,
    text_box,
)
from drawings.annotations.primitives import TEXT_HEIGHT, ArcStroke, FilledPolygon, Primitive, Stroke, Text
from drawings.annotations.symbols import BOX_RISE, symbol_text_width
from drawings.views.segment_index import (
    Line,
    SegmentIndex,
    arc_points,
    count_meetings,
    curve_points,
    enlarged,
    line_box,
    line_meets_box,
    points_beside,
    polyline_lines,
)
from drawings.views.view import Box2, Layer, Point2, View, bounding_box, direction, enclosing_box, offset

OUTLINE: tuple[Layer, ...] = ("VISIBLE", "HIDDEN")
"""Layers of the edges of the part, without centre lines and hatch."""
LEADER_TIP = 0.3
"""Half side of the box about the tip of a leader in which a line of the part must lie, mm."""
CALLOUT_TIP = 0.5
"""Half side of that box for a callout, which may end between the two lines of a chamfer, mm."""
SELF_CLEARANCE, TEXT_CLEARANCE, LINE_CLEARANCE = 0.2, 1.2, 0.4
"""Clearance of a text from the lines of its own annotation, from everything else, and of a line from a text, mm."""
FRAME_REACH = 1.0
"""Distance by which a control frame within a callout exceeds its line of text, mm."""
ONE_POINT, ALONG = 0.8, 1.0
"""Distance below which two leaders end at one point or one ends on a dimension line, and below which the line under a
text runs along another line, mm."""
TRIANGLE = 2.8
"""Distance from the foot of a datum triangle below which a leader ends on the triangle, mm."""
DIMENSION_LINE_SPACING = 6.0
"""Least distance of parallel dimension lines, mm."""
CROSSES_LINE = "a leader crosses a dimension line, or the line or arrow of a section or view"
ENDS_ON_LINE = "a leader ends on a dimension line, or on the line or arrow of a section"


@dataclass(frozen=True)
class Footprint:
    """Area of the paper that one annotation occupies."""

    texts: list[Box2]  # bounding boxes of the texts
    lines: list[Line]  # all other lines
    dimension_lines: list[Line]  # those of `lines` that need distance from parallel dimension lines
    # whether an own line that meets an own text is a conflict. False for a text at an angle, whose bounding box is
    # larger than the text, for a number in a frame, which is closer to its own line than another text may be, and where
    # text and lines cannot meet
    own_text_checked: bool = True
    leaders: tuple[Line, ...] = ()  # those of `lines` that are a leader, or the stem and triangle of a datum symbol
    shelf: Line | None = None  # line under a text, or before it, at the end of a leader

    @property
    def boxes(self) -> list[Box2]:
        """Bounding boxes of all texts and lines."""
        return [*self.texts, *map(line_box, self.lines)]


class Occupancy:
    """Elements drawn so far around views in their places on the paper."""

    def __init__(self, *views: View) -> None:
        self.outline_lines, self.part_lines = SegmentIndex(), SegmentIndex()
        self.annotation_lines = SegmentIndex()
        self._texts, self._dimension_lines = SegmentIndex(), SegmentIndex()  # texts as diagonals of their boxes
        self.dimension_index, self.leader_index = SegmentIndex(), SegmentIndex()
        self.leader_tips: list[Point2] = []
        self.datum_feet: list[Point2] = []
        self._boxes: list[Box2] = []
        for view in views:
            part = view_lines(view)
            self.outline_lines.add(view_lines(view, OUTLINE))
            self.part_lines.add(part)
            self._boxes += [enclosing_box([line_box(line) for line in part])] if part else []

    @property
    def box(self) -> Box2:
        """Bounding box of everything."""
        return enclosing_box(self._boxes)

    def add(self, annotation: Annotation, view: View, footprint: Footprint | None = None) -> None:
        """Enter an annotation, with its footprint if there is one already."""
        footprint = footprint or footprint_of(annotation, view)
        tip = annotation.leader_tip(view)
        self.leader_tips += [tip] if tip else []
        if tip and isinstance(annotation, DatumSymbol):
            self.datum_feet.append(tip)
        self._texts.add(footprint.texts)
        self.annotation_lines.add(footprint.lines)
        self._dimension_lines.add(footprint.dimension_lines)
        if isinstance(annotation, LinearDimension):
            self.dimension_index.add([_lengthened(line, ONE_POINT) for line in footprint.dimension_lines])
        elif isinstance(annotation, SectionMark | ReferenceArrow):
            self.dimension_index.add(footprint.lines)
        self.leader_index.add(footprint.leaders)
        self._boxes += footprint.boxes

    def add_text(self, box: Box2) -> None:
        """Enter a text by its bounding box."""
        self._texts.add([box])
        self._boxes.append(box)

    def is_on_outline(self, point: Point2) -> bool:
        """Whether an edge of the part is drawn at a point."""
        return bool(self.outline_lines.count_in(enlarged((*point, *point), LEADER_TIP)))

    def continues_dimension_line(self, tip: Point2, footprint: Footprint) -> bool:
        """Whether a leader is in line with a dimension line that ends at its tip: it applies to an axis."""
        box = enlarged((*tip, *tip), ONE_POINT)
        ended_on = [line for line in self.dimension_index.near(box) if line_meets_box(line, box)]
        return any(in_line(line, footprint.leaders[:1]) for line in ended_on)

    def end_faults(self, annotation: Annotation, view: View) -> Iterator[str]:
        """What is wrong with the end of the leader of an annotation on the part."""
        point, tip = annotation.attachment(view), annotation.leader_tip(view)
        if point and not self.is_on_outline(point):
            yield "a leader ends where no line of the part is"
        if point and isinstance(annotation, RadialDimension):
            beside = points_beside(point, view.to_paper(annotation.centre))
            if not all(map(self.is_on_outline, beside)):
                yield "the leader of a diameter or radius ends beside its arc"
        callout = tip if isinstance(annotation, Callout) else None
        if callout and not self.part_lines.count_in(enlarged((*callout, *callout), CALLOUT_TIP)):
            yield "a leader ends where no line of the part is"

    def leader_conflicts(self, annotation: Annotation, view: View, footprint: Footprint) -> Iterator[tuple[str, int]]:
        """Conflicts of the leader of an annotation, each with its number: leaders, dimension lines and cutting lines
        that it crosses or on which it ends, leaders with the same end, edges and lines along which it runs. For a
        linear dimension also leaders that its dimension line crosses or meets."""
        tip = annotation.leader_tip(view)
        yield CROSSES_LINE, self.dimension_index.count_crossing(*footprint.leaders)
        yield "two leaders cross, or one crosses a datum symbol", self.leader_index.count_crossing(*footprint.leaders)
        if isinstance(annotation, LinearDimension):
            longer = [_lengthened(line, ONE_POINT) for line in footprint.dimension_lines]
            yield CROSSES_LINE, self.leader_index.count_crossing(*longer)
            near = [enlarged((*other, *other), ONE_POINT) for other in self.leader_tips]
            yield ENDS_ON_LINE, sum(line_meets_box(line, box) for line in footprint.dimension_lines for box in near)
        if tip:
            yield "two leaders end at one point", sum(math.dist(tip, other) < ONE_POINT for other in self.leader_tips)
            feet = self.leader_tips if isinstance(annotation, DatumSymbol) else ()
            ends = sum(math.dist(tip, other) < TRIANGLE for other in (*self.datum_feet, *feet))
            yield "a leader ends on the triangle of a datum", ends
            box = enlarged((*tip, *tip), ONE_POINT)
            ended_on = [line for line in self.dimension_index.near(box) if line_meets_box(line, box)]
            yield ENDS_ON_LINE, sum(not in_line(line, footprint.leaders[:1]) for line in ended_on)
        along = self.outline_lines.count_beside(ALONG, *footprint.leaders[:2])[0]
        yield "a leader runs along an edge of the part", along
        if footprint.shelf:
            beside = self.annotation_lines.count_beside(ALONG, footprint.shelf)[0]
            yield "the line of a leader next to its text runs along another line", beside

    def near_dimension_lines(self, footprint: Footprint) -> int:
        """Number of dimension lines of an annotation that are too near to another one."""
        return self._dimension_lines.count_beside(DIMENSION_LINE_SPACING, *footprint.dimension_lines)[1]

    def line_conflicts(self, footprint: Footprint, most: float = math.inf) -> int:
        """Number of an annotation's lines that cross texts, and of its dimension lines too near to another one."""
        conflicts = self.near_dimension_lines(footprint)
        if not footprint.lines or conflicts >= most:
            return conflicts
        if footprint.own_text_checked:
            conflicts += count_meetings(footprint.lines, footprint.texts, SELF_CLEARANCE)
        return conflicts + self._texts.count_into(footprint.lines, LINE_CLEARANCE)

    def text_conflicts(self, box: Box2, clearance: float = TEXT_CLEARANCE) -> int:
        """Number of lines and texts that a text would touch."""
        wide = enlarged(box, clearance)
        touched = self.part_lines.count_in(wide) + self.annotation_lines.count_in(wide)
        return touched + len(self.touched_texts(box, clearance))

    def touched_texts(self, box: Box2, clearance: float = TEXT_CLEARANCE) -> list[int]:
        """Numbers of the texts, in the order of their entry, that a text would touch."""
        return self._texts.numbers_near(enlarged(box, clearance))


def view_outline(view: View) -> Box2:
    """Bounding box of the edges of the part in a view at the origin of the paper; of a detail, that of its circle."""
    if view.clip:
        (u, v), radius = view.clip
        return enlarged((u * view.scale, v * view.scale, u * view.scale, v * view.scale), radius * view.scale)
    return enclosing_box([line_box(line) for line in view_lines(replace(view, place=(0.0, 0.0)), OUTLINE)])


def view_lines(view: View, layers: Sequence[Layer] = ()) -> list[Line]:
    """Straight lines on the paper that approximate the curves of a view, of all layers or of some."""
    return [
        line
        for layer, curves in view.curves.items()
        if not layers or layer in layers
        for curve in curves
        for line in polyline_lines([view.to_paper(point) for point in curve_points(curve, view.scale)])
    ]


def footprint_of(annotation: Annotation, view: View) -> Footprint:
    """Area of the paper that an annotation of a view occupies."""
    primitives = list(annotation.primitives(view))
    texts = [text_box(item) for item in primitives if isinstance(item, Text)]
    lines = [line for item in primitives for line in primitive_lines(item)]
    match annotation:
        case LinearDimension():
            u, v = direction(annotation.angle)
            dimension_line = max(lines, key=lambda line: abs((line[2] - line[0]) * u + (line[3] - line[1]) * v))
            slanting = annotation.angle not in (0.0, 90.0)
            texts = _slices(primitives) if slanting else [enclosing_box(texts)] if texts else []
            if "{box:" in annotation.text:
                # The frame of the number counts as text.
                texts = [enlarged(texts[0], BOX_RISE * TEXT_HEIGHT)]
                lines = [line for line in lines if not _is_within(line, enlarged(texts[0], 0.1))]
            checked = not slanting and "{box:" not in annotation.text
            return Footprint(texts, lines, [dimension_line], checked)
        case FeatureControlFrame() | DatumSymbol():
            # The whole frame counts as text.
            cells = [item.points for item in primitives if isinstance(item, Stroke) and len(item.points) == 5]
            frame = enclosing_box([(*points[0], *points[2]) for points in cells])
            outside = [line for line in lines if not _is_within(line, enlarged(frame, 0.1))]
            if isinstance(annotation, DatumSymbol):
                # The stem, and the two sides of the triangle that meet in it.
                apex, *base = next(item.points for item in primitives if isinstance(item, FilledPolygon))
                leader = (*_leader(primitives), *((*apex, *corner) for corner in base))
            else:
                leader = tuple(line for line in _leader(primitives) if line in outside)
            return Footprint([frame], outside, [], False, leader)
        case Callout():
            # Symbols within the text count as text; the rest is the leader.
            texts = annotation.boxes
            near = [enlarged(box, FRAME_REACH) for box in texts]
            outside = [line for line in lines if not any(_is_within(line, box) for box in near)]
            leader = _leader(primitives)
            return Footprint(texts, outside, [], leaders=leader, shelf=leader[-1])
        case RadialDimension():
            leader = _leader(primitives)
            return Footprint(texts, lines, [], leaders=leader, shelf=leader[-1])
        case DatumTarget():
            # The whole circle counts as text.
            circle = enlarged((*annotation.circle_at, *annotation.circle_at), TARGET)
            outside = [line for line in lines if not _is_within(line, enlarged(circle, 0.1))]
            end = view.to_paper(annotation.at)
            return Footprint([circle], outside, [], False, tuple(line for line in outside if line[2:] == end))
        case SectionMark():
            # Dimension lines keep away from the stems of the arrows.
            u, v = annotation.sight
            stems = [(x, y, x + 9.0 * u, y + 9.0 * v) for x, y in (annotation.start, annotation.end)]
            return Footprint(texts, lines, stems, False)
        case _:
            return Footprint(texts, lines, [], not isinstance(annotation, DetailMark | ReferenceArrow))


def _slices(primitives: Sequence[Primitive]) -> list[Box2]:
    """Boxes of the pieces of a slanting text, each as long as the text is high."""
    boxes = []
    for text in primitives:
        if isinstance(text, Text):
            width, u = symbol_text_width(text.text, text.height), direction(text.angle)
            count = max(1, math.ceil(width / text.height))
            start = {"left": 0.0, "middle": -width / 2, "right": -width}[text.alignment]
            for number in range(count):
                along = [start + width * step / count for step in (number, number + 1)]
                corners = [offset(text.at, u, a, b) for a in along for b in (0.0, text.height)]
                boxes.append(bounding_box(corners))
    return boxes


def _leader(primitives: Sequence[Primitive]) -> tuple[Line, ...]:
    """Lines of the leader: the first line of a callout, radius or control frame."""
    return tuple(polyline_lines(next(item for item in primitives if isinstance(item, Stroke)).points))


def _is_within(line: Line, box: Box2) -> bool:
    (x0, y0, x1, y1), (low_x, low_y, high_x, high_y) = line, box
    return low_x <= x0 <= high_x and low_x <= x1 <= high_x and low_y <= y0 <= high_y and low_y <= y1 <= high_y


def primitive_lines(item: Primitive) -> list[Line]:
    """Straight lines that approximate a primitive; none for a text."""
    match item:
        case Stroke():
            return polyline_lines(item.points)
        case ArcStroke():
            return polyline_lines(arc_points(item.arc))
        case FilledPolygon():
            return polyline_lines((*item.points, item.points[0]))
        case _:
            return []


def _lengthened(line: Line, by: float) -> Line:
    """A line made longer at both ends."""
    length = max(math.dist(line[:2], line[2:]), 1e-9)
    u, v = by * (line[2] - line[0]) / length, by * (line[3] - line[1]) / length
    return (line[0] - u, line[1] - v, line[2] + u, line[3] + v)


def in_line(line: Line, others: Sequence[Line]) -> bool:
    """Whether a line is parallel to all others, as a datum symbol is to the dimension line that it continues."""
    dx, dy = line[2] - line[0], line[3] - line[1]
    return all(abs(dx * (y1 - y0) - dy * (x1 - x0)) < 1e-6 for x0, y0, x1, y1 in others)
