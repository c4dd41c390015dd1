"""Declarations of a part, turned into what its views are asked to show: each one once, measured on the solid.

Which view shows a dimension: the one its declaration names, if it is seen true there, a detail of that view before the
view itself; else any view in which it is seen true. What no view shows true, the depth of a hole seen from above, is
told in a callout.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from drawings.dimensions.edges import SQUARE, face_line
from drawings.dimensions.specification import AngleSpec, CalloutSpec, DimensionSpec, DistanceSpec, FrameSpec, RoundSpec
from drawings.dimensions.text import DIAMETER, callout, number, plain, times
from drawings.views.view import View, degrees_of, dot
from stagecad.parameters.dimension import (
    DatumFeature,
    Dimension,
    FaceRequirement,
    GeometricTolerance,
    Point,
    SurfaceTexture,
)
from stagecad.solids.modelling.verification import DimensionVerifier, Surface

EXACT = 1e-6
"""How near the solid must come to what is printed, before rounding, mm."""

LONGEST_BESIDE = 12
"""A note longer than this many letters does not go beside its number; it goes into a callout or the sheet's notes."""


@dataclass(frozen=True)
class Request:
    """What the views are asked to show, and the notes that go with it.

    Args:
        asked: in the order of the declarations.
        notes: texts that numbers in brackets (`[1]`) refer to.
        missing: names of declarations that no view can show.
    """

    asked: tuple[DimensionSpec, ...]
    notes: tuple[str, ...]
    missing: tuple[str, ...]


def request(
    dimensions: Sequence[Dimension],
    requirements: Sequence[FaceRequirement],
    design: Any,
    gauge: DimensionVerifier,
    views: Sequence[View],
) -> Request:
    """Every declaration, in the view that shows it best.

    Args:
        dimensions, requirements: of the part; on this sheet.
        design: for the tolerances of the classes.
        gauge: of the part's solid.
        views: of this sheet, with their curves; places do not matter.

    Raises:
        ValueError: the solid does not measure what the declaration says.
    """
    maker = _Maker(design, gauge, views)
    done: set[str] = set()
    for dimension in dimensions:
        if dimension.name in done:
            continue
        together = _together(dimension, dimensions, maker)
        done.update(d.name for d in together)
        maker.add(together)
    for requirement in requirements:
        maker.require(requirement)
    return Request(tuple(maker.asked), tuple(maker.notes), tuple(maker.missing))


def _together(dimension: Dimension, dimensions: Sequence[Dimension], maker: _Maker) -> list[Dimension]:
    """What goes into one callout with a dimension: all of its feature that is not a distance seen true."""
    if not dimension.feature or maker.stands_alone(dimension):
        return [dimension]
    return [d for d in dimensions if d.feature == dimension.feature and not maker.stands_alone(d)]


