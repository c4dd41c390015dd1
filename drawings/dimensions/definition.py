"""Completeness of definition: whether size and place of every face of a part follow from its declarations.

Computed on the solid. Sizes: every radius is that of a declared diameter, radius or tap drill, or half a declared
width. Places: along each axis a face or the axis of a round face is at a level that dimensions connect to the reference
(`drawings.dimensions.levels`); a chamfer or fillet is placed by the faces it joins, a hole by the hole table. The
module of a part says what its notes say: `SYMMETRIC`, axes whose middle plane is a plane of symmetry; `TURNED`, number
of equal sectors about z; `defined_by_note(design, point)`, faces that a note or a detail defines.
"""

import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from drawings.dimensions.consistency import contradictions, is_on, parallel
from drawings.dimensions.levels import (
    AXES,
    NEAR,
    SQUARE,
    Levels,
    along_of,
    corners,
    is_fillet,
    like_edges,
    outward_normal,
)
from drawings.dimensions.round_sections import sections_of
from drawings.views.segment_index import SegmentIndex, lines_of
from drawings.views.view import View, auxiliary, dot, projection_of
from stagecad.parameters.dimension import Dimension, FaceRequirement, GeometricTolerance, Point, SurfaceTexture
from stagecad.solids.modelling.frame import cross, subtract
from stagecad.solids.modelling.verification import DimensionVerifier, Surface, moved

HEADINGS = ("face", "kind", "x", "y", "z", "size", "place", "form", "finish")
IN_VIEW = 0.1
"""Half side of the box about a point of an edge in which a line of a view must lie, mm."""


@dataclass(frozen=True)
class FaceDefinition:
    """One face and what defines it."""

    number: int  # in the solid's order, from 1
    kind: str  # plane, cylinder, cone, sphere, torus, or other
    middle: Point  # of its box, part coordinates, mm
    # size, place, form, finish: declarations or notes that give them; empty where nothing does
    size: str
    place: str
    form: str
    finish: str
    shown: bool = True  # whether a view shows an edge of it

    @property
    def problems(self) -> Iterator[str]:
        """What is not defined, one text for each of size and place."""
        where = ", ".join(f"{round(value, 3) + 0.0:g}" for value in self.middle)
        for what in ("size", "place"):
            if not getattr(self, what):
                yield f"the {what} of face {self.number} ({self.kind} at {where}) is not defined"
        if not self.shown:
            yield f"face {self.number} ({self.kind} at {where}) is in no view"

    @property
    def row(self) -> tuple[str, ...]:
        """Cells below `HEADINGS`."""
        middle = (f"{round(value, 3) + 0.0:g}" for value in self.middle)
        return (str(self.number), self.kind, *middle, self.size, self.place, self.form, self.finish)


@dataclass(frozen=True)
class Definition:
    """Definition of a part."""

    faces: tuple[FaceDefinition, ...]  # of the solid
    superfluous: tuple[str, ...]  # dimensions that follow from others
    contradictory: tuple[str, ...] = ()  # tolerances, fits and threads

    @property
    def problems(self) -> tuple[str, ...]:
        """Everything that is missing or given twice, a line each."""
        missing = [problem for face in self.faces for problem in face.problems]
        return (
            *missing,
            *self.contradictory,
            *(f"the dimension '{name}' follows from others" for name in self.superfluous),
        )


@dataclass(frozen=True)
class Notes:
    """Shape of a part that its notes define."""

    symmetric: str = ""  # names of axes whose middle plane is a plane of symmetry
    turned: int = 1  # number of equal sectors about z
    # whether the origin of the part is its middle, axis or datum plane by agreement, and faces without a simple shape
    # are intersections of others. For other parts only what is stated or seen on the solid counts
    packaged: bool = True
    # text of what defines a face at a point besides dimensions; empty for nothing
    defines: Callable[[Point], str] = lambda point: ""


def notes_on_shape(module: Any, design: Any) -> Notes:
    """Symmetry and faces defined by notes, as the module of a part declares them."""
    by_note = getattr(module, "defined_by_note", None)
    return Notes(
        getattr(module, "SYMMETRIC", ""),
        getattr(module, "TURNED", 1),
        True,
        (lambda point: by_note(design, point)) if by_note else lambda point: "",
    )


