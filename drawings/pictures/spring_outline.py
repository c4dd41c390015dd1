"""Round wire bent in arcs, as a spring is: its outlines in closed form.

The outline of a tube of radius r about a line c(t) is c + r n and c - r n, with n at right angles to the line and to
the direction of view; where the line turns so sharply in the view that its parallel runs backwards, that stretch lies
on the tube's far side. The exact algorithm follows the outlines of each torus by steps instead: of one spring in a
quarter of the time of the whole machine.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np

from drawings.pictures.depth_refinement import CloseUp
from drawings.views.view import Polyline, Projection
from stagecad.solids.modelling.frame import Frame

STEP = 0.1
"""From one place of an outline to the next, over the wire's radius."""
INTO = 0.4
"""How far behind what is in front an outline must lie to be hidden, over the wire's radius."""

CROWN = 0.01
"""Angle to the direction of view below which a wire runs at the eye, rad."""
SWING, HALVED = 0.3, 10
"""By how much an outline may turn about the wire from one place to the next, rad; how often a step is halved for it."""


@dataclass(frozen=True)
class _Arc:
    """A line's arc: centre + radius (cos t x + sin t y), between two angles."""

    centre: np.ndarray
    x: np.ndarray
    y: np.ndarray
    radius: float
    first: float
    last: float

    def at(self, turns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points, and directions."""
        c, s = np.cos(turns)[:, None], np.sin(turns)[:, None]
        return self.centre + self.radius * (c * self.x + s * self.y), c * self.y - s * self.x


@dataclass(frozen=True)
class Wire:
    """A wire in a shape's own coordinates.

    Attributes:
        radius: of the wire, mm.
        arcs: of its middle line.
    """

    radius: float
    arcs: tuple[_Arc, ...]

    def outlines(self, frame: Frame, projection: Projection, seen: CloseUp, chord: float) -> Iterator[Polyline]:
        """What is seen of the wire's outlines and of the rims of its ends.

        Args:
            frame: where the wire stands.
            projection: direction of view.
            seen: what is in front where the wire is.
            chord: greatest distance of a polyline from its curve, mm.
        """
        turn, shift = np.array(frame.rotation), np.array(frame.shift)
        eye = np.array(projection.towards_eye)
        tolerance = INTO * self.radius
        # Looked at just beside the wire, where it does not stand before itself.
        beyond = 1.5 * seen.pixel
        for arc in self.arcs:
            turns = self._turns(arc, turn.T @ eye)
            places, along = arc.at(turns)
            places, along = places @ turn.T + shift, along @ turn.T
            across = _across(along, eye)
            length = np.sqrt(_products(across, across))
            sides = across / np.maximum(length, 1e-12)[:, None]
            for sign in (1.0, -1.0):
                points = places + sign * self.radius * sides
                forward = _products(points[1:] - points[:-1], places[1:] - places[:-1]) > 0.0
                shown = (length > 1e-9) & seen.in_front(points + sign * beyond * sides, tolerance)
                yield from _runs(points, forward & shown[1:] & shown[:-1], projection, chord)
            # Where the wire runs at the eye and back, its outline goes round it.
            turned = np.flatnonzero(_products(sides[1:], sides[:-1]) < 0.0).tolist()
            for place in [*turned, *([-1] if length[-1] < CROWN else [])]:
                outward = places[place] - (arc.centre @ turn.T + shift)
                outward -= (outward @ eye) * eye
                outward /= np.linalg.norm(outward)
                c, s = (of(np.linspace(0.0, math.pi, 33))[:, None] for of in (np.cos, np.sin))
                round_it = c * np.cross(eye, outward) + s * outward
                shown = seen.in_front(places[place] + (self.radius + beyond) * round_it, tolerance)
                yield from _runs(places[place] + self.radius * round_it, shown[1:] & shown[:-1], projection, chord)
        for middle, out, radial in self._ends():
            turns = np.linspace(0.0, 2 * math.pi, self._count(2 * math.pi * self.radius))
            c, s = np.cos(turns)[:, None], np.sin(turns)[:, None]
            normals = (c * radial + s * np.cross(out, radial)) @ turn.T
            points = middle @ turn.T + shift + self.radius * normals
            # Seen from the edge it is a line to and fro, of which one way is enough.
            faces = (turn @ out) @ eye > 1e-6
            shown = (faces | (normals @ eye > 0.0)) & seen.in_front(points, tolerance)
            yield from _runs(points, shown[1:] & shown[:-1], projection, chord)

    def _turns(self, arc: _Arc, eye: np.ndarray) -> np.ndarray:
        """Angles along an arc, so close that its outlines turn little from one to the next."""
        turns = np.linspace(arc.first, arc.last, self._count(arc.radius * (arc.last - arc.first)))
        return _halved(turns, np.cross(arc.x, eye), np.cross(arc.y, eye))

    def _count(self, length: float) -> int:
        return max(8, math.ceil(length / (STEP * self.radius)))

    def _ends(self) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Middle, outward direction, and a direction at right angles to it, of each end of the wire."""
        ends = []
        for arc in self.arcs:
            places, along = arc.at(np.array([arc.first, arc.last]))
            ends += [(places[0], -along[0], arc), (places[1], along[1], arc)]
        for number, (place, out, arc) in enumerate(ends):
            others = [other for index, (other, *_) in enumerate(ends) if index != number]
            if not any(np.linalg.norm(place - other) < self.radius / 100 for other in others):
                radial = place - arc.centre
                yield place, out, radial / np.linalg.norm(radial)


def wire_of(faces: Iterable[Any]) -> Wire | None:
    """The wire that a shape's faces make up: parts of tori of one thickness, and plane ends; None for anything else."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_Plane, GeomAbs_Torus

    arcs: list[_Arc] = []
    radii: set[float] = set()
    for face in faces:
        surface = BRepAdaptor_Surface(face)
        if surface.GetType() == GeomAbs_Torus:
            torus = surface.Torus()
            place = torus.Position()
            whole = surface.LastVParameter() - surface.FirstVParameter()
            if whole < 2 * math.pi - 1e-6:
                return None
            centre, x, y = (
                np.array([of.X(), of.Y(), of.Z()]) for of in (place.Location(), place.XDirection(), place.YDirection())
            )
            arcs.append(_Arc(centre, x, y, torus.MajorRadius(), surface.FirstUParameter(), surface.LastUParameter()))
            radii.add(round(torus.MinorRadius(), 6))
        elif surface.GetType() != GeomAbs_Plane:
            return None
    return Wire(radii.pop(), tuple(arcs)) if len(radii) == 1 else None


def _across(vectors: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Products (n, 3) of vectors with another, at right angles to both; numpy's own takes five times as long."""
    (x, y, z), (u, v, w) = vectors.T, other
    return np.column_stack((y * w - z * v, z * u - x * w, x * v - y * u))


def _products(some: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Scalar products (n,) of vectors (n, 3) in pairs."""
    return np.einsum("ij,ij->i", some, others)


@numba.njit(cache=True)
def _halved(turns, x, y):  # pragma: no cover - compiled
    """Angles with more between them, where what is at right angles to cos t y - sin t x and to the eye turns far.

    Args:
        turns: angles t along an arc.
        x, y: the arc's directions times the direction of view.
    """
    for _ in range(HALVED):
        count = len(turns)
        wide = np.zeros(count, dtype=np.bool_)
        before = np.zeros(3)
        for place in range(count):
            across = np.cos(turns[place]) * y - np.sin(turns[place]) * x
            across /= max(np.sqrt((across * across).sum()), 1e-12)
            wide[place] = place > 0 and (across * before).sum() < np.cos(SWING)
            before = across
        if not wide.any():
            break
        more = np.empty(count + wide.sum())
        at = 0
        for place in range(count):
            if wide[place]:
                more[at] = (turns[place - 1] + turns[place]) / 2
                at += 1
            more[at] = turns[place]
            at += 1
        turns = more
    return turns


def _runs(points: np.ndarray, shown: np.ndarray, projection: Projection, chord: float) -> Iterator[Polyline]:
    """The stretches of a line that are shown, with no more points than the chord asks for.

    Args:
        points: along the line.
        shown: whether each piece between two points is.
        chord: greatest distance from the line, mm.
    """
    flat = points @ np.array([projection.right, projection.up]).T
    edges = np.flatnonzero(np.diff(np.concatenate(([False], shown, [False]))))
    for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        stretch = flat[begin : end + 1]
        yield Polyline(tuple((float(x), float(y)) for x, y in stretch[_needed(stretch, chord)]))


@numba.njit(cache=True)
def _needed(points, chord):  # pragma: no cover - compiled
    """Which points keep a line within a chord of all: each as far from the one before as that allows, and the last."""
    chosen = np.zeros(len(points), dtype=np.bool_)
    chosen[0] = chosen[-1] = True
    first = 0
    for last in range(2, len(points)):
        u, v = points[last, 0] - points[first, 0], points[last, 1] - points[first, 1]
        limit = chord * max(np.sqrt(u * u + v * v), 1e-12)
        for place in range(first + 1, last):
            x, y = points[place, 0] - points[first, 0], points[place, 1] - points[first, 1]
            if abs(x * v - y * u) > limit:
                first = last - 1
                chosen[first] = True
                break
    return chosen
