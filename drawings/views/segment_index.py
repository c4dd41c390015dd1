"""Straight lines on the paper, and queries for those that a box or a line meets; curves as chords of such lines.

The placement of annotations and the check of the finished sheet use the same queries. Coordinates in mm on the paper.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from drawings.views.view import Arc, Box2, Curve, Point2, Polyline, Segment

Line = tuple[float, float, float, float]
"""Ends of a straight line: x0, y0, x1, y1."""

CHORD = 0.05
"""Greatest distance of a chord from its arc, mm on the paper."""


BESIDE_TIP, OF_RADIUS = 1.5, 0.25
"""Distance along an arc on either side of the end of a leader at which the arc must be drawn, mm on the paper, and its
greatest value as a fraction of the radius."""


class SegmentIndex:
    """Straight lines as arrays, with their bounding boxes, for vectorised queries."""

    def __init__(self, lines: Sequence[Line] = ()) -> None:
        # Rows: x0, y0, x1, y1, then the bounding box: low x, low y, high x, high y.
        self._rows = np.empty((8, 0))
        self.add(lines)

    def add(self, lines: Sequence[Line]) -> None:
        """Add lines to the index."""
        if lines:
            ends = np.array(lines).T
            new = np.vstack((ends, np.minimum(ends[:2], ends[2:]), np.maximum(ends[:2], ends[2:])))
            self._rows = np.hstack((self._rows, new))

    def count_in(self, box: Box2) -> int:
        """Number of lines that reach into a box."""
        near = self._near(box)
        dx, dy = near[2] - near[0], near[3] - near[1]
        half_x, half_y = (box[2] - box[0]) / 2, (box[3] - box[1]) / 2
        off = dx * ((box[1] + box[3]) / 2 - near[1]) - dy * ((box[0] + box[2]) / 2 - near[0])
        return int(np.count_nonzero(np.abs(off) < np.abs(dx) * half_y + np.abs(dy) * half_x))

    def near(self, box: Box2) -> list[Line]:
        """The lines whose bounding boxes overlap a box."""
        return [(x0, y0, x1, y1) for x0, y0, x1, y1 in self._near(box).T.tolist()]

    def outside(self, box: Box2) -> list[Line]:
        """The lines that are not entirely within a box."""
        rows = self._rows
        out = (rows[4] < box[0]) | (rows[6] > box[2]) | (rows[5] < box[1]) | (rows[7] > box[3])
        return [(x0, y0, x1, y1) for x0, y0, x1, y1 in rows[:4, out].T.tolist()]

    def count_crossing(self, line: Line) -> int:
        """Number of lines that a line crosses; lines that only touch it with an end are not counted."""
        x0, y0, x1, y1 = line
        near = self._near(line_box(line))
        dx, dy = x1 - x0, y1 - y0
        ex, ey = near[2] - near[0], near[3] - near[1]
        first = dx * (near[1] - y0) - dy * (near[0] - x0)
        second = dx * (near[3] - y0) - dy * (near[2] - x0)
        third = ex * (y0 - near[1]) - ey * (x0 - near[0])
        fourth = ex * (y1 - near[1]) - ey * (x1 - near[0])
        least = 1e-6
        return int(np.count_nonzero((first * second < -least) & (third * fourth < -least)))

    def collinear_run(self, point: Point2, direction: Point2, near: float = 0.05) -> tuple[float, float]:
        """The stretch without gaps that lines cover on the line through a point, as distances from the point.

        Both are 0 where there is no line.
        """
        u, v = direction
        ends = self._rows[:4]
        off = [(ends[i] - point[0]) * v - (ends[i + 1] - point[1]) * u for i in (0, 2)]
        on = (np.abs(off[0]) < near) & (np.abs(off[1]) < near)
        at = [(ends[i, on] - point[0]) * u + (ends[i + 1, on] - point[1]) * v for i in (0, 2)]
        low, high = 0.0, 0.0
        for a, b in sorted(zip(np.minimum(*at).tolist(), np.maximum(*at).tolist())):
            if a <= high + near and b >= low - near:
                low, high = min(low, a), max(high, b)
        return low, high

    def count_parallel(self, line: Line, distance: float) -> int:
        """Number of lines parallel to a line, nearer than a distance, for more than a millimetre."""
        x0, y0, x1, y1 = line
        near = self._near(enlarged(line_box(line), distance))
        length = math.hypot(x1 - x0, y1 - y0)
        if length < 1e-9:
            return 0
        u, v = (x1 - x0) / length, (y1 - y0) / length
        off = [np.abs((near[i] - x0) * v - (near[i + 1] - y0) * u) for i in (0, 2)]
        at = [(near[i] - x0) * u + (near[i + 1] - y0) * v for i in (0, 2)]
        shared = np.minimum(np.maximum(*at), length) - np.maximum(np.minimum(*at), 0.0)
        return int(np.count_nonzero((np.maximum(*off) < distance) & (shared > 1.0)))

    def _near(self, box: Box2) -> np.ndarray:
        """Ends (4, n) of the lines whose bounding boxes overlap a box."""
        rows = self._rows
        return rows[:4, (rows[6] > box[0]) & (rows[4] < box[2]) & (rows[7] > box[1]) & (rows[5] < box[3])]


def boxes_overlap(one: Box2, other: Box2) -> bool:
    """Whether two boxes share some area."""
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def enlarged(box: Box2, margin: float) -> Box2:
    """A box enlarged by a margin on each side."""
    return (box[0] - margin, box[1] - margin, box[2] + margin, box[3] + margin)


def line_box(line: Line) -> Box2:
    """Bounding box of a straight line."""
    x0, y0, x1, y1 = line
    return (min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))


def line_meets_box(line: Line, box: Box2) -> bool:
    """Whether a straight line reaches into a box."""
    if not boxes_overlap(line_box(line), box):
        return False
    x0, y0, x1, y1 = line
    dx, dy = x1 - x0, y1 - y0
    off = dx * ((box[1] + box[3]) / 2 - y0) - dy * ((box[0] + box[2]) / 2 - x0)
    return abs(off) < abs(dx) * (box[3] - box[1]) / 2 + abs(dy) * (box[2] - box[0]) / 2


def polyline_lines(points: Sequence[Point2]) -> list[Line]:
    """The straight lines of a polyline."""
    return [(*a, *b) for a, b in pairwise(points)]


def arc_points(arc: Arc, scale: float = 1.0) -> list[Point2]:
    """Points along an arc whose chords deviate from it by at most `CHORD` on the paper."""
    radius = max(arc.radius * scale, 1e-9)
    step = 2 * math.acos(max(1 - CHORD / radius, 0.0))
    turn = math.radians((arc.end_angle - arc.start_angle) % 360.0 or 360.0)
    count = max(2, math.ceil(turn / step))
    start = math.radians(arc.start_angle)
    return [
        (arc.centre[0] + arc.radius * math.cos(a), arc.centre[1] + arc.radius * math.sin(a))
        for a in (start + turn * i / count for i in range(count + 1))
    ]


def points_beside(tip: Point2, centre: Point2) -> tuple[Point2, Point2]:
    """Points of the arc on either side of the end of the leader of a radius, mm on paper."""
    radius = math.dist(tip, centre)
    turn = math.atan2(tip[1] - centre[1], tip[0] - centre[0])
    step = min(BESIDE_TIP / max(radius, 1e-9), OF_RADIUS)
    one, other = (
        (centre[0] + radius * math.cos(turn + side), centre[1] + radius * math.sin(turn + side))
        for side in (-step, step)
    )
    return one, other


def curve_points(curve: Curve, scale: float = 1.0) -> Sequence[Point2]:
    """Points of the polyline that approximates a curve of a view at a scale."""
    match curve:
        case Segment():
            return (curve.start, curve.end)
        case Polyline():
            return curve.points
        case Arc():
            return arc_points(curve, scale)