def definition(
    verifier: DimensionVerifier,
    dimensions: Sequence[Dimension],
    requirements: Sequence[FaceRequirement],
    notes: Notes,
    views: Sequence[View] = (),
    roughness: float = 3.2,
) -> Definition:
    """Definition of a part by its declarations."""
    part = _Part(verifier, dimensions, notes) if notes.packaged else _StatedPart(verifier, dimensions, notes)
    drawn = [(view, lines_of(view.on("VISIBLE", "HIDDEN"))) for view in views if not view.clip]
    faces = []
    for number, surface in enumerate(verifier.surfaces, start=1):
        tolerances = [r for r in requirements if is_on(surface, r)]
        faces.append(
            FaceDefinition(
                number,
                surface.kind.lower(),
                _middle(surface),
                part.size_of(surface),
                part.place_of(surface),
                ", ".join(r.characteristic for r in tolerances if isinstance(r, GeometricTolerance)) or "general",
                next((f"Ra {r.roughness:g}" for r in tolerances if isinstance(r, SurfaceTexture)), f"Ra {roughness:g}"),
                not drawn or any(_is_shown(surface, view, lines) for view, lines in drawn),
            )
        )
    superfluous = tuple(name for one in part.levels.values() for name in one.superfluous)
    wrong = contradictions(verifier, dimensions, requirements, roughness)
    return Definition(tuple(faces), superfluous, tuple(wrong))


