"""Annotations of a sheet with their places: dimensions, callouts, tolerances, datums, marks, notes.

Coordinates are either view coordinates (mm at 1:1, so that a DIMENSION entity measures the part's true size) or paper
coordinates (mm). `names` are the declarations that an annotation shows; each is on a sheet once. Proportions according
to ISO 129-1.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Annotated, Any, Literal, Self, get_args

from drawings.annotations.primitives import (
    LARGE_HEIGHT,
    LAYERS,
    LINE_PITCH,
    TEXT_HEIGHT,
    THICK,
    ArcStroke,
    FilledPolygon,
    Primitive,
    Stroke,
    Symbol,
    Text,
    rectangle,
    turned,
)
from drawings.annotations.symbols import symbol_primitives, symbol_text_primitives, symbol_text_width, symbol_width
from drawings.views.view import (
    Arc,
    Box2,
    Point2,
    View,
    bounding_box,
    direction,
    distance_along,
    extreme_points,
    offset,
    view_box,
)

ARROW = 3.0
"""Length of an arrow head, mm; its width is a third of it."""
GAP = 1.0
"""Gap between the part and the start of an extension line, and between a dimension line and its text, mm."""
BEYOND = 2.0
"""Length of an extension line past the dimension line, mm."""
TAIL = 5.0
"""Length of a dimension line outside its extension lines, where the arrow heads do not fit between them, mm."""
LANDING = 3.0
"""Horizontal end of a leader before the text, mm."""
BOX = 2 * TEXT_HEIGHT
"""Height of a feature control frame and of a datum letter's frame, mm."""
BALLOON = 5.0
"""Radius of a balloon, mm."""
TARGET, CROSS = 6.0, 3.0
"""Radius of the circle of a datum target, and size of its cross, mm."""
DOT = 0.6
"""Radius of the dot at the end of a balloon's leader, mm."""
THICK_END, STEM = 6.0, 9.0
"""Lengths of a cutting line's thick end and of its arrow, mm."""


def readable(angle: float) -> float:
    """The angle at which a text along a line is read from below or from the right, degrees: up to 30 degrees beyond
    the vertical from the right (ISO 129-1)."""
    return round((angle + 60.0) % 180.0 - 60.0, 9)


def _unit(start: Point2, end: Point2) -> Point2:
    """Unit vector from one point to another; to the right where they coincide."""
    length = math.dist(start, end)
    return ((end[0] - start[0]) / length, (end[1] - start[1]) / length) if length > 1e-9 else (1.0, 0.0)


def _opposite(u: Point2) -> Point2:
    return (-u[0], -u[1])


def _arrow(tip: Point2, way: Point2, length: float = ARROW) -> FilledPolygon:
    """A closed, filled arrow head whose tip points along a unit vector."""
    half = length / 6
    return FilledPolygon((tip, offset(tip, way, -length, half), offset(tip, way, -length, -half)))


def _centred(text: str, at: Point2, height: float = TEXT_HEIGHT, angle: float = 0.0) -> Text:
    """A text whose middle is at a point."""
    return Text(text, offset(at, direction(angle), 0.0, -height / 2), height, "middle", angle)


def _centred_line(text: str, at: Point2, angle: float = 0.0) -> Iterator[Primitive]:
    """A text with its symbols whose middle is at a point."""
    if "{" in text:
        start = (at[0] - symbol_text_width(text) / 2, at[1] - TEXT_HEIGHT / 2)
        yield from (turned(piece, at, angle) if angle else piece for piece in symbol_text_primitives(text, start))
    else:
        yield _centred(text, at, TEXT_HEIGHT, angle)


PaperPoint = Annotated[Point2, "of the paper"]
"""A point of the paper: it moves with the view of its annotation."""