class _Maker:
    """Makes requests of declarations, and remembers what could not be shown."""

    def __init__(self, design: Any, gauge: DimensionVerifier, views: Sequence[View]) -> None:
        self.design, self.gauge, self.views = design, gauge, views
        self.asked: list[DimensionSpec] = []
        self.notes: list[str] = []
        self.missing: list[str] = []

    def stands_alone(self, dimension: Dimension) -> bool:
        """Whether it is a distance in a view of its own, rather than a line of its feature's callout."""
        if dimension.kind not in ("linear", "depth"):
            return False
        view = self.view_of(dimension)
        if view is None or dimension.kind == "linear":
            return view is not None
        return view.cut is not None if dimension.view == "section" else view.projection.name == dimension.view

    def add(self, together: list[Dimension]) -> None:
        """One request for one dimension, or for all of a feature."""
        for dimension in together:
            self._check(dimension)
        head = together[0]
        view = self.view_of(head) or self._any_view(head)
        if view is None:
            self.missing += [d.name for d in together]
            return
        if len(together) > 1 or (head.feature and not self.stands_alone(head)):
            self._callout(view, together)
            return
        match head.kind:
            case "linear":
                self._distance(view, head)
            case "depth" if self._true(view, head):
                self._distance(view, head)
            case "diameter" | "tap_drill" if not self._seen_as_circle(view, head):
                self._across(view, head)
            case "diameter" | "radius":
                self._round(view, head)
            case "angle":
                self._angle(view, head)
            case _:
                self._callout(view, together)

    def _check(self, dimension: Dimension) -> None:
        if not dimension.points:
            return
        measured = self.gauge.measure(dimension)
        if measured is not None and abs(measured - dimension.value) > EXACT:
            raise ValueError(f"'{dimension.name}': declared {dimension.value!r}, the solid measures {measured!r}")

    def view_of(self, dimension: Dimension) -> View | None:
        """The view that shows a dimension best; none where no view shows it true."""
        preferred = _preferred(self.views, dimension.view, dimension.points)
        details = [v for v in self.views if v.clip and any(_parallel(v, p) for p in preferred)]
        details = [v for v in details if self._fits(v, dimension)]
        if dimension.view == "section" and preferred and preferred[0].cut:
            details = []
        for view in (*details, *preferred):
            if self._true(view, dimension):
                return view
        return None

    def _any_view(self, dimension: Dimension) -> View | None:
        """Where a callout can point at a dimension that no view shows true."""
        return next(iter(_preferred(self.views, dimension.view, dimension.points)), None)

    def _fits(self, view: View, dimension: Dimension) -> bool:
        assert view.clip is not None
        centre, radius = view.clip
        return all(math.dist(view.projection.to_view(p), centre) < radius for p in dimension.points)

    def _true(self, view: View, dimension: Dimension) -> bool:
        eye, along = view.projection.towards_eye, dimension.direction
        if along is None:
            return True
        match dimension.kind:
            case "linear" | "depth":
                return abs(dot(along, eye)) < SQUARE
            case "angle":
                return abs(abs(eye[2]) - 1) < SQUARE
            case "radius":
                return self._surface(dimension).kind != "CYLINDER" or abs(abs(dot(along, eye)) - 1) < SQUARE
            case _:
                return True

    def _seen_as_circle(self, view: View, dimension: Dimension) -> bool:
        assert dimension.direction is not None
        return abs(abs(dot(dimension.direction, view.projection.towards_eye)) - 1) < SQUARE

    def _text(self, dimension: Dimension) -> str:
        """Text with its note beside it where that is short, else with the number of a note."""
        text = plain(dimension, self._plus_minus(dimension))
        note = dimension.note.removeprefix("spherical").strip(" ;") if dimension.kind == "radius" else dimension.note
        note = "" if dimension.kind == "tap_drill" else note
        if not note:
            return text
        if len(note) <= LONGEST_BESIDE:
            return f"{text} {note}"
        if note not in self.notes:
            self.notes.append(note)
        return f"{text} [{self.notes.index(note) + 1}]"

    def _plus_minus(self, dimension: Dimension) -> float:
        name = {"X": "tolerance_x", "X.X": "tolerance_x_x", "X.XX": "tolerance_x_xx"}.get(dimension.tolerance or "")
        return getattr(self.design.drawing, name) if name else 0.0

    def _distance(self, view: View, d: Dimension) -> None:
        first, second = (view.projection.to_view(point) for point in d.points)
        assert d.direction is not None
        angle = degrees_of(view.projection.to_view(d.direction)) % 180
        self.asked.append(
            DistanceSpec(
                view.name, first, second, _tidy(angle), self._text(d).replace("{depth}", ""), d.value, (d.name,)
            )
        )

    def _across(self, view: View, d: Dimension) -> None:
        """A diameter on what is seen from the side: between its two outlines."""
        assert d.direction is not None
        axis = view.projection.to_view(d.direction)
        size = math.hypot(*axis)
        square = (-axis[1] / size, axis[0] / size)
        at, half = view.projection.to_view(d.points[0]), d.value / 2
        ends = [(at[0] + side * half * square[0], at[1] + side * half * square[1]) for side in (-1, 1)]
        angle = _tidy(degrees_of(square) % 180)
        self.asked.append(DistanceSpec(view.name, ends[0], ends[1], angle, self._text(d), d.value, (d.name,)))

    def _round(self, view: View, d: Dimension) -> None:
        on = d.points[-1]
        kind = "radius" if d.kind == "radius" else "diameter"
        if kind == "diameter":
            centre, radius = view.projection.to_view(d.points[0]), d.value / 2
            towards, spread = (45.0, 180.0)
        else:
            centre3 = _centre_of_round(self._surface(d), on)
            centre, radius = view.projection.to_view(centre3), d.value
            at = view.projection.to_view(on)
            towards, spread = degrees_of((at[0] - centre[0], at[1] - centre[1])), 20.0
        self.asked.append(
            RoundSpec(view.name, kind, centre, radius, towards, spread, self._text(d), d.value, (d.name,))
        )

    def _angle(self, view: View, d: Dimension) -> None:
        vertex, second = (view.projection.to_view(point) for point in d.points)
        assert d.direction is not None
        along, reach = view.projection.to_view(d.direction), math.dist(vertex, second)
        first = (vertex[0] + reach * along[0], vertex[1] + reach * along[1])
        self.asked.append(AngleSpec(view.name, vertex, first, second, self._text(d), d.value, (d.name,)))

    def _callout(self, view: View, together: list[Dimension]) -> None:
        head, names = together[0], tuple(d.name for d in together)
        if len(together) == 1 and not head.feature:
            words = [plain(head, self._plus_minus(head)), *([head.note] if head.note else [])]
            if head.kind == "depth":
                words = [times(head.count) + words[0].removeprefix(times(head.count))] + words[1:]
            lines = tuple(words)
        else:
            lines = callout(together, [self._plus_minus(d) for d in together])
        radius = 0.0
        first = next((d for d in together if d.kind in ("diameter", "tap_drill")), None)
        if first and first.direction and self._seen_as_circle(view, first):
            radius = max(d.value for d in together if d.kind in ("diameter", "tap_drill")) / 2
        self.asked.append(CalloutSpec(view.name, view.projection.to_view(head.points[0]), radius, lines, names))

    def _surface(self, dimension: Dimension) -> Surface:
        for surface in self.gauge.surfaces:
            if surface.kind in ("CYLINDER", "SPHERE", "TORUS") and surface.holds(dimension.points[0]):
                return surface
        raise LookupError(f"'{dimension.name}': no round face at {dimension.points[0]}")

    def require(self, requirement: FaceRequirement) -> None:
        """A datum, a tolerance or a texture on the line as which its face is seen."""
        views = _preferred(self.views, requirement.view, requirement.points)
        for view in views:
            line = face_line(view, requirement, self.gauge)
            if line:
                break
        else:
            self.missing.append(getattr(requirement, "name", getattr(requirement, "letter", "")))
            return
        first, second, outward = line
        match requirement:
            case DatumFeature():
                name = f"datum {requirement.letter}"
                diameter = self._diameter(requirement) if requirement.round else 0.0
                made = FrameSpec(
                    view.name, first, second, outward, (name,), letter=requirement.letter, diameter=diameter
                )
            case GeometricTolerance():
                text = f"{requirement.value:g}"
                if requirement.combined:
                    text += " CZ"
                if requirement.round and requirement.characteristic == "perpendicularity":
                    text = DIAMETER + text
                name = f"{requirement.characteristic} {requirement.name}"
                made = FrameSpec(
                    view.name, first, second, outward, (name,), requirement.characteristic, text, requirement.datums
                )
            case SurfaceTexture():
                lines = (f"{{surface}}Ra {number(requirement.roughness, None, 0.0)} {requirement.process}".strip(),)
                places = tuple(
                    (first[0] + t * (second[0] - first[0]), first[1] + t * (second[1] - first[1]))
                    for t in (0.5, 0.25, 0.75, 0.1, 0.9, 0.4, 0.6, 0.02, 0.98)
                )
                name = f"texture {requirement.name}"
                made = CalloutSpec(view.name, places[0], 0.0, lines, (name,), places[1:])
        self.asked.append(made)

    def _diameter(self, datum: DatumFeature) -> float:
        bore = Dimension("datum", "diameter", 1.0, datum.letter, datum.points, datum.normal)
        return self.gauge.measure(bore) or 0.0