class _Part:
    """Sizes and levels of a part."""

    def __init__(self, verifier: DimensionVerifier, dimensions: Sequence[Dimension], notes: Notes) -> None:
        self._notes = notes
        self._surfaces = verifier.surfaces
        self.levels = {
            name: Levels(
                axis,
                dimensions,
                name in notes.symmetric,
                partial(self._feature_at, axis),
                datum=notes.packaged or name in notes.symmetric or self._on_axis(axis),
                rounds=[s for s in verifier.surfaces if s.kind == "CYLINDER"],
                halved=() if notes.packaged else [d for d in dimensions if self._is_slot(d)],
                strict=not notes.packaged,
            )
            for name, axis in AXES.items()
        }
        self._radii = list(_radii(dimensions))
        self._fillets = [(d.value, d.name) for d in dimensions if d.kind == "radius"]
        self._chamfers = [(d.value, d.name) for d in dimensions if d.kind == "chamfer"]
        self._distances = [d for d in dimensions if d.kind == "linear"]
        self._slopes = [d for d in dimensions if d.kind in ("slope", "angle")]
        self._tabulated = {d.value for d in dimensions if d.table and d.kind in ("diameter", "tap_drill")}

    def _is_slot(self, d: Dimension) -> bool:
        """Whether a distance is the width of a slot: its middle is the axis of the half cylinder at an end."""
        if d.kind != "linear" or d.direction is None:
            return False
        middle = (dot(d.points[0], d.direction) + dot(d.points[1], d.direction)) / 2
        return any(
            s.is_round(d.value / 2)
            and abs(dot(s.axis, d.direction)) < SQUARE
            and abs(dot(s.origin, d.direction) - middle) < NEAR
            for s in self._surfaces
        )

    def _on_axis(self, along: Point) -> bool:
        """Whether the origin of the part is on the axis of its largest outer round face, across a direction."""
        outside = [s for s in self._surfaces if s.kind == "CYLINDER" and s.outward]
        largest = max((s for s in outside), key=lambda s: s.radius, default=None)
        size = max(s.high[n] - s.low[n] for s in self._surfaces for n in range(3))
        if largest is None or abs(dot(largest.axis, along)) > SQUARE or abs(dot(largest.origin, along)) > NEAR:
            return False
        ends = [(s.low, s.high) for s in self._surfaces]
        across = [max(dot(high, along) for _, high in ends), -min(dot(low, along) for low, _ in ends)]
        return largest.radius > 0.7 * max(across) or largest.radius > 0.35 * size

    def _feature_at(self, along: Point, point: Point) -> Hashable:
        """The plane face at a point, else the axis across a direction of a round face, else the point itself."""
        flat = [(n, s) for n, s in enumerate(self._surfaces) if s.kind == "PLANE" and s.holds(point)]
        square = [n for n, surface in flat if parallel(surface, along)]
        if square or (flat and self._notes.packaged):
            return square[0] if square else flat[0][0]
        if flat and not square:
            return ("level", round(dot(point, along), 2))
        for surface in self._surfaces:
            if surface.kind == "CYLINDER" and surface.off_axis(point) < NEAR and not parallel(surface, along):
                reach = dot(surface.origin, surface.axis)
                foot = (o - reach * a for o, a in zip(surface.origin, surface.axis, strict=True))
                return tuple(round(value, 2) + 0.0 for value in foot)
        return tuple(round(value, 2) + 0.0 for value in point)

    def size_of(self, surface: Surface) -> str:
        if surface.kind not in ("CYLINDER", "SPHERE", "TORUS"):
            return "-"
        if name := next((name for radius, name in self._radii if abs(radius - surface.radius) < NEAR), ""):
            return name
        return self._notes.defines(_middle(surface))

    def place_of(self, surface: Surface) -> str:
        """Declaration that locates a face, or one of its images by rotation."""
        if joined := self._joins(surface):
            return joined
        for sector in range(self._notes.turned):
            angle = 2 * math.pi * sector / self._notes.turned
            found = self._level_names(_turned(surface.origin, angle), _turned(surface.axis, angle), surface)
            if found:
                return found
        return self._on_circle(surface) or self._notes.defines(_middle(surface))

    def _on_circle(self, surface: Surface) -> str:
        """An upright axis on a circle of equal sectors: by its radius, or the distance of neighbours."""
        if self._notes.turned == 1 or surface.kind == "PLANE" or not parallel(surface, AXES["z"]):
            return ""
        radius = math.hypot(surface.origin[0], surface.origin[1])
        apart = 2 * radius * math.sin(math.pi / self._notes.turned)
        for d in self._distances:
            if min(abs(d.value - radius), abs(d.value - apart)) < NEAR:
                return f"{d.name}, on a circle"
        return ""

    def _joins(self, surface: Surface) -> str:
        """Fillets, chamfers and drill points, placed by the faces that they join; slopes; intersections."""
        if surface.kind not in ("PLANE", "CYLINDER", "CONE", "SPHERE", "TORUS"):
            return "intersection of other faces"
        for radius, name in self._fillets:
            if surface.kind != "PLANE" and abs(surface.radius - radius) < NEAR:
                return f"{name}, by the faces it joins"
        if surface.kind == "CYLINDER" and any(abs(2 * surface.radius - value) < NEAR for value in self._tabulated):
            return "hole table"
        if surface.kind in ("CONE", "PLANE"):
            sides = sorted(high - low for low, high in zip(surface.low, surface.high, strict=True))
            for leg, name in self._chamfers:
                if any(abs(side - leg) < 20 * NEAR for side in sides):
                    return f"{name}, by the faces it joins"
        for d in self._slopes:
            if surface.kind == "PLANE" and surface.holds(d.points[0]):
                return d.name
        if surface.kind == "CONE":
            return self._cone(surface)
        return ""

    def _cone(self, surface: Surface) -> str:
        """A drill point, or a cone between round faces about its axis."""
        for other in self._surfaces:
            if other.kind == "CYLINDER" and other.off_axis(surface.origin) < NEAR and parallel(other, surface.axis):
                return "drill point or cone at the end of a bore"
        return ""

    def _level_names(self, origin: Point, axis: Point, surface: Surface) -> str:
        """Names of what places a plane along its normal, or a round face across its axis."""
        names = []
        along = next((name for name, unit in AXES.items() if abs(abs(dot(axis, unit)) - 1.0) < SQUARE), None)
        if along is None:
            return ""
        across = [along] if surface.kind == "PLANE" else [name for name in AXES if name != along]
        for name in across:
            found = self.levels[name].located_by(dot(origin, AXES[name]), face=surface.kind == "PLANE")
            if not found:
                return ""
            names.append(found)
        return "; ".join(dict.fromkeys(names))


