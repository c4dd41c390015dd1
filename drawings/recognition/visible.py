"""Lines that the six views of a solid show, and the view in which a point of it is seen; vectors of the axes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from drawings.dimensions.definition import AXES
from drawings.recognition.features import NEAR, Features, along_of, is_usual, middle_of_face, outward_normal
from drawings.views.projection import project
from drawings.views.segment_index import SegmentIndex, curve_points, polyline_lines
from drawings.views.view import PROJECTIONS, Point2, dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.verification import DimensionVerifier, moved

LINE_NEAR = 0.02
"""Half side of the box about a point of a dimension in which a line of a view must be drawn, mm at 1:1."""
VIEW_OF = {
    (0.0, 0.0, 1.0): "top",
    (0.0, 0.0, -1.0): "bottom",
    (0.0, -1.0, 0.0): "front",
    (0.0, 1.0, 0.0): "back",
    (1.0, 0.0, 0.0): "right",
    (-1.0, 0.0, 0.0): "left",
}
"""View from the side of an outward normal."""
PREFERRED = {
    "x": ("front", "top", "bottom", "back"),
    "y": ("right", "top", "left", "bottom"),
    "z": ("front", "right", "left", "back"),
}
"""Views that show lengths along an axis, the usual ones first."""
PASSING = 60.0
"""Cost of a point through which lines only pass, mm."""
NEIGHBOURS = (-0.01, 0.0, 0.01)


class VisibleLines:
    """Visible lines of the views of a solid."""

    def __init__(self, verifier: DimensionVerifier) -> None:
        self._verifier = verifier
        self._lines = {name: _visible(verifier, name) for name in VIEW_OF.values()}
        self._size = max(s.high[n] - s.low[n] for s in verifier.surfaces for n in range(3))

    def seen(self, point: Point, view: str) -> float | None:
        """Cost of a point in a view, mm: none where a line of the part ends, more where one passes; None elsewhere."""
        u, v = PROJECTIONS[view].to_view(point)
        lines, ends = self._lines[view]
        if (round(u, 2) + 0.0, round(v, 2) + 0.0) in ends:
            return 0.0
        box = (u - LINE_NEAR, v - LINE_NEAR, u + LINE_NEAR, v + LINE_NEAR)
        return PASSING if lines.count_in(box) else None

    def open_view(self, axis: Point, point: Point) -> str:
        """View along an axis from the side on which a point is not covered."""
        usual = tidy(axis) if is_usual(axis) else tidy(negative(axis))
        for eye in (usual, negative(usual)):
            view = VIEW_OF.get(eye)
            steps = [moved(point, eye, self._size * part / 40) for part in range(40)]
            if view and not any(map(self._verifier.is_inside, steps)):
                return view
        return VIEW_OF.get(usual, "front")


def views_along(name: str) -> tuple[str, ...]:
    return tuple(view for view in VIEW_OF.values() if abs(dot(PROJECTIONS[view].towards_eye, AXES[name])) < 1e-6)


def _visible(verifier: DimensionVerifier, name: str) -> tuple[SegmentIndex, set[Point2]]:
    """Visible lines of a view, and where they end, view coordinates."""
    curves = project(verifier.solid.wrapped, PROJECTIONS[name], hidden=False)["VISIBLE"]
    rows = [list(curve_points(curve)) for curve in curves]
    ends = {(round(u, 2) + 0.0, round(v, 2) + 0.0) for row in rows for u, v in (row[0], row[-1])}
    near = {(round(u + a, 2), round(v + b, 2)) for u, v in ends for a in NEIGHBOURS for b in NEIGHBOURS}
    return SegmentIndex([line for row in rows for line in polyline_lines(row)]), near


def tidy(point: Point) -> Point:
    """A point without rounding errors of the kernel."""
    x, y, z = (round(value, 9) + 0.0 for value in point)
    return (x, y, z)


def negative(vector: Point) -> Point:
    return (-vector[0] + 0.0, -vector[1] + 0.0, -vector[2] + 0.0)


def positive(vector: Point) -> Point:
    """A direction or its opposite, whichever is along an axis of the part."""
    vector = tidy(vector)
    return vector if vector > (0.0, 0.0, 0.0) else negative(vector)


def cross(a: Point, b: Point) -> Point:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@dataclass(frozen=True)
class ProposedDatum:
    """A datum: a plane face, or the axis of the largest shaft; a point of it, its normal or axis, and its view."""

    letter: str
    point: Point
    normal: Point
    view: str
    round: bool = False


def proposed_datums(verifier: DimensionVerifier, features: Features, views: Sequence[str]) -> Iterator[ProposedDatum]:
    """The axis of a turned part and its largest end face; else the largest faces at right angles to each other."""
    used: list[Point] = []
    letters = iter("ABC")
    # The outline of a bore about the same axis would be taken for that of the shaft.
    bored = {face.axis_key for hole in features.holes for face in hole.faces}
    shafts = [one for one in features.shafts if one.face.axis_key not in bored]
    shaft = max(shafts, key=lambda one: one.radius, default=None)
    if shaft is not None and max(abs(dot(shaft.face.origin, unit)) for unit in _across(shaft.face.axis)) < NEAR:
        axis = positive(shaft.face.axis)
        at = moved(
            shaft.face.origin, shaft.face.axis, (shaft.low + shaft.high) / 2 - dot(shaft.face.origin, shaft.face.axis)
        )
        view = next((v for v in views if v in PROJECTIONS and abs(dot(PROJECTIONS[v].towards_eye, axis)) < 1e-6), "")
        if view:
            yield ProposedDatum(next(letters), tidy(at), axis, view, True)
            used = [unit for unit in AXES.values() if abs(dot(unit, axis)) < 1e-6]
    planes = [s for s in verifier.surfaces if s.kind == "PLANE" and along_of(s.axis) is not None]
    for surface in sorted(planes, key=lambda s: -round(s.face.Area(), 3)):
        normal = outward_normal(surface)
        if any(abs(dot(normal, other)) > 0.5 for other in used):
            continue
        shown = (v for v in views if v in PROJECTIONS and abs(dot(PROJECTIONS[v].towards_eye, normal)) < 1e-6)
        view, letter = next(shown, ""), next(letters, "")
        if not view or not letter:
            break
        point = surface.vertices[0] if surface.vertices else middle_of_face(surface)
        yield ProposedDatum(letter, tidy(point), normal, view)
        used.append(normal)


def _across(axis: Point) -> list[Point]:
    return [unit for unit in AXES.values() if abs(dot(unit, axis)) < 1e-6]
