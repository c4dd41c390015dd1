"""Candidate positions of annotations, and the cost of each position by itself.

The view is at the origin of the paper. All costs are in mm: lengths of leaders and distances from the part, and for
other properties the additional length of a leader that is as unfavourable. With `extended`, candidates are finer and
extend farther.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from drawings.annotations.annotation import (
    ARROW,
    BOX,
    GAP,
    TARGET,
    AngularDimension,
    Annotation,
    Callout,
    DatumSymbol,
    DatumTarget,
    DetailMark,
    FeatureControlFrame,
    HoleTag,
    LinearDimension,
    RadialDimension,
    ReferenceArrow,
    SectionMark,
    readable,
)
from drawings.annotations.primitives import TEXT_HEIGHT
from drawings.annotations.symbols import symbol_text_width
from drawings.dimensions.edges import near_end, places_along
from drawings.dimensions.specification import (
    AngleSpec,
    CalloutSpec,
    DistanceSpec,
    FrameSpec,
    RoundSpec,
    TagSpec,
    TargetSpec,
)
from drawings.views.segment_index import SegmentIndex
from drawings.views.view import Box2, Point2, View, direction, offset

FIRST, PITCH = 10.0, 8.0
"""Distance of the first dimension line from the part, and of the next ones from each other, mm (ISO 129-1: 10, 7)."""
LEVEL_COST, EXTENSION_COST = 5.0, 0.3
"""Cost of each level of dimension lines, mm, and of extension lines per mm."""
INSIDE_COST, INSIDE_STEP, INSIDE_SPAN_COST = 14.0, 6.0, 0.12
"""Cost of a dimension line within the outline, mm; cost and distance of each further one, mm; cost per mm of length."""
THROUGH_COST, THROUGH_MOST = 0.25, 6.0
"""Cost of an extension line within the outline, mm per mm, and its greatest value, mm."""
ANOTHER_COST, ANOTHER_NEAR = 40.0, 0.05
"""Cost of extension lines that both run along edges of another feature, which seems to be meant, mm; their distance."""
ACROSS_COST, ACROSS_SPAN_COST = 14.0, 0.3
"""Cost of a dimension line across the feature, without extension lines, mm, and cost per mm of its length."""
OFF_MIDDLE_COST, OFF_MIDDLE_DISTANCE_COST = 1.5, 0.02
"""Cost of a text at the end of its dimension line instead of in the middle, mm, and cost per mm off the middle."""
BESIDE_COST, BESIDE_DISTANCE_COST = 0.5, 0.25
"""Cost of a text outside its dimension line, mm, and cost per mm away from it."""
LEADER_COST = 0.4
"""Cost of a leader per mm."""
OBLIQUE_COST = 0.05
"""Cost of a leader that is not normal to its arc, mm per degree."""
INSIDE_OUTLINE_COST = 9.0
"""Cost of a text within the outline of the part, mm."""
AXIS_PARALLEL_COST, AXIS_PARALLEL_ANGLE = 2.5, 12.0
"""Cost of a leader that resembles a line of the part, mm, and its largest angle to an axis of the paper, degrees."""
INWARD_COST, ON_CENTRE_LINE = 15.0, 0.05
"""Cost of a leader that passes through the material to its face, or along a centre line of its hole, mm; sine of the
greatest angle between the two."""
COLUMN_BONUS = 2.0
"""Reduction of the cost of a callout in the column at either side of the view, mm."""
ARC_TEXT_COST = 4.0
"""Cost of an angle's text at an end of its arc instead of at its middle, mm per length of the arc."""
TAG_CLEARANCE, TAG_STEP = 2.0, 0.5
"""Clearance of a hole's name from the hole, and step and cost of each step by which it is farther away, mm."""
CUTTING_LINE_STEP, STEPS_BEYOND = 3.0, 4
"""Step, and cost of each step, by which an end of a cutting line is farther from the part, mm."""

FRAME_LEADER_COST, FRAME_SHIFT_COST, OFF_CENTRE_COST = 0.5, 0.3, 2.0
"""Costs of a control frame or datum symbol: of its leader per mm, of its shift along the face per mm, and of a leader
at the end of the face instead of at its middle, mm."""
FRAME_CLEARANCE = 1.3
"""Distance of a control frame from the end of the dimension line that it continues, mm."""
END_COST = 10.0
"""Cost of a leader at an end of the line of its face, mm."""