class _StatedPart(_Part):
    """A part of which nothing is agreed: each round face needs its own declaration, each place its dimensions."""

    def __init__(self, verifier: DimensionVerifier, dimensions: Sequence[Dimension], notes: Notes) -> None:
        super().__init__(verifier, dimensions, notes)
        self._verifier = verifier
        self._sizes: dict[int, str] = {}
        self._cones: list[Dimension] = []
        self._depths = [d for d in dimensions if d.kind == "depth"]
        self._circles = [d for d in dimensions if d.kind == "pitch_circle"]
        self._chamfers = []
        # The ends of slots have the radius of their width, whatever fillets have the same.
        for d in sorted(dimensions, key=lambda d: d.kind != "linear"):
            self._enter(d)

    def _enter(self, d: Dimension) -> None:
        """Enter the round faces whose size a dimension gives."""
        if d.kind in ("diameter", "tap_drill") and d.direction is not None:
            try:
                holes = self._verifier.holes(d)
            except LookupError:
                self._cones.append(d)
                return
            like = [*sections_of(s for s in self._surfaces if s.is_round(holes[0].radius))]
            every = len(holes) < d.count and len(like) <= d.count
            for section in like:
                # Walls of one bore have one diameter; collars of one shaft are counted.
                bore = not section.face.outward and any(map(section.face.is_coaxial, holes))
                if every or bore or any(face is hole for face in section.faces for hole in holes):
                    for face in section.faces:
                        self._sizes.setdefault(self._number(face), d.name)
        elif d.kind in ("radius", "chamfer"):
            like = {n: key for n, key in like_edges(self._verifier, d).items() if n not in self._sizes}
            own = [n for n, surface in enumerate(self._surfaces) if surface.holds(d.points[0])]
            keys = {like.get(number, number) for number in own}
            # Where the solid has more than are counted, a note says which are meant, else only the one that is touched.
            every = len({*like.values()}) <= d.count or (d.kind == "chamfer" and d.note != "")
            for number in (*own, *(n for n, key in like.items() if every or key in keys)):
                if d.kind == "radius" or self._surfaces[number].kind in ("PLANE", "CONE"):
                    self._sizes.setdefault(number, d.name)
        elif d.kind == "linear" and d.direction is not None:
            middle = (dot(d.points[0], d.direction) + dot(d.points[1], d.direction)) / 2
            for section in sections_of(s for s in self._surfaces if s.is_round(d.value / 2)):
                across = not section.whole and abs(dot(section.face.axis, d.direction)) < SQUARE
                if across and (d.count > 1 or abs(dot(section.face.origin, d.direction) - middle) < NEAR):
                    for face in section.faces:
                        self._sizes.setdefault(self._number(face), f"{d.name} (ends)")

    def size_of(self, surface: Surface) -> str:
        number = self._number(surface)
        if surface.kind in ("CYLINDER", "SPHERE", "TORUS"):
            return self._sizes.get(number, "") or self._notes.defines(_middle(surface))
        if surface.kind == "CONE" and not self._joins(surface):
            return ""
        return "-"

    def _number(self, surface: Surface) -> int:
        return next(n for n, other in enumerate(self._surfaces) if other is surface)

    def place_of(self, surface: Surface) -> str:
        found = super().place_of(surface)
        if found:
            return found
        if surface.kind == "PLANE":
            for d in self._depths:
                across = surface.holds(d.points[1]) or self._is_floor(surface, d)
                if d.direction and parallel(surface, d.direction) and across:
                    return d.name
            return self._by_vertices(surface) or self._notes.defines(_middle(surface))
        if surface.kind == "CYLINDER":
            if slanting := self._slanting(surface) or self._square_to_face(surface):
                return slanting
            for d in self._circles:
                centre, _ = d.points
                if d.direction is None or not parallel(surface, d.direction):
                    continue
                across = [name for name, unit in AXES.items() if abs(dot(unit, d.direction)) < SQUARE]
                placed = all(self.levels[name].located_by(dot(centre, AXES[name])) for name in across)
                # No angle is needed where the holes are mirror images about an axis of the part.
                u, v = (dot(surface.origin, AXES[name]) - dot(centre, AXES[name]) for name in across[:2])
                step = 180.0 / d.count
                offs = [(math.degrees(math.atan2(v, u)) - axis) % step for axis in (0.0, 90.0)]
                mirrored = min(min(off, step - off) for off in offs) < 1e-3
                on = abs(2 * surface.off_axis(centre) - d.value) < NEAR and mirrored
                if placed and on:
                    return f"{d.name}, equally spaced"
        return ""

    def _slanting(self, surface: Surface) -> str:
        """A hole at an angle: by the angle, and the levels of the point where its axis meets the face, or of the middle
        of a ring of holes."""
        for d in self._slopes:
            if d.kind == "angle" and (_is_at(surface, d) or all(surface.off_axis(point) < NEAR for point in d.points)):
                levels = [self.levels[name].located_by(dot(d.points[0], unit)) for name, unit in AXES.items()]
                if all(levels):
                    return "; ".join(dict.fromkeys((d.name, *levels)))
        return ""

    def _square_to_face(self, surface: Surface) -> str:
        """A hole square to a slanting face, placed by its corners: by distances from an edge of it, or levels."""
        for face in self._surfaces:
            if face.kind != "PLANE" or along_of(face.axis) or not parallel(face, surface.axis):
                continue
            view, placed = projection_of(auxiliary(outward_normal(face))), self._by_vertices(face)
            names = [placed] if placed else []
            for way in (view.right, view.up) if placed else ():
                name = along_of(way)
                level = dot(surface.origin, AXES[name] if name else way)
                names.append(self.levels[name].located_by(level) if name else self._from_edge(level, way, face, placed))
            if placed and all(names):
                return "; ".join(dict.fromkeys(names))
        return ""

    def _from_edge(self, level: float, way: Point, face: Surface, placed: str) -> str:
        """The last of the distances in a direction that lead from a corner of a slanting face to a level."""
        ends = [(d.name, sorted(dot(p, way) for p in d.points)) for d in self._distances if self._is_in(d, way)]
        known = {dot(corner, way): placed for corner in corners(face)}
        for _ in ends:
            for name, (low, high) in ends:
                for here, there in ((low, high), (high, low)):
                    if any(abs(here - one) < NEAR for one in known):
                        known.setdefault(there, name)
        return next((name for one, name in known.items() if abs(one - level) < NEAR), "")

    @staticmethod
    def _is_in(d: Dimension, way: Point) -> bool:
        return d.direction is not None and abs(dot(d.direction, way)) > 1 - SQUARE

    def _is_floor(self, surface: Surface, d: Dimension) -> bool:
        """Whether a plane face is the floor of a stepped hole whose depth is declared, or of one of its equals."""
        assert d.direction is not None
        if abs(dot(surface.origin, d.direction) - dot(d.points[1], d.direction)) > NEAR:
            return False
        middle = _middle(surface)
        return any(
            other.kind == "CYLINDER" and parallel(other, d.direction) and other.off_axis(middle) < NEAR
            for other in self._surfaces
            if d.count > 1 or other.off_axis(d.points[1]) < NEAR
        )

    def _by_vertices(self, surface: Surface) -> str:
        """A plane at an angle, by the located levels of all its corners."""
        names: list[str] = []
        for corner in corners(surface):
            for name, unit in AXES.items():
                if abs(dot(surface.axis, unit)) > SQUARE:
                    found = self.levels[name].located_by(dot(corner, unit), face=along_of(surface.axis) is not None)
                    if not found:
                        return ""
                    names.append(found)
        return "; ".join(dict.fromkeys(names)) and f"corners: {'; '.join(dict.fromkeys(names))}"

    def _joins(self, surface: Surface) -> str:
        if surface.kind == "SPHERE":
            names = [self._ball_level(surface, name) for name in AXES]
            return "; ".join(dict.fromkeys(names)) if all(names) else ""
        if surface.kind == "CYLINDER" and not is_fillet(surface, self._surfaces):
            return ""
        if surface.kind == "TORUS" and any(_continues(s, surface) for s in self._surfaces):
            return ""
        chamfer = self._sizes.get(self._number(surface), "") if surface.kind in ("PLANE", "CONE") else ""
        if chamfer:
            return f"{chamfer}, by the faces it joins"
        if surface.kind not in ("PLANE", "CYLINDER", "CONE", "SPHERE", "TORUS"):
            return self._notes.defines(_middle(surface))
        return super()._joins(surface)

    def _ball_level(self, surface: Surface, name: str) -> str:
        """What gives the middle of a ball along an axis, or its outermost point there."""
        middle = dot(surface.origin, AXES[name])
        tips = (moved(surface.origin, AXES[name], side * surface.radius) for side in (1.0, -1.0))
        levels = [middle, *(dot(tip, AXES[name]) for tip in tips if surface.holds(tip))]
        return next(filter(None, map(self.levels[name].located_by, levels)), "")

    def _cone(self, surface: Surface) -> str:
        """A drill point below a depth, a countersink, or a cone between diameters at located levels."""
        along = next((name for name in AXES if parallel(surface, AXES[name])), None)
        if along is None:
            return ""
        for d in self._cones:
            if d.direction and parallel(surface, d.direction) and "countersink" in d.name:
                low, high = surface.extent(AXES[along])
                own = surface.off_axis(d.points[0]) < NEAR or d.count > 1
                wide = max(map(surface.off_axis, surface.vertices), default=0.0)
                level = low - NEAR <= dot(d.points[0], AXES[along]) <= high + NEAR
                if own and level and abs(2 * wide - d.value) < NEAR:
                    return d.name
        rims = {round(dot(v, AXES[along]), 4): surface.off_axis(v) for v in surface.vertices}
        ends = {level: radius for level, radius in rims.items() if radius > NEAR}
        for level, radius in ends.items():
            known = any(
                number in self._sizes and abs(other.radius - radius) < NEAR and other.is_coaxial(surface)
                for number, other in enumerate(self._surfaces)
                if other.kind == "CYLINDER"
            )
            stated = any(
                surface.off_axis(d.points[0]) < NEAR and abs(dot(d.points[0], AXES[along]) - level) < NEAR
                for d in self._cones
            )
            if not (known or stated) or not self.levels[along].locates_end(level):
                return ""
        return "cone between diameters, or drill point below a depth" if ends else ""


