"""Dimension specifications of a sheet from the declarations of a part: each once, verified on the solid.

View of a dimension: the one that its declaration names, if the dimension is in true size there, a detail of that view
before the view itself; else any view that shows it in true size. A dimension that no
view shows in true size, as the depth of a hole seen from above, becomes a line of a callout.
"""

import math
import string
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from drawings.dimensions import edges
from drawings.dimensions.levels import drawn_at
from drawings.dimensions.specification import (
    AngleSpec,
    CalloutSpec,
    DimensionSpec,
    DistanceSpec,
    FrameSpec,
    RoundSpec,
    TagSpec,
    TargetSpec,
)
from drawings.dimensions.text import (
    DIAMETER,
    callout,
    dimension_text,
    lines_of_features,
    roughness_text,
    tolerance_text,
    wrapped_lines,
)
from drawings.views.segment_index import enlarged, lines_of
from drawings.views.view import Segment, View, degrees_of, distance_along, dot
from stagecad.parameters.dimension import (
    DatumFeature,
    Dimension,
    FaceRequirement,
    GeometricTolerance,
    SurfaceTexture,
    feature_of,
)
from stagecad.solids.modelling.verification import DimensionVerifier


@dataclass(frozen=True)
class HoleGroup:
    """Equal holes."""

    lines: tuple[str, ...]  # callout
    rows: tuple[TagSpec, ...]  # the holes, from the left column up
    names: tuple[str, ...]  # declarations of the callout


@dataclass(frozen=True)
class HoleTable:
    """The table of a view."""

    view: str  # name of the view, whose origin is that of the coordinates
    groups: tuple[HoleGroup, ...]  # of equal holes
    names: tuple[str, ...]  # declarations of distances between the holes, which follow from the coordinates


ROUND = ("CYLINDER", "SPHERE", "TORUS")
OUTLINED = 0.02
"""Half side of the box at the end of a diameter in which its outline must be drawn, mm."""
SEEN = 6
"""Least number of 16 points of the circle of a hole at which lines are drawn where its mouth is seen."""
LONGEST_BESIDE = 12
"""Length of the longest note printed at its dimension, characters; a longer one is a numbered note of the sheet."""


@dataclass(frozen=True)
class SheetDimensions:
    """Dimensions and tolerances to be shown in the views of a sheet, and its notes."""

    specs: tuple[DimensionSpec, ...]  # in the order of the declarations
    notes: tuple[str, ...]  # texts of the notes that dimensions refer to by number (`[1]`)
    missing: tuple[str, ...]  # names of declarations that no view can show
    table: HoleTable | None = None  # of holes; None where no declaration asks for one
    elsewhere: tuple[str, ...] = ()  # dimensions that the view for which they are declared does not show, a line each


def sheet_dimensions(
    dimensions: Sequence[Dimension],
    requirements: Sequence[FaceRequirement],
    design: Any,
    gauge: DimensionVerifier,
    views: Sequence[View],
    *,
    stated: bool = False,
) -> SheetDimensions:
    """Specifications of all declarations, each in the view that shows it best."""
    builder = _Builder(design, gauge, views)
    builder.stated = stated
    builder.lines = lines_of_features(requirements)
    done: set[str] = set()
    for dimension in dimensions:
        if dimension.name not in done:
            group = builder.callout_group(dimension, dimensions)
            done.update(d.name for d in group)
            builder.add(group)
    for requirement in requirements:
        if not feature_of(requirement):
            builder.require(requirement)
    return SheetDimensions(
        tuple(builder.specs), tuple(builder.notes), tuple(builder.missing), builder.table(), tuple(builder.elsewhere)
    )


