"""Straight lines on the paper, and queries for those that meet a box or a line; curves are approximated by chords.

The placement of annotations and the check of the finished sheet use the same queries, some 100 000 of them for a large
sheet: they are compiled. Coordinates in mm on the paper.
"""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numba
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
    """Straight lines as an array, with their bounding boxes, for compiled queries of several boxes or lines at once."""

    def __init__(self, lines: Sequence[Line] = ()) -> None:
        # Columns: x0, y0, x1, y1, then the bounding box: low x, low y, high x, high y.
        self._rows = np.empty((0, 8))
        self.add(lines)

    def add(self, lines: Sequence[Line]) -> None:
        """Add lines to the index."""
        if lines:
            ends = np.array(lines, dtype=float)
            low, high = np.minimum(ends[:, :2], ends[:, 2:]), np.maximum(ends[:, :2], ends[:, 2:])
            self._rows = np.vstack((self._rows, np.hstack((ends, low, high))))

    def count_in(self, *boxes: Box2) -> int:
        """Number of lines that reach into boxes."""
        return count_meetings(self._rows, boxes)

    def count_into(self, lines: Sequence[Line], by: float) -> int:
        """Number of times that lines reach into the boxes of the lines of the index, enlarged by a margin."""
        return count_meetings(lines, self._rows[:, 4:], by)

    def numbers_near(self, box: Box2) -> list[int]:
        """Numbers of the lines, in the order of their entry, whose bounding boxes overlap a box."""
        rows = self._rows
        over = (rows[:, 6] > box[0]) & (rows[:, 4] < box[2]) & (rows[:, 7] > box[1]) & (rows[:, 5] < box[3])
        return np.flatnonzero(over).tolist()

    def near(self, box: Box2) -> list[Line]:
        """The lines whose bounding boxes overlap a box."""
        return [(x0, y0, x1, y1) for x0, y0, x1, y1 in self._rows[self.numbers_near(box), :4].tolist()]

    def outside(self, box: Box2) -> list[Line]:
        """The lines that are not entirely within a box."""
        rows = self._rows
        out = (rows[:, 4] < box[0]) | (rows[:, 6] > box[2]) | (rows[:, 5] < box[1]) | (rows[:, 7] > box[3])
        return [(x0, y0, x1, y1) for x0, y0, x1, y1 in rows[out, :4].tolist()]

    def count_crossing(self, *lines: Line) -> int:
        """Number of lines that lines cross; lines that only touch one with an end are not counted."""
        return _count_crossing(self._rows, np.array(lines)) if lines and len(self._rows) else 0

    def collinear_run(self, point: Point2, direction: Point2, near: float = 0.05) -> tuple[float, float]:
        """The range without gaps that lines cover on the line through a point, as distances from the point.

        Both are 0 where there is no line.
        """
        u, v = direction
        ends = self._rows[:, :4].T
        off = [(ends[i] - point[0]) * v - (ends[i + 1] - point[1]) * u for i in (0, 2)]
        on = (np.abs(off[0]) < near) & (np.abs(off[1]) < near)
        at = [(ends[i, on] - point[0]) * u + (ends[i + 1, on] - point[1]) * v for i in (0, 2)]
        low, high = 0.0, 0.0
        for a, b in sorted(zip(np.minimum(*at).tolist(), np.maximum(*at).tolist())):
            if a <= high + near and b >= low - near:
                low, high = min(low, a), max(high, b)
        return low, high

    def count_beside(self, distance: float, *lines: Line) -> tuple[int, int]:
        """Number of lines parallel to lines, nearer than a distance, for more than a millimetre; and of the lines that
        are within 0.1 rad of the direction of one of the index, and of which an end of this is nearer than that."""
        return _count_beside(self._rows, np.array(lines), distance) if lines and len(self._rows) else (0, 0)


def count_meetings(lines: Sequence[Line] | np.ndarray, boxes: Sequence[Box2] | np.ndarray, by: float = 0.0) -> int:
    """Number of times that lines reach into boxes that are enlarged by a margin."""
    return _count_in(np.asarray(lines), np.asarray(boxes), by) if len(lines) and len(boxes) else 0


