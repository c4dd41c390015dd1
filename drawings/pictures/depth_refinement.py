"""A small part of a picture in a fine depth buffer: what is in front there, and which lines that hides."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from drawings.views.bounding_box import bounding_box, extreme_points
from drawings.views.view import Arc, Curve, Point2, Polyline, Projection, Segment

FINE = 1.0
"""Step along an arc in which it is looked at, degrees."""


@dataclass(frozen=True)
class CloseUp:
    """A window of a view.

    Attributes:
        projection: direction of view.
        low: left and upper edge, in the buffer's directions: to the right, and down.
        pixel: mm.
        depth: of what is in front, along the view, mm; infinite where there is nothing.
        own: whether what is in front is the piece that the window is about.
    """

    projection: Projection
    low: Point2
    pixel: float
    depth: np.ndarray
    own: np.ndarray

    def in_front(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """Which of some points (n, 3) nothing is in front of by more than a tolerance, mm."""
        flat = points @ np.array([self.projection.right, self.projection.up]).T
        away = -(points @ np.array(self.projection.towards_eye))
        return away <= self._looked_up(self.depth, flat, np.inf) + tolerance

    def without_hidden(self, curve: Curve) -> Iterator[Curve]:
        """What is left of a visible curve of another piece outside the one that the window is about.

        The curve may lie in front of that piece: then what it belongs to is seen beside it.
        """
        corners = _corners(curve)
        along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))))
        places = np.linspace(0.0, along[-1], max(2, math.ceil(along[-1] / self.pixel)) + 1)
        flat = np.column_stack([np.interp(places, along, corners[:, axis]) for axis in (0, 1)])
        free = ~self._within(flat)
        if free.all():
            yield curve
            return
        edges = np.flatnonzero(np.diff(np.concatenate(([False], free, [False]))))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            if end - 1 > begin:
                inner = corners[(along > places[begin]) & (along < places[end - 1])]
                yield _piece(curve, np.concatenate((flat[begin : begin + 1], inner, flat[end - 1 : end])))

    def meets(self, curve: Curve) -> bool:
        """Whether a curve may come into the window."""
        x0, y0, x1, y1 = bounding_box(extreme_points(curve))
        height, width = self.own.shape
        left, top = self.low[0], -self.low[1]
        right, bottom = left + width * self.pixel, top - height * self.pixel
        return x0 < right and x1 > left and y0 < top and y1 > bottom

    def _within(self, flat: np.ndarray) -> np.ndarray:
        """Which places have nothing but the window's own piece around them."""
        inside = np.ones(len(flat), dtype=bool)
        for dx in (-1.5, 0.0, 1.5):
            for dy in (-1.5, 0.0, 1.5):
                beside = flat + np.array((dx, dy)) * self.pixel
                inside &= self._looked_up(self.own, beside, False)
        return inside

    def _looked_up(self, buffer: np.ndarray, flat: np.ndarray, outside: float) -> np.ndarray:
        """Values of a buffer at places of the view."""
        columns = np.floor((flat[:, 0] - self.low[0]) / self.pixel).astype(np.int64)
        rows = np.floor((-flat[:, 1] - self.low[1]) / self.pixel).astype(np.int64)
        height, width = buffer.shape
        there = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        values = np.full(len(flat), outside, dtype=buffer.dtype)
        values[there] = buffer[rows[there], columns[there]]
        return values


def _corners(curve: Curve) -> np.ndarray:
    """Points through which a curve runs, (n, 2)."""
    if isinstance(curve, Segment):
        return np.array((curve.start, curve.end))
    if isinstance(curve, Arc):
        count = max(2, math.ceil((curve.end_angle - curve.start_angle) / FINE))
        turns = np.radians(np.linspace(curve.start_angle, curve.end_angle, count + 1))
        return curve.centre + curve.radius * np.column_stack((np.cos(turns), np.sin(turns)))
    return np.array(curve.points)


def _piece(curve: Curve, points: np.ndarray) -> Curve:
    """The part of a curve that runs through points on it."""
    ends = [(float(x), float(y)) for x, y in (points[0], points[-1])]
    if isinstance(curve, Segment):
        return Segment(ends[0], ends[1])
    if isinstance(curve, Arc):
        x, y = curve.centre
        first, last = (math.degrees(math.atan2(v - y, u - x)) for u, v in ends)
        return Arc(curve.centre, curve.radius, first, first + (last - first) % 360.0)
    return Polyline(tuple((float(x), float(y)) for x, y in points))
