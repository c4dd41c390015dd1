"""Lines of a view put in order: pieces of one line become one, and nothing lies hidden under a visible line.

Hidden-line removal gives each edge of the solid by itself: a line in pieces where faces change behind it, and the
edges of the near and the far side one upon the other. On paper each line is drawn once, and a visible one covers a
hidden one (ISO 128-2).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import TypeVar

import numpy as np

from drawings.view import Arc, Curve, Point2, Polyline, Segment

NEAR = 1e-3
"""Lines closer than this are one line, and gaps shorter than this are none, mm."""
SHORTEST = 0.01
"""Pieces shorter than this are dust of the kernel's tolerances, mm."""
SAME_DIRECTION = 1e-5
"""Angle below which two directions are one, rad."""
CHORD = 0.01
"""Greatest distance of a polyline from its curve where nothing else is said, mm."""
COVERED = 3.0
"""A polyline runs on another where it is closer than this many chord errors: that of both, and a little."""

Span = tuple[float, float]
Item = tuple[float, Span, bool]
Kind = TypeVar("Kind")


def cleaned(
    visible: Iterable[Curve], hidden: Iterable[Curve] = (), chord: float = CHORD
) -> tuple[tuple[Curve, ...], tuple[Curve, ...]]:
    """Visible and hidden curves, each drawn once and sorted, none hidden where one is visible.

    Args:
        visible, hidden: curves as they come, in one coordinate system, mm.
        chord: greatest distance of the polylines from their curves, mm.
    """
    seen, behind = list(visible), list(hidden)
    lines = _segments(_of(Segment, seen), _of(Segment, behind))
    arcs = _arcs(_of(Arc, seen), _of(Arc, behind))
    others = _polylines(_of(Polyline, seen), _of(Polyline, behind), COVERED * chord)
    return (
        (*sorted(lines[0], key=_order), *sorted(arcs[0], key=_order), *sorted(others[0], key=_order)),
        (*sorted(lines[1], key=_order), *sorted(arcs[1], key=_order), *sorted(others[1], key=_order)),
    )


def _of(kind: type[Kind], curves: list[Curve]) -> list[Kind]:
    return [curve for curve in curves if isinstance(curve, kind)]


def _order(curve: Curve) -> tuple[float, ...]:
    if isinstance(curve, Segment):
        return (*_rounded(curve.start), *_rounded(curve.end))
    if isinstance(curve, Arc):
        return (*_rounded(curve.centre), round(curve.radius, 4), round(curve.start_angle, 4))
    return tuple(value for point in curve.points for value in _rounded(point))


def _rounded(point: Point2) -> Point2:
    return (round(point[0], 4), round(point[1], 4))


def _segments(visible: list[Segment], hidden: list[Segment]) -> tuple[list[Segment], list[Segment]]:
    seen: list[Segment] = []
    behind: list[Segment] = []
    marked = [(s, False) for s in visible] + [(s, True) for s in hidden]
    for same_direction in _by_direction(marked):
        longest = max((s for s, _ in same_direction), key=lambda s: math.dist(s.start, s.end))
        length = math.dist(longest.start, longest.end)
        u, v = (longest.end[0] - longest.start[0]) / length, (longest.end[1] - longest.start[1]) / length
        if (u, v) < (0.0, 0.0):
            u, v = -u, -v
        placed = sorted(
            ((s.start[1] * u - s.start[0] * v, _span(s, u, v), is_hidden) for s, is_hidden in same_direction),
            key=lambda item: item[0],
        )
        for row in _chained(placed):
            offset = row[0][0]
            shown = joined(span for _, span, is_hidden in row if not is_hidden)
            dashed = without(joined(span for _, span, is_hidden in row if is_hidden), shown)
            for spans, kept in ((shown, seen), (dashed, behind)):
                kept.extend(_placed(span, offset, u, v) for span in spans if span[1] - span[0] > SHORTEST)
    return seen, behind


def _by_direction(marked: Sequence[tuple[Segment, bool]]) -> list[list[tuple[Segment, bool]]]:
    """Groups of like direction, whichever way the segments run."""

    def angle(segment: Segment) -> float:
        (x, y), (p, q) = segment.start, segment.end
        return math.atan2(q - y, p - x) % math.pi

    found: list[list[tuple[Segment, bool]]] = []
    last = -1.0
    for item in sorted(marked, key=lambda item: angle(item[0])):
        here = angle(item[0])
        if not found or here - last > SAME_DIRECTION:
            found.append([])
        found[-1].append(item)
        last = here
    if len(found) > 1 and angle(found[0][0][0]) + math.pi - last < SAME_DIRECTION:
        found[0].extend(found.pop())
    return found


def _chained(placed: list[Item]) -> list[list[Item]]:
    """Items sorted by offset, in groups that lie on one line."""
    rows: list[list[Item]] = []
    for item in placed:
        if not rows or item[0] - rows[-1][-1][0] > NEAR:
            rows.append([])
        rows[-1].append(item)
    return rows


def _span(segment: Segment, u: float, v: float) -> Span:
    ends = sorted(x * u + y * v for x, y in (segment.start, segment.end))
    return (ends[0], ends[1])


def _placed(span: Span, offset: float, u: float, v: float) -> Segment:
    low, high = span
    return Segment((low * u - offset * v, low * v + offset * u), (high * u - offset * v, high * v + offset * u))


