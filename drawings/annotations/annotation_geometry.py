"""How each annotation looks: lines, arrows and lettering on the paper, the one place where that is said.

The document draws from it, the layout takes the room of its texts from it. Proportions after ISO 129-1.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from drawings.annotations.annotation import (
    AngularDimension,
    Annotation,
    Balloon,
    Callout,
    DatumSymbol,
    DetailMark,
    FeatureControlFrame,
    LinearDimension,
    Note,
    RadialDimension,
    SectionMark,
    SurfaceTextureSymbol,
)
from drawings.annotations.font import LARGE_HEIGHT, LINE_PITCH, TEXT_HEIGHT
from drawings.annotations.primitives import THICK, ArcStroke, FilledPolygon, Primitive, Stroke, Text, rectangle
from drawings.annotations.symbols import symbol_primitives, symbol_text_primitives, symbol_text_width, symbol_width
from drawings.views.bounding_box import bounding_box, extreme_points, view_box
from drawings.views.view import Arc, Box2, Point2, View

ARROW = 3.0
"""Length of an arrow head, mm; it is a third as wide."""
GAP = 1.0
"""From the part to the start of an extension line, and from a dimension line to its text, mm."""
BEYOND = 2.0
"""How far an extension line passes the dimension line, mm."""
TAIL = 5.0
"""Length of a dimension line outside its extension lines, where the arrows do not fit between, mm."""
LANDING = 3.0
"""Level end of a leader before the text, mm."""
BOX = 2 * TEXT_HEIGHT
"""Height of a control frame and of a datum letter's frame, mm."""
BALLOON = 5.0
"""Radius of a balloon, mm."""
DOT = 0.6
"""Radius of the dot in which a balloon's leader ends, mm."""


def annotation_primitives(annotation: Annotation, view: View) -> Iterator[Primitive]:
    """Everything an annotation puts on the paper, in paper coordinates."""
    match annotation:
        case LinearDimension():
            yield from _linear(annotation, view)
        case RadialDimension():
            yield from _round(annotation, view)
        case AngularDimension():
            yield from _angular(annotation, view)
        case Callout():
            yield from _callout(annotation, view)
        case FeatureControlFrame():
            yield from _control_frame(annotation, view)
        case DatumSymbol():
            yield from _datum(annotation, view)
        case SurfaceTextureSymbol():
            yield from _surface(annotation, view)
        case Balloon():
            yield from _balloon(annotation, view)
        case SectionMark():
            yield from _section(annotation)
        case DetailMark():
            centre = view.to_paper(annotation.centre)
            yield ArcStroke(Arc(centre, annotation.radius * view.scale))
            yield _centred(annotation.letter, annotation.letter_at, LARGE_HEIGHT)


def note_primitives(note: Note) -> Iterator[Primitive]:
    """The lines of a note, from the top down to its lower left corner."""
    x, y = note.at
    for number, line in enumerate(reversed(note.lines)):
        yield from symbol_text_primitives(line, (x, y + number * LINE_PITCH * note.height), note.height)


def text_box(words: Text) -> Box2:
    """Room of a text at a multiple of 90 degrees: from the base line to the height of capitals, paper."""
    width = symbol_text_width(words.text, words.height)
    start = {"left": 0.0, "middle": -width / 2, "right": -width}[words.alignment]
    turn = math.radians(words.angle)
    c, s = math.cos(turn), math.sin(turn)
    corners = [
        (words.at[0] + x * c - y * s, words.at[1] + x * s + y * c)
        for x in (start, start + width)
        for y in (0.0, words.height)
    ]
    xs, ys = zip(*corners)
    return (min(xs), min(ys), max(xs), max(ys))


def primitive_box(primitive: Primitive) -> Box2:
    """Bounding box of a primitive, paper."""
    if isinstance(primitive, Text):
        return text_box(primitive)
    return bounding_box(extreme_points(primitive.arc) if isinstance(primitive, ArcStroke) else primitive.points)


