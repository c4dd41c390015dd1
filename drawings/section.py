"""Sections: what a cutting plane leaves of a solid, and the hatch on the faces it cut (ISO 128-3, ISO 128-50)."""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from drawings.view import Cut, Point2, Projection, Segment

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

HATCH_PITCH = 3.0
"""Distance of hatch lines on paper, mm."""
HATCH_ANGLE = 45.0
_CHORD = 0.02


def cut_shape(shape: TopoDS_Shape, cut: Cut) -> TopoDS_Shape:
    """What is left of a shape behind a cutting plane.

    Raises:
        ValueError: the plane misses the shape.
    """
    from OCP.Bnd import Bnd_Box
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    size = 2.0 * math.sqrt(box.SquareExtent()) + 1.0
    frame = gp_Ax2(gp_Pnt(*cut.point), gp_Dir(*cut.normal))
    along, across = frame.XDirection(), frame.YDirection()
    corner = [p - size / 2 * (a + b) for p, a, b in zip(cut.point, _numbers(along), _numbers(across), strict=True)]
    air = BRepPrimAPI_MakeBox(gp_Ax2(gp_Pnt(*corner), gp_Dir(*cut.normal), along), size, size, size).Shape()
    result = BRepAlgoAPI_Cut(shape, air)
    if not result.IsDone() or not any(True for _ in cut_faces(result.Shape(), cut)):
        raise ValueError(f"section {cut.letter}-{cut.letter}: the plane does not cut the part")
    return result.Shape()


def _numbers(direction: Any) -> tuple[float, float, float]:
    return (direction.X(), direction.Y(), direction.Z())


def cut_faces(shape: TopoDS_Shape, cut: Cut) -> Iterator[Any]:
    """Plane faces in the cutting plane, towards the eye."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_Plane
    from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        face = TopoDS.Face_s(explorer.Current())
        surface = BRepAdaptor_Surface(face)
        if surface.GetType() == GeomAbs_Plane:
            plane = surface.Plane()
            sign = -1.0 if face.Orientation() == TopAbs_REVERSED else 1.0
            facing = sum(sign * a * b for a, b in zip(_numbers(plane.Axis().Direction()), cut.normal, strict=True))
            at = plane.Location()
            if facing > 1 - 1e-9 and cut.holds((at.X(), at.Y(), at.Z()), 1e-4):
                yield face
        explorer.Next()


def hatch(faces: Iterable[Any], projection: Projection, scale: float, *, falling: bool = False) -> tuple[Segment, ...]:
    """Hatch lines on cut faces, clipped to them; at the pitch that is right on paper.

    Args:
        faces: in the cutting plane (`cut_faces`).
        scale: of the view, paper over part.
        falling: whether lines fall to the right, to tell one part from its neighbour.
    """
    loops: list[list[Point2]] = []
    for face in faces:
        loops.extend(_loops(face, projection))
    return hatch_lines(loops, HATCH_PITCH / scale, -HATCH_ANGLE if falling else HATCH_ANGLE)


def hatch_lines(loops: list[list[Point2]], pitch: float, angle: float = HATCH_ANGLE) -> tuple[Segment, ...]:
    """Lines inside an odd number of closed loops; their grid runs through the origin."""
    turn = math.radians(angle)
    u, v = (math.cos(turn), math.sin(turn)), (-math.sin(turn), math.cos(turn))
    edges: list[tuple[float, float, float, float]] = []
    for loop in loops:
        turned = [(x * u[0] + y * u[1], x * v[0] + y * v[1]) for x, y in loop]
        edges.extend((*a, *b) for a, b in zip(turned, [*turned[1:], turned[0]]))
    if not edges:
        return ()
    low = min(min(b, d) for _, b, _, d in edges)
    high = max(max(b, d) for _, b, _, d in edges)
    lines: list[Segment] = []
    for row in range(math.floor(low / pitch) + 1, math.ceil(high / pitch)):
        level = row * pitch
        hits = sorted(a + (level - b) * (c - a) / (d - b) for a, b, c, d in edges if (b > level) != (d > level))
        for start, end in zip(hits[::2], hits[1::2]):
            if end - start > 0.02 * pitch:
                lines.append(
                    Segment(
                        (start * u[0] + level * v[0], start * u[1] + level * v[1]),
                        (end * u[0] + level * v[0], end * u[1] + level * v[1]),
                    )
                )
    return tuple(lines)


def _loops(face: Any, projection: Projection) -> Iterator[list[Point2]]:
    """Boundary of a face as closed polygons in view coordinates."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.BRepTools import BRepTools_WireExplorer
    from OCP.GCPnts import GCPnts_QuasiUniformDeflection
    from OCP.TopAbs import TopAbs_REVERSED, TopAbs_WIRE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    wires = TopExp_Explorer(face, TopAbs_WIRE)
    while wires.More():
        loop: list[Point2] = []
        walk = BRepTools_WireExplorer(TopoDS.Wire_s(wires.Current()), face)
        while walk.More():
            edge = walk.Current()
            curve = BRepAdaptor_Curve(edge)
            points = GCPnts_QuasiUniformDeflection(curve, _CHORD, curve.FirstParameter(), curve.LastParameter())
            places = [points.Value(i) for i in range(1, points.NbPoints() + 1)]
            if edge.Orientation() == TopAbs_REVERSED:
                places.reverse()
            loop.extend(projection.to_view((p.X(), p.Y(), p.Z())) for p in places[:-1])
            walk.Next()
        yield loop
        wires.Next()