@dataclass(frozen=True)
class Annotation:
    """What is drawn on a sheet for a view."""

    view: str  # name of the view it belongs to

    def primitives(self, view: View) -> Iterator[Primitive]:
        """Its lines, arrow heads and texts in paper coordinates."""
        raise NotImplementedError

    def attachment(self, view: View) -> Point2 | None:
        """Point at which its arrow or datum triangle must meet a line of the part; None if it need not."""
        return None

    def leader_tip(self, view: View) -> Point2 | None:
        """Tip of its leader; None for one without a leader."""
        return self.attachment(view)

    def translated(self, by: Point2) -> Self:
        """With its paper coordinates moved along with its view."""

        def to(at: Any) -> Any:
            return tuple(map(to, at)) if isinstance(at[0], tuple) else (at[0] + by[0], at[1] + by[1])

        moving = [one.name for one in fields(self) if PaperPoint in (one.type, *get_args(one.type))]
        return replace(self, **{name: to(at) for name in moving if (at := getattr(self, name))})


@dataclass(frozen=True)
class LinearDimension(Annotation):
    """A distance along a direction: two extension lines, the dimension line between them, the text on it."""

    # first, second: measured points, view coordinates
    first: Point2
    second: Point2
    angle: float  # direction of measurement, degrees from u
    line_at: PaperPoint  # a point on the dimension line, paper
    text: str  # as printed, with its decimals, count and tolerance (`2x 40.00`)
    measured: float  # value on the solid, mm
    names: tuple[str, ...]
    text_at: PaperPoint | None = None  # centre of the text, paper; None for the middle of the dimension line

    def primitives(self, view: View) -> Iterator[Primitive]:
        u = direction(self.angle)
        points = (view.to_paper(self.first), view.to_paper(self.second))
        # Where the extension lines meet the dimension line.
        ends = [offset(self.line_at, u, distance_along(point, self.line_at, u)) for point in points]
        for point, end in zip(points, ends):
            if math.dist(point, end) > 2 * GAP:
                n = _unit(point, end)
                yield Stroke((offset(point, n, GAP), offset(end, n, BEYOND)))
        start, span = ends[0], math.dist(*ends)
        along = _unit(*ends)
        angle = readable(self.angle)
        middle = offset(start, along, span / 2)
        text_at = self.text_at or offset(middle, direction(angle), 0.0, TEXT_HEIGHT / 2 + GAP)
        inside = span >= 2 * ARROW + 1.0
        yield _arrow(ends[0], _opposite(along) if inside else along)
        yield _arrow(ends[1], along if inside else _opposite(along))
        low, high = (0.0, span) if inside else (-TAIL, span + TAIL)
        at = distance_along(text_at, start, along)
        if at < 0.0 or at > span:
            # The text is beside the extension lines: the dimension line is extended under it.
            half = symbol_text_width(self.text) / 2
            low, high = min(low, at - half), max(high, at + half)
        yield Stroke((offset(start, along, low), offset(start, along, high)))
        yield from _centred_line(self.text, text_at, angle)


@dataclass(frozen=True)
class RadialDimension(Annotation):
    """A diameter or radius on a leader to a circle in true shape."""

    kind: Literal["diameter", "radius"]
    # centre, radius: view coordinates
    centre: Point2
    radius: float
    towards: float  # direction of the leader from the centre, degrees
    text: str
    text_at: PaperPoint  # centre of the text, paper
    measured: float  # value on the solid, mm
    names: tuple[str, ...]

    def primitives(self, view: View) -> Iterator[Primitive]:
        on_circle = offset(view.to_paper(self.centre), direction(self.towards), self.radius * view.scale)
        # The line under the text, from its end next to the circle.
        x, y = self.text_at
        half = symbol_text_width(self.text) / 2 + GAP
        near, far = (x - half, x + half) if on_circle[0] <= x else (x + half, x - half)
        y -= TEXT_HEIGHT / 2 + GAP
        yield _arrow(on_circle, _unit((near, y), on_circle))
        yield Stroke((on_circle, (near, y), (far, y)))
        yield from _centred_line(self.text, self.text_at)

    def attachment(self, view: View) -> Point2:
        return view.to_paper(offset(self.centre, direction(self.towards), self.radius))


