"""Hidden-line removal: the lines of a solid as one direction of view shows them, at 1:1.

The kernel's exact algorithm (`HLRBRep_Algo`) gives edges in the plane of projection. Here they become segments, arcs
and polylines; pieces of one line that touch or overlap become one, and what lies under a visible line is not hidden.
Edges across which the surface is smooth are left out, as a draughtsman does with a fillet's ends; silhouettes stay.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from drawings.views.line_cleaning import CHORD, cleaned
from drawings.views.view import Arc, Curve, Layer, Point2, Polyline, Projection, Segment

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

FLAT = 1e-4
"""A curve seen as a line is one when it is straighter than this, mm."""
ROUND = 1e-3
"""A spline is an arc of a circle when it leaves it by no more than this, mm."""
FEW = 12
"""Poles of a spline that stays as it is."""


def project(
    shape: TopoDS_Shape, projection: Projection, *, hidden: bool = True, exact: bool = True, simple: bool = False
) -> dict[Layer, tuple[Curve, ...]]:
    """Visible and hidden lines of a shape.

    Args:
        shape: solid or compound, part coordinates.
        projection: direction of view.
        hidden: whether hidden lines are wanted.
        exact: by the exact algorithm; else by the one on a mesh, which cannot hang and gives polylines only.
        simple: whether the shape has been through `with_simple_curves` already.

    Returns:
        Curves in view coordinates, mm at 1:1, on the layers ``VISIBLE`` and ``HIDDEN``, in an order that is always the
        same for the same shape.
    """
    drawn = shape if simple or not exact else with_simple_curves(shape)
    result = (_exactly if exact else _by_mesh)([drawn], projection)
    unseen = [result.HCompound(), result.OutLineHCompound()] if hidden else []
    visible, behind = cleaned(_curves([result.VCompound(), result.OutLineVCompound()]), _curves(unseen))
    return {"VISIBLE": visible, "HIDDEN": behind}


def hidden_lines(
    shapes: Sequence[TopoDS_Shape | None], projection: Projection, *, chord: float = CHORD, exact: bool = True
) -> list[tuple[Curve, ...]]:
    """Visible lines of several shapes that hide one another, shape by shape; none of a shape that is None.

    Args:
        shapes: in place; faces that are never visible should have been left out (`drawings.pictures.scene`).
        projection: direction of view.
        chord: greatest distance of a polyline from its curve, mm.
        exact: as for `project`.
    """
    drawn = [shape and with_simple_curves(shape) for shape in shapes] if exact else list(shapes)
    result = (_exactly if exact else _by_mesh)([shape for shape in drawn if shape is not None], projection)
    return [
        tuple(_curves([result.VCompound(shape), result.OutLineVCompound(shape)], chord)) if shape is not None else ()
        for shape in drawn
    ]


def _exactly(shapes: Sequence[TopoDS_Shape], projection: Projection) -> Any:
    """Result of the exact algorithm."""
    from OCP.HLRBRep import HLRBRep_Algo, HLRBRep_HLRToShape

    algorithm = HLRBRep_Algo()
    for shape in shapes:
        algorithm.Add(shape)
    algorithm.Projector(_projector(projection))
    algorithm.Update()
    algorithm.Hide()
    return HLRBRep_HLRToShape(algorithm)


def _by_mesh(shapes: Sequence[TopoDS_Shape], projection: Projection) -> Any:
    """Result of the algorithm that works on triangles."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.HLRBRep import HLRBRep_PolyAlgo, HLRBRep_PolyHLRToShape

    algorithm = HLRBRep_PolyAlgo()
    for shape in shapes:
        BRepMesh_IncrementalMesh(shape, 0.02, False, 0.1, False)
        algorithm.Load(shape)
    algorithm.Projector(_projector(projection))
    algorithm.Update()
    result = HLRBRep_PolyHLRToShape()
    result.Update(algorithm)
    return result


def _projector(projection: Projection) -> Any:
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
    from OCP.HLRAlgo import HLRAlgo_Projector

    frame = gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(*projection.towards_eye), gp_Dir(*projection.right))
    return HLRAlgo_Projector(frame)


def with_simple_curves(shape: TopoDS_Shape) -> TopoDS_Shape:
    """The shape with simpler curves for its free-form edges: arcs where they are arcs to a micrometre (where a crowned
    pad meets its corners), else (where bore meets bore) splines of a few poles, to some 5 um.

    The exact algorithm's time grows steeply with the poles of a spline: of the edges where two bores cross, with
    their 74 poles, nine made a view of the base take 7 s; and it is slow where splines coincide in a view, as those of
    two pads do. The shape that is handed in stays as it is.
    """
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy

    if not any(_splines(shape)):
        return shape
    copy = BRepBuilderAPI_Copy(shape).Shape()
    for edge, poles in list(_splines(copy)):
        if not _made_arc(edge) and poles > FEW:
            _make_simple(edge)
    return copy