@numba.njit(cache=True)
def _count_in(lines, boxes, by):  # pragma: no cover - compiled
    """Number of times that lines reach into boxes that are enlarged by a margin."""
    count = 0
    for box in boxes:
        x0, y0, x1, y1 = box[0] - by, box[1] - by, box[2] + by, box[3] + by
        middle_x, middle_y, half_x, half_y = (x0 + x1) / 2, (y0 + y1) / 2, (x1 - x0) / 2, (y1 - y0) / 2
        for line in lines:
            a, b, c, d = line[0], line[1], line[2], line[3]
            if (a > x0 or c > x0) and (a < x1 or c < x1) and (b > y0 or d > y0) and (b < y1 or d < y1):
                off = (c - a) * (middle_y - b) - (d - b) * (middle_x - a)
                count += abs(off) < abs(c - a) * half_y + abs(d - b) * half_x
    return count


@numba.njit(cache=True)
def _count_crossing(rows, lines):  # pragma: no cover - compiled
    """Rows of a `SegmentIndex` that lines cross."""
    count = 0
    for x0, y0, x1, y1 in lines:
        low_x, low_y, high_x, high_y = min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)
        dx, dy = x1 - x0, y1 - y0
        for row in rows:
            if row[6] > low_x and row[4] < high_x and row[7] > low_y and row[5] < high_y:
                ex, ey = row[2] - row[0], row[3] - row[1]
                first = dx * (row[1] - y0) - dy * (row[0] - x0)
                second = dx * (row[3] - y0) - dy * (row[2] - x0)
                third = ex * (y0 - row[1]) - ey * (x0 - row[0])
                fourth = ex * (y1 - row[1]) - ey * (x1 - row[0])
                count += first * second < -1e-6 and third * fourth < -1e-6
    return count


@numba.njit(cache=True)
def _count_beside(rows, lines, distance):  # pragma: no cover - compiled
    """Rows of a `SegmentIndex` parallel to lines and nearer than a distance for more than a millimetre, and lines that
    are too near to one of them."""
    parallel, too_near = 0, 0
    for x0, y0, x1, y1 in lines:
        length = math.hypot(x1 - x0, y1 - y0)
        if length < 1e-9:
            continue
        low_x, low_y, high_x, high_y = min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)
        u, v = (x1 - x0) / length, (y1 - y0) / length
        near = False
        for row in rows:
            beside = row[6] > low_x - distance and row[4] < high_x + distance
            if beside and row[7] > low_y - distance and row[5] < high_y + distance:
                first, second = (row[0] - x0) * v - (row[1] - y0) * u, (row[2] - x0) * v - (row[3] - y0) * u
                begin, end = (row[0] - x0) * u + (row[1] - y0) * v, (row[2] - x0) * u + (row[3] - y0) * v
                shared = min(max(begin, end), length) - max(min(begin, end), 0.0)
                parallel += max(abs(first), abs(second)) < distance and shared > 1.0
                own = math.hypot(first - second, end - begin)
                along = own > 1e-9 and abs(first - second) <= 0.1 * own
                near = near or (along and min(abs(first), abs(second)) < distance and shared > 0.0)
        too_near += near
    return parallel, too_near


def lines_cross(one: Line, other: Line) -> bool:
    """Whether two straight lines cross; not where one only touches the other with an end."""
    (ax, ay, bx, by), (x0, y0, x1, y1) = one, other
    dx, dy, ex, ey = x1 - x0, y1 - y0, bx - ax, by - ay
    sides = (dx * (ay - y0) - dy * (ax - x0)) * (dx * (by - y0) - dy * (bx - x0))
    return sides < -1e-6 and (ex * (y0 - ay) - ey * (x0 - ax)) * (ex * (y1 - ay) - ey * (x1 - ax)) < -1e-6


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


def lines_of(curves: Iterable[Curve], scale: float = 1.0) -> SegmentIndex:
    """The lines that approximate curves of a view at a scale."""
    return SegmentIndex([line for curve in curves for line in polyline_lines(list(curve_points(curve, scale)))])