@dataclass(frozen=True)
class AngularDimension(Annotation):
    """An angle between two directions from a vertex."""

    # vertex, first, second: the vertex and a point in each direction, view coordinates
    vertex: Point2
    first: Point2
    second: Point2
    arc_at: PaperPoint  # position of the text on the dimension arc, paper
    text: str
    measured: float  # value on the solid, degrees
    names: tuple[str, ...]

    def primitives(self, view: View) -> Iterator[Primitive]:
        vertex = view.to_paper(self.vertex)
        radius = math.dist(vertex, self.arc_at)
        points = (view.to_paper(self.first), view.to_paper(self.second))
        start, end = (math.degrees(math.atan2(p[1] - vertex[1], p[0] - vertex[0])) for p in points)
        end = end if end > start else end + 360.0
        yield ArcStroke(Arc(vertex, radius, start, end))
        for point, angle, sign in ((points[0], start, -1.0), (points[1], end, 1.0)):
            out = direction(angle)
            # The head is a chord of the arc: turned from its tangent by half of the angle that it covers.
            turned = angle + sign * (90.0 - math.degrees(ARROW / radius / 2))
            yield _arrow(offset(vertex, out, radius), direction(turned))
            if radius > math.dist(vertex, point) + GAP:
                yield Stroke((offset(point, out, GAP), offset(vertex, out, radius + BEYOND)))
        out = _unit(vertex, self.arc_at)
        away = GAP + abs(out[0]) * symbol_text_width(self.text) / 2 + abs(out[1]) * TEXT_HEIGHT / 2
        yield _centred(self.text, offset(self.arc_at, out, away))


@dataclass(frozen=True)
class Callout(Annotation):
    """A leader with lines of text: a hole callout, a chamfer, a note on a face."""

    at: Point2  # the point on the feature, view coordinates
    elbow: PaperPoint  # point from which the leader is horizontal, paper
    lines: tuple[str, ...]  # text by line; `{depth}`, `{counterbore}` and the like are a `Symbol`
    names: tuple[str, ...]
    leftward: bool = False  # whether the text is left of the elbow

    def box(self, number: int) -> Box2:
        """Bounding box of one line of the text, symbols included, paper."""
        width, away = symbol_text_width(self.lines[number]), LANDING + GAP
        x = self.elbow[0] - away - width if self.leftward else self.elbow[0] + away
        y = self.elbow[1] - TEXT_HEIGHT / 2 - number * LINE_PITCH * TEXT_HEIGHT
        return (x, y, x + width, y + TEXT_HEIGHT)

    @property
    def boxes(self) -> list[Box2]:
        """Bounding boxes of all lines of the text."""
        return [self.box(number) for number in range(len(self.lines))]

    def primitives(self, view: View) -> Iterator[Primitive]:
        at = view.to_paper(self.at)
        end = (self.elbow[0] + (-LANDING if self.leftward else LANDING), self.elbow[1])
        yield _arrow(at, _unit(self.elbow, at))
        yield Stroke((at, self.elbow, end))
        for number, line in enumerate(self.lines):
            yield from symbol_text_primitives(line, self.box(number)[:2])

    def leader_tip(self, view: View) -> Point2:
        return view.to_paper(self.at)


@dataclass(frozen=True)
class FeatureControlFrame(Annotation):
    """A feature control frame on a leader: characteristic, tolerance, datum letters (ISO 1101)."""

    at: Point2  # the point on the feature, view coordinates
    elbow: PaperPoint  # end of the frame at which the leader begins, paper
    characteristic: Symbol
    tolerance: str
    datums: tuple[str, ...] = ()
    count: int = 1  # of the faces for which it holds, beside the frame

    def primitives(self, view: View) -> Iterator[Primitive]:
        at = view.to_paper(self.at)
        widths = [symbol_width(self.characteristic) + TEXT_HEIGHT, symbol_text_width(self.tolerance) + TEXT_HEIGHT]
        widths += [max(BOX, symbol_text_width(letter) + TEXT_HEIGHT) for letter in self.datums]
        rightward = self.elbow[0] >= at[0] - 1e-6
        x = self.elbow[0] if rightward else self.elbow[0] - sum(widths)
        low = self.elbow[1] - BOX / 2
        if self.count > 1:
            # On the side away from the leader.
            number, away = f"{self.count}x", symbol_text_width(f"{self.count}x") / 2 + GAP
            yield from _centred_line(number, (x + sum(widths) + away if rightward else x - away, low + BOX / 2))
        if math.dist(at, self.elbow) > 2 * ARROW:
            yield _arrow(at, _unit(self.elbow, at))
        if at != self.elbow:
            yield Stroke((at, self.elbow))
        for text, width in zip(("", self.tolerance, *self.datums), widths, strict=True):
            yield rectangle((x, low, x + width, low + BOX))
            if text:
                yield from _centred_line(text, (x + width / 2, low + BOX / 2))
            else:
                yield from symbol_primitives(self.characteristic, (x + TEXT_HEIGHT / 2, low + TEXT_HEIGHT / 2))
            x += width

    @property
    def is_axial(self) -> bool:
        """Whether it is that of an axis, in line with the dimension line of its diameter."""
        return self.tolerance.startswith("⌀")

    def attachment(self, view: View) -> Point2 | None:
        return None if self.is_axial else view.to_paper(self.at)