class _Builder:
    """Builds specifications from declarations; the attributes are as of `SheetDimensions`."""

    def __init__(self, design: Any, gauge: DimensionVerifier, views: Sequence[View]) -> None:
        self.design, self.gauge, self.views = design, gauge, views
        self.specs: list[DimensionSpec] = []
        self.notes: list[str] = []
        self.missing: list[str] = []
        self.elsewhere: list[str] = []
        self.stated = False
        self.lines: dict[str, list[str]] = {}
        self._table_view: View | None = None
        self._groups: list[HoleGroup] = []
        self._tabulated: list[str] = []

    def callout_group(self, dimension: Dimension, dimensions: Sequence[Dimension]) -> list[Dimension]:
        """The dimensions of one callout: all of a feature that are no dimension by themselves."""
        if not dimension.feature or self._stands_alone(dimension):
            return [dimension]
        return [d for d in dimensions if d.feature == dimension.feature and not self._stands_alone(d)]

    def _stands_alone(self, dimension: Dimension) -> bool:
        """Whether a dimension is a distance in a view, and no line of the callout of its feature."""
        if dimension.kind not in ("linear", "depth", "pitch"):
            return False
        view = self._view_of(dimension)
        if view is None or dimension.kind != "depth":
            return view is not None
        return view.cut is not None if dimension.view == "section" else view.projection.name == dimension.view

    def add(self, group: list[Dimension]) -> None:
        """Add the specification of one dimension, or of the callout of a feature."""
        head = group[0]
        if head.table:
            self._tabulate(group)
            return
        called = len(group) > 1 or (head.feature and not self._stands_alone(head))
        # A depth as a line of a callout is seen along its direction.
        view = None if called and head.kind == "depth" else self._view_of(head)
        view = view or next(iter(_preferred(self.views, head)), None)
        if self.stated and view is not None and len(group) == 1:
            view = self._where_outlined(view, head)
        if view is None:
            self.missing += [d.name for d in group]
            return
        self._compare_view(view, head)
        if called:
            self.specs.append(self._callout(view, group))
        else:
            self.specs.append(self._single(view, head))

    def _where_outlined(self, view: View, d: Dimension) -> View:
        """The view, or for a diameter seen from the side whose outline it lacks, one that shows the outline."""
        if d.kind != "diameter" or self._is_circle(view, d) or self._outlined(view, d):
            return view
        others = [one for one in self.views if not one.clip and one.projection.name != "iso"]
        found = next((one for one in others if not self._is_circle(one, d) and self._outlined(one, d)), None)
        if found is None:
            self.elsewhere.append(
                f"'{d.name}': its outline is not seen in the view '{view.name}'; declare another view"
            )
        return found or view

    def _outlined(self, view: View, d: Dimension) -> bool:
        """Whether lines of the part are drawn at both ends of a diameter that is seen from the side."""
        spec = self._diameter_from_side(view, d)
        lines = lines_of(view.on("VISIBLE", "HIDDEN"))
        return all(lines.count_in(enlarged((*end, *end), OUTLINED)) for end in (spec.first, spec.second))

    def _compare_view(self, view: View, head: Dimension | FaceRequirement) -> None:
        """Note a dimension that is in another view than declared, and what of it its view does not show: the mouth of a
        hole, the ends of a distance."""
        as_declared = head.view in ("any", view.name, view.projection.name)
        if not as_declared and not (head.view == "section" and view.cut):
            name = f"datum {head.letter}" if isinstance(head, DatumFeature) else f"'{head.name}'"
            self.elsewhere.append(
                f"{name} is declared for the view '{head.view}', which does not show it: it is in '{view.name}'"
            )
        if not isinstance(head, Dimension):
            return
        if self.stated and head.kind in ("linear", "pitch") and head.direction:
            u, v = view.projection.to_view(head.direction)
            axes = [c for c in view.on("CENTRE") if isinstance(c, Segment)]
            across = [c for c in axes if abs(distance_along(c.end, c.start, (u, v))) < 1e-3]
            shown = lines_of([*view.on("VISIBLE", "HIDDEN", "THREAD"), *across])
            ends = (drawn_at(point, self.gauge) for point in head.points)
            boxes = [enlarged((*end, *end), 5 * OUTLINED) for end in map(view.projection.to_view, ends)]
            # Or where centre lines cross.
            if not all(shown.count_in(box) or lines_of(axes).count_in(box) > 1 for box in boxes):
                self.elsewhere.append(f"'{head.name}' ends where the view '{view.name}' shows no line")
        if head.kind in ("diameter", "tap_drill") and head.direction and not view.cut and self._is_circle(view, head):
            (u, v), radius = view.projection.to_view(head.points[0]), head.value / 2
            turns = [math.tau * number / 16 for number in range(16)]
            on = [(u + radius * math.cos(turn), v + radius * math.sin(turn)) for turn in turns]
            lines = lines_of(view.on("VISIBLE", "THREAD"))
            seen = [lines.count_in(enlarged((*point, *point), 5 * OUTLINED)) > 0 for point in on]
            # Rounded corners are opposite each other.
            if sum(seen) < SEEN and sum(map(all, zip(seen[:8], seen[8:]))) < 2:
                self.elsewhere.append(f"'{head.name}' is not seen in the view '{view.name}'")

    def _tabulate(self, group: list[Dimension]) -> None:
        """Add holes, or a distance between holes, to the hole table."""
        view = next(view for view in self.views if view.name == group[0].table)
        self._table_view = view
        holes = [d for d in group if d.kind in ("diameter", "tap_drill")]
        if not holes:
            self._tabulated += [d.name for d in group]
            return
        letter, radius = string.ascii_uppercase[len(self._groups)], max(d.value for d in holes) / 2
        places = sorted(view.projection.to_view(face.origin) for face in self.gauge.holes(holes[0]))
        rows = tuple(TagSpec(view.name, place, radius, f"{letter}{n}") for n, place in enumerate(places, start=1))
        self._groups.append(HoleGroup(self._callout_lines(group), rows, tuple(d.name for d in group)))
        self.specs += rows

    def table(self) -> HoleTable | None:
        """The hole table, if there is one."""
        if self._table_view is None:
            return None
        return HoleTable(self._table_view.name, tuple(self._groups), tuple(self._tabulated))

    def _callout_lines(self, group: list[Dimension]) -> tuple[str, ...]:
        """Lines of the callout of a feature, with its control frames and roughness."""
        return (*callout(group, [self._plus_minus(d) for d in group]), *self.lines.get(group[0].feature, ()))

    def _single(self, view: View, dimension: Dimension) -> DimensionSpec:
        match dimension.kind:
            case "linear" | "pitch":
                return self._distance(view, dimension)
            case "depth" if self._is_true_size(view, dimension):
                return self._distance(view, dimension)
            case "diameter" | "tap_drill" if not self._is_circle(view, dimension):
                return self._diameter_from_side(view, dimension)
            case "diameter" | "radius":
                return self._round(view, dimension)
            case "angle":
                return self._angle(view, dimension)
            case "pitch_circle":
                centre = view.projection.to_view(dimension.points[0])
                return CalloutSpec(view.name, centre, dimension.value / 2, (self._text(dimension),), (dimension.name,))
            case _:
                return self._callout(view, [dimension])

    def _view_of(self, dimension: Dimension) -> View | None:
        """The view that shows a dimension best; None where no view shows it in true size."""
        preferred = _preferred(self.views, dimension)
        sides = [view.projection for view in preferred]
        details = [
            v
            for v in self.views
            if v.clip
            and v.projection in sides
            and all(math.dist(v.projection.to_view(p), v.clip[0]) < v.clip[1] for p in dimension.points)
        ]
        if dimension.view == "section" and preferred and preferred[0].cut:
            details = [v for v in details if v.cut == preferred[0].cut]
        shown = [*details, *preferred]
        if self.stated:
            # The side that is declared before any other.
            shown.sort(key=lambda view: sides.index(view.projection))
        return next((view for view in shown if self._is_true_size(view, dimension)), None)

    def _is_true_size(self, view: View, dimension: Dimension) -> bool:
        eye, along = view.projection.towards_eye, dimension.direction
        if along is None:
            return True
        match dimension.kind:
            case "linear" | "depth" | "pitch":
                return abs(dot(along, eye)) < edges.SQUARE
            case "angle":
                first, second = dimension.points
                step = (second[0] - first[0], second[1] - first[1], second[2] - first[2])
                slanting = (
                    abs(dot(step, eye)) < edges.SQUARE and abs(step[2] * along[2]) + abs(along[2]) + abs(step[2]) > 1e-9
                )
                return abs(dot(along, eye)) < edges.SQUARE and (slanting or abs(abs(eye[2]) - 1) < edges.SQUARE)
            case "pitch_circle":
                return self._is_circle(view, dimension)
            case "radius":
                return (
                    self.gauge.face_on(dimension.points[0], *ROUND).kind != "CYLINDER"
                    or abs(abs(dot(along, eye)) - 1) < edges.SQUARE
                )
            case _:
                return True

    def _is_circle(self, view: View, dimension: Dimension) -> bool:
        assert dimension.direction is not None
        return abs(abs(dot(dimension.direction, view.projection.towards_eye)) - 1) < edges.SQUARE

    def _text(self, dimension: Dimension) -> str:
        """Text of a dimension with its note, or where that is long, with the number of a note of the sheet."""
        text = dimension_text(dimension, self._plus_minus(dimension))
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

    def _distance(self, view: View, d: Dimension) -> DistanceSpec:
        first, second = (view.projection.to_view(point) for point in d.points)
        assert d.direction is not None
        angle = _tidy(degrees_of(view.projection.to_view(d.direction)) % 180)
        span = d.value * d.count if d.kind == "pitch" else d.value
        return DistanceSpec(view.name, first, second, angle, self._text(d).replace("{depth}", ""), span, (d.name,))

    def _diameter_from_side(self, view: View, d: Dimension) -> DistanceSpec:
        """A diameter of a feature seen from the side: the distance of its two outlines."""
        assert d.direction is not None
        axis = view.projection.to_view(d.direction)
        size = math.hypot(*axis)
        across = (-axis[1] / size, axis[0] / size)
        at, half = view.projection.to_view(d.points[0]), d.value / 2
        first, second = ((at[0] + side * half * across[0], at[1] + side * half * across[1]) for side in (-1, 1))
        angle = _tidy(degrees_of(across) % 180)
        return DistanceSpec(view.name, first, second, angle, self._text(d), d.value, (d.name,))

    def _round(self, view: View, d: Dimension) -> RoundSpec:
        middle, at = d.points[0], view.projection.to_view(d.points[-1])
        if d.kind == "radius":
            middle = edges.centre_of_round(self.gauge.face_on(d.points[0], *ROUND), d.points[-1])
        centre, text, names = view.projection.to_view(middle), self._text(d), (d.name,)
        towards = degrees_of((at[0] - centre[0], at[1] - centre[1]))
        if d.kind == "radius":
            return RoundSpec(view.name, "radius", centre, d.value, towards, 20.0, text, d.value, names)
        towards = towards if d.points[1:] else 45.0
        return RoundSpec(view.name, "diameter", centre, d.value / 2, towards, 180.0, text, d.value, names)

    def _angle(self, view: View, d: Dimension) -> AngleSpec:
        vertex, second = (view.projection.to_view(point) for point in d.points)
        assert d.direction is not None
        along, reach = view.projection.to_view(d.direction), math.dist(vertex, second)
        first = (vertex[0] + reach * along[0], vertex[1] + reach * along[1])
        return AngleSpec(view.name, vertex, first, second, self._text(d), d.value, (d.name,))

    def _callout(self, view: View, group: list[Dimension]) -> CalloutSpec:
        head = group[0]
        if head.kind == "callout":
            lines = tuple(head.note.split("; "))
        elif len(group) == 1 and not head.feature:
            text = dimension_text(head, self._plus_minus(head))
            lines = (text, *wrapped_lines([head.note])) if head.note else (text,)
        else:
            lines = self._callout_lines(group)
        rim = edges.rim_of_chamfer(view, head, self.gauge) if head.kind == "chamfer" else None
        if rim:
            return CalloutSpec(view.name, *rim, lines, tuple(d.name for d in group))
        holes = [d for d in group if d.kind in ("diameter", "tap_drill")]
        round_ends = holes and holes[0].direction and self._is_circle(view, holes[0])
        radius = max(d.major or d.value for d in holes) / 2 if round_ends else 0.0
        # A hole seen from the side is touched at its wall.
        on = head.points[-1] if holes and not round_ends else head.points[0]
        at = view.projection.to_view(on)
        outward = None if holes or head.kind == "chamfer" else edges.outward_at(view, on, self.gauge)
        names, equal = tuple(d.name for d in group), edges.equal_holes(view, holes[0], self.gauge) if round_ends else ()
        return CalloutSpec(view.name, at, radius, lines, names, equal, outward)

    def require(self, requirement: FaceRequirement) -> None:
        """Add a datum, a tolerance or a texture on the line as which its face is seen."""
        if isinstance(requirement, DatumFeature) and requirement.targets:
            view = next(view for view in self.views if view.name == requirement.targets)
            self.specs += [
                TargetSpec(view.name, view.projection.to_view(point), f"{requirement.letter}{index}")
                for index, point in enumerate(requirement.points, start=1)
            ]
        for view in _preferred(self.views, requirement):
            line = edges.edge_of_face(view, requirement, self.gauge)
            if line:
                self._compare_view(view, requirement)
                self.specs.append(self._on_face(view, line, requirement))
                return
        self.missing.append(getattr(requirement, "name", getattr(requirement, "letter", "")))

    def _on_face(self, view: View, line: edges.EdgeOfFace, requirement: FaceRequirement) -> DimensionSpec:
        first, second, outward, at = line
        match requirement:
            case DatumFeature():
                names = (f"datum {requirement.letter}",)
                diameter = self._diameter(requirement) if requirement.round else 0.0
                if requirement.median:
                    diameter = math.dist(*requirement.points)
                return FrameSpec(
                    view.name, first, second, outward, names, letter=requirement.letter, diameter=diameter, at=at
                )
            case GeometricTolerance():
                text = tolerance_text(requirement)
                names = (f"{requirement.characteristic} {requirement.name}",)
                return FrameSpec(
                    view.name,
                    first,
                    second,
                    outward,
                    names,
                    requirement.characteristic,
                    text,
                    requirement.datums,
                    diameter=self._diameter(requirement) if text.startswith(DIAMETER) else 0.0,
                    at=at,
                    count=len(requirement.points) if requirement.combined else 1,
                )
            case SurfaceTexture():
                lines = (roughness_text(requirement),)
                places = edges.places_of_texture(view, requirement, line, self.gauge)
                return CalloutSpec(
                    view.name, places[0], 0.0, lines, (f"texture {requirement.name}",), places[1:], outward
                )

    def _diameter(self, feature: DatumFeature | GeometricTolerance) -> float:
        name = feature.letter if isinstance(feature, DatumFeature) else feature.name
        return self.gauge.measure(Dimension("feature", "diameter", 1.0, name, feature.points, feature.normal)) or 0.0


def _preferred(views: Sequence[View], declared: Dimension | FaceRequirement) -> list[View]:
    """Views for a declaration: that of its name, a section or auxiliary view at its points, views from its side."""

    def rank(view: View) -> tuple[int, float]:
        plane = {"section": view.cut, "auxiliary": view.face}.get(declared.view)
        if view.name == declared.view:
            return (0, 0.0)
        if plane:
            along = getattr(declared, "direction", None) or plane.normal
            return (1, -sum(map(plane.holds, declared.points)) - abs(dot(along, plane.normal)))
        return (2, -view.scale) if view.projection.name == declared.view else (3, 0.0)

    return sorted((view for view in views if not view.clip and view.projection.name != "iso"), key=rank)


def _tidy(angle: float) -> float:
    """The angle without rounding errors: 0 instead of 180 or 1e-15."""
    near = round(angle, 9)
    return 0.0 if near in (0.0, 180.0) else near