def joined(spans: Iterable[Span], gap: float = NEAR) -> list[Span]:
    """The stretches covered by any of the spans."""
    found: list[Span] = []
    for low, high in sorted(spans):
        if found and low - found[-1][1] < gap:
            found[-1] = (found[-1][0], max(found[-1][1], high))
        else:
            found.append((low, high))
    return found


def without(spans: Iterable[Span], taken: Sequence[Span], gap: float = NEAR) -> list[Span]:
    """What is left of the spans outside `taken` (which is sorted and joined); nothing shorter than `gap`."""
    left: list[Span] = []
    for low, high in spans:
        for start, end in taken:
            if end <= low or start >= high:
                continue
            if start - low > gap:
                left.append((low, start))
            low = max(low, end)
        if high - low > gap:
            left.append((low, high))
    return left


def _arcs(visible: list[Arc], hidden: list[Arc]) -> tuple[list[Arc], list[Arc]]:
    seen: list[Arc] = []
    behind: list[Arc] = []

    def circle(item: tuple[Arc, bool]) -> tuple[float, float, float]:
        arc = item[0]
        return (round(arc.centre[0], 3) + 0.0, round(arc.centre[1], 3) + 0.0, round(arc.radius, 3))

    marked = [(a, False) for a in visible] + [(a, True) for a in hidden]
    for _, same in groupby(sorted(marked, key=circle), key=circle):
        group = list(same)
        pattern = group[0][0]
        gap = math.degrees(NEAR / pattern.radius)
        shown = joined((span for a, is_hidden in group if not is_hidden for span in _turns(a)), gap)
        dashed = without(joined((span for a, is_hidden in group if is_hidden for span in _turns(a)), gap), shown, gap)
        shortest = math.degrees(SHORTEST / pattern.radius)
        for spans, kept in ((shown, seen), (dashed, behind)):
            kept.extend(
                Arc(pattern.centre, pattern.radius, low, high)
                for low, high in _closed(spans, gap)
                if high - low > shortest
            )
    return seen, behind


def _turns(arc: Arc) -> list[Span]:
    """The arc's angles as spans within 0 to 360 degrees."""
    low = arc.start_angle % 360.0
    high = low + (arc.end_angle - arc.start_angle)
    return [(low, high)] if high <= 360.0 else [(low, 360.0), (0.0, high - 360.0)]


def _closed(spans: list[Span], gap: float) -> list[Span]:
    """Spans within one turn, the one that ends at 360 degrees joined to the one that begins at 0."""
    if len(spans) > 1 and spans[0][0] < gap and spans[-1][1] > 360.0 - gap:
        return [*spans[1:-1], (spans[-1][0], spans[0][1] + 360.0)]
    return [(0.0, 360.0) if high - low > 360.0 - gap else (low, high) for low, high in spans]


def _polylines(visible: list[Polyline], hidden: list[Polyline], near: float) -> tuple[list[Polyline], list[Polyline]]:
    drawn = _Drawn(near)
    return (
        [piece for line in sorted(visible, key=_order) for piece in drawn.add(line)],
        [piece for line in sorted(hidden, key=_order) for piece in drawn.add(line)],
    )


class _Drawn:
    """Polylines that are drawn already, with their boxes, which settle most questions."""

    def __init__(self, near: float) -> None:
        self._near = near
        self._lines: list[tuple[float, float, float, float, np.ndarray]] = []

    def add(self, line: Polyline) -> list[Polyline]:
        """Take in a polyline, and give the runs of it that do not lie on one taken in before."""
        points = np.array(line.points)
        u0, v0, u1, v1 = _box(points)
        by = self._near
        others = [
            corners
            for a, b, c, d, corners in self._lines
            if c > u0 - by and a < u1 + by and d > v0 - by and b < v1 + by
        ]
        pieces = _uncovered(line, points, others, by)
        self._lines.extend((*_box(corners), corners) for corners in (np.array(piece.points) for piece in pieces))
        return pieces


def _box(points: np.ndarray) -> tuple[float, float, float, float]:
    low, high = points.min(axis=0), points.max(axis=0)
    return (float(low[0]), float(low[1]), float(high[0]), float(high[1]))


def _uncovered(line: Polyline, points: np.ndarray, others: Sequence[np.ndarray], near: float) -> list[Polyline]:
    """The runs of a polyline that do not lie on another."""
    covered = np.zeros(len(points), dtype=bool)
    for corners in others:
        covered |= _distances(points, corners) < near
    if not covered.any():
        return [line]
    # A piece between two covered points is covered, too; a free point keeps its pieces to both neighbours.
    free = ~(covered[:-1] & covered[1:])
    runs: list[Polyline] = []
    start = 0
    while start < len(free):
        if not free[start]:
            start += 1
            continue
        end = start
        while end < len(free) and free[end]:
            end += 1
        runs.append(Polyline(line.points[start : end + 1]))
        start = end
    return runs


def _distances(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distance of each point from a polyline."""
    start, step = corners[:-1], np.diff(corners, axis=0)
    square = np.maximum((step**2).sum(axis=1), 1e-30)
    along = np.clip((((points[:, None, :] - start) * step).sum(axis=2)) / square, 0.0, 1.0)
    nearest = start + along[..., None] * step
    return np.linalg.norm(points[:, None, :] - nearest, axis=2).min(axis=1)