@dataclass(frozen=True)
class DatumSymbol(Annotation):
    """The filled triangle and framed letter of a datum (ISO 5459)."""

    at: Point2  # the point on the feature, view coordinates
    frame_at: PaperPoint  # centre of the letter's frame, paper
    letter: str

    def primitives(self, view: View) -> Iterator[Primitive]:
        at = view.to_paper(self.at)
        out = _unit(at, self.frame_at)
        apex, base = offset(at, out, TEXT_HEIGHT), TEXT_HEIGHT * 0.6
        yield FilledPolygon((apex, offset(at, out, 0.0, base), offset(at, out, 0.0, -base)))
        (x, y), half = self.frame_at, BOX / 2
        # The leader ends where it meets the frame.
        yield Stroke((apex, offset(self.frame_at, out, -half / max(abs(out[0]), abs(out[1])))))
        yield rectangle((x - half, y - half, x + half, y + half))
        yield _centred(self.letter, self.frame_at)

    def attachment(self, view: View) -> Point2:
        return view.to_paper(self.at)


@dataclass(frozen=True)
class DatumTarget(Annotation):
    """A datum target point: a cross on the face, and a divided circle with the target's name (ISO 5459)."""

    at: Point2  # the point on the face, view coordinates
    circle_at: PaperPoint  # centre of the circle, paper
    text: str  # letter and number, `A1`

    def primitives(self, view: View) -> Iterator[Primitive]:
        (x, y), at, half = self.circle_at, view.to_paper(self.at), CROSS / 2
        for rise in (-half, half):
            yield Stroke(((at[0] - half, at[1] - rise), (at[0] + half, at[1] + rise)), style=LAYERS["VISIBLE"])
        yield ArcStroke(Arc(self.circle_at, TARGET))
        yield Stroke(((x - TARGET, y), (x + TARGET, y)))
        yield Stroke((offset(self.circle_at, _unit(self.circle_at, at), TARGET), at))
        yield _centred(self.text, (x, y - TARGET * 0.48))


@dataclass(frozen=True)
class HoleTag(Annotation):
    """The name of a hole in the hole table, next to the hole."""

    at: Point2  # centre of the hole, view coordinates
    middle: PaperPoint  # of the text, paper
    text: str  # `A1`

    def primitives(self, view: View) -> Iterator[Primitive]:
        yield _centred(self.text, self.middle)


@dataclass(frozen=True)
class Balloon(Annotation):
    """A numbered circle on a leader, for the assembly's parts list."""

    at: Point2  # the point on the part, view coordinates
    centre: PaperPoint  # of the circle, paper
    number: int

    def primitives(self, view: View) -> Iterator[Primitive]:
        at = view.to_paper(self.at)
        yield ArcStroke(Arc(self.centre, BALLOON))
        yield Stroke((offset(self.centre, _unit(self.centre, at), BALLOON), at))
        yield FilledPolygon(tuple(offset(at, direction(angle), DOT) for angle in range(0, 360, 30)))
        yield _centred(str(self.number), self.centre)