def centred_axes(verifier: DimensionVerifier) -> str:
    """Names of the axes along which a solid reaches equally far to both sides of the origin: what is not dimensioned
    from a side is symmetric about this middle, and the sheet says so."""
    return "".join(name for name, low, high in zip(AXES, *verifier.box, strict=True) if abs(low + high) < NEAR)


def _continues(tube: Surface, bend: Surface) -> bool:
    """Whether a tube goes on in a bend, which a distance to its axis places, and not the faces it joins."""
    across = tube.is_round(bend.radius) and abs(dot(tube.axis, bend.axis)) < SQUARE
    return across and any(map(tube.holds, bend.vertices))


def _is_at(surface: Surface, d: Dimension) -> bool:
    """Whether an axis is one of several at equal angles about a vertex."""
    if d.count == 1 or d.direction is None or surface.off_axis(d.points[0]) > NEAR:
        return False
    normal = cross(d.direction, subtract(d.points[1], d.points[0]))
    angle = math.degrees(math.acos(max(-1.0, min(1.0, dot(surface.axis, d.direction)))))
    steps = [one / d.value for one in (angle, 180.0 - angle)]
    return any(abs(one - round(one)) < NEAR for one in steps) and abs(dot(surface.axis, normal)) < NEAR * math.hypot(
        *normal
    )


