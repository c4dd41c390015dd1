"""Coincident curves of a view merged: each line is drawn once, and no hidden line is under a visible one.

Hidden-line removal gives the edges of the solid one by one: pieces of one line, and edges of the near and the far side
that coincide in projection. A visible line takes precedence over a hidden one (ISO 128-2).
"""

import math
from collections.abc import Iterable, Sequence
from itertools import chain, groupby
from operator import itemgetter
from typing import TypeVar

import numpy as np

from drawings.views.view import Arc, Curve, Polyline, Segment
from drawings.views.view import offset as moved

NEAR = 1e-3
"""Greatest distance of coincident lines, and greatest gap that is closed, mm."""
SHORTEST = 0.01
"""Shortest piece that is kept: shorter ones come from the tolerances of the kernel, mm."""
SAME_DIRECTION = 1e-5
"""Greatest angle between parallel lines, rad."""
CHORD = 0.01
"""Default of the greatest distance of a polyline from its curve, mm."""
COVERED = 3.0
"""Greatest distance of coincident polylines, in chord errors."""

Span = tuple[float, float]
Item = tuple[float, Span, bool]
Kind = TypeVar("Kind")


def cleaned(
    visible: Iterable[Curve], hidden: Iterable[Curve] = (), chord: float = CHORD
) -> tuple[tuple[Curve, ...], tuple[Curve, ...]]:
    """Visible and hidden curves of one coordinate system without coincident ones, sorted by position; `chord`: greatest
    distance of the polylines from their curves, mm."""
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
    """Key by which curves are sorted: their coordinates."""
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
                kept.extend(
                    Segment(*(moved((0.0, 0.0), (u, v), along, offset) for along in span))
                    for span in spans
                    if span[1] - span[0] > SHORTEST
                )
    return seen, behind


def _by_direction(marked: Sequence[tuple[Segment, bool]]) -> list[list[tuple[Segment, bool]]]:
    """Groups of parallel segments."""

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
    """Groups of collinear items; the items are sorted by offset."""
    rows: list[list[Item]] = []
    for item in placed:
        if not rows or item[0] - rows[-1][-1][0] > NEAR:
            rows.append([])
        rows[-1].append(item)
    return rows


def _span(segment: Segment, u: float, v: float) -> Span:
    ends = sorted(x * u + y * v for x, y in (segment.start, segment.end))
    return (ends[0], ends[1])


def joined(spans: Iterable[Span], gap: float = NEAR) -> list[Span]:
    """Union of spans; gaps shorter than `gap` are closed."""
    found: list[Span] = []
    for low, high in sorted(spans):
        if found and low - found[-1][1] < gap:
            found[-1] = (found[-1][0], max(found[-1][1], high))
        else:
            found.append((low, high))
    return found


def without(spans: Iterable[Span], taken: Sequence[Span], gap: float = NEAR) -> list[Span]:
    """Spans minus those in `taken`, which is sorted and joined; nothing shorter than `gap`."""
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

    def circle(arc: Arc) -> tuple[float, float, float]:
        return (round(arc.centre[0], 3) + 0.0, round(arc.centre[1], 3) + 0.0, round(arc.radius, 3))

    marked = sorted(
        ((circle(a), side, a) for side, arcs in enumerate((visible, hidden)) for a in arcs), key=itemgetter(0)
    )
    for _, same in groupby(marked, key=itemgetter(0)):
        group = [(arc, bool(side)) for _, side, arc in same]
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
    """The angles of an arc as spans within 0 to 360 degrees."""
    low = arc.start_angle % 360.0
    high = low + (arc.end_angle - arc.start_angle)
    return [(low, high)] if high <= 360.0 else [(low, 360.0), (0.0, high - 360.0)]


def _closed(spans: list[Span], gap: float) -> list[Span]:
    """Spans within one turn, those that meet at 360 degrees joined."""
    if len(spans) > 1 and spans[0][0] < gap and spans[-1][1] > 360.0 - gap:
        return [*spans[1:-1], (spans[-1][0], spans[0][1] + 360.0)]
    return [(0.0, 360.0) if high - low > 360.0 - gap else (low, high) for low, high in spans]


def _polylines(visible: list[Polyline], hidden: list[Polyline], near: float) -> tuple[list[Polyline], list[Polyline]]:
    """Each polyline without the runs that lie on one before it; visible ones are before hidden ones."""
    lines = [*sorted(visible, key=_order), *sorted(hidden, key=_order)]
    points = [np.array(line.points) for line in lines]
    low = np.array([corners.min(axis=0) for corners in points]).reshape(-1, 2) - near
    high = np.array([corners.max(axis=0) for corners in points]).reshape(-1, 2) + near
    kept: list[list[Polyline]] = []
    for number, line in enumerate(lines):
        overlap = ((low[:number] < high[number]) & (high[:number] > low[number])).all(axis=1)
        others = [np.array(piece.points) for before in np.flatnonzero(overlap) for piece in kept[before]]
        kept.append(_uncovered(line, points[number], others, near))
    count = len(visible)
    return list(chain.from_iterable(kept[:count])), list(chain.from_iterable(kept[count:]))


def _uncovered(line: Polyline, points: np.ndarray, others: Sequence[np.ndarray], near: float) -> list[Polyline]:
    """The runs of a polyline that do not lie on another one."""
    covered = np.zeros(len(points), dtype=bool)
    for corners in others:
        covered |= _distances(points[:, None, :], corners[:-1], corners[1:]).min(axis=1) < near
    # A straight piece is covered where both of its ends are.
    free = np.concatenate(([False], ~(covered[:-1] & covered[1:]), [False]))
    ends = np.flatnonzero(np.diff(free)).tolist()
    return [Polyline(line.points[start : end + 1]) for start, end in zip(ends[::2], ends[1::2], strict=True)]


def _distances(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distances of points from line segments."""
    step = end - start
    square = np.maximum((step**2).sum(axis=-1), 1e-30)
    along = np.clip(((points - start) * step).sum(axis=-1) / square, 0.0, 1.0)
    return np.linalg.norm(points - start - along[..., None] * step, axis=-1)