@dataclass(frozen=True)
class SectionMark(Annotation):
    """Cutting plane of a section: wide ends of the line, arrows in the direction of sight, letters (ISO 128-3)."""

    # start, end: of the cutting line, paper; a little outside the part
    start: PaperPoint
    end: PaperPoint
    sight: Point2  # unit vector in the direction of sight at the start
    letter: str  # of the section
    corners: tuple[PaperPoint, ...] = ()  # of the line between its ends, paper

    def primitives(self, view: View) -> Iterator[Primitive]:
        path = (self.start, *self.corners, self.end)
        first, last = _unit(*path[:2]), _unit(*path[-2:])
        # The plane at the end of an aligned section is turned against that at its start.
        cosine, sine = first[0] * last[0] + first[1] * last[1], first[0] * last[1] - first[1] * last[0]
        turned = (cosine * self.sight[0] - sine * self.sight[1], sine * self.sight[0] + cosine * self.sight[1])
        at_end = turned if len(self.corners) == 1 and cosine > 1e-6 else self.sight
        for point, inward, sight in ((self.start, first, self.sight), (self.end, _opposite(last), at_end)):
            tip = offset(point, sight, STEM)
            yield Stroke((point, offset(point, inward, THICK_END)), "SECTION", THICK)
            yield Stroke((point, tip))
            yield _arrow(tip, sight, ARROW * 1.3)
            yield _centred(self.letter, offset(offset(point, sight, STEM / 2), inward, -4.5), LARGE_HEIGHT)
        for before, corner, after in zip(path, path[1:], path[2:], strict=False):
            for end in (before, after):
                reach = min(THICK_END, math.dist(corner, end) / 2)
                yield Stroke((corner, offset(corner, _unit(corner, end), reach)), "SECTION", THICK)


@dataclass(frozen=True)
class ReferenceArrow(Annotation):
    """Arrow in the direction of sight of a view that is not in its place by projection, with its letter (ISO 128-3)."""

    tip: PaperPoint  # paper; a little outside the part
    sight: Point2  # unit vector in the direction of sight
    letter: str  # label of that view

    def primitives(self, view: View) -> Iterator[Primitive]:
        start = offset(self.tip, self.sight, -STEM * 1.3)
        yield Stroke((start, self.tip))
        yield _arrow(self.tip, self.sight, ARROW * 1.3)
        yield _centred(self.letter, offset(start, self.sight, -LARGE_HEIGHT * 0.9), LARGE_HEIGHT)


@dataclass(frozen=True)
class DetailMark(Annotation):
    """The thin circle around the area of a detail view, and the view's letter."""

    # centre, radius: view coordinates
    centre: Point2
    radius: float
    letter_at: PaperPoint  # centre of the letter, paper
    letter: str

    def primitives(self, view: View) -> Iterator[Primitive]:
        yield ArcStroke(Arc(view.to_paper(self.centre), self.radius * view.scale), "HATCH")
        yield _centred(self.letter, self.letter_at, LARGE_HEIGHT)


MeasuredDimension = LinearDimension | RadialDimension | AngularDimension
"""Written to DXF as DIMENSION entities."""


@dataclass(frozen=True)
class Note:
    """A text on the sheet that belongs to no view."""

    at: Point2  # its lower left corner, paper
    lines: tuple[str, ...]  # from the top down
    height: float = TEXT_HEIGHT  # of capitals, mm

    def primitives(self) -> Iterator[Primitive]:
        """Its texts and symbols."""
        x, y = self.at
        for number, line in enumerate(reversed(self.lines)):
            yield from symbol_text_primitives(line, (x, y + number * LINE_PITCH * self.height), self.height)


def label_primitives(view: View) -> Iterator[Primitive]:
    """The name of a section or detail view, below the view."""
    box = view_box(view)
    if view.label and box:
        at = view.label_at or ((box[0] + box[2]) / 2, box[1] - 3.0 - LARGE_HEIGHT)
        yield Text(view.label, at, LARGE_HEIGHT, "middle")


def primitive_box(primitive: Primitive) -> Box2:
    """Bounding box of a primitive, paper."""
    if isinstance(primitive, Text):
        return text_box(primitive)
    return bounding_box(extreme_points(primitive.arc) if isinstance(primitive, ArcStroke) else primitive.points)


def text_box(text: Text) -> Box2:
    """Bounding box of a text from the base line to the height of capitals, paper."""
    width = symbol_text_width(text.text, text.height)
    start = {"left": 0.0, "middle": -width / 2, "right": -width}[text.alignment]
    u = direction(text.angle)
    return bounding_box([offset(text.at, u, x, y) for x in (start, start + width) for y in (0.0, text.height)])