def _splines(shape: Any) -> Iterator[tuple[Any, int]]:
    """Edges that are splines, with the number of their poles."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GeomAbs import GeomAbs_BSplineCurve

    for edge in _edges(shape):
        curve = BRepAdaptor_Curve(edge)
        if curve.GetType() == GeomAbs_BSplineCurve:
            yield edge, curve.NbPoles()


def _made_arc(edge: Any) -> bool:
    """Give an edge that is an arc of a circle the arc for its curve; whether it is one."""
    from OCP.BRep import BRep_Builder
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GC import GC_MakeArcOfCircle
    from OCP.TopLoc import TopLoc_Location

    curve = BRepAdaptor_Curve(edge)
    first, last = curve.FirstParameter(), curve.LastParameter()
    points = [curve.Value(first + (last - first) * k / 16) for k in range(17)]
    if points[0].Distance(points[-1]) < ROUND:
        return False
    maker = GC_MakeArcOfCircle(points[0], points[8], points[16])
    if not maker.IsDone():
        return False
    arc = maker.Value()
    circle = BRepAdaptor_Curve(_edge_of(arc)).Circle()
    if max(circle.Distance(point) for point in points) > ROUND:
        return False
    builder = BRep_Builder()
    builder.UpdateEdge(edge, arc, TopLoc_Location(), ROUND)
    builder.Range(edge, arc.FirstParameter(), arc.LastParameter(), True)
    return True


def _edge_of(curve: Any) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge

    return BRepBuilderAPI_MakeEdge(curve).Edge()


def _make_simple(edge: Any) -> None:
    """Give an edge a spline of few poles, where one comes near enough."""
    from OCP.BRep import BRep_Builder, BRep_Tool
    from OCP.GeomAbs import GeomAbs_C1
    from OCP.GeomConvert import GeomConvert_ApproxCurve
    from OCP.TopLoc import TopLoc_Location

    segments, degree, tolerance = 4, 7, 1e-3
    fit = GeomConvert_ApproxCurve(BRep_Tool.Curve_s(edge, 0.0, 1.0), tolerance, GeomAbs_C1, segments, degree)
    if fit.HasResult() and fit.MaxError() < CHORD:
        BRep_Builder().UpdateEdge(edge, fit.Curve(), TopLoc_Location(), fit.MaxError())


def _edges(shape: Any) -> Iterator[Any]:
    """Each edge once, in the shape's own order."""
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopExp import TopExp
    from OCP.TopoDS import TopoDS
    from OCP.TopTools import TopTools_IndexedMapOfShape

    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, TopAbs_EDGE, found)
    for index in range(1, found.Extent() + 1):
        yield TopoDS.Edge_s(found.FindKey(index))


def _curves(compounds: Iterable[Any], chord: float = CHORD) -> Iterator[Curve]:
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.BRepLib import BRepLib
    from OCP.GeomAbs import GeomAbs_Line

    for compound in compounds:
        if compound is None or compound.IsNull():
            continue
        BRepLib.BuildCurves3d_s(compound)
        for edge in _edges(compound):
            curve = BRepAdaptor_Curve(edge)
            drawn = _straight(curve) if curve.GetType() == GeomAbs_Line else _round(curve, chord)
            if drawn is not None:
                yield drawn


def _straight(curve: Any) -> Curve | None:
    """A line in the plane z = 0; None when it has no length there."""
    start, end = _at(curve, curve.FirstParameter()), _at(curve, curve.LastParameter())
    return Segment(start, end) if math.dist(start, end) >= FLAT else None


def _round(curve: Any, chord: float) -> Curve | None:
    """Any other curve in the plane z = 0; None when it has no length there."""
    from OCP.GCPnts import GCPnts_QuasiUniformDeflection
    from OCP.GeomAbs import GeomAbs_Circle

    first, last = curve.FirstParameter(), curve.LastParameter()
    if curve.GetType() == GeomAbs_Circle:
        circle = curve.Circle()
        axis = circle.Axis().Direction().Z()
        if abs(axis) > 1 - 1e-9:
            centre = (circle.Location().X(), circle.Location().Y())
            if last - first > 2 * math.pi - 1e-9:
                return Arc(centre, circle.Radius())
            ends = [_at(curve, first), _at(curve, last)]
            start, end = (_angle(centre, point) for point in (ends if axis > 0 else reversed(ends)))
            return Arc(centre, circle.Radius(), start, end if end > start else end + 360.0)
    points = GCPnts_QuasiUniformDeflection(curve, chord, first, last)
    found = [points.Value(i) for i in range(1, points.NbPoints() + 1)]
    places = [(point.X(), point.Y()) for point in found]
    return (None if _bent(places) else _segment(places)) or _polyline(places)


def _at(curve: Any, parameter: float) -> Point2:
    point = curve.Value(parameter)
    return (point.X(), point.Y())


def _angle(centre: Point2, point: Point2) -> float:
    return math.degrees(math.atan2(point[1] - centre[1], point[0] - centre[0])) % 360.0


def _segment(points: list[Point2]) -> Segment | None:
    """The straight line through the points, to its farthest ends; None when they bend or coincide."""
    ends = max(((a, b) for a in (points[0], points[-1]) for b in points), key=lambda pair: math.dist(*pair))
    length = math.dist(*ends)
    if length < FLAT:
        return None
    (x, y), (p, q) = ends
    if max(abs((u - x) * (q - y) - (v - y) * (p - x)) / length for u, v in points) > FLAT:
        return None
    return Segment(*ends)


def _bent(points: list[Point2]) -> bool:
    """Whether three of some points already lie on no straight line; a quick look before all of them are compared."""
    (x, y), (u, v), (p, q) = points[0], points[len(points) // 2], points[-1]
    longest = max(math.hypot(u - x, v - y), math.hypot(p - u, q - v), math.hypot(p - x, q - y))
    return abs((u - x) * (q - y) - (v - y) * (p - x)) > 2.0 * FLAT * longest


def _polyline(points: list[Point2]) -> Polyline | None:
    return Polyline(tuple(points)) if max(math.dist(points[0], point) for point in points) > FLAT else None
