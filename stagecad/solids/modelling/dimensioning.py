"""Writes down a part's dimensions briefly: the value and its tolerance class come from the parameter named.

Nothing here repeats a number: a declaration gives the key and where on the part to look.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from stagecad.parameters.dimension import (
    Characteristic,
    Datum,
    DatumFeature,
    Dimension,
    FaceRequirement,
    GeometricTolerance,
    Kind,
    Point,
    SurfaceTexture,
    View,
)
from stagecad.solids.modelling.threads import DESIGNATION

X: Point = (1.0, 0.0, 0.0)
Y: Point = (0.0, 1.0, 0.0)
Z: Point = (0.0, 0.0, 1.0)


class Declarations:
    """The dimensions of one part, in the order in which they are written down."""

    def __init__(self, design: Any) -> None:
        self._design = design
        self._all: list[Dimension] = []

    def __iter__(self) -> Iterator[Dimension]:
        return iter(self._all)

    def add(self, kind: Kind, name: str, key: str, points: tuple[Point, ...], direction: Point, **more: Any) -> None:
        """One dimension of any kind; the other methods say the same more briefly.

        Args:
            key: table and name of the parameter, "stage.length".
            more: further fields of `Dimension` (view, feature, count, note).
        """
        table, entry = key.split(".")
        value = float(getattr(getattr(self._design, table), entry))
        self._all.append(Dimension(name, kind, value, key, points, direction, self._design.tolerance(key), **more))

    def linear(self, name: str, key: str, first: Point, second: Point, along: Point | None = None, **more: Any) -> None:
        """Distance between two faces or axes, along the line through the points unless `along` says otherwise."""
        self.add("linear", name, key, (first, second), along or towards(first, second), **more)

    def depth(self, name: str, key: str, mouth: Point, end: Point, along: Point | None = None, **more: Any) -> None:
        """Depth of a hole or pocket from its mouth to where its full section ends."""
        self.add("depth", name, key, (mouth, end), along or towards(mouth, end), **more)

    def diameter(
        self, name: str, key: str, at: Point, axis: Point = Z, *, on: Point | None = None, **more: Any
    ) -> None:
        """Diameter of the round face about `axis` through `at`, a point on the axis beside that face.

        `on`, a direction square to the axis, names the side on which to touch the face, where one stands in another.
        """
        table, entry = key.split(".")
        touch = moved(at, on, getattr(getattr(self._design, table), entry) / 2) if on else None
        self.add("diameter", name, key, (at, touch) if touch else (at,), axis, **more)

    def angle(self, name: str, key: str, vertex: Point, point: Point, start: Point, **more: Any) -> None:
        """Angle at the upright axis `vertex` from the direction `start` to the upright axis `point`, degrees."""
        self.add("angle", name, key, (vertex, point), start, **more)

    def slope(self, name: str, key: str, on: Point, along: Point, **more: Any) -> None:
        """Tangent of the angle between the face at `on` and the direction `along`."""
        self.add("slope", name, key, (on,), along, **more)

    def radius(self, name: str, key: str, on: Point, axis: Point = Z, **more: Any) -> None:
        """Radius of the fillet, corner or crown on whose face `on` lies."""
        self.add("radius", name, key, (on,), axis, **more)

    def chamfer(self, name: str, key: str, on: Point, along: Point = Z, **more: Any) -> None:
        """Leg of the 45 degree chamfer on whose face `on` lies."""
        self.add("chamfer", name, key, (on,), along, **more)

    def derived(
        self,
        name: str,
        value: float,
        keys: tuple[str, ...],
        first: Point,
        second: Point,
        along: Point | None = None,
        **more: Any,
    ) -> None:
        """Distance that follows from several parameters, of the tolerance class of the first."""
        tolerance, along = self._design.tolerance(keys[0]), along or towards(first, second)
        self._all.append(
            Dimension(name, "linear", value, "", (first, second), along, tolerance, derived_from=keys, **more)
        )

    def counted(self, name: str, key: str, at: Point, along: Point = X, **more: Any) -> None:
        """Number of features in the pattern that holds the one at `at`, on the line along `along`."""
        self.add("count", name, key, (at,), along, **more)

    def tapped(
        self,
        feature: str,
        thread: str,
        mouth: Point,
        into: Point,
        *,
        thread_depth: str | None = None,
        drill_depth: str | None = None,
        shows_drill: bool = True,
        view: View = "top",
        count: int = 1,
    ) -> None:
        """A tapped hole: its tap drill, thread depth and drill depth, gathered in one callout.

        Args:
            thread: key in the table of threads, `m6`.
            thread_depth, drill_depth: keys of the depths; none for a hole that goes through.
            shows_drill: whether the tap drill is told here, or was in another callout of the same thread.
        """
        note, key = DESIGNATION[thread], f"threads.{thread}_tap_drill"
        if shows_drill:
            at = moved(mouth, into, 2.0)
            touch = moved(at, X if abs(into[2]) > 0.5 else Z, getattr(self._design.threads, f"{thread}_tap_drill") / 2)
            self.add(
                "tap_drill",
                f"{feature} tap drill",
                key,
                (at, touch),
                into,
                note=note,
                view=view,
                feature=feature,
                count=count,
            )
        if thread_depth:
            self.add(
                "thread_depth",
                f"{feature} thread depth",
                thread_depth,
                (mouth,),
                into,
                note=note,
                view=view,
                feature=feature,
                count=count,
            )
        if drill_depth:
            table, entry = drill_depth.split(".")
            end = moved(mouth, into, getattr(getattr(self._design, table), entry))
            self.depth(
                f"{feature} drill depth", drill_depth, mouth, end, note=note, view=view, feature=feature, count=count
            )


class FaceRequirements:
    """What the faces of one part must be, in the order in which it is written down; values by their keys."""

    def __init__(self, design: Any) -> None:
        self._design = design
        self._all: list[FaceRequirement] = []

    def __iter__(self) -> Iterator[FaceRequirement]:
        return iter(self._all)

    def datum(self, letter: str, points: tuple[Point, ...], normal: Point, view: View, *, round: bool = False) -> None:
        """A face, some faces in one plane, or an axis that others are referred to."""
        self._all.append(DatumFeature(letter, points, normal, view, round))

    def keeps(
        self,
        characteristic: Characteristic,
        name: str,
        key: str,
        points: tuple[Point, ...],
        normal: Point,
        view: View,
        **more: Any,
    ) -> None:
        """Form or direction within the value of `key`, a length."""
        value = round(self._design.si(key) * 1e3, 9)
        self._all.append(GeometricTolerance(name, characteristic, value, key, points, normal, view, **more))

    def smooth(
        self, name: str, key: str, points: tuple[Point, ...], normal: Point, view: View, process: str = ""
    ) -> None:
        """Mean roughness Ra of the value of `key`."""
        value = round(self._design.si(key) * 1e6, 9)
        self._all.append(SurfaceTexture(name, value, key, points, normal, view, process))


def named(*datums: Datum) -> dict[str, Datum]:
    """Datums by their names."""
    return {datum.name: datum for datum in datums}


def towards(first: Point, second: Point) -> Point:
    """Unit vector from one point to another."""
    step = (second[0] - first[0], second[1] - first[1], second[2] - first[2])
    size = math.sqrt(sum(s * s for s in step))
    return (step[0] / size, step[1] / size, step[2] / size)


def moved(point: Point, direction: Point, by: float) -> Point:
    """The point moved along a direction, mm."""
    return (point[0] + by * direction[0], point[1] + by * direction[1], point[2] + by * direction[2])
