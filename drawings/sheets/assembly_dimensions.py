"""What a shop wants to know of the whole machine before it finds a place for it: its size, and how far its stage goes.

All of it is for reference, in brackets (ISO 129-1): each number follows from the parts' own dimensions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from drawings.annotations.annotation import LinearDimension
from drawings.annotations.annotation_geometry import ARROW
from drawings.annotations.font import text_width
from drawings.views.bounding_box import extreme_points, view_box
from drawings.views.view import Curve, Point2, Segment, View
from stagecad.parameters.dimension import Point

FIRST, NEXT = 12.0, 10.0
"""From a view to its first dimension line, and from one to the next, mm on paper."""
SIDE = 24.0
"""From the view from above to the dimension line of its width, which passes the letters of the section, mm on paper."""
DIMENSIONED = FIRST + 2 * NEXT
"""Room that the dimensions above a view take, mm on paper."""
_NEAR = 1e-3


@dataclass(frozen=True)
class Extent:
    """How much room the machine takes.

    Args:
        low, high: corners of its box at the middle of travel, assembly coordinates, mm.
        travel: of the stage from end to end, mm.
    """

    low: Point
    high: Point
    travel: float


@dataclass(frozen=True)
class Reach:
    """The ends of the stage's travel in a view along which it goes.

    Args:
        lines: what is drawn of the stage there, view coordinates.
        corners: the upper corner of the stage's end face, on the left and on the right, at the middle of travel.
    """

    lines: tuple[Curve, ...]
    corners: tuple[Point2, Point2]


def reach_of(stage: Sequence[Curve], travel: float) -> Reach:
    """Both end faces of the stage at the ends of travel, and its sides from there to where it stands in the view.

    Args:
        stage: its visible lines, view coordinates; it goes to the left and to the right.
        travel: from end to end, mm.
    """
    lines: list[Curve] = []
    corners: list[Point2] = []
    for side in (-1.0, 1.0):
        ends = {number: max(side * u for u, _ in extreme_points(curve)) for number, curve in enumerate(stage)}
        face = [stage[number] for number, end in ends.items() if end > max(ends.values()) - _NEAR]
        upright = [c for c in face if isinstance(c, Segment) and abs(c.start[0] - c.end[0]) < _NEAR]
        shift = side * travel / 2
        low, high = (
            pick((point for curve in upright or face for point in extreme_points(curve)), key=lambda point: point[1])
            for pick in (min, max)
        )
        corners.append(high)
        moved = [(u + shift, v) for u, v in (low, high)]
        lines.append(Segment(moved[0], moved[1]))
        lines += [Segment(at, end) for at, end in zip((low, high), moved, strict=True)]
    return Reach(tuple(lines), (corners[0], corners[1]))


def overall(extent: Extent, top: View, front: View, reach: Reach) -> Iterator[LinearDimension]:
    """Length and width at the view from above, height and travel at the section.

    Args:
        top, front: placed; with all their lines.
        reach: drawn in the section.
    """
    (x0, y0, z0), (x1, y1, z1) = extent.low, extent.high
    left, _, _, above = view_box(top) or (0.0, 0.0, 0.0, 0.0)
    yield _reference(top, (x0, y1), (x1, y1), 0.0, (left, above + FIRST), "overall length")
    yield _reference(top, (x0, y0), (x0, y1), 90.0, (left - SIDE, above), "overall width")
    _, _, right, above = view_box(front) or (0.0, 0.0, 0.0, 0.0)
    half = extent.travel / 2
    (u0, v0), (u1, v1) = reach.corners
    yield _reference(front, (x1, z0), (u1 + half, z1), 90.0, (right + FIRST, above), "overall height")
    halves = [
        _reference(front, first, second, 0.0, (right, above + FIRST), "half of the travel")
        for first, second in (((u0 - half, v0), (u0, v0)), ((u1, v1), (u1 + half, v1)))
    ]
    # Between arrows that stand too close for the number, it is left to the notes.
    if half * front.scale > max(text_width(one.text) for one in halves) + 2 * ARROW:
        yield from halves
    over = (right, above + FIRST + NEXT)
    yield _reference(front, (u0 - half, v0), (u1 + half, v1), 0.0, over, "length over the ends of travel")


def _reference(view: View, first: Point2, second: Point2, angle: float, line_at: Point2, name: str) -> LinearDimension:
    """A dimension in brackets, level or upright, between two points of a view."""
    measured = abs(second[0] - first[0]) if angle == 0.0 else abs(second[1] - first[1])
    return LinearDimension(view.name, first, second, angle, line_at, f"({measured:.1f})", measured, (name,))
