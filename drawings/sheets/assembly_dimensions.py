"""Overall dimensions of the machine and the travel of its stage, as reference dimensions in brackets (ISO 129-1)."""

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
"""Distance of the first dimension line from the view, and of the next ones, mm on the paper."""
SIDE = 24.0
"""Distance of the dimension lines from the top view, beyond the letters of the sections, mm on the paper."""
DIMENSIONED = FIRST + 2 * NEXT
"""Height of the dimensions above a view, mm on the paper."""
_NEAR = 1e-3


@dataclass(frozen=True)
class MachineSize:
    """Size of the machine.

    Args:
        low, high: corners of its bounding box at the middle of travel, assembly coordinates, mm.
        travel: of the parts that move from end to end, mm; 0 without.
    """

    low: Point
    high: Point
    travel: float


@dataclass(frozen=True)
class TravelRange:
    """The stage at both ends of its travel, in a view with the travel along u.

    Args:
        lines: outline of the stage at the ends, view coordinates.
        corners: upper corners of its end faces, left and right, at the middle of travel.
    """

    lines: tuple[Curve, ...]
    corners: tuple[Point2, Point2]


def travel_range(stage: Sequence[Curve], travel: float) -> TravelRange:
    """The end faces of the stage at the ends of travel, and its upper and lower edges up to the middle position.

    Args:
        stage: its visible lines, view coordinates.
        travel: from end to end, mm.
    """
    lines: list[Curve] = []
    corners: list[Point2] = []
    for side in (-1.0, 1.0):
        farthest = {number: max(side * u for u, _ in extreme_points(curve)) for number, curve in enumerate(stage)}
        face = [stage[number] for number, end in farthest.items() if end > max(farthest.values()) - _NEAR]
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
    return TravelRange(tuple(lines), (corners[0], corners[1]))


def overall_dimensions(
    size: MachineSize, top: View, front: View, ends: TravelRange | None
) -> Iterator[LinearDimension]:
    """Length and width at the view from above, height and travel at the section."""
    (x0, y0, z0), (x1, y1, z1) = size.low, size.high
    left, _, _, above = view_box(top) or (0.0, 0.0, 0.0, 0.0)
    yield _reference(top, (x0, y1), (x1, y1), 0.0, (left, above + SIDE), "overall length")
    yield _reference(top, (x0, y0), (x0, y1), 90.0, (left - SIDE, above), "overall width")
    _, _, right, above = view_box(front) or (0.0, 0.0, 0.0, 0.0)
    if ends is None:
        yield _reference(front, (x1, z0), (x1, z1), 90.0, (right + FIRST, above), "overall height")
        return
    half = size.travel / 2
    (u0, v0), (u1, v1) = ends.corners
    yield _reference(front, (x1, z0), (u1 + half, z1), 90.0, (right + FIRST, above), "overall height")
    halves = [
        _reference(front, first, second, 0.0, (right, above + FIRST), "half of the travel")
        for first, second in (((u0 - half, v0), (u0, v0)), ((u1, v1), (u1 + half, v1)))
    ]
    # Where the number does not fit between the arrows, the travel is in the notes only.
    if half * front.scale > max(text_width(one.text) for one in halves) + 2 * ARROW:
        yield from halves
    over = (right, above + FIRST + NEXT)
    yield _reference(front, (u0 - half, v0), (u1 + half, v1), 0.0, over, "length over the ends of travel")


def _reference(view: View, first: Point2, second: Point2, angle: float, line_at: Point2, name: str) -> LinearDimension:
    """A horizontal or vertical dimension in brackets between two points of a view."""
    measured = abs(second[0] - first[0]) if angle == 0.0 else abs(second[1] - first[1])
    return LinearDimension(view.name, first, second, angle, line_at, f"({measured:.1f})", measured, (name,))