LEADERS = (8.0, 12.0, 17.0, 23.0, 30.0, 38.0, 48.0, 60.0, 75.0, 95.0, 120.0)
"""Lengths of leaders, mm."""
DIRECTIONS = (45, 135, -45, -135, 60, 120, -60, -120, 30, 150, -30, -150, 75, 105, -75, -105, 15, 165, -15, -165)
"""Directions of leaders, degrees."""
_ARC_RADII = (0.5, 0.7, 0.85, 0.3, 1.0, 1.15, 1.3, 1.6, 2.0, 2.5, 3.0)
_ARC_COSTS = (4.0, 3.0, 3.0, 6.0, 5.0, 6.0, 7.0, 9.0, 12.0, 15.0, 18.0)
ARCS = tuple(zip(_ARC_RADII, _ARC_COSTS, strict=True))
"""Radius of an angle's arc over the length of its sides, and its cost, mm."""
EXTENDED_ARCS = tuple((0.2 + 0.1 * k, 6.0 + k) for k in range(40))

Candidate = tuple[float, Annotation]
"""Cost in mm, and the annotation at that position."""


def distance_candidates(
    spec: DistanceSpec, view: View, outline: Box2, part: SegmentIndex, *, extended: bool = False
) -> Iterator[Candidate]:
    """Dimension lines outside the part, level by level on both sides; within its outline; across the feature.

    Where a measured face is seen as a line, the extension line begins at the end of that line nearest to the dimension
    line.
    """
    levels = [0.5 * level for level in range(30)] if extended else [float(level) for level in range(9)]
    u = direction(spec.angle)
    n = (-u[1], u[0])
    points = (view.to_paper(spec.first), view.to_paper(spec.second))
    heights = [dot(point, n) for point in points]
    runs = [part.collinear_run(point, n) for point in points]
    corners = [(x, y) for x in (outline[0], outline[2]) for y in (outline[1], outline[3])]
    span = abs(dot(points[0], u) - dot(points[1], u))
    reach = [dot(corner, n) for corner in corners]
    across = (min(reach), max(reach))
    places: list[tuple[float, float]] = []
    for side in (-1, 1):
        own = max(side * height + max(side * end for end in run) for height, run in zip(heights, runs, strict=True))
        edge = max(side * dot(corner, n) for corner in corners) if spec.angle in (0.0, 90.0) else own
        for level in levels:
            height = edge + FIRST + PITCH * level
            places.append((LEVEL_COST * level + EXTENSION_COST * (height - own), side * height))
        if edge > own + FIRST:
            steps = [INSIDE_STEP * k for k in range(3)]
            places += [(INSIDE_COST + INSIDE_SPAN_COST * span + step, side * (own + FIRST + step)) for step in steps]
    if abs(heights[0] - heights[1]) < 1e-6:
        places.append((ACROSS_COST + ACROSS_SPAN_COST * span, heights[0]))
    ends = sorted(dot(point, u) for point in points)
    up = direction(readable(spec.angle) + 90.0)
    rise = TEXT_HEIGHT / 2 + GAP
    for cost, height in sorted(places):
        starts, ways = [], []
        for own, run, point in zip(heights, runs, (spec.first, spec.second), strict=True):
            start = own + min(max(height - own, run[0]), run[1])
            starts.append(offset(point, n, (start - own) / view.scale))
            ways.append((*offset(view.to_paper(point), n, start - own), *offset(view.to_paper(point), n, height - own)))
            within = min(max(start, height), across[1]) - max(min(start, height), across[0])
            cost += min(THROUGH_MOST, THROUGH_COST * max(0.0, within))
        cost += ANOTHER_COST * all(part.count_beside(ANOTHER_NEAR, way)[0] for way in ways)
        line_at = (u[0] * ends[0] + n[0] * height, u[1] * ends[0] + n[1] * height)
        for text_cost, middle in _text_positions(spec.text, ends[0], ends[1], extended):
            text_at = offset((u[0] * middle + n[0] * height, u[1] * middle + n[1] * height), up, rise)
            dimension = LinearDimension(
                spec.view, starts[0], starts[1], spec.angle, line_at, spec.text, spec.measured, spec.names, text_at
            )
            yield cost + text_cost, dimension