def label_primitives(view: View) -> Iterator[Primitive]:
    """The name of a section or detail view, below the view."""
    box = view_box(view)
    if view.label and box:
        at = view.label_at or ((box[0] + box[2]) / 2, box[1] - 3.0 - LARGE_HEIGHT)
        yield Text(view.label, at, LARGE_HEIGHT, "middle")


def text_boxes(ink: Iterable[Primitive]) -> list[Box2]:
    """Room of all texts among some ink."""
    return [text_box(item) for item in ink if isinstance(item, Text)]


def arrow(tip: Point2, direction: Point2, length: float = ARROW) -> FilledPolygon:
    """A closed, filled arrow head whose tip points along a unit vector."""
    (x, y), (u, v) = tip, direction
    back = (x - u * length, y - v * length)
    half = length / 6
    return FilledPolygon((tip, (back[0] - v * half, back[1] + u * half), (back[0] + v * half, back[1] - u * half)))


def _centred(text: str, at: Point2, height: float = TEXT_HEIGHT, angle: float = 0.0) -> Text:
    """A text whose middle is at a point."""
    turn = math.radians(angle)
    return Text(
        text, (at[0] + math.sin(turn) * height / 2, at[1] - math.cos(turn) * height / 2), height, "middle", angle
    )


def _centred_line(text: str, at: Point2, angle: float = 0.0) -> Iterator[Primitive]:
    """A text that may have symbols in it, its middle at a point; symbols stand level only."""
    if "{" in text and abs(angle) < 1e-9:
        yield from symbol_text_primitives(text, (at[0] - symbol_text_width(text) / 2, at[1] - TEXT_HEIGHT / 2))
    else:
        yield _centred(text, at, TEXT_HEIGHT, angle)


def _unit(start: Point2, end: Point2) -> Point2:
    length = math.dist(start, end)
    return ((end[0] - start[0]) / length, (end[1] - start[1]) / length) if length > 1e-9 else (1.0, 0.0)


def readable(angle: float) -> float:
    """The angle at which a text along a line is read from below or from the right, degrees (ISO 129-1)."""
    angle = (angle + 90.0) % 180.0 - 90.0
    return 90.0 if abs(angle + 90.0) < 1e-6 else angle


def _linear(d: LinearDimension, view: View) -> Iterator[Primitive]:
    turn = math.radians(d.angle)
    u = (math.cos(turn), math.sin(turn))
    first, second = view.to_paper(d.first), view.to_paper(d.second)

    def foot(point: Point2) -> Point2:
        """Where the dimension line is met from a measured point."""
        along = (point[0] - d.line_at[0]) * u[0] + (point[1] - d.line_at[1]) * u[1]
        return (d.line_at[0] + along * u[0], d.line_at[1] + along * u[1])

    ends = [foot(first), foot(second)]
    for point, end in zip((first, second), ends):
        away = math.dist(point, end)
        if away > 2 * GAP:
            n = _unit(point, end)
            start = (point[0] + n[0] * GAP, point[1] + n[1] * GAP)
            yield Stroke((start, (end[0] + n[0] * BEYOND, end[1] + n[1] * BEYOND)))
    span = math.dist(*ends)
    along = _unit(*ends)
    back = (-along[0], -along[1])
    angle = readable(d.angle)
    up = (-math.sin(math.radians(angle)), math.cos(math.radians(angle)))
    width = symbol_text_width(d.text)
    middle = ((ends[0][0] + ends[1][0]) / 2, (ends[0][1] + ends[1][1]) / 2)
    rise = TEXT_HEIGHT / 2 + GAP
    text_at = d.text_at or (middle[0] + up[0] * rise, middle[1] + up[1] * rise)
    # Along the line from its first end: 0 to span is between the arrows.
    reach = [0.0, span]
    if span < 2 * ARROW + 1.0:
        yield arrow(ends[0], along)
        yield arrow(ends[1], back)
        reach = [-TAIL, span + TAIL]
    else:
        yield arrow(ends[0], back)
        yield arrow(ends[1], along)
    at = (text_at[0] - ends[0][0]) * along[0] + (text_at[1] - ends[0][1]) * along[1]
    if at < 0.0 or at > span:
        # The text stands beside the measured stretch: the line runs on under it.
        reach = [min(reach[0], at - width / 2), max(reach[1], at + width / 2)]
    yield Stroke(
        tuple((ends[0][0] + r * along[0], ends[0][1] + r * along[1]) for r in reach)  # type: ignore[arg-type]
    )
    yield from _centred_line(d.text, text_at, angle)


