"""Size and place of each face of a part by its declarations: what gives them, and where nothing does.

Sizes: every radius is that of a declared diameter, radius or tap drill, or half a declared width. Places: along each
axis a face or the axis of a round face is at a level that dimensions connect to the reference
(`drawings.dimensions.levels`); a chamfer or fillet is placed by the faces it joins, a hole by the hole table, a
slanting face by its corners or an angle, equal features around an axis by one of them and the angle to the next.
"""

import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from drawings.dimensions.consistency import parallel
from drawings.dimensions.levels import (
    AXES,
    AXIS,
    CORNER,
    NEAR,
    OUTLINE,
    SQUARE,
    Levels,
    along_of,
    axis_kind,
    axis_of_reference,
    is_fillet,
    touch,
)
from drawings.views.view import dot
from stagecad.parameters.dimension import Dimension, Point
from stagecad.solids.modelling.dimensioning import towards
from stagecad.solids.modelling.frame import scaled, subtract
from stagecad.solids.modelling.surface import Surface
from stagecad.solids.modelling.verification import DimensionVerifier


@dataclass(frozen=True)
class Notes:
    """Shape of a part that its notes define."""

    symmetric: str = ""  # names of axes whose middle plane is a plane of symmetry
    turned: int = 1  # number of equal sectors about z
    # whether the origin of the part is its middle, axis or datum plane by agreement, and faces without a simple shape
    # are intersections of others. For other parts only what is stated or seen on the solid counts
    packaged: bool = True
    model: bool = False  # whether the model gives the shape of free-form faces and of outlines of marks
    # text of what defines a face at a point besides dimensions; empty for nothing
    defines: Callable[[Point], str] = lambda point: ""


