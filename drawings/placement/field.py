"""What already stands on the paper around a view, and whether something more would touch it.

Lines of the part, lines of annotations, and boxes of texts, in paper mm. A text must touch nothing; a line must pass no
text; lines may cross lines, at a price. The layout and the check of the finished sheet ask the same questions.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from drawings.views.view import Arc, Box2, Curve, Point2, Polyline, Segment

Line = tuple[float, float, float, float]

CHORD = 0.05
"""How far a chord may leave its arc, mm on paper."""


class Lines:
    """Many straight pieces, asked together."""

    def __init__(self, capacity: int = 256) -> None:
        # Rows: x0, y0, x1, y1, then the box: low x, low y, high x, high y.
        self._held = np.empty((8, capacity))
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, lines: Sequence[Line]) -> None:
        """Some more pieces: x0, y0, x1, y1."""
        if not lines:
            return
        needed = self._count + len(lines)
        if needed > self._held.shape[1]:
            grown = np.empty((8, 2 * needed))
            grown[:, : self._count] = self._held[:, : self._count]
            self._held = grown
        new = np.array(lines).T
        added = self._held[:, self._count : needed]
        added[:4] = new
        added[4:6] = np.minimum(new[:2], new[2:])
        added[6:] = np.maximum(new[:2], new[2:])
        self._count = needed

    def touching(self, box: Box2) -> int:
        """How many pieces reach into a box."""
        near = self._near(box)
        if near is None:
            return 0
        dx, dy = near[2] - near[0], near[3] - near[1]
        half_x, half_y = (box[2] - box[0]) / 2, (box[3] - box[1]) / 2
        off = dx * ((box[1] + box[3]) / 2 - near[1]) - dy * ((box[0] + box[2]) / 2 - near[0])
        return int(np.count_nonzero(np.abs(off) < np.abs(dx) * half_y + np.abs(dy) * half_x))

    def within(self, box: Box2) -> list[Line]:
        """The pieces whose own boxes reach into a box."""
        near = self._near(box)
        return [] if near is None else [(x0, y0, x1, y1) for x0, y0, x1, y1 in near.T.tolist()]

    def leaving(self, box: Box2) -> list[Line]:
        """The pieces that are not wholly within a box."""
        held = self._held[:, : self._count]
        out = (held[4] < box[0]) | (held[6] > box[2]) | (held[5] < box[1]) | (held[7] > box[3])
        return [(x0, y0, x1, y1) for x0, y0, x1, y1 in held[:4, out].T.tolist()]

    def crossing(self, line: Line) -> int:
        """How many pieces a line crosses, ends that just touch left out."""
        x0, y0, x1, y1 = line
        near = self._near((min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)))
        if near is None:
            return 0
        dx, dy = x1 - x0, y1 - y0
        ex, ey = near[2] - near[0], near[3] - near[1]
        first = dx * (near[1] - y0) - dy * (near[0] - x0)
        second = dx * (near[3] - y0) - dy * (near[2] - x0)
        third = ex * (y0 - near[1]) - ey * (x0 - near[0])
        fourth = ex * (y1 - near[1]) - ey * (x1 - near[0])
        least = 1e-6
        return int(np.count_nonzero((first * second < -least) & (third * fourth < -least)))

    def along(self, point: Point2, direction: Point2, near: float = 0.05) -> tuple[float, float]:
        """From where to where pieces run on, without a break, on the line through a point: distances from the point.

        Both are 0 where no piece lies on that line at the point.
        """
        u, v = direction
        held = self._held[:4, : self._count]
        off = [(held[i] - point[0]) * v - (held[i + 1] - point[1]) * u for i in (0, 2)]
        on = (np.abs(off[0]) < near) & (np.abs(off[1]) < near)
        if not on.any():
            return (0.0, 0.0)
        at = [(held[i, on] - point[0]) * u + (held[i + 1, on] - point[1]) * v for i in (0, 2)]
        low, high = 0.0, 0.0
        for a, b in sorted(zip(np.minimum(*at).tolist(), np.maximum(*at).tolist())):
            if a <= high + near and b >= low - near:
                low, high = min(low, a), max(high, b)
        return low, high

    def beside(self, line: Line, apart: float) -> int:
        """How many pieces run along a line, nearer than `apart`, for more than a millimetre."""
        x0, y0, x1, y1 = line
        near = self._near(grown((min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)), apart))
        size = math.hypot(x1 - x0, y1 - y0)
        if near is None or size < 1e-9:
            return 0
        u, v = (x1 - x0) / size, (y1 - y0) / size
        off = [np.abs((near[i] - x0) * v - (near[i + 1] - y0) * u) for i in (0, 2)]
        at = [(near[i] - x0) * u + (near[i + 1] - y0) * v for i in (0, 2)]
        shared = np.minimum(np.maximum(*at), size) - np.maximum(np.minimum(*at), 0.0)
        return int(np.count_nonzero((np.maximum(*off) < apart) & (shared > 1.0)))

    def _near(self, box: Box2) -> np.ndarray | None:
        """Ends of the pieces whose own boxes reach into a box; none where there are no such pieces, which is most."""
        held = self._held[:, : self._count]
        there = (held[6] > box[0]) & (held[4] < box[2]) & (held[7] > box[1]) & (held[5] < box[3])
        (numbers,) = there.nonzero()
        return held[:4].take(numbers, axis=1) if numbers.size else None


class Field:
    """Lines of the part, lines of annotations, dimension lines, and texts, around one view."""

    def __init__(self) -> None:
        self.part = Lines(1024)
        self.drawn = Lines()
        self.boxes: list[Box2] = []
        self.lanes: list[Line] = []

    def text_hits(self, box: Box2, margin: float) -> int:
        """How many lines and texts a text's box would touch."""
        wide = grown(box, margin)
        hits = self.part.touching(wide) + self.drawn.touching(wide)
        return hits + sum(overlap(wide, other) for other in self.boxes)

    def over_texts(self, lines: Iterable[Line], margin: float) -> int:
        """How many texts some lines would pass over."""
        boxes = [grown(box, margin) for box in self.boxes]
        return sum(reaches(line, box) for line in lines for box in boxes)

    def crossings(self, lines: Iterable[Line]) -> int:
        """How many lines of annotations some lines would cross."""
        return sum(self.drawn.crossing(line) for line in lines)

    def in_lane(self, line: Line, apart: float) -> bool:
        """Whether a dimension line would run beside, or along, another one nearer than `apart`."""
        return any(_beside(line, lane, apart) for lane in self.lanes)