def _round(d: RadialDimension, view: View) -> Iterator[Primitive]:
    turn = math.radians(d.towards)
    out = (math.cos(turn), math.sin(turn))
    centre = view.to_paper(d.centre)
    radius = d.radius * view.scale
    on = (centre[0] + out[0] * radius, centre[1] + out[1] * radius)
    elbow, shelf_end = _shelf(d.text, d.text_at, on)
    yield arrow(on, _unit(elbow, on))
    yield Stroke((on, elbow, shelf_end))
    yield from _centred_line(d.text, d.text_at)


def _shelf(text: str, text_at: Point2, from_point: Point2) -> tuple[Point2, Point2]:
    """The level line under a text: its end towards a point, and the other."""
    half, y = symbol_text_width(text) / 2 + GAP, text_at[1] - TEXT_HEIGHT / 2 - GAP
    ends = ((text_at[0] - half, y), (text_at[0] + half, y))
    return ends if from_point[0] <= text_at[0] else (ends[1], ends[0])


def _angular(d: AngularDimension, view: View) -> Iterator[Primitive]:
    vertex = view.to_paper(d.vertex)
    radius = math.dist(vertex, d.arc_at)
    start, end = (
        math.degrees(math.atan2(p[1] - vertex[1], p[0] - vertex[0]))
        for p in (view.to_paper(d.first), view.to_paper(d.second))
    )
    end = end if end > start else end + 360.0
    yield ArcStroke(Arc(vertex, radius, start, end))
    for point, at, sign in ((d.first, start, -1.0), (d.second, end, 1.0)):
        turn = math.radians(at)
        out = (math.cos(turn), math.sin(turn))
        tip = (vertex[0] + out[0] * radius, vertex[1] + out[1] * radius)
        # The head lies on the arc: turned by half of what it covers.
        lean = turn + sign * (math.pi / 2 - ARROW / radius / 2)
        yield arrow(tip, (math.cos(lean), math.sin(lean)))
        near = view.to_paper(point)
        reach = math.dist(vertex, near)
        if radius > reach + GAP:
            beyond = (vertex[0] + out[0] * (radius + BEYOND), vertex[1] + out[1] * (radius + BEYOND))
            yield Stroke(((near[0] + out[0] * GAP, near[1] + out[1] * GAP), beyond))
    out = _unit(vertex, d.arc_at)
    away = GAP + abs(out[0]) * symbol_text_width(d.text) / 2 + abs(out[1]) * TEXT_HEIGHT / 2
    yield _centred(d.text, (d.arc_at[0] + out[0] * away, d.arc_at[1] + out[1] * away))


def callout_box(c: Callout, number: int) -> Box2:
    """Room of one of a callout's lines, symbols included, paper."""
    width, away = symbol_text_width(c.lines[number]), LANDING + GAP
    x = c.elbow[0] - away - width if c.leftward else c.elbow[0] + away
    y = c.elbow[1] - TEXT_HEIGHT / 2 - number * LINE_PITCH * TEXT_HEIGHT
    return (x, y, x + width, y + TEXT_HEIGHT)


def _callout(c: Callout, view: View) -> Iterator[Primitive]:
    at = view.to_paper(c.at)
    end = (c.elbow[0] + (-LANDING if c.leftward else LANDING), c.elbow[1])
    yield arrow(at, _unit(c.elbow, at))
    yield Stroke((at, c.elbow, end))
    for number, line in enumerate(c.lines):
        yield from symbol_text_primitives(line, callout_box(c, number)[:2])