def _text_positions(text: str, low: float, high: float, extended: bool) -> Iterator[tuple[float, float]]:
    """Cost and middle of a text along its dimension line: between the arrows where it fits, else outside them."""
    width, span = symbol_text_width(text), high - low
    middle = (low + high) / 2
    if width + 2 * GAP < span:
        yield 0.0, middle
        slack = (span - width) / 2 - GAP - (ARROW if span > 2 * ARROW + 1 else 0.0)
        for fraction in (0.35, -0.35, 0.7, -0.7, 1.0, -1.0):
            if slack > 3.0:
                off = abs(slack * fraction)
                yield OFF_MIDDLE_COST * abs(fraction) + OFF_MIDDLE_DISTANCE_COST * off, middle + slack * fraction
    if extended or width + 2 * GAP >= span:
        for away in (1.5, 8.0, 15.0, 22.0, 29.0, 36.0) if extended else (1.5, 8.0):
            cost = BESIDE_COST + BESIDE_DISTANCE_COST * away
            yield cost, high + away + width / 2
            yield cost + 0.1, low - away - width / 2


def round_candidates(spec: RoundSpec, view: View, outline: Box2, *, extended: bool = False) -> Iterator[Candidate]:
    """Leaders approximately normal to the arc, from outside, or from the side of the centre for a radius."""
    obliques = (0.0, 20.0, -20.0, 40.0, -40.0, *((10.0, -10.0, 30.0, -30.0, 60.0, -60.0) if extended else ()))
    width = symbol_text_width(spec.text)
    centre, radius = view.to_paper(spec.centre), spec.radius * view.scale
    if spec.kind == "diameter":
        turns = [45.0, 135.0, -45.0, -135.0, 30.0, 60.0, 120.0, 150.0, -30.0, -60.0, -120.0, -150.0, spec.towards]
    else:
        spread = min(spec.spread, math.degrees(3.0 / max(radius, 1e-9))) / 2
        turns = [spec.towards, spec.towards + spread, spec.towards - spread]
    sides = (0.0, 180.0) if spec.kind == "radius" and radius > 0 else (0.0,)
    shown = partial(RadialDimension, spec.view, spec.kind, spec.centre, spec.radius, text=spec.text, names=spec.names)
    for towards in turns:
        on = offset(centre, direction(towards), radius)
        for side in sides:
            for oblique in obliques:
                out = direction(towards + side + oblique)
                for length in LEADERS:
                    elbow = offset(on, out, length)
                    side_of_text = 1.0 if out[0] >= -1e-9 else -1.0
                    text_at = (elbow[0] + side_of_text * (width / 2 + GAP), elbow[1] + TEXT_HEIGHT / 2 + GAP)
                    cost = LEADER_COST * length + OBLIQUE_COST * abs(oblique) + _leader_cost(elbow, out, outline)
                    yield cost, shown(towards=towards, text_at=text_at, measured=spec.measured)


def callout_candidates(
    spec: CalloutSpec, view: View, outline: Box2, columns: tuple[float, float], *, extended: bool = False
) -> Iterator[Candidate]:
    """Positions of a callout in all directions around the feature, and in a column at either side of the view."""
    directions = range(-175, 180, 5) if extended else DIRECTIONS
    steps, pitch = (range(-60, 61), 3.0) if extended else (range(-9, 10), 7.0)
    for rank, choice in enumerate((spec.at, *spec.choices)):
        at, radius = view.to_paper(choice), spec.radius * view.scale
        elbows = [(0.0, offset(at, direction(turn), radius + length)) for turn in directions for length in LEADERS]
        elbows += [(-COLUMN_BONUS, (x, at[1] + pitch * step)) for x in columns for step in steps]
        for extra, elbow in elbows:
            away = math.dist(at, elbow)
            if away < radius + 4.0:
                continue
            out = ((elbow[0] - at[0]) / away, (elbow[1] - at[1]) / away)
            on = view_point(offset(at, out, radius), view)
            cost = extra + LEADER_COST * (away - radius) + _leader_cost(elbow, out, outline) + rank
            if radius and min(map(abs, out)) < ON_CENTRE_LINE:
                cost += INWARD_COST
            if spec.outward is not None and dot(out, direction(spec.outward)) < 0.1:
                cost += INWARD_COST
            yield cost, Callout(spec.view, on, elbow, spec.lines, spec.names, out[0] < 0)