def _preferred(views: Sequence[View], name: str, points: Sequence[Point]) -> list[View]:
    """Views that may show something declared for the view `name`, the best first; details left out.

    The view of that name; a section whose plane it lies in; a view from the same side, the larger the better.
    """

    def rank(view: View) -> tuple[int, float]:
        if view.name == name:
            return (0, 0.0)
        if name == "section" and view.cut:
            return (1, -sum(map(view.cut.holds, points)))
        if view.projection.name == name:
            return (2, -view.scale)
        return (3, 0.0)

    return sorted((view for view in views if not view.clip and view.projection.name != "iso"), key=rank)


def _parallel(one: View, other: View) -> bool:
    return dot(one.projection.towards_eye, other.projection.towards_eye) > 1 - SQUARE


def _centre_of_round(surface: Surface, on: Point) -> Point:
    """Centre of the circle of a fillet, corner or crown through a point of it."""
    if surface.kind == "SPHERE":
        return surface.origin
    to = (on[0] - surface.origin[0], on[1] - surface.origin[1], on[2] - surface.origin[2])
    along = dot(to, surface.axis)
    on_axis = tuple(o + along * a for o, a in zip(surface.origin, surface.axis, strict=True))
    if surface.kind == "CYLINDER":
        return (on_axis[0], on_axis[1], on_axis[2])
    from OCP.BRepAdaptor import BRepAdaptor_Surface  # pyright: ignore[reportAttributeAccessIssue, reportMissingImports]

    major = BRepAdaptor_Surface(surface.face.wrapped).Torus().MajorRadius()
    away = tuple(p - o for p, o in zip(on, on_axis, strict=True))
    size = math.hypot(*away)
    x, y, z = (o + major * a / size for o, a in zip(surface.origin, away, strict=True))
    return (x, y, z)


def _tidy(angle: float) -> float:
    """Free of the rounding of a turn: 0 rather than 180 or 1e-15."""
    near = round(angle, 9)
    return 0.0 if near in (0.0, 180.0) else near
