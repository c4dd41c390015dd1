"""Walls: thicknesses of webs between notches, widths of arms about round features, angles of slanting faces."""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations
from math import dist
from typing import Any

from drawings.dimensions.levels import AXES, NEAR, along_of, axes_about, tangent_rounds, touch
from drawings.recognition.distances import Distances
from drawings.recognition.features import AXIS, Level, middle_of_face
from drawings.recognition.rings import webs
from drawings.recognition.visible import negative, positive, tidy, views_along
from drawings.views.view import dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.dimensioning import towards
from stagecad.solids.modelling.frame import add, cross, scaled, subtract
from stagecad.solids.modelling.surface import Surface, meeting, mirrored, moved


@dataclass(frozen=True)
class _Leg:
    """Angle of a flank, degrees: vertex, point of the flank, and direction of the other leg."""

    angle: float
    points: tuple[Point, Point, Point]
    beside: bool = False  # whether the other leg is on a face, or its extension
    inside: bool = False  # whether it is within that face


class Walls(Distances):
    """Collects proposals, of webs, arms and angles of flanks, too."""

    def webs(self) -> None:
        """Thicknesses of thin webs between round notches, equal ones together."""
        groups: dict[tuple[Point, float, float], list[tuple[Point, Point, Surface]]] = defaultdict(list)
        for one, other, notch in webs(self.verifier):
            along = positive(scaled(subtract(other, one), 1 / dist(one, other)))
            low, high = sorted((one, other), key=lambda end: dot(end, along))
            groups[along, round(dot(low, along), 3), round(dot(high, along), 3)].append((low, high, notch))
        for (along, *_), group in groups.items():
            one, other, notch = group[0]
            view, count = self.lines.open_view(notch.axis, one), {"count": len(group)} if group[1:] else {}
            self.add("linear", "web", dist(one, other), one, other, along, view=view, **count)

    def arms(self) -> None:
        """Widths of arms and ribs: of walls about the axis of a round feature that both of them meet, and at an angle
        about another one, too. A slanting wall that touches two round faces needs none."""
        surfaces = self.verifier.surfaces
        self.images |= {id(s) for s in self.features.slanted if tangent_rounds(s, surfaces)}
        walls = [s for s in surfaces if s.kind == "PLANE" and id(s) not in self.images]
        # A fillet may be between a wall and the round face.
        ends = {
            id(s): [v for f in (s, *self.features.fillets) if f is s or touch(f, s) for v in f.vertices] for s in walls
        }
        groups = defaultdict[tuple[Any, ...], dict[Any, tuple[Surface, Surface]]](dict)
        for one, other in combinations(walls, 2):
            width = dot(subtract(one.origin, other.origin), one.normal)
            if dot(one.normal, other.normal) > 1e-9 - 1 or width < NEAR:
                continue
            about = axes_about(one, dot(one.origin, one.axis) - 0.5 * width * dot(one.axis, one.normal), surfaces)
            met = [s for s in about if s.outward and all(any(map(s.is_at, ends[id(wall)])) for wall in (one, other))]
            several = len({s.axis_key for s in about}) > 1
            if not met or not (along_of(one.axis) or several):
                continue
            axis = positive(met[0].axis)
            run, hub = cross(axis, one.axis), max(about, key=lambda s: s.radius).origin
            runs = [[dot(subtract(v, hub), run) for v in wall.vertices] for wall in (one, other)]
            if max(map(min, runs)) < min(map(max, runs)):
                levels = (round(end, 2) for wall in (one, other) for end in wall.extent(axis))
                key = (round(width, 3), axis, one.axis_key[3:] if not several else (), *levels)
                # A hole may divide a wall.
                whole = not any(s.is_at(v) for hole in self.features.holes for s in hole.faces for v in one.vertices)
                groups[key].setdefault((one.axis_key[3:], several and whole and sum(runs[0]) > 0), (one, other))
        for (_, axis, *_), group in groups.items():
            one, other = next(iter(group.values()))
            near, width = middle_of_face(one), dot(subtract(one.origin, other.origin), one.normal)
            far = moved(near, one.normal, -width)
            far = far if other.holds(far) else middle_of_face(other)
            count, before = max(len(group), self.around.get(id(one), 1)), len(self.proposed)
            # Flats on a neck are covered from both ends.
            ends, name = (tidy(far), tidy(near)), along_of(one.axis)
            views = (self.lines.open_view(axis, near), *(views_along(name) if name else ()))
            view = next((v for v in views if all(self.lines.seen(end, v) is not None for end in ends)), views[0])
            several = {"count": count} if count > 1 else {}
            self.add("linear", "arm", width, *ends, positive(one.axis), view=view, **several)
            if len(self.proposed) > before:
                of = [wall for pair in group.values() for wall in pair]
                same = (s for s in walls for wall in of if s.is_level(wall.origin) and s.normal == wall.normal)
                self.images |= {id(wall) for wall in same}

    def angles(self) -> None:
        """Angles of slanting faces: of a dovetail; of usual values, between two flanks or to a face."""
        groups: dict[tuple[float, ...], list[Surface]] = defaultdict(list)
        for s in self.features.slanted:
            if id(s) not in self.images and sum(abs(a) < 1e-6 for a in s.axis) == 1:
                groups[mirrored(s.axis)].append(s)
        for normal, flanks in groups.items():
            edge = next(unit for unit, a in zip(AXES.values(), normal, strict=True) if a < 1e-6)
            found = [leg for flank in flanks for leg in self._legs(flank, edge)]
            roots = [leg for leg in found if sum(leg.points[0] == other.points[0] for other in found) == 4]
            # A dovetail has an acute angle at both its parallel faces.
            inner = [leg for leg in found if leg.inside]
            ways = {leg.points[2] for leg in inner}
            undercut = len(inner) == 2 * len(flanks) and len(ways) == 2 and len({along_of(way) for way in ways}) == 1
            whole = [leg for leg in found if abs(2 * leg.angle - round(2 * leg.angle)) < 1e-3 and leg.beside]
            legs = inner if undercut else sorted(whole, key=lambda leg: (not leg.inside, leg.angle > 45.0))
            planes = {(s.normal, round(dot(s.origin, s.normal), 2)) for s in flanks}
            vees = {tidy(subtract(leg.points[0], scaled(edge, dot(leg.points[0], edge)))) for leg in roots}
            if roots and len(planes) == 2 * len(vees):
                vertex = roots[0].points[0]
                ends = sorted({leg.points[1] for leg in roots if leg.points[0] == vertex})
                ways = [subtract(end, vertex) for end in ends]
                unit = tidy(scaled(ways[0], 1 / math.hypot(*ways[0])))
                angle = math.degrees(math.acos(dot(unit, ways[1]) / math.hypot(*ways[1])))
                legs = [_Leg(angle, (vertex, ends[1], unit))] if abs(angle - round(angle)) < 1e-3 else []
            if len(flanks) == 2 and not roots and not undercut and (apex := self._groove(flanks, edge)):
                legs = [apex]
            for leg in legs[:1]:
                several = len(planes) if leg.beside else len(vees)
                count: dict[str, Any] = {"count": several} if several > 1 else {}
                # In the middle of the flank, where a section shows it if no view does.
                middle = scaled(add(flanks[0].low, flanks[0].high), 0.5)
                by = dot(subtract(middle, leg.points[0]), edge)
                inner = [tidy(moved(point, edge, by)) for point in leg.points[:2]]
                on = any(all(map(s.holds, inner)) for s in flanks)
                vertex, point = inner if on else leg.points[:2]
                view = self.lines.open_view(edge, point if len(flanks) == 2 else vertex, "section")
                self.add("angle", "angle of flank", leg.angle, vertex, point, leg.points[2], view=view, **count)
                self.at_angle |= {id(s) for s in flanks}

    def _groove(self, flanks: Sequence[Surface], edge: Point) -> _Leg | None:
        """The angle between the flanks of a V that a relief cuts off a little before they meet, and the depth of the
        line in which they would."""
        one, other = flanks
        square = [unit for unit in AXES.values() if abs(dot(unit, edge)) < NEAR]
        way, across = sorted(square, key=lambda unit: dot(one.normal, unit) * dot(other.normal, unit), reverse=True)
        way = way if dot(one.normal, way) > 0 else negative(way)
        near, far = (pick(one.corners, key=lambda v: dot(v, way)) for pick in (min, max))
        apex = tidy(meeting(one, other, far) or far)
        if math.dist(apex, far) < NEAR:
            return None
        opposite = moved(far, across, 2 * dot(subtract(apex, far), across))
        angle = 2 * math.degrees(math.acos(dot(way, towards(apex, far))))
        facing = dot(subtract(opposite, far), one.normal) > NEAR and other.holds(tidy(opposite))
        reach = dot(subtract(near, apex), way) < dot(subtract(far, near), way)
        if not facing or not reach or abs(angle - round(angle)) > 1e-3:
            return None
        view = self.lines.open_view(edge, far)
        self.add("linear", "depth of groove", dot(subtract(far, apex), way), apex, tidy(far), way, view=view)
        self.levels_of[along_of(across) or "x"].append(Level(dot(apex, positive(across)), (apex,), view, AXIS))
        return _Leg(angle, (apex, tidy(far), towards(apex, opposite)))

    def _legs(self, flank: Surface, edge: Point) -> Iterator[_Leg]:
        """Acute angles of a flank with the axes of the part, at its corners at one end."""
        ends = [v for v in flank.corners if abs(dot(v, edge) - min(dot(one, edge) for one in flank.corners)) < NEAR]
        for vertex, far in permutations(ends, 2):
            step = subtract(far, vertex)
            for unit in (unit for unit in AXES.values() if abs(dot(unit, edge)) < NEAR):
                along = tidy(scaled(unit, math.copysign(1.0, dot(step, unit))))
                planes = [s for s in self.verifier.surfaces if s.kind == "PLANE" and s is not flank and s.holds(vertex)]
                beside = [s for s in planes if abs(dot(s.axis, unit)) + abs(dot(s.axis, edge)) < NEAR]
                angle = math.degrees(math.acos(dot(step, along) / math.hypot(*step)))
                inside = any(s.holds(moved(vertex, along, 0.01)) for s in beside)
                yield _Leg(angle, (tidy(vertex), tidy(far), along), bool(beside), inside)