def angle_candidates(spec: AngleSpec, view: View, *, extended: bool = False) -> Iterator[Candidate]:
    """Arcs about the vertex, each with its text at several angles."""
    fractions = [0.05 * k for k in range(1, 20)] if extended else (0.5, 0.35, 0.65, 0.2, 0.8)
    vertex = view.to_paper(spec.vertex)
    ends = [view.to_paper(spec.first), view.to_paper(spec.second)]
    turns = [math.atan2(y - vertex[1], x - vertex[0]) for x, y in ends]
    sweep = (turns[1] - turns[0]) % math.tau
    first, second = spec.first, spec.second
    if sweep > math.pi:
        turns.reverse()
        first, second, sweep = second, first, math.tau - sweep
    side = math.dist(vertex, ends[1])
    for ratio, cost in ARCS + (EXTENDED_ARCS if extended else ()):
        radius = max(side * ratio, 8.0)
        for fraction in fractions:
            turn = turns[0] + sweep * fraction
            at = (vertex[0] + radius * math.cos(turn), vertex[1] + radius * math.sin(turn))
            dimension = AngularDimension(
                spec.view, spec.vertex, first, second, at, spec.text, spec.measured, spec.names
            )
            yield cost + ARC_TEXT_COST * abs(fraction - 0.5), dimension


def tag_candidates(spec: TagSpec, view: View, *, extended: bool = False) -> Iterator[Candidate]:
    """Positions of the name of a hole next to the hole in all directions, the nearest first."""
    at, radius = view.to_paper(spec.at), spec.radius * view.scale
    half = symbol_text_width(spec.text) / 2
    steps = [TAG_STEP * k for k in range(40 if extended else 14)]
    for turn in (45, 135, -45, -135, 0, 90, 180, -90, 20, 70, 110, 160, -20, -70, -110, -160):
        out = direction(turn)
        # The box of the text touches a circle about the hole.
        clear = radius + TAG_CLEARANCE + abs(out[0]) * half + abs(out[1]) * TEXT_HEIGHT / 2
        for step in steps:
            yield step, HoleTag(spec.view, spec.at, offset(at, out, clear + step), spec.text)


def target_candidates(spec: TargetSpec, view: View, outline: Box2) -> Iterator[Candidate]:
    """Positions of the circle of a datum target in all directions, preferably outside the outline of the part."""
    at = view.to_paper(spec.at)
    for turn in range(-175, 180, 5):
        out = direction(turn)
        for length in LEADERS:
            centre = offset(at, out, length + TARGET)
            cost = LEADER_COST * length + _leader_cost(centre, out, outline)
            yield cost, DatumTarget(spec.view, spec.at, centre, spec.text)


def frame_candidates(spec: FrameSpec, view: View, *, extended: bool = False) -> Iterator[Candidate]:
    """Frames on leaders normal to the face, at several places along it; a control frame may be shifted sideways."""
    lengths = [9.0 + 4.0 * k for k in range(25)] if extended else (9.0, 14.0, 20.0, 27.0, 35.0, 44.0, 54.0)
    shifts = [4.0 * k for k in range(-15, 16)] if extended else (0.0, 6.0, -6.0, 14.0, -14.0, 26.0, -26.0)
    first, second = view.to_paper(spec.first), view.to_paper(spec.second)
    out = direction(spec.outward)
    along = (-out[1], out[0])
    face = math.dist(first, second)
    for fraction in places_along(spec.at, face):
        on = between(spec.first, spec.second, fraction)
        at = between(first, second, fraction)
        for length in lengths:
            cost = FRAME_LEADER_COST * length + OFF_CENTRE_COST * abs(fraction - spec.at)
            cost += END_COST * near_end(fraction, face)
            place = offset(at, out, length)
            if spec.letter:
                yield cost, DatumSymbol(spec.view, on, place, spec.letter)
                continue
            for shift in shifts:
                yield cost + FRAME_SHIFT_COST * abs(shift), _frame(spec, on, offset(place, along, shift))


def axis_candidates(spec: FrameSpec, view: View, diameter: LinearDimension) -> Iterator[Candidate]:
    """Datum symbols and control frames in line with the dimension line of a diameter: they apply to its axis (ISO 1101,
    ISO 5459). A control frame may also be at the end of the dimension line that is extended under its text."""
    u = direction(diameter.angle)
    base = dot(diameter.line_at, u)
    for point, out in ((diameter.first, 1.0), (diameter.second, 1.0), (diameter.first, -1.0), (diameter.second, -1.0)):
        step = dot(view.to_paper(point), u) - base
        other = diameter.second if point is diameter.first else diameter.first
        if out * (dot(view.to_paper(other), u) - base - step) > 0.0:
            continue
        foot = offset(diameter.line_at, u, step)
        for length in (10.0, 14.0, 18.0, 24.0, 32.0, 44.0):
            yield FRAME_LEADER_COST * length, _in_line(spec, view, foot, offset(foot, u, out * length))
        if spec.letter or diameter.text_at is None:
            continue
        beyond = out * (dot(diameter.text_at, u) - base - step) + symbol_text_width(diameter.text) / 2
        if beyond > 0.0:
            end = offset(foot, u, out * beyond)
            clear = FRAME_CLEARANCE + abs(u[1]) * BOX / 2
            yield 0.0, _in_line(spec, view, end, offset(end, u, out * clear))


