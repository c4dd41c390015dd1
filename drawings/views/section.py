"""Sections: a solid behind a cutting plane, and the hatch on the cut faces (ISO 128-3, ISO 128-50)."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, pairwise
from typing import Any

import numpy as np

from drawings.views.line_cleaning import Span, joined, without
from drawings.views.view import Curve, Cut, Point2, Projection, Segment, direction, offset
from stagecad.solids.modelling.frame import Box, add, cross, dot, near, scaled, subtract
from stagecad.solids.modelling.kernel import KernelShape, cq, occ, parts_of
from stagecad.solids.modelling.surface import Surface, surface_of

HATCH_PITCH = 3.0
"""Distance of hatch lines on paper, mm."""
HATCH_ANGLE = 45.0
HATCHES = ((False, HATCH_PITCH), (True, HATCH_PITCH), (False, 0.6 * HATCH_PITCH), (True, 0.6 * HATCH_PITCH))
"""Hatches of parts, whether falling and their pitch on the paper, in mm: neighbours differ (ISO 128-50)."""
SHIFTS = (2e-5, -2e-5)
"""Steps by which a cutting plane is moved where the kernel does not cut in it, mm."""
_CHORD = 0.02


def cut_shape(shape: KernelShape, cut: Cut) -> KernelShape:
    """The part of a shape behind a cutting plane, or behind several (ISO 128-3); of an aligned section the part beyond
    the change is turned into the first plane."""
    box = occ.Bnd_Box()
    occ.BRepBndLib.Add_s(shape, box)
    size = 2.0 * math.sqrt(box.SquareExtent()) + 1.0
    x0, y0, z0, x1, y1, z1 = box.Get()
    middle = ((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2)
    usual = _numbers(occ.gp_Ax2(occ.gp_Pnt(), occ.gp_Dir(*cut.normal)).XDirection())
    way = cut.way if cut.more or cut.kind == "half" else usual
    across = cross(cut.normal, way)

    def without(shape: KernelShape, height: float, low: float, high: float, deep: float = 0.0) -> KernelShape:
        """A shape without what is in front of a plane, from one coordinate along the way to another."""
        # The air is centred on the shape, which may be far from the point that gives the plane.
        foot = add(
            scaled(cut.normal, height - deep), add(scaled(way, low), scaled(across, dot(middle, across) - size / 2))
        )
        frame = occ.gp_Ax2(occ.gp_Pnt(*foot), occ.gp_Dir(*cut.normal), occ.gp_Dir(*way))
        return occ.BRepAlgoAPI_Cut(shape, occ.BRepPrimAPI_MakeBox(frame, high - low, size, size + deep).Shape()).Shape()

    begin, end, result = dot(middle, way) - size / 2, dot(middle, way) + size / 2, shape
    heights = [dot(point, cut.normal) for point in (cut.point, *cut.more)]
    if cut.kind == "aligned":
        (step,) = (subtract(point, cut.point) for point in cut.more)
        turn = occ.gp_Trsf()
        angle = math.atan2(dot(step, cut.normal), dot(step, way))
        turn.SetRotation(occ.gp_Ax1(occ.gp_Pnt(*cut.point), occ.gp_Dir(*across)), angle)
        result, builder, (change,) = occ.TopoDS_Compound(), occ.BRep_Builder(), cut.changes
        builder.MakeCompound(result)
        for one, low, high in ((shape, change, end), (shape.Moved(occ.TopLoc_Location(turn)), begin, change)):
            builder.Add(result, without(without(one, heights[0], begin, end), heights[0], low, high, size))
    else:
        ends = (cut.changes[0], end) if cut.kind == "half" else (begin, *cut.changes, end)
        # The kernel may leave a shape whole where a seam is in the plane.
        for by in (0.0, *SHIFTS):
            result = shape
            for height, (low, high) in zip(heights, pairwise(ends), strict=True):
                result = without(result, height + by, low, high)
            at = (dot(vertex.toTuple(), cut.normal) for vertex in cq.Shape.cast(result).Vertices())
            if cut.kind == "half" or max(at, default=0.0) < max(heights) + 2 * SHIFTS[0]:
                break
    if not any(True for _ in cut_faces(result, cut)):
        raise ValueError(f"section {cut.letter}-{cut.letter}: the plane does not cut the part")
    return result


def without_changes(curves: Iterable[Curve], cut: Cut, projection: Projection) -> tuple[Curve, ...]:
    """Lines of a section without those at which its plane changes, which are no edges of the part."""
    u, v = projection.to_view(cut.way)
    changes = cut.changes if cut.more or cut.kind == "half" else ()

    def at_change(curve: Curve) -> bool:
        return isinstance(curve, Segment) and any(
            all(abs(a * u + b * v - change) < 1e-3 for a, b in (curve.start, curve.end)) for change in changes
        )

    return tuple(curve for curve in curves if not at_change(curve))


def _numbers(direction: Any) -> tuple[float, float, float]:
    return (direction.X(), direction.Y(), direction.Z())


def cut_faces(shape: KernelShape, cut: Cut) -> Iterator[Any]:
    """The faces of a shape in the cutting plane, with their normals towards the eye."""
    planes = (cut.point, *(cut.more if cut.kind == "offset" else ()))
    for face in parts_of(shape, "Face"):
        surface = occ.BRepAdaptor_Surface(face)
        if surface.GetType() == occ.GeomAbs_Plane:
            plane = surface.Plane()
            sign = -1.0 if face.Orientation() == occ.TopAbs_REVERSED else 1.0
            facing = sum(sign * a * b for a, b in zip(_numbers(plane.Axis().Direction()), cut.normal, strict=True))
            at = plane.Location()
            level = dot((at.X(), at.Y(), at.Z()), cut.normal)
            if facing > 1 - 1e-9 and any(abs(level - dot(one, cut.normal)) < 1e-4 for one in planes):
                yield face


def ribs(shape: KernelShape, cut: Cut) -> Iterator[tuple[cq.Face, list[cq.Edge]]]:
    """A wall of each rib or web that a plane cuts lengthwise, which is not hatched (ISO 128-50), and the edges at which
    it meets the parts that it joins.

    Its two walls are equal, on both sides of the plane, and nearer to each other than half their shorter side; and two
    faces that are not parallel go on beyond them.
    """
    surfaces = [surface_of(cq.Face(face)) for face in parts_of(shape, "Face")]
    planes = [s for s in surfaces if s.kind == "PLANE" and abs(dot(s.axis, cut.normal)) > 1 - 1e-9]
    square = [(s, dot(s.normal, cut.normal), dot(subtract(s.origin, cut.point), cut.normal)) for s in planes]
    for wall, way, off in square:
        equal = (at for s, other, at in square if way > 0 > other and abs(s.area - wall.area) < 1e-3 * s.area)
        sides = sorted(high - low for low, high in zip(wall.low, wall.high))
        if off < 0 or not any(at < 0 and off - at < 0.5 * sides[1] for at in equal):
            continue
        edges, joined_to = list[cq.Edge](), list[Surface]()
        for edge in wall.face.Edges():
            at = edge.positionAt(0.5).toTuple()  # pyright: ignore[reportAttributeAccessIssue]
            beside = (s for s in surfaces if s is not wall and s.holds(at))
            level = dot(wall.origin, cut.normal) + 1e-3
            beyond = [s for s in beside if s.extent(cut.normal)[1] > level]
            edges += [edge] if beyond else []
            joined_to += beyond
        pairs = combinations(joined_to, 2)
        if any(one.kind != other.kind or abs(dot(one.axis, other.axis)) < 0.999 for one, other in pairs):
            yield wall.face, edges


def hatch(
    faces: Iterable[Any],
    projection: Projection,
    scale: float,
    *,
    falling: bool = False,
    pitch: float = HATCH_PITCH,
    covers: Sequence[np.ndarray] = (),
) -> tuple[Segment, ...]:
    """Hatch lines on cut faces, `pitch` apart on the paper, mm; none on outlines `covers` of parts that are not cut, as
    of a screw in its hole (ISO 6410-1)."""
    loops: list[list[Point2]] = []
    for face in faces:
        # The kernel leaves wires without edges where a plane touches a round face.
        loops.extend(loop for loop in _loops(face, projection) if loop)
    return hatch_lines(loops, pitch / scale, -HATCH_ANGLE if falling else HATCH_ANGLE, covers)


def hatch_lines(
    loops: list[list[Point2]], pitch: float, angle: float = HATCH_ANGLE, covers: Sequence[np.ndarray] = ()
) -> tuple[Segment, ...]:
    """Lines within an odd number of closed loops and outside all covers; their grid contains the origin."""
    u = direction(angle)
    v = (-u[1], u[0])
    pieces = [(*a, *b) for loop in loops for a, b in zip(loop, [*loop[1:], loop[0]])]
    if not pieces:
        return ()
    edges, *covering = (np.reshape(outline, (-1, 2, 2)) @ np.array((u, v)).T for outline in (pieces, *covers))
    low, high = float(edges[..., 1].min()), float(edges[..., 1].max())
    lines: list[Segment] = []
    for row in range(math.floor(low / pitch) + 1, math.ceil(high / pitch)):
        level = row * pitch
        spans = _inside(edges, level)
        for outline in covering:
            spans = without(spans, joined(_inside(outline, level), 0.0), 0.0)
        for start, end in spans:
            if end - start > 0.02 * pitch:
                lines.append(Segment(*(offset((0.0, 0.0), u, along, level) for along in (start, end))))
    return tuple(lines)


def _inside(edges: np.ndarray, level: float) -> list[Span]:
    """Spans of a line at constant height within an odd number of loops, given by their edges (n, 2, 2)."""
    above = edges[..., 1] > level
    crossed = edges[above[:, 0] != above[:, 1]]
    (a, b), (c, d) = crossed[:, 0].T, crossed[:, 1].T
    hits = np.sort(a + (level - b) * (c - a) / (d - b)).tolist()
    return list(zip(hits[::2], hits[1::2]))


def different_hatches(boxes: Sequence[Box], gap: float) -> list[tuple[bool, float]]:
    """A hatch of `HATCHES` for each part: the first that none of those before has whose box is closer than the gap,
    mm, else the first."""
    chosen: list[tuple[bool, float]] = []
    for box in boxes:
        taken = {hatch for other, hatch in zip(boxes, chosen, strict=False) if near(box, other, gap)}
        chosen.append(next((hatch for hatch in HATCHES if hatch not in taken), HATCHES[0]))
    return chosen


def in_plane(corners: np.ndarray, triangles: np.ndarray, cut: Cut, projection: Projection) -> np.ndarray:
    """Intersection of a mesh, its vertices (n, 3) in place and their indices by triangle (m, 3), with a plane: line
    segments (k, 4) of closed outlines, in view coordinates."""
    heights = (corners - cut.point) @ np.array(cut.normal)
    above = heights >= 0.0
    count = above[triangles].sum(axis=1)
    crossed = triangles[(count == 1) | (count == 2)]
    lone = np.argmax(above[crossed] == (above[crossed].sum(axis=1) == 1)[:, None], axis=1)
    first, *others = np.take_along_axis(crossed, (lone[:, None] + np.arange(3)) % 3, axis=1).T
    ends = []
    for other in others:
        share = heights[first] / (heights[first] - heights[other])
        places = corners[first] + share[:, None] * (corners[other] - corners[first])
        ends.append(places @ np.array([projection.right, projection.up]).T)
    return np.hstack(ends)


def _loops(face: Any, projection: Projection) -> Iterator[list[Point2]]:
    """Boundary of a face as closed polygons in view coordinates."""
    for wire in parts_of(face, "Wire"):
        loop: list[Point2] = []
        walk = occ.BRepTools_WireExplorer(wire, face)
        while walk.More():
            loop.extend(edge_points(walk.Current(), projection)[:-1])
            walk.Next()
        yield loop


def edge_points(edge: Any, projection: Projection) -> list[Point2]:
    """Points of an edge in view coordinates, in its order."""
    curve = occ.BRepAdaptor_Curve(edge)
    points = occ.GCPnts_QuasiUniformDeflection(curve, _CHORD, curve.FirstParameter(), curve.LastParameter())
    places = [points.Value(i) for i in range(1, points.NbPoints() + 1)]
    if edge.Orientation() == occ.TopAbs_REVERSED:
        places.reverse()
    return [projection.to_view((p.X(), p.Y(), p.Z())) for p in places]


def outline(face: Any, projection: Projection) -> np.ndarray:
    """Boundary of a face as line segments (n, 4) in view coordinates."""
    rows = [(*a, *b) for loop in _loops(face, projection) for a, b in zip(loop, [*loop[1:], *loop[:1]])]
    return np.array(rows)