class Part:
    """Sizes and levels of a part."""

    def __init__(self, verifier: DimensionVerifier, dimensions: Sequence[Dimension], notes: Notes) -> None:
        self._notes = notes
        self._surfaces, self._verifier = verifier.surfaces, verifier
        slots = [d for d in dimensions if verifier.kept(("slot", d), partial(self._is_slot, d))]
        self.box, cylinders = verifier.box, [s for s in verifier.surfaces if s.kind == "CYLINDER"]
        self.rounds = [s for s in cylinders if notes.packaged or not self._is_fillet(s)]
        dimensions = [*dimensions, *_of_rays(dimensions)]
        self.levels: dict[str, Levels] = {}
        for name, axis in AXES.items():
            datum = notes.packaged or name in notes.symmetric or self._on_axis(axis)
            halved, own = () if notes.packaged else slots, name in notes.symmetric
            self.levels[name] = Levels(self, axis, dimensions, own, halved, datum=datum, strict=not notes.packaged)
        self._radii = list(_radii(dimensions))
        self._fillets = [(d.value, d.name) for d in dimensions if d.kind == "radius"]
        self._chamfers = [(d.value, d.name) for d in dimensions if d.kind == "chamfer"]
        self._distances = [d for d in dimensions if d.kind == "linear"]
        self._slopes = [d for d in dimensions if d.kind in ("slope", "angle")]
        self._tabulated = {d.value for d in dimensions if d.table and d.kind in ("diameter", "tap_drill")}

    def _is_fillet(self, surface: Surface) -> bool:
        return self._verifier.kept(("fillet", id(surface)), lambda: is_fillet(surface, self._surfaces))

    def _is_slot(self, d: Dimension) -> bool:
        """Whether a distance is a width about an axis: of a prism, or of a round face that both walls meet."""
        along = d.direction
        if d.kind != "linear" or along is None:
            return False
        middle = (dot(d.points[0], along) + dot(d.points[1], along)) / 2
        walls = [s for point in d.points for s in self._surfaces if parallel(s, along) and s.holds(point)]
        rounds = (s for s in self._surfaces if s.kind == "CYLINDER" and abs(dot(s.axis, along)) < SQUARE)
        return any(one.spans(d.points, along) for one in self._verifier.prisms) or any(
            s.is_round(d.value / 2) or (len(walls) == 2 and all(touch(s, w) for w in walls))
            for s in rounds
            if abs(dot(s.origin, along) - middle) < NEAR
        )

    def meets(self, along: Point, level: float) -> bool:
        """Whether a plane face at a level meets a round one whose axis is there."""
        return self._verifier.kept(("meets", along, round(level, 3)), lambda: self._faces_meet(along, level))

    def _faces_meet(self, along: Point, level: float) -> bool:
        at = [s for s in self._surfaces if abs(dot(s.origin, along) - level) < NEAR]
        planes = [s for s in at if s.kind == "PLANE" and parallel(s, along)]
        rounds = [s for s in at if s.kind == "CYLINDER" and abs(dot(s.axis, along)) < SQUARE]
        return any(touch(one, other) for one in planes for other in rounds)

    def side(self, along: Point, point: Point) -> float:
        """Normal along a direction of the plane face at a point; 0 where there are none or two opposite ones."""

        def sides() -> set[float]:
            return {
                round(dot(s.normal, along))
                for s in self._surfaces
                if parallel(s, along) and s.kind == "PLANE" and s.holds(point)
            }

        return float(sum(self._verifier.kept(("side", along, point), sides)))

    def equal(self, along: Point, d: Dimension) -> list[tuple[float, float]]:
        """Levels of the ends of a dimension for several features, and of all of which the faces are like its own."""
        return self._verifier.kept(("equal", along, d), lambda: self._equal_levels(along, d))

    def _equal_levels(self, along: Point, d: Dimension) -> list[tuple[float, float]]:
        ends = sorted(d.points, key=lambda point: dot(point, along))
        found = [(dot(ends[0], along), dot(ends[1], along))]
        for sign in (1.0, -1.0):
            places = [
                {
                    sign * dot(end, along) + by
                    for own in self._surfaces
                    if (own.kind == "PLANE" and abs(dot(own.axis, along)) > SQUARE and own.holds(end))
                    or (own.kind == "CYLINDER" and own.off_axis(end) < NEAR)
                    for by in self._like(own, along, sign)
                }
                for end in ends
            ]
            step = sign * (found[0][1] - found[0][0])
            found += [(one, other) for one in places[0] for other in places[1] if abs(other - one - step) < NEAR]
        return found

    def _like(self, own: Surface, along: Point, sign: float) -> Iterator[float]:
        """How far faces are away that differ from one, or with a sign of -1 from its mirror image, by their place."""
        number, normal = along.index(1.0), own.normal if own.kind == "PLANE" else own.axis
        for s in self._surfaces:
            if s.kind == own.kind == "CYLINDER":
                if s.is_round(own.radius) and parallel(s, own.axis):
                    yield dot(s.origin, along) - sign * dot(own.origin, along)
            elif s.kind == own.kind and abs(s.normal[number] - sign * normal[number]) < SQUARE:
                # Turned about the direction, too.
                sizes = [[one.high[n] - one.low[n] for n in (number, number - 1, number - 2)] for one in (s, own)]
                if all(abs(a - b) < 0.02 for a, b in zip(*([one[0], *sorted(one[1:])] for one in sizes))):
                    yield (s.low[number] + s.high[number] - sign * (own.low[number] + own.high[number])) / 2

    def _on_axis(self, along: Point) -> bool:
        """Whether the origin of the part is on the axis of its largest outer round face, across a direction."""
        own = axis_of_reference(self._surfaces, along)
        if own and abs(dot(own.origin, along)) < NEAR:
            return True
        outside = [s for s in self._surfaces if s.kind == "CYLINDER" and s.outward]
        largest = max((s for s in outside), key=lambda s: s.radius, default=None)
        size = max(s.high[n] - s.low[n] for s in self._surfaces for n in range(3))
        if largest is None or abs(dot(largest.axis, along)) > SQUARE or abs(dot(largest.origin, along)) > NEAR:
            return False
        ends = [(s.low, s.high) for s in self._surfaces]
        across = [max(dot(high, along) for _, high in ends), -min(dot(low, along) for low, _ in ends)]
        return largest.radius > 0.7 * max(across) or largest.radius > 0.35 * size

    def axis_kind(self, along: Point, level: float, name: str) -> str:
        """As `drawings.dimensions.levels.axis_kind`."""
        return axis_kind(self._verifier, along, level, name)

    def feature_at(self, along: Point, point: Point) -> Hashable:
        """The plane face at a point, by its number, else the axis across a direction of a round face, else the point
        itself."""
        key = ("feature", self._notes.packaged, along, point)
        return self._verifier.kept(key, lambda: self._feature(along, point))

    def _feature(self, along: Point, point: Point) -> Hashable:
        flat = [(n, s) for n, s in enumerate(self._surfaces) if s.kind == "PLANE" and s.holds(point)]
        square = [n for n, surface in flat if parallel(surface, along)]
        if square or (flat and self._notes.packaged):
            return square[0] if square else flat[0][0]
        if flat and not square:
            on = self.is_at_outline(point)
            return ("level" if on else CORNER, round(dot(point, along), 2))
        rounds = (s for s in self._surfaces if s.kind in ("CYLINDER", "TORUS") and s.off_axis(point) < NEAR)
        axes = [(s.origin, s.axis) for s in rounds if not parallel(s, along)]
        axes += [(one.centre, one.axis) for one in self._verifier.prisms if one.is_axis(point, along)]
        for origin, axis in axes:
            foot = subtract(origin, scaled(axis, dot(origin, axis)))
            return (AXIS, along_of(axis) or "", *(round(value, 2) + 0.0 for value in foot))
        on = any(s.kind == "CYLINDER" and s.place(point, along) and s.is_at(point) for s in self._surfaces)
        return (OUTLINE if on else "point", *(round(value, 2) + 0.0 for value in point))

    def is_at_outline(self, point: Point) -> bool:
        """Whether a point is at the radius of a round face."""
        return any(s.kind == "CYLINDER" and s.is_at(point) for s in self._surfaces)

    def size_of(self, surface: Surface) -> str:
        if surface.kind not in ("CYLINDER", "SPHERE", "TORUS"):
            return "-"
        if name := next((name for radius, name in self._radii if abs(radius - surface.radius) < NEAR), ""):
            return name
        return self._notes.defines(middle_of_box(surface))

    def place_of(self, surface: Surface) -> str:
        """Declaration that locates a face, or one of its images by rotation."""
        if joined := self._joins(surface):
            return joined
        for sector in range(self._notes.turned):
            angle = 2 * math.pi * sector / self._notes.turned
            found = self._level_names(_turned(surface.origin, angle), _turned(surface.axis, angle), surface)
            if found:
                return found
        return self._on_circle(surface) or self._notes.defines(middle_of_box(surface))

    def _on_circle(self, surface: Surface) -> str:
        """An upright axis on a circle of equal sectors: by its radius, or the distance of neighbours."""
        if self._notes.turned == 1 or surface.kind == "PLANE" or not parallel(surface, AXES["z"]):
            return ""
        radius = math.hypot(surface.origin[0], surface.origin[1])
        apart = 2 * radius * math.sin(math.pi / self._notes.turned)
        near = (d for d in self._distances if min(abs(d.value - radius), abs(d.value - apart)) < NEAR)
        return next((f"{d.name}, on a circle" for d in near), "")

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
            if surface.kind == "PLANE" and surface.holds(d.points[0]) and (self._notes.packaged or d.kind == "slope"):
                return d.name
        return self._cone(surface) if surface.kind == "CONE" else ""

    def _cone(self, surface: Surface) -> str:
        """A drill point, or a cone between round faces about its axis."""
        about = (s for s in self._surfaces if s.kind == "CYLINDER" and parallel(s, surface.axis))
        near = any(s.off_axis(surface.origin) < NEAR for s in about)
        return "drill point or cone at the end of a bore" if near else ""

    def _level_names(self, origin: Point, axis: Point, surface: Surface) -> str:
        """Names of what places a plane along its normal, or a round face across its axis."""
        names = []
        along = next((name for name, unit in AXES.items() if abs(abs(dot(axis, unit)) - 1.0) < SQUARE), None)
        if along is None:
            return ""
        flat = surface.kind == "PLANE"
        across = [along] if flat else [name for name in AXES if name != along]
        for name in across:
            found = self.levels[name].located_by(
                dot(origin, AXES[name]), dot(surface.normal, AXES[name]) if flat else 0.0, about=axis
            )
            if not found:
                return ""
            names.append(found)
        return "; ".join(dict.fromkeys(names))


def _of_rays(dimensions: Sequence[Dimension]) -> Iterator[Dimension]:
    """What a distance from an axis at an angle says along the axes of the part."""
    angles = [d.points for d in dimensions if d.kind == "angle" and d.count == 1]
    for d in (d for d in dimensions if d.kind == "linear" and d.direction and not along_of(d.direction)):
        start, far = d.points
        way = towards(start, far)
        # The angle may be that of another feature on the ray, at another height.
        rays = [(subtract(start, vertex), towards(vertex, end)) for vertex, end in angles]
        beside = [own for off, own in rays if abs(dot(off, own)) < NEAR and sum(abs(a) > NEAR for a in off) < 2]
        if any(math.dist(own, way) < SQUARE for own in beside):
            steps = {unit: dot(subtract(far, start), unit) for unit in AXES.values()}
            yield from (replace(d, value=abs(step), direction=unit) for unit, step in steps.items() if abs(step) > NEAR)


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


def middle_of_box(surface: Surface) -> Point:
    (x0, y0, z0), (x1, y1, z1) = surface.low, surface.high
    return ((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2)


def _turned(vector: Point, angle: float) -> Point:
    c, s = math.cos(angle), math.sin(angle)
    return (c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2])
