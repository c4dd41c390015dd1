"""Compact declarations of a part's dimensions and of the requirements on its faces.

Value and tolerance class of a dimension come from the parameter it names: a declaration gives the key and where on the
part to measure, and repeats no number.
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
from stagecad.parameters.iso286 import is_class
from stagecad.solids.modelling.surface import moved

X: Point = (1.0, 0.0, 0.0)
Y: Point = (0.0, 1.0, 0.0)
Z: Point = (0.0, 0.0, 1.0)
DOWN: Point = (0.0, 0.0, -1.0)


class DimensionDeclarations:
    """The dimensions of one part, in the order of their declaration; values and tolerance classes are the design's.

    In all methods `key` is a parameter, either of the part's own table (`length`) or with its table (`pads.length`),
    and further fields of `Dimension` (view, feature, count, note) are given by name.
    """

    def __init__(self, design: Any, table: str) -> None:
        self._design, self._table = design, table
        self._all: list[Dimension] = []
        self._common: dict[str, Any] = {}

    def __iter__(self) -> Iterator[Dimension]:
        return iter(self._all)

    def group(self, **common: Any) -> DimensionDeclarations:
        """Declarations that extend the same list, with fields common to all of the group."""
        group = DimensionDeclarations(self._design, self._table)
        group._all, group._common = self._all, {**self._common, **common}
        return group

    def _value(self, key: str) -> float:
        table, _, name = key.rpartition(".")
        return getattr(getattr(self._design, table or self._table), name)

    def add(self, kind: Kind, name: str, key: str, points: tuple[Point, ...], direction: Point, **fields: Any) -> None:
        """One dimension of any kind."""
        full = key if "." in key else f"{self._table}.{key}"
        fields = {"tolerance": self._design.tolerance(full), **self._common, **fields}
        if is_class(fields["tolerance"] or ""):
            fields["deviations"] = self._design.deviations(full)
        self._all.append(Dimension(name, kind, float(self._value(key)), full, points, direction, **fields))

    def linear(
        self, name: str, key: str, first: Point, second: Point, along: Point | None = None, **fields: Any
    ) -> None:
        """Distance between two faces or axes, in the direction `along` or from point to point."""
        self.add("linear", name, key, (first, second), along or towards(first, second), **fields)

    def depth(self, name: str, key: str, mouth: Point, end: Point, along: Point | None = None, **fields: Any) -> None:
        """Depth of a hole or pocket from its mouth to the end of its full section."""
        self.add("depth", name, key, (mouth, end), along or towards(mouth, end), **fields)

    def diameter(self, name: str, key: str, at: Point, axis: Point = Z, on: Point | None = None, **fields: Any) -> None:
        """Diameter of the round face about `axis` through `at`, a point on the axis at the height of that face.

        `on`, a direction at right angles to the axis, gives the side of the face to touch, needed for coaxial faces.
        """
        points = (at, moved(at, on, self._value(key) / 2)) if on else (at,)
        self.add("diameter", name, key, points, axis, **fields)

    def angle(self, name: str, key: str, vertex: Point, point: Point, start: Point, **fields: Any) -> None:
        """Angle at the upright axis `vertex` from the direction `start` to the upright axis `point`, degrees."""
        self.add("angle", name, key, (vertex, point), start, **fields)

    def slope(self, name: str, key: str, on: Point, along: Point, **fields: Any) -> None:
        """Tangent of the angle between the face at `on` and the direction `along`."""
        self.add("slope", name, key, (on,), along, **fields)

    def radius(self, name: str, key: str, on: Point, axis: Point = Z, **fields: Any) -> None:
        """Radius of the fillet, corner or crown that contains the point `on`."""
        self.add("radius", name, key, (on,), axis, **fields)

    def chamfer(self, name: str, key: str, on: Point, along: Point = Z, **fields: Any) -> None:
        """Leg of the 45 degree chamfer that contains the point `on`."""
        self.add("chamfer", name, key, (on,), along, **fields)

    def derived(
        self, name: str, value: float, keys: tuple[str, ...], points: tuple[Point, Point], along: Point, **fields: Any
    ) -> None:
        """Distance that follows from several parameters (`keys` with their tables), in the class of the first."""
        fields = {"kind": "linear", "tolerance": self._design.tolerance(keys[0]), **self._common, **fields}
        self._all.append(
            Dimension(name, value=value, parameter="", points=points, direction=along, derived_from=keys, **fields)
        )

    def pitch(self, name: str, key: str, first: Point, last: Point, steps: int, **fields: Any) -> None:
        """Distance of neighbours in a row from the first to the last of equal features, `steps` distances."""
        self.add("pitch", name, key, (first, last), towards(first, last), **{**fields, "count": steps})

    def pitch_circle(
        self, name: str, key: str, centre: Point, hole: Point, count: int, axis: Point = Z, **fields: Any
    ) -> None:
        """Diameter of the circle about `centre` on which `count` equal holes, one of them about `hole`, are spaced."""
        self.add("pitch_circle", name, key, (centre, hole), axis, **{**fields, "count": count})

    def remark(self, name: str, keys: tuple[str, ...], on: Point, text: str, **fields: Any) -> None:
        """A text on a feature, with the parameters that it gives (`keys` with their tables)."""
        fields = {"direction": X, **self._common, **fields, "note": text}
        self._all.append(Dimension(name, "callout", 0.0, "", (on,), derived_from=keys, **fields))

    def counted(self, name: str, key: str, at: Point, along: Point = X, **fields: Any) -> None:
        """Number of features in the pattern of the one at `at`, in the direction `along`."""
        self.add("count", name, key, (at,), along, **fields)

    def tapped(
        self,
        feature: str,
        thread: str,
        mouth: Point,
        into: Point,
        depths: tuple[str, str] | None = None,
        *,
        extra: str = "",
        **fields: Any,
    ) -> None:
        """A tapped hole: thread (`stagecad.parameters.threads`), its depth, tap drill and drill depth as one callout.

        Threads are cosmetic: the solid has the tap drill's hole, the sheet the designation and thin lines (ISO 6410-1).
        The tap drill is that of the machine's table `threads` if it has the thread.
        """
        row = self._design.thread(thread)
        named = {"note": row.designation, "major": row.major, "feature": feature}
        fields = {"view": "top", **self._common, **fields, **named}
        drill, at = f"threads.{thread}_tap_drill", moved(mouth, into, 2.0)
        stated = hasattr(getattr(self._design, "threads", None), f"{thread}_tap_drill")
        size = self._value(drill) if stated else row.tap_drill
        points = (at, moved(at, X if abs(into[2]) > 0.5 else Z, size / 2))
        if stated:
            self.add("tap_drill", f"{feature} tap drill", drill, points, into, **fields)
        else:
            keys = (drill,)
            drilled = Dimension(
                f"{feature} tap drill", "tap_drill", size, "", points, into, derived_from=keys, **fields
            )
            self._all.append(drilled)
        if depths:
            self.add("thread_depth", f"{feature} thread depth", depths[0], (mouth,), into, **fields)
            self.depth(f"{feature} drill depth", depths[1], mouth, moved(mouth, into, self._value(depths[1])), **fields)
        if extra:
            self.remark(f"{feature} remark", (drill,), mouth, extra, **{**fields, "note": "", "major": 0.0})


class FaceRequirements:
    """Requirements on the faces of one part, in the order of their declaration; values by their keys."""

    def __init__(self, design: Any) -> None:
        self._design = design
        self._all: list[FaceRequirement] = []

    def __iter__(self) -> Iterator[FaceRequirement]:
        return iter(self._all)

    def datum(
        self,
        letter: str,
        points: tuple[Point, ...],
        normal: Point,
        view: View,
        *,
        round: bool = False,
        targets: str = "",
        median: bool = False,
    ) -> None:
        """Datum feature: a face, several faces in one plane, an axis, or the middle plane of two faces."""
        self._all.append(DatumFeature(letter, points, normal, view, round, targets, median))

    def tolerance(
        self,
        characteristic: Characteristic,
        name: str,
        key: str,
        points: tuple[Point, ...],
        normal: Point,
        view: View,
        **more: Any,
    ) -> None:
        """Geometrical tolerance with the value of `key`, a length, as the width of its zone."""
        value = round(self._design.si(key) * 1e3, 9)
        self._all.append(GeometricTolerance(name, characteristic, value, key, points, normal, view, **more))

    def texture(
        self, name: str, key: str, points: tuple[Point, ...], normal: Point, view: View, process: str = "", **more: str
    ) -> None:
        """Mean roughness Ra of the value of `key`; with `feature` in the callout of its holes."""
        value = round(self._design.si(key) * 1e6, 9)
        self._all.append(SurfaceTexture(name, value, key, points, normal, view, process, **more))


def named(*datums: Datum) -> dict[str, Datum]:
    """Datums by their names."""
    return {datum.name: datum for datum in datums}


def towards(first: Point, second: Point) -> Point:
    """Unit vector from one point to another."""
    step = (second[0] - first[0], second[1] - first[1], second[2] - first[2])
    size = math.sqrt(sum(s * s for s in step))
    return (step[0] / size, step[1] / size, step[2] / size)


def fillet_inset(radius: float) -> float:
    """Distance of the middle of a 90 degree fillet from each of the two faces that it joins, mm."""
    return radius * (1 - math.sqrt(0.5))
