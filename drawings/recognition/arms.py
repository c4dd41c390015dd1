"""Thicknesses of webs between notches, and widths of arms about round features."""

from collections import defaultdict
from itertools import combinations
from math import dist
from typing import Any

from drawings.dimensions.levels import NEAR, along_of, axes_about, tangent_rounds, touch
from drawings.recognition.distances import Distances
from drawings.recognition.features import middle_of_face
from drawings.recognition.rings import webs
from drawings.recognition.visible import positive, tidy
from drawings.views.view import dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.frame import cross, scaled, subtract
from stagecad.solids.modelling.surface import Surface, moved


class Arms(Distances):
    """Collects proposals, of webs and arms, too."""

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
            view, several = self.lines.open_view(axis, near), {"count": count} if count > 1 else {}
            self.add("linear", "arm", width, tidy(far), tidy(near), positive(one.axis), view=view, **several)
            if len(self.proposed) > before:
                of = [wall for pair in group.values() for wall in pair]
                same = (s for s in walls for wall in of if s.is_level(wall.origin) and s.normal == wall.normal)
                self.images |= {id(wall) for wall in same}