def _radii(dimensions: Iterable[Dimension]) -> Iterator[tuple[float, str]]:
    """Radii of round faces with the names of their declarations; the end of a slot has half its width."""
    for d in dimensions:
        if d.kind in ("diameter", "tap_drill"):
            yield d.value / 2, d.name
        elif d.kind == "radius":
            yield d.value, d.name
    for d in dimensions:
        if d.kind == "linear":
            yield d.value / 2, f"{d.name} (ends)"


def _middle(surface: Surface) -> Point:
    (x0, y0, z0), (x1, y1, z1) = surface.low, surface.high
    return ((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2)


def _turned(vector: Point, angle: float) -> Point:
    c, s = math.cos(angle), math.sin(angle)
    return (c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2])


def _is_shown(surface: Surface, view: View, lines: SegmentIndex) -> bool:
    """Whether the middle of an edge of a face is drawn in a view, or a point of it in the plane of a section."""
    for edge in surface.face.Edges():
        points = [edge.positionAt(part).toTuple() for part in (0.37, 0.0, 0.25, 0.5, 0.75)]  # pyright: ignore[reportAttributeAccessIssue]
        cut = [point for point in points[1:] if view.cut and view.cut.holds(point, NEAR)]
        for u, v in map(view.projection.to_view, (points[0], *cut)):
            if lines.count_in((u - IN_VIEW, v - IN_VIEW, u + IN_VIEW, v + IN_VIEW)):
                return True
    return False