def overlap(one: Box2, other: Box2) -> bool:
    """Whether two boxes share some area."""
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def grown(box: Box2, by: float) -> Box2:
    """A box with a margin round it."""
    return (box[0] - by, box[1] - by, box[2] + by, box[3] + by)


def around(boxes: Iterable[Box2]) -> Box2:
    """The box that holds all the others."""
    x0, y0, x1, y1 = zip(*boxes)
    return (min(x0), min(y0), max(x1), max(y1))


def reaches(line: Line, box: Box2) -> bool:
    """Whether a line reaches into a box."""
    x0, y0, x1, y1 = line
    if max(x0, x1) <= box[0] or min(x0, x1) >= box[2] or max(y0, y1) <= box[1] or min(y0, y1) >= box[3]:
        return False
    dx, dy = x1 - x0, y1 - y0
    off = dx * ((box[1] + box[3]) / 2 - y0) - dy * ((box[0] + box[2]) / 2 - x0)
    return abs(off) < abs(dx) * (box[3] - box[1]) / 2 + abs(dy) * (box[2] - box[0]) / 2


def pieces(points: Sequence[Point2]) -> list[Line]:
    """The straight pieces of a line through points."""
    return [(*a, *b) for a, b in pairwise(points)]


def arc_points(arc: Arc, scale: float = 1.0) -> list[Point2]:
    """Points along an arc whose chords leave it by no more than `CHORD` on the paper."""
    radius = max(arc.radius * scale, 1e-9)
    step = 2 * math.acos(max(1 - CHORD / radius, 0.0))
    turn = math.radians((arc.end_angle - arc.start_angle) % 360.0 or 360.0)
    count = max(2, math.ceil(turn / step))
    start = math.radians(arc.start_angle)
    return [
        (arc.centre[0] + arc.radius * math.cos(a), arc.centre[1] + arc.radius * math.sin(a))
        for a in (start + turn * i / count for i in range(count + 1))
    ]


def curve_points(curve: Curve, scale: float = 1.0) -> Sequence[Point2]:
    """Points that stand for a curve of a view at a scale."""
    match curve:
        case Segment():
            return (curve.start, curve.end)
        case Polyline():
            return curve.points
        case Arc():
            return arc_points(curve, scale)


def _beside(one: Line, other: Line, apart: float) -> bool:
    dx, dy = one[2] - one[0], one[3] - one[1]
    ex, ey = other[2] - other[0], other[3] - other[1]
    size, length = math.hypot(dx, dy), math.hypot(ex, ey)
    if size < 1e-9 or length < 1e-9 or abs(dx * ey - dy * ex) > 0.1 * size * length:
        return False
    u, v = dx / size, dy / size
    away = [abs((x - one[0]) * v - (y - one[1]) * u) for x, y in (other[:2], other[2:])]
    along = [(x - one[0]) * u + (y - one[1]) * v for x, y in (other[:2], other[2:])]
    return min(away) < apart and max(along) > 0.0 and min(along) < size
