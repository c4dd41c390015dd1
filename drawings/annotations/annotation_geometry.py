"""The primitives of each annotation: lines, arrow heads and texts, with proportions according to ISO 129-1.

The writers draw them, and the placement uses the boxes of their texts and lines.
"""

import math
from collections.abc import Iterator

from drawings.annotations.annotation import (
    LARGE_HEIGHT,
    LAYERS,
    LINE_PITCH,
    TEXT_HEIGHT,
    THICK,
    AngularDimension,
    Annotation,
    ArcStroke,
    Balloon,
    Callout,
    DatumSymbol,
    DatumTarget,
    DetailMark,
    FeatureControlFrame,
    FilledPolygon,
    HoleTag,
    LinearDimension,
    Note,
    Primitive,
    RadialDimension,
    ReferenceArrow,
    SectionMark,
    Stroke,
    SurfaceTextureSymbol,
    Text,
    rectangle,
    turned,
)
from drawings.annotations.symbols import symbol_primitives, symbol_text_primitives, symbol_text_width, symbol_width
from drawings.views.view import Arc, Box2, Point2, View, bounding_box, extreme_points, view_box

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


def annotation_primitives(annotation: Annotation, view: View) -> Iterator[Primitive]:
    """The primitives of an annotation in paper coordinates."""
    match annotation:
        case LinearDimension():
            yield from _linear(annotation, view)
        case RadialDimension():
            yield from _radial(annotation, view)
        case AngularDimension():
            yield from _angular(annotation, view)
        case Callout():
            yield from _callout(annotation, view)
        case FeatureControlFrame():
            yield from _feature_control_frame(annotation, view)
        case DatumSymbol():
            yield from _datum(annotation, view)
        case DatumTarget():
            yield from _datum_target(annotation, view)
        case HoleTag():
            yield _centred(annotation.text, annotation.middle)
        case SurfaceTextureSymbol():
            yield from _surface_texture(annotation, view)
        case Balloon():
            yield from _balloon(annotation, view)
        case SectionMark():
            yield from _section(annotation)
        case ReferenceArrow():
            yield from _reference_arrow(annotation)
        case DetailMark():
            centre = view.to_paper(annotation.centre)
            yield ArcStroke(Arc(centre, annotation.radius * view.scale), "HATCH")
            yield _centred(annotation.letter, annotation.letter_at, LARGE_HEIGHT)


def note_primitives(note: Note) -> Iterator[Primitive]:
    """The texts and symbols of a note."""
    x, y = note.at
    for number, line in enumerate(reversed(note.lines)):
        yield from symbol_text_primitives(line, (x, y + number * LINE_PITCH * note.height), note.height)


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
    u = _direction(text.angle)
    return bounding_box([_offset(text.at, u, x, y) for x in (start, start + width) for y in (0.0, text.height)])


def readable(angle: float) -> float:
    """The angle at which a text along a line is read from below or from the right, degrees: up to 30 degrees beyond
    the vertical from the right (ISO 129-1)."""
    return round((angle + 60.0) % 180.0 - 60.0, 9)


def _direction(angle: float) -> Point2:
    """Unit vector at an angle, degrees."""
    return (math.cos(math.radians(angle)), math.sin(math.radians(angle)))


def _unit(start: Point2, end: Point2) -> Point2:
    """Unit vector from one point to another; to the right where they coincide."""
    length = math.dist(start, end)
    return ((end[0] - start[0]) / length, (end[1] - start[1]) / length) if length > 1e-9 else (1.0, 0.0)


def _opposite(u: Point2) -> Point2:
    return (-u[0], -u[1])


def _offset(point: Point2, u: Point2, along: float, across: float = 0.0) -> Point2:
    """A point moved along a unit vector and across it, to its left."""
    return (point[0] + u[0] * along - u[1] * across, point[1] + u[1] * along + u[0] * across)


def _distance_along(point: Point2, start: Point2, u: Point2) -> float:
    """Distance of a point from a start along a unit vector."""
    return (point[0] - start[0]) * u[0] + (point[1] - start[1]) * u[1]


def _arrow(tip: Point2, direction: Point2, length: float = ARROW) -> FilledPolygon:
    """A closed, filled arrow head whose tip points along a unit vector."""
    half = length / 6
    return FilledPolygon((tip, _offset(tip, direction, -length, half), _offset(tip, direction, -length, -half)))


def _centred(text: str, at: Point2, height: float = TEXT_HEIGHT, angle: float = 0.0) -> Text:
    """A text whose middle is at a point."""
    return Text(text, _offset(at, _direction(angle), 0.0, -height / 2), height, "middle", angle)


def _centred_line(text: str, at: Point2, angle: float = 0.0) -> Iterator[Primitive]:
    """A text with its symbols whose middle is at a point."""
    if "{" in text:
        start = (at[0] - symbol_text_width(text) / 2, at[1] - TEXT_HEIGHT / 2)
        yield from (turned(piece, at, angle) if angle else piece for piece in symbol_text_primitives(text, start))
    else:
        yield _centred(text, at, TEXT_HEIGHT, angle)