def _in_line(spec: FrameSpec, view: View, foot: Point2, end: Point2) -> DatumSymbol | FeatureControlFrame:
    """A datum symbol or control frame with its leader from one point on the paper to another."""
    at = view_point(foot, view)
    return _frame(spec, at, end) if spec.characteristic else DatumSymbol(spec.view, at, end, spec.letter)


def _frame(spec: FrameSpec, at: Point2, end: Point2) -> FeatureControlFrame:
    assert spec.characteristic is not None
    return FeatureControlFrame(spec.view, at, end, spec.characteristic, spec.tolerance, spec.datums, spec.count)


def detail_mark_candidates(mark: DetailMark, view: View, outline: Box2) -> Iterator[Candidate]:
    """Positions of the letter at the circle of a detail in all directions, the nearest outside the part first."""
    centre, radius = view.to_paper(mark.centre), mark.radius * view.scale
    for turn in (45, 135, -45, -135, 90, -90, 0, 180, 65, 25, 115, 155, -65, -25, -115, -155):
        for away in (4.0, 6.0, 9.0, 12.0, 16.0, 20.0, 26.0):
            x, y = at = offset(centre, direction(turn), radius + away)
            inside = outline[0] < x < outline[2] and outline[1] < y < outline[3]
            yield away + INSIDE_OUTLINE_COST * inside, replace(mark, letter_at=at)


def reference_arrow_candidates(arrow: ReferenceArrow) -> Iterator[Candidate]:
    """Positions of a reference arrow at several distances from the part, shifted along its side."""
    along = (-arrow.sight[1], arrow.sight[0])
    for away in range(10):
        for shift in (0.0, 8.0, -8.0, 16.0, -16.0, 28.0, -28.0, 40.0, -40.0):
            tip = offset(offset(arrow.tip, arrow.sight, -CUTTING_LINE_STEP * away), along, shift)
            yield CUTTING_LINE_STEP * away + 0.1 * abs(shift), replace(arrow, tip=tip)


def section_mark_candidates(mark: SectionMark, reach: float) -> Iterator[Candidate]:
    """Positions of a cutting line with each end at several distances from the part, also beyond what is drawn up to
    a distance `reach` from the part."""
    first, last = (mark.corners or (mark.end,))[0], (mark.corners or (mark.start,))[-1]
    steps = int(reach / CUTTING_LINE_STEP) + STEPS_BEYOND
    for i in range(steps):
        for j in range(steps):
            ways = ((first, mark.start, i), (last, mark.end, j))
            start, end = (between(a, b, 1.0 + CUTTING_LINE_STEP * step / math.dist(a, b)) for a, b, step in ways)
            yield CUTTING_LINE_STEP * (i + j), replace(mark, start=start, end=end)


def _leader_cost(elbow: Point2, out: Point2, outline: Box2) -> float:
    """Cost of a text within the outline of the part, and of a leader nearly parallel to an axis of the paper."""
    inside = outline[0] < elbow[0] < outline[2] and outline[1] < elbow[1] < outline[3]
    angle = abs(math.degrees(math.atan2(out[1], out[0]))) % 90
    parallel = min(angle, 90 - angle) < AXIS_PARALLEL_ANGLE
    return (INSIDE_OUTLINE_COST if inside else 0.0) + (AXIS_PARALLEL_COST if parallel else 0.0)


def between(first: Point2, second: Point2, fraction: float) -> Point2:
    return (first[0] + fraction * (second[0] - first[0]), first[1] + fraction * (second[1] - first[1]))


def view_point(point: Point2, view: View) -> Point2:
    """View coordinates of a point of the paper."""
    return ((point[0] - view.place[0]) / view.scale, (point[1] - view.place[1]) / view.scale)


def dot(a: Point2, b: Point2) -> float:
    return a[0] * b[0] + a[1] * b[1]
