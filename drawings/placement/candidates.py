"""Where an annotation could stand, the likely places first: its cost without regard to what else is on the paper.

All on paper with the view's origin at (0, 0). Costs are in mm: of leader, of distance from the part, of what looks as
bad as so many mm more would.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from drawings.annotations.annotation import (
    AngularDimension,
    Annotation,
    Callout,
    DatumSymbol,
    FeatureControlFrame,
    LinearDimension,
    RadialDimension,
)
from drawings.annotations.annotation_geometry import ARROW, GAP, readable
from drawings.annotations.font import TEXT_HEIGHT
from drawings.annotations.symbols import symbol_text_width
from drawings.dimensions.specification import AskedAngle, AskedCallout, AskedDistance, AskedFrame, AskedRound
from drawings.placement.field import Lines
from drawings.views.view import Box2, Point2, View

FIRST, PITCH = 10.0, 8.0
"""Of the first dimension line from the part, and of the next ones from it, mm (ISO 129-1 asks for 10 and 7)."""

LEADERS = (8.0, 12.0, 17.0, 23.0, 30.0, 38.0, 48.0, 60.0, 75.0, 95.0, 120.0)
"""Lengths of leaders, mm."""

FAN = (45, 135, -45, -135, 60, 120, -60, -120, 30, 150, -30, -150, 75, 105, -75, -105, 15, 165, -15, -165)
"""Directions of leaders, degrees."""

ARCS = (
    (0.5, 4.0),
    (0.7, 3.0),
    (0.85, 3.0),
    (0.3, 6.0),
    (1.0, 5.0),
    (1.15, 6.0),
    (1.3, 7.0),
    (1.6, 9.0),
    (2.0, 12.0),
    (2.5, 15.0),
    (3.0, 18.0),
)
"""Radii of the arcs of angles over the distance of what they measure, and what each costs, mm."""

FINE_ARCS = tuple((0.2 + 0.1 * k, 6.0 + k) for k in range(40))

Candidate = tuple[float, Annotation]


def of_distance(
    asked: AskedDistance, view: View, outline: Box2, part: Lines, *, harder: bool = False
) -> Iterator[Candidate]:
    """A dimension line outside the part, tier by tier on both sides; else close to what it measures.

    Where a measured face is seen as a line, the extension line starts from that line's end nearest to the dimension
    line. Where the likely places will not do, `harder` gives finer and farther ones.
    """
    tiers = [0.5 * tier for tier in range(30)] if harder else [float(tier) for tier in range(9)]
    turn = math.radians(asked.angle)
    u, n = (math.cos(turn), math.sin(turn)), (-math.sin(turn), math.cos(turn))
    points = (view.to_paper(asked.first), view.to_paper(asked.second))
    levels = [_dot(point, n) for point in points]
    runs = [part.along(point, n) for point in points]
    corners = [(x, y) for x in (outline[0], outline[2]) for y in (outline[1], outline[3])]
    span = abs(_dot(points[0], u) - _dot(points[1], u))
    upright = asked.angle in (0.0, 90.0)
    places: list[tuple[float, float]] = []
    for side in (-1, 1):
        own = max(side * level + max(side * end for end in run) for level, run in zip(levels, runs, strict=True))
        edge = max(side * _dot(corner, n) for corner in corners) if upright else own
        for tier in tiers:
            level = edge + FIRST + PITCH * tier
            reach = level - own
            places.append((5.0 * tier + 0.3 * reach, side * level))
        if edge > own + FIRST:
            places += [(14.0 + 0.12 * span + 6.0 * k, side * (own + FIRST + 6.0 * k)) for k in range(3)]
    if abs(levels[0] - levels[1]) < 1e-6:
        # Right across the feature, without extension lines.
        places.append((10.0 + 0.3 * span, levels[0]))
    ends = sorted(_dot(point, u) for point in points)
    for cost, level in sorted(places):
        starts = []
        for own, run, point in zip(levels, runs, (asked.first, asked.second), strict=True):
            step = min(max(level - own, run[0]), run[1]) / view.scale
            starts.append((point[0] + step * n[0], point[1] + step * n[1]))
        for extra, middle in _text_places(asked.text, ends[0], ends[1], harder):
            at = (u[0] * ends[0] + n[0] * level, u[1] * ends[0] + n[1] * level)
            angle = math.radians(readable(asked.angle))
            rise = TEXT_HEIGHT / 2 + GAP
            text_at = (
                u[0] * middle + n[0] * level - math.sin(angle) * rise,
                u[1] * middle + n[1] * level + math.cos(angle) * rise,
            )
            yield (
                cost + extra,
                LinearDimension(
                    asked.view,
                    starts[0],
                    starts[1],
                    asked.angle,
                    at,
                    asked.text,
                    asked.measured,
                    asked.names,
                    text_at,
                ),
            )


def _text_places(text: str, low: float, high: float, harder: bool) -> Iterator[tuple[float, float]]:
    """Middles of the text along the dimension line: between the arrows where it fits, else beside."""
    width, span = symbol_text_width(text), high - low
    middle = (low + high) / 2
    if width + 2 * GAP < span:
        yield 0.0, middle
        room = (span - width) / 2 - GAP - (ARROW if span > 2 * ARROW + 1 else 0.0)
        for share in (0.35, -0.35, 0.7, -0.7, 1.0, -1.0):
            if room > 3.0:
                yield 1.5 * abs(share) + 0.02 * abs(room * share), middle + room * share
    if harder or width + 2 * GAP >= span:
        for away in (1.5, 8.0, 15.0, 22.0, 29.0, 36.0) if harder else (1.5, 8.0):
            yield 0.5 + away / 4, high + away + width / 2
            yield 0.6 + away / 4, low - away - width / 2


def of_round(asked: AskedRound, view: View, outline: Box2, *, harder: bool = False) -> Iterator[Candidate]:
    """A leader that runs about square to the arc, from outside or from the side of the centre."""
    leans = (0.0, 20.0, -20.0, 40.0, -40.0, *((10.0, -10.0, 30.0, -30.0, 60.0, -60.0) if harder else ()))
    width, scale = symbol_text_width(asked.text), view.scale
    centre, radius = view.to_paper(asked.centre), asked.radius * scale
    if asked.kind == "diameter":
        turns = [45.0, 135.0, -45.0, -135.0, 30.0, 60.0, 120.0, 150.0, -30.0, -60.0, -120.0, -150.0]
    else:
        spread = min(asked.spread, math.degrees(3.0 / max(radius, 1e-9))) / 2
        turns = [asked.towards, asked.towards + spread, asked.towards - spread]
    inwards = (1.0, -1.0) if asked.kind == "radius" and radius > 0 else (1.0,)
    for towards in turns:
        turn = math.radians(towards)
        on = (centre[0] + radius * math.cos(turn), centre[1] + radius * math.sin(turn))
        for way in inwards:
            for lean in leans:
                lean_turn = math.radians(towards + lean) if way > 0 else math.radians(towards + 180 + lean)
                for length in LEADERS:
                    elbow = (on[0] + length * math.cos(lean_turn), on[1] + length * math.sin(lean_turn))
                    side = 1.0 if math.cos(lean_turn) >= -1e-9 else -1.0
                    text_at = (elbow[0] + side * (width / 2 + GAP), elbow[1] + TEXT_HEIGHT / 2 + GAP)
                    cost = 0.4 * length + abs(lean) / 20 + _indoors(elbow, outline) + _level(lean_turn)
                    yield (
                        cost,
                        RadialDimension(
                            asked.view,
                            asked.kind,
                            asked.centre,
                            asked.radius,
                            towards,
                            asked.text,
                            text_at,
                            asked.measured,
                            asked.names,
                        ),
                    )


def of_callout(
    asked: AskedCallout, view: View, outline: Box2, columns: tuple[float, float], *, harder: bool = False
) -> Iterator[Candidate]:
    """Elbows in a fan round the feature, and in a column at either side.

    Args:
        columns: where the columns of texts begin, left and right.
    """
    for rank, choice in enumerate((asked.at, *asked.choices)):
        at, radius = view.to_paper(choice), asked.radius * view.scale
        elbows: list[tuple[float, Point2]] = []
        for turn in range(-175, 180, 5) if harder else FAN:
            c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
            elbows += [(0.0, (at[0] + (radius + length) * c, at[1] + (radius + length) * s)) for length in LEADERS]
        for x in columns:
            for step in range(-60, 61) if harder else range(-9, 10):
                elbows.append((-2.0, (x, at[1] + (3.0 if harder else 7.0) * step)))
        for extra, elbow in elbows:
            away = math.dist(at, elbow)
            if away < radius + 4.0:
                continue
            out = ((elbow[0] - at[0]) / away, (elbow[1] - at[1]) / away)
            on = (at[0] + radius * out[0], at[1] + radius * out[1])
            cost = extra + 0.4 * (away - radius) + _indoors(elbow, outline) + _level(math.atan2(out[1], out[0])) + rank
            yield (
                cost,
                Callout(
                    asked.view,
                    ((on[0] - view.place[0]) / view.scale, (on[1] - view.place[1]) / view.scale),
                    elbow,
                    asked.lines,
                    asked.names,
                    out[0] < 0,
                ),
            )


def of_angle(asked: AskedAngle, view: View, *, harder: bool = False) -> Iterator[Candidate]:
    """Arcs about the vertex, from inside what is measured outwards."""
    parts = [0.05 * k for k in range(1, 20)] if harder else (0.5, 0.35, 0.65, 0.2, 0.8)
    vertex = view.to_paper(asked.vertex)
    ends = [view.to_paper(asked.first), view.to_paper(asked.second)]
    turns = [math.atan2(y - vertex[1], x - vertex[0]) for x, y in ends]
    sweep = (turns[1] - turns[0]) % math.tau
    first, second = asked.first, asked.second
    if sweep > math.pi:
        turns.reverse()
        first, second, sweep = second, first, math.tau - sweep
    reach = math.dist(vertex, ends[1])
    for share, cost in ARCS + (FINE_ARCS if harder else ()):
        radius = max(reach * share, 8.0)
        for part in parts:
            at = turns[0] + sweep * part
            yield (
                cost + 4 * abs(part - 0.5),
                AngularDimension(
                    asked.view,
                    asked.vertex,
                    first,
                    second,
                    (vertex[0] + radius * math.cos(at), vertex[1] + radius * math.sin(at)),
                    asked.text,
                    asked.measured,
                    asked.names,
                ),
            )


def of_frame(asked: AskedFrame, view: View, *, harder: bool = False) -> Iterator[Candidate]:
    """Square to the face, at several places along it; a control frame may lean."""
    lengths = [9.0 + 4.0 * k for k in range(25)] if harder else (9.0, 14.0, 20.0, 27.0, 35.0, 44.0, 54.0)
    leans = [4.0 * k for k in range(-15, 16)] if harder else (0.0, 6.0, -6.0, 14.0, -14.0, 26.0, -26.0)
    first, second = view.to_paper(asked.first), view.to_paper(asked.second)
    turn = math.radians(asked.outward)
    out, side = (math.cos(turn), math.sin(turn)), (-math.sin(turn), math.cos(turn))
    for share in (0.5, 0.3, 0.7, 0.15, 0.85, 0.4, 0.6, 0.05, 0.95):
        on = _between(asked.first, asked.second, share)
        at = _between(first, second, share)
        for length in lengths:
            cost = 0.5 * length + 2 * abs(share - 0.5)
            place = (at[0] + length * out[0], at[1] + length * out[1])
            if asked.letter:
                yield cost, DatumSymbol(asked.view, on, place, asked.letter)
                continue
            assert asked.characteristic is not None
            for lean in leans:
                elbow = (place[0] + lean * side[0], place[1] + lean * side[1])
                yield (
                    cost + 0.3 * abs(lean),
                    FeatureControlFrame(asked.view, on, elbow, asked.characteristic, asked.tolerance, asked.datums),
                )


def of_axis(asked: AskedFrame, view: View, across: LinearDimension) -> Iterator[Candidate]:
    """A datum's mark in line with the dimension of a diameter: the datum is its axis (ISO 5459)."""
    turn = math.radians(across.angle)
    u = (math.cos(turn), math.sin(turn))
    base = _dot(across.line_at, u)
    for point, out in ((across.first, 1.0), (across.second, 1.0), (across.first, -1.0), (across.second, -1.0)):
        step = _dot(view.to_paper(point), u) - base
        other = across.second if point is across.first else across.first
        if out * (_dot(view.to_paper(other), u) - base - step) > 0.0:
            continue
        foot = (across.line_at[0] + step * u[0], across.line_at[1] + step * u[1])
        on = ((foot[0] - view.place[0]) / view.scale, (foot[1] - view.place[1]) / view.scale)
        for length in (10.0, 14.0, 18.0, 24.0, 32.0, 44.0):
            frame_at = (foot[0] + out * length * u[0], foot[1] + out * length * u[1])
            yield 0.5 * length, DatumSymbol(asked.view, on, frame_at, asked.letter)


def _between(first: Point2, second: Point2, share: float) -> Point2:
    return (first[0] + share * (second[0] - first[0]), first[1] + share * (second[1] - first[1]))


def _indoors(point: Point2, outline: Box2) -> float:
    """What a text within the part's outline costs more than one outside."""
    inside = outline[0] < point[0] < outline[2] and outline[1] < point[1] < outline[3]
    return 9.0 if inside else 0.0


def _level(turn: float) -> float:
    """What a leader costs that is nearly level or upright, and so looks like a line of the part."""
    steep = abs(math.degrees(turn)) % 90
    return 2.5 if min(steep, 90 - steep) < 12 else 0.0


def _dot(a: Point2, b: Point2) -> float:
    return a[0] * b[0] + a[1] * b[1]
