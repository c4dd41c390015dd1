"""Lines that the six views of a solid show, and the view in which a point of it is seen; vectors of the axes."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from drawings.dimensions.levels import AXES, SQUARE, along_of, drawn_at, touch
from drawings.dimensions.round_sections import Section
from drawings.pictures.picture import faces_of_views
from drawings.recognition.features import NEAR, Features, is_usual, middle_of_face
from drawings.views.projection import project, with_simple_curves
from drawings.views.section import cut_shape
from drawings.views.segment_index import CHORD, SegmentIndex, curve_points, polyline_lines
from drawings.views.view import PROJECTIONS, Cut, Point2, dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.frame import cross, subtract
from stagecad.solids.modelling.surface import Surface, moved
from stagecad.solids.modelling.verification import DimensionVerifier

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
OUTER = 3.0
"""Weight of the area of a face at the outside of the part, which a clamp or table reaches, in the choice of datums."""
SMALL_FACE = 20.0
"""Longest edge of a face whose datum symbol is at its middle, mm."""
NEIGHBOURS = (-0.01, 0.0, 0.01)


class VisibleLines:
    """Visible lines of the views of a solid."""

    def __init__(self, verifier: DimensionVerifier) -> None:
        self._verifier = verifier
        self._lines: dict[str, tuple[SegmentIndex, set[Point2]]] = {}
        self._seen_from = faces_of_views(with_simple_curves(verifier.solid.wrapped), None)

    def seen(self, point: Point, view: str) -> float | None:
        """Cost of a point in a view, mm: none where a line of the part ends, more where one passes; None elsewhere."""
        real = drawn_at(point, self._verifier)
        u, v = PROJECTIONS[view].to_view(real)
        # Lines up to a theoretical corner are drawn where they have their true length.
        if abs(dot(subtract(point, real), PROJECTIONS[view].towards_eye)) > SQUARE:
            return None
        if view not in self._lines:
            self._lines[view] = _visible(self._seen_from(PROJECTIONS[view]), view)
        lines, ends = self._lines[view]
        if (round(u, 2) + 0.0, round(v, 2) + 0.0) in ends:
            return 0.0
        box = (u - LINE_NEAR, v - LINE_NEAR, u + LINE_NEAR, v + LINE_NEAR)
        return PASSING if lines.count_in(box) else None

    def drawn(self, points: Sequence[Point], view: str) -> bool:
        """Whether a view has lines at different points of an edge, or at a single point."""
        apart = len({tidy((*PROJECTIONS[view].to_view(point), 0.0)) for point in points}) == len(points)
        return apart and all(self.seen(point, view) is not None for point in points)

    def cut_front(self, cut: Cut | None) -> None:
        """Take the lines of a section for those of the front view, or no section."""
        self._lines.pop("front", None)
        if cut:
            self._lines["front"] = _visible(cut_shape(self._verifier.solid.wrapped, cut), "front")

    def open_view(self, axis: Point, point: Point, otherwise: str = "") -> str:
        """View along an axis from the side on which a point is not covered; another one where it is on both sides."""
        usual = usual_eye(axis)
        for eye in (usual, negative(usual)):
            view = VIEW_OF.get(eye)
            if view and not self.is_covered(eye, point):
                return view
        return otherwise or VIEW_OF.get(usual, "front")

    def has_centre_line(self, at: Point, view: str) -> bool:
        """Whether a view shows both outlines of a round face from the side, with its axis through a point."""
        eye = PROJECTIONS[view].towards_eye
        rounds = (s for s in self._verifier.surfaces if s.kind in ("CYLINDER", "CONE") and s.span > math.pi - NEAR)
        for face in (s for s in rounds if s.off_axis(at) < NEAR and abs(dot(s.axis, eye)) < NEAR):
            (low, high), start = face.extent(face.axis), dot(face.origin, face.axis)
            for along in (low + part * (high - low) - start for part in (0.02, 0.5, 0.98)):
                foot, radius = moved(face.origin, face.axis, along), face.radius + face.taper * along
                outlines = (tidy(moved(foot, cross(eye, face.axis), side * radius)) for side in (1.0, -1.0))
                if all(self.seen(end, view) is not None for end in outlines):
                    return True
        return False

    def is_covered(self, eye: Point, point: Point) -> bool:
        """Whether material is between a point and the eye."""
        return self._verifier.is_covered(point, eye)


def views_along(name: str, of: Collection[Any] = tuple(VIEW_OF.values())) -> tuple[str, ...]:
    """Those of some views that show lengths along an axis."""
    true_size = [view for view in VIEW_OF.values() if abs(dot(PROJECTIONS[view].towards_eye, AXES[name])) < 1e-6]
    return tuple(view for view in true_size if view in of)


def _visible(shape: Any, name: str) -> tuple[SegmentIndex, set[Point2]]:
    """Visible lines of a view, and where they end, view coordinates."""
    curves = project(shape, PROJECTIONS[name], hidden=False)["VISIBLE"]
    # Chords of arcs are nearer to them than a point may be to a line.
    rows = [list(curve_points(curve, 2 * CHORD / LINE_NEAR)) for curve in curves]
    ends = {(round(u, 2) + 0.0, round(v, 2) + 0.0) for row in rows for u, v in (row[0], row[-1])}
    near = {(round(u + a, 2), round(v + b, 2)) for u, v in ends for a in NEIGHBOURS for b in NEIGHBOURS}
    return SegmentIndex([line for row in rows for line in polyline_lines(row)]), near


def tidy(point: Point) -> Point:
    """A point without rounding errors of the kernel."""
    x, y, z = (round(value, 9) + 0.0 for value in point)
    return (x, y, z)


def at_level(point: Point, name: str, level: float) -> Point:
    """The point at a level along an axis of the part."""
    return tidy(tuple(level if axis == name else value for axis, value in zip(AXES, point, strict=True)))  # type: ignore[arg-type]


def negative(vector: Point) -> Point:
    return (-vector[0] + 0.0, -vector[1] + 0.0, -vector[2] + 0.0)


def usual_eye(axis: Point) -> Point:
    """Direction along an axis towards the eye of the top, front or right view, rather than of their opposites."""
    return tidy(axis) if is_usual(axis) else tidy(negative(axis))


def positive(vector: Point) -> Point:
    """A direction or its opposite, whichever is along an axis of the part."""
    vector = tidy(vector)
    return vector if vector > (0.0, 0.0, 0.0) else negative(vector)


@dataclass(frozen=True)
class ProposedDatum:
    """A datum: a plane face, or the axis of the largest shaft; points of it, its normal or axis, and its view."""

    letter: str
    points: tuple[Point, ...]
    normal: Point
    view: str
    round: bool = False


def proposed_datums(
    verifier: DimensionVerifier,
    features: Features,
    views: Sequence[str],
    shown: Mapping[float, str],
    lines: VisibleLines,
    walls: Collection[int],
) -> Iterator[ProposedDatum]:
    """The axis of a turned part and its largest end face; else the largest faces at right angles to each other.
    `shown`: views of diameters that are dimensioned; `walls`: identities of faces within slots, which are no datums."""
    used: list[Point] = []
    letters = iter("ABC")

    def side_views(axis: Point) -> list[str]:
        return [v for v in views if v in PROJECTIONS and abs(dot(PROJECTIONS[v].towards_eye, axis)) < 1e-6]

    def of_axis(shaft: Section) -> Iterator[ProposedDatum]:
        face, axis = shaft.face, positive(shaft.face.axis)
        at = moved(face.origin, shaft.axis, (shaft.low + shaft.high) / 2 - dot(face.origin, shaft.axis))
        rim = (moved(at, unit, side * shaft.radius) for unit in _across(axis) for side in (1.0, -1.0))
        touch = next((point for point in rim if any(one.holds(tidy(point)) for one in shaft.faces)), None)
        if touch and side_views(axis):
            # Another shaft of the same diameter may have the dimension.
            view = min(side_views(axis), key=lambda one: one != shown.get(round(2 * shaft.radius, 9)))
            yield ProposedDatum(next(letters), (tidy(at), tidy(touch)), axis, view, True)
            used.extend(_across(axis))

    shaft = max((one for one in features.shafts if one.whole), key=lambda one: one.radius, default=None)
    low, high = verifier.box
    # Of a part that is within it, whatever slots it has.
    across = _across(shaft.face.axis) if shaft else []
    reach = [abs(dot(subtract(end, shaft.face.origin), unit)) for unit in across for end in (low, high) if shaft]
    if shaft and max(reach, default=math.inf) < shaft.radius + NEAR:
        yield from of_axis(shaft)
    planes = [s for s in verifier.surfaces if s.kind == "PLANE" and along_of(s.axis) and id(s) not in walls]

    def is_outer(surface: Surface) -> bool:
        number = max(range(3), key=lambda n: abs(surface.axis[n]))
        return min(abs(surface.origin[number] - low[number]), abs(surface.origin[number] - high[number])) < NEAR

    for surface in sorted(planes, key=lambda one: -round((OUTER if is_outer(one) else 1.0) * one.face.Area(), 3)):
        normal = surface.normal
        # A part without a flat outside in the plane of its largest face lies in it by its largest boss.
        inner = len(used) == 1 and not is_outer(surface) and abs(dot(normal, used[0])) < 1e-6
        if inner and shaft and abs(dot(shaft.axis, used[0])) > 1 - 1e-6:
            yield from of_axis(shaft)
        if not is_outer(surface) and sum(touch(surface, s) for s in verifier.surfaces if id(s) in walls) > 1:
            continue  # the floor of a slot
        if any(abs(dot(normal, other)) > 0.5 for other in used):
            continue
        edges = sorted(surface.face.Edges(), key=lambda edge: -round(edge.Length(), 3))
        # Off the middle, where centre lines and cutting lines are, except on a small face between others.
        along = [[edge.positionAt(part).toTuple() for part in (0.3, 0.7)] for edge in edges]  # pyright: ignore[reportAttributeAccessIssue]
        rows = [*along, [middle_of_face(surface)], *([vertex] for vertex in surface.vertices)]
        if edges[0].Length() < SMALL_FACE:
            rows.insert(0, [middle_of_face(surface)])
        # A line of the face, and not one that passes by chance.
        drawn = ((row[0], v) for row in rows for v in side_views(normal) if lines.drawn(row, v))
        found = next((one for one in drawn if surface.holds(one[0])), None)
        letter = next(letters, "") if found else ""
        if found and letter:
            yield ProposedDatum(letter, (tidy(found[0]),), normal, found[1])
            used.append(normal)


def _across(axis: Point) -> list[Point]:
    return [unit for unit in AXES.values() if abs(dot(unit, axis)) < 1e-6]


def on_outline(cone: Surface, view: str) -> Point:
    """A point of a conical chamfer where a view shows its outline."""
    levels = [dot(vertex, cone.axis) for vertex in cone.vertices]
    radii = [cone.off_axis(vertex) for vertex in cone.vertices]
    middle = (min(levels) + max(levels)) / 2
    foot = moved(cone.origin, cone.axis, middle - dot(cone.origin, cone.axis))
    across = cross(PROJECTIONS[view].towards_eye, cone.axis)
    sides = (moved(foot, across, side * (min(radii) + max(radii)) / 2) for side in (1.0, -1.0))
    return next((point for point in sides if cone.holds(tidy(point))), middle_of_face(cone))


def extremes(surface: Surface) -> list[Point]:
    """Ends of the outline of a plane face from the side: outermost points of its circles along the axes of the part."""
    found: list[Point] = []
    for edge in surface.face.Edges():
        if edge.geomType() == "CIRCLE":
            centre = edge.arcCenter().toTuple()
            radius: float = edge.radius()  # pyright: ignore[reportAttributeAccessIssue]
            ways = (unit for unit in AXES.values() if abs(dot(unit, surface.axis)) < 1e-6)
            ends = [tidy(moved(centre, unit, side * radius)) for unit in ways for side in (-1.0, 1.0)]
            found += ends if edge.IsClosed() else filter(surface.holds, ends)
    return found