def _linear(d: LinearDimension, view: View) -> Iterator[Primitive]:
    u = _direction(d.angle)
    points = (view.to_paper(d.first), view.to_paper(d.second))
    # Where the extension lines meet the dimension line.
    ends = [_offset(d.line_at, u, _distance_along(point, d.line_at, u)) for point in points]
    for point, end in zip(points, ends):
        if math.dist(point, end) > 2 * GAP:
            n = _unit(point, end)
            yield Stroke((_offset(point, n, GAP), _offset(end, n, BEYOND)))
    start, span = ends[0], math.dist(*ends)
    along = _unit(*ends)
    angle = readable(d.angle)
    text_at = d.text_at or _offset(_offset(start, along, span / 2), _direction(angle), 0.0, TEXT_HEIGHT / 2 + GAP)
    inside = span >= 2 * ARROW + 1.0
    yield _arrow(ends[0], _opposite(along) if inside else along)
    yield _arrow(ends[1], along if inside else _opposite(along))
    low, high = (0.0, span) if inside else (-TAIL, span + TAIL)
    at = _distance_along(text_at, start, along)
    if at < 0.0 or at > span:
        # The text is beside the extension lines: the dimension line is extended under it.
        half = symbol_text_width(d.text) / 2
        low, high = min(low, at - half), max(high, at + half)
    yield Stroke((_offset(start, along, low), _offset(start, along, high)))
    yield from _centred_line(d.text, text_at, angle)


def _radial(d: RadialDimension, view: View) -> Iterator[Primitive]:
    on_circle = _offset(view.to_paper(d.centre), _direction(d.towards), d.radius * view.scale)
    # The line under the text, from its end next to the circle.
    x, y = d.text_at
    half = symbol_text_width(d.text) / 2 + GAP
    near, far = (x - half, x + half) if on_circle[0] <= x else (x + half, x - half)
    y -= TEXT_HEIGHT / 2 + GAP
    yield _arrow(on_circle, _unit((near, y), on_circle))
    yield Stroke((on_circle, (near, y), (far, y)))
    yield from _centred_line(d.text, d.text_at)


def _angular(d: AngularDimension, view: View) -> Iterator[Primitive]:
    vertex = view.to_paper(d.vertex)
    radius = math.dist(vertex, d.arc_at)
    points = (view.to_paper(d.first), view.to_paper(d.second))
    start, end = (math.degrees(math.atan2(p[1] - vertex[1], p[0] - vertex[0])) for p in points)
    end = end if end > start else end + 360.0
    yield ArcStroke(Arc(vertex, radius, start, end))
    for point, angle, sign in ((points[0], start, -1.0), (points[1], end, 1.0)):
        out = _direction(angle)
        # The head is a chord of the arc: turned from its tangent by half of the angle that it covers.
        turned = angle + sign * (90.0 - math.degrees(ARROW / radius / 2))
        yield _arrow(_offset(vertex, out, radius), _direction(turned))
        if radius > math.dist(vertex, point) + GAP:
            yield Stroke((_offset(point, out, GAP), _offset(vertex, out, radius + BEYOND)))
    out = _unit(vertex, d.arc_at)
    away = GAP + abs(out[0]) * symbol_text_width(d.text) / 2 + abs(out[1]) * TEXT_HEIGHT / 2
    yield _centred(d.text, _offset(d.arc_at, out, away))


def callout_boxes(c: Callout) -> list[Box2]:
    """Bounding boxes of the lines of a callout, symbols included, paper."""
    return [callout_box(c, number) for number in range(len(c.lines))]


def callout_box(c: Callout, number: int) -> Box2:
    """Bounding box of one line of a callout, symbols included, paper."""
    width, away = symbol_text_width(c.lines[number]), LANDING + GAP
    x = c.elbow[0] - away - width if c.leftward else c.elbow[0] + away
    y = c.elbow[1] - TEXT_HEIGHT / 2 - number * LINE_PITCH * TEXT_HEIGHT
    return (x, y, x + width, y + TEXT_HEIGHT)


def _callout(c: Callout, view: View) -> Iterator[Primitive]:
    at = view.to_paper(c.at)
    end = (c.elbow[0] + (-LANDING if c.leftward else LANDING), c.elbow[1])
    yield _arrow(at, _unit(c.elbow, at))
    yield Stroke((at, c.elbow, end))
    for number, line in enumerate(c.lines):
        yield from symbol_text_primitives(line, callout_box(c, number)[:2])


