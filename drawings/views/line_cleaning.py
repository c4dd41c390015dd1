"""Lines of a view put in order: pieces of one line become one, and nothing lies hidden under a visible line.

Hidden-line removal gives each edge of the solid by itself: a line in pieces where faces change behind it, and the
edges of the near and the far side one upon the other. On paper each line is drawn once, and a visible one covers a
hidden one (ISO 128-2).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import chain, groupby
from typing import TypeVar

import numpy as np

from drawings.views.view import Arc, Curve, Polyline, Segment

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
        (*sorted(lines[0], key=_order), *sorted(arcs[0], key=_order), *others[0]),
        (*sorted(lines[1], key=_order), *sorted(arcs[1], key=_order), *others[1]),
    )


def _of(kind: type[Kind], curves: list[Curve]) -> list[Kind]:
    return [curve for curve in curves if isinstance(curve, kind)]


def _order(curve: Curve) -> tuple[float, ...]:
    """What curves are sorted by: where they are."""
    if isinstance(curve, Segment):
        numbers = (*curve.start, *curve.end)
    elif isinstance(curve, Arc):
        numbers = (*curve.centre, curve.radius, curve.start_angle)
    else:
        numbers = tuple(chain.from_iterable(curve.points))
    return tuple([round(number, 4) for number in numbers])


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
    """Each polyline without the runs that lie on one before it, those that are visible first."""
    lines = [*_in_order(visible), *_in_order(hidden)]
    kept: list[list[Polyline]] = []
    for line, before in zip(lines, _touching([np.array(line.points) for line in lines], near), strict=True):
        others = [np.array(piece.points) for number in before for piece in kept[number]]
        kept.append(_uncovered(line, np.array(line.points), others, near) if others else [line])
    count = len(visible)
    return list(chain.from_iterable(kept[:count])), list(chain.from_iterable(kept[count:]))


def _in_order(lines: list[Polyline]) -> list[Polyline]:
    """Polylines sorted by where they are; those that begin at one place by all of their points, which few need."""

    def begin(line: Polyline) -> tuple[float, float]:
        (x, y), *_ = line.points
        return (round(x, 4), round(y, 4))

    return [line for _, same in groupby(sorted(lines, key=begin), key=begin) for line in _sorted_all(list(same))]


def _sorted_all(lines: list[Polyline]) -> list[Polyline]:
    return sorted(lines, key=_order) if len(lines) > 1 else lines


AT_ONCE = 20000
"""Places whose distances are worked out together: of more, the numbers leave the processor's own memory."""


def _touching(lines: Sequence[np.ndarray], near: float) -> list[list[int]]:
    """Of each polyline with a piece that may lie on others before it, these; of all together, since few have one."""
    found: list[list[int]] = [[] for _ in lines]
    if len(lines) < 2:
        return found
    counts = np.array([len(line) for line in lines])
    begins = np.cumsum(counts) - counts
    points = np.concatenate(lines)
    low, high = np.minimum.reduceat(points, begins) - near, np.maximum.reduceat(points, begins) + near
    meet = np.tri(len(lines), k=-1, dtype=bool)
    for axis in (0, 1):
        meet &= (low[:, None, axis] < high[None, :, axis]) & (high[:, None, axis] > low[None, :, axis])
    one, other = np.nonzero(meet)
    point, other = _ranges(begins[one], counts[one]), np.repeat(other, counts[one])
    inside = ((points[point] > low[other]) & (points[point] < high[other])).all(axis=1)
    point, other = point[inside], other[inside]
    close = np.zeros(len(point), dtype=bool)
    for start in range(0, len(point), AT_ONCE):
        lot = slice(start, start + AT_ONCE)
        pieces = counts[other[lot]] - 1
        first = _ranges(begins[other[lot]], pieces)
        away = _from_piece(np.repeat(points[point[lot]], pieces, axis=0), points[first], points[first + 1])
        close[lot] = np.minimum.reduceat(away, np.cumsum(pieces) - pieces) < near
    covered = np.zeros(len(points), dtype=bool)
    covered[point[close]] = True
    owner = np.repeat(np.arange(len(lines)), counts)
    # A piece is covered where both of its ends are.
    lying = np.zeros(len(lines), dtype=bool)
    lying[owner[:-1][covered[:-1] & covered[1:] & (owner[:-1] == owner[1:])]] = True
    pairs = zip(owner[point[close]].tolist(), other[close].tolist())
    for number, before in sorted({pair for pair in pairs if lying[pair[0]]}):
        found[number].append(before)
    return found


def _ranges(begins: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Numbers from each beginning on, as many as its count."""
    return np.arange(counts.sum()) + np.repeat(begins - (np.cumsum(counts) - counts), counts)


def _uncovered(line: Polyline, points: np.ndarray, others: Sequence[np.ndarray], near: float) -> list[Polyline]:
    """The runs of a polyline that do not lie on another."""
    covered = np.zeros(len(points), dtype=bool)
    for corners in others:
        covered |= _from_piece(points[:, None, :], corners[:-1], corners[1:]).min(axis=1) < near
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


def _from_piece(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance of points from straight pieces."""
    step = end - start
    square = np.maximum((step**2).sum(axis=-1), 1e-30)
    along = np.clip(((points - start) * step).sum(axis=-1) / square, 0.0, 1.0)
    return np.linalg.norm(points - start - along[..., None] * step, axis=-1)