def _control_frame(f: FeatureControlFrame, view: View) -> Iterator[Primitive]:
    at = view.to_paper(f.at)
    widths = [symbol_width(f.characteristic) + TEXT_HEIGHT, symbol_text_width(f.tolerance) + TEXT_HEIGHT]
    widths += [max(BOX, symbol_text_width(letter) + TEXT_HEIGHT) for letter in f.datums]
    left = f.elbow[0] if f.elbow[0] >= at[0] - 1e-6 else f.elbow[0] - sum(widths)
    low = f.elbow[1] - BOX / 2
    if math.dist(at, f.elbow) > ARROW:
        yield arrow(at, _unit(f.elbow, at))
        yield Stroke((at, f.elbow))
    x = left
    for number, width in enumerate(widths):
        yield rectangle((x, low, x + width, low + BOX))
        if number == 0:
            yield from symbol_primitives(f.characteristic, (x + TEXT_HEIGHT / 2, low + TEXT_HEIGHT / 2))
        else:
            text = f.tolerance if number == 1 else f.datums[number - 2]
            yield from _centred_line(text, (x + width / 2, low + BOX / 2))
        x += width


def _datum(m: DatumSymbol, view: View) -> Iterator[Primitive]:
    at = view.to_paper(m.at)
    out = _unit(at, m.frame_at)
    half = BOX / 2
    apex = (at[0] + out[0] * TEXT_HEIGHT, at[1] + out[1] * TEXT_HEIGHT)
    wide = TEXT_HEIGHT * 0.6
    yield FilledPolygon(
        (apex, (at[0] - out[1] * wide, at[1] + out[0] * wide), (at[0] + out[1] * wide, at[1] - out[0] * wide))
    )
    x, y = m.frame_at
    # The leader ends where it meets the frame.
    reach = half / max(abs(out[0]), abs(out[1]))
    yield Stroke((apex, (x - out[0] * reach, y - out[1] * reach)))
    yield rectangle((x - half, y - half, x + half, y + half))
    yield _centred(m.letter, m.frame_at)


def _surface(m: SurfaceTextureSymbol, view: View) -> Iterator[Primitive]:
    x, y = view.to_paper(m.at)
    turn = math.radians(m.angle)
    c, s = math.cos(turn), math.sin(turn)

    def place(a: float, b: float) -> Point2:
        return (x + a * c - b * s, y + a * s + b * c)

    low, high = 1.4 * TEXT_HEIGHT, 3.0 * TEXT_HEIGHT
    run = 1 / math.tan(math.radians(60))
    shelf = symbol_text_width(m.text) + 2 * GAP
    yield Stroke((place(-low * run, low), (x, y), place(high * run, high), place(high * run + shelf, high)))
    yield Stroke((place(-low * run, low), place(low * run, low)))
    at = place(high * run + GAP, high - GAP - TEXT_HEIGHT)
    yield Text(m.text, at, TEXT_HEIGHT, "left", m.angle)


def _balloon(b: Balloon, view: View) -> Iterator[Primitive]:
    at = view.to_paper(b.at)
    out = _unit(b.centre, at)
    yield ArcStroke(Arc(b.centre, BALLOON))
    yield Stroke(((b.centre[0] + out[0] * BALLOON, b.centre[1] + out[1] * BALLOON), at))
    turns = [t * math.pi / 6 for t in range(12)]
    yield FilledPolygon(tuple((at[0] + DOT * math.cos(t), at[1] + DOT * math.sin(t)) for t in turns))
    yield _centred(str(b.number), b.centre)


def _section(m: SectionMark) -> Iterator[Primitive]:
    along = _unit(m.start, m.end)
    thick, stem = 6.0, 9.0
    for point, inward in ((m.start, along), (m.end, (-along[0], -along[1]))):
        yield Stroke((point, (point[0] + inward[0] * thick, point[1] + inward[1] * thick)), "SECTION", THICK)
        tip = (point[0] + m.sight[0] * stem, point[1] + m.sight[1] * stem)
        yield Stroke((point, tip))
        yield arrow(tip, m.sight, ARROW * 1.3)
        out = (-inward[0] * 4.5, -inward[1] * 4.5)
        beside = stem / 2
        at = (point[0] + m.sight[0] * beside + out[0], point[1] + m.sight[1] * beside + out[1])
        yield _centred(m.letter, at, LARGE_HEIGHT)