def _feature_control_frame(f: FeatureControlFrame, view: View) -> Iterator[Primitive]:
    at = view.to_paper(f.at)
    widths = [symbol_width(f.characteristic) + TEXT_HEIGHT, symbol_text_width(f.tolerance) + TEXT_HEIGHT]
    widths += [max(BOX, symbol_text_width(letter) + TEXT_HEIGHT) for letter in f.datums]
    rightward = f.elbow[0] >= at[0] - 1e-6
    x = f.elbow[0] if rightward else f.elbow[0] - sum(widths)
    low = f.elbow[1] - BOX / 2
    if f.count > 1:
        # On the side away from the leader.
        away = symbol_text_width(f"{f.count}x") / 2 + GAP
        yield from _centred_line(f"{f.count}x", (x + sum(widths) + away if rightward else x - away, low + BOX / 2))
    if math.dist(at, f.elbow) > 2 * ARROW:
        yield _arrow(at, _unit(f.elbow, at))
    if at != f.elbow:
        yield Stroke((at, f.elbow))
    for text, width in zip(("", f.tolerance, *f.datums), widths, strict=True):
        yield rectangle((x, low, x + width, low + BOX))
        if text:
            yield from _centred_line(text, (x + width / 2, low + BOX / 2))
        else:
            yield from symbol_primitives(f.characteristic, (x + TEXT_HEIGHT / 2, low + TEXT_HEIGHT / 2))
        x += width


def _datum(m: DatumSymbol, view: View) -> Iterator[Primitive]:
    at = view.to_paper(m.at)
    out = _unit(at, m.frame_at)
    apex, base = _offset(at, out, TEXT_HEIGHT), TEXT_HEIGHT * 0.6
    yield FilledPolygon((apex, _offset(at, out, 0.0, base), _offset(at, out, 0.0, -base)))
    (x, y), half = m.frame_at, BOX / 2
    # The leader ends where it meets the frame.
    yield Stroke((apex, _offset(m.frame_at, out, -half / max(abs(out[0]), abs(out[1])))))
    yield rectangle((x - half, y - half, x + half, y + half))
    yield _centred(m.letter, m.frame_at)


def _datum_target(m: DatumTarget, view: View) -> Iterator[Primitive]:
    (x, y), at, half = m.centre, view.to_paper(m.at), CROSS / 2
    for rise in (-half, half):
        yield Stroke(((at[0] - half, at[1] - rise), (at[0] + half, at[1] + rise)), style=LAYERS["VISIBLE"])
    yield ArcStroke(Arc(m.centre, TARGET))
    yield Stroke(((x - TARGET, y), (x + TARGET, y)))
    yield Stroke((_offset(m.centre, _unit(m.centre, at), TARGET), at))
    yield _centred(m.text, (x, y - TARGET * 0.48))


def _surface_texture(m: SurfaceTextureSymbol, view: View) -> Iterator[Primitive]:
    at, u = view.to_paper(m.at), _direction(m.angle)
    low, high = 1.4 * TEXT_HEIGHT, 3.0 * TEXT_HEIGHT
    run = 1 / math.tan(math.radians(60))
    left, corner = _offset(at, u, -low * run, low), _offset(at, u, high * run, high)
    yield Stroke((left, at, corner, _offset(corner, u, symbol_text_width(m.text) + 2 * GAP)))
    yield Stroke((left, _offset(at, u, low * run, low)))
    yield Text(m.text, _offset(corner, u, GAP, -GAP - TEXT_HEIGHT), TEXT_HEIGHT, "left", m.angle)


def _balloon(b: Balloon, view: View) -> Iterator[Primitive]:
    at = view.to_paper(b.at)
    yield ArcStroke(Arc(b.centre, BALLOON))
    yield Stroke((_offset(b.centre, _unit(b.centre, at), BALLOON), at))
    yield FilledPolygon(tuple(_offset(at, _direction(angle), DOT) for angle in range(0, 360, 30)))
    yield _centred(str(b.number), b.centre)


def _reference_arrow(m: ReferenceArrow) -> Iterator[Primitive]:
    start = _offset(m.tip, m.sight, -STEM * 1.3)
    yield Stroke((start, m.tip))
    yield _arrow(m.tip, m.sight, ARROW * 1.3)
    yield _centred(m.letter, _offset(start, m.sight, -LARGE_HEIGHT * 0.9), LARGE_HEIGHT)


def _section(m: SectionMark) -> Iterator[Primitive]:
    path = (m.start, *m.corners, m.end)
    first, last = _unit(*path[:2]), _unit(*path[-2:])
    # The plane at the end of an aligned section is turned against that at its start.
    cosine, sine = first[0] * last[0] + first[1] * last[1], first[0] * last[1] - first[1] * last[0]
    turned = (cosine * m.sight[0] - sine * m.sight[1], sine * m.sight[0] + cosine * m.sight[1])
    at_end = turned if len(m.corners) == 1 and cosine > 1e-6 else m.sight
    for point, inward, sight in ((m.start, first, m.sight), (m.end, _opposite(last), at_end)):
        tip = _offset(point, sight, STEM)
        yield Stroke((point, _offset(point, inward, THICK_END)), "SECTION", THICK)
        yield Stroke((point, tip))
        yield _arrow(tip, sight, ARROW * 1.3)
        yield _centred(m.letter, _offset(_offset(point, sight, STEM / 2), inward, -4.5), LARGE_HEIGHT)
    for before, corner, after in zip(path, path[1:], path[2:], strict=False):
        for end in (before, after):
            reach = min(THICK_END, math.dist(corner, end) / 2)
            yield Stroke((corner, _offset(corner, _unit(corner, end), reach)), "SECTION", THICK)
