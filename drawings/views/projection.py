"""Hidden-line removal: visible and hidden lines of a solid in one direction of view, at 1:1.

The edges that the kernel's exact algorithm (`HLRBRep_Algo`) projects become segments, arcs and polylines; coincident
ones are merged (`drawings.views.line_cleaning`). Smooth edges, as at the ends of a fillet, are left out; silhouettes
are kept.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from drawings.views.line_cleaning import CHORD, cleaned
from drawings.views.view import Arc, Curve, Layer, Point2, Polyline, Projection, Segment, degrees_of
from stagecad.solids.modelling.kernel import KernelShape, occ

FLAT = 1e-4
"""Greatest distance of a straight curve from its chord, and length below which a curve is left out, mm."""
MOST_POLES = 12
"""Greatest number of poles of a spline that is not simplified."""


def project(
    shape: KernelShape, projection: Projection, *, hidden: bool = True, exact: bool = True, simple: bool = False
) -> dict[Layer, tuple[Curve, ...]]:
    """Visible and hidden lines of a shape, in view coordinates, mm at 1:1, in a reproducible order."""
    drawn = shape if simple or not exact else with_simple_curves(shape)
    result = _removed([drawn], projection, exact=exact and not _is_swept_far(drawn))
    unseen = [result.HCompound(), result.OutLineHCompound()] if hidden else []
    visible, behind = cleaned(_curves([result.VCompound(), result.OutLineVCompound()]), _curves(unseen))
    return {"VISIBLE": visible, "HIDDEN": behind}


def hidden_lines(
    shapes: Sequence[KernelShape | None], projection: Projection, *, chord: float = CHORD, exact: bool = True
) -> list[tuple[Curve, ...]]:
    """Visible lines of several shapes that hide one another, shape by shape; none of a shape that is None. Faces that
    are never visible should have been left out (`drawings.pictures.picture`); `chord`, `exact` as for `project`."""
    drawn = [shape and with_simple_curves(shape) for shape in shapes] if exact else list(shapes)
    result = _removed([shape for shape in drawn if shape is not None], projection, exact=exact)
    return [
        tuple(_curves([result.VCompound(shape), result.OutLineVCompound(shape)], chord)) if shape is not None else ()
        for shape in drawn
    ]


def _removed(shapes: Sequence[KernelShape], projection: Projection, *, exact: bool) -> Any:
    """Result of the exact algorithm, or of that on triangles, also where the exact one cannot evaluate a surface."""
    if exact:
        try:
            return _exactly(shapes, projection)
        except Exception as error:  # the kernel raises a dozen kinds
            if not type(error).__module__.startswith("OCP"):
                raise
    return _by_mesh(shapes, projection)


def _exactly(shapes: Sequence[KernelShape], projection: Projection) -> Any:
    """Result of the exact algorithm."""
    algorithm = occ.HLRBRep_Algo()
    for shape in shapes:
        algorithm.Add(shape)
    algorithm.Projector(_projector(projection))
    algorithm.Update()
    algorithm.Hide()
    return occ.HLRBRep_HLRToShape(algorithm)


def _by_mesh(shapes: Sequence[KernelShape], projection: Projection) -> Any:
    """Result of the algorithm that works on triangles."""
    algorithm = occ.HLRBRep_PolyAlgo()
    for shape in shapes:
        occ.BRepMesh_IncrementalMesh(shape, 0.02, False, 0.35, False)
        algorithm.Load(shape)
    algorithm.Projector(_projector(projection))
    algorithm.Update()
    result = occ.HLRBRep_PolyHLRToShape()
    result.Update(algorithm)
    return result


def _projector(projection: Projection) -> Any:
    frame = occ.gp_Ax2(occ.gp_Pnt(0, 0, 0), occ.gp_Dir(*projection.towards_eye), occ.gp_Dir(*projection.right))
    return occ.HLRAlgo_Projector(frame)


def with_simple_curves(shape: KernelShape) -> KernelShape:
    """A copy of the shape in which splines of many poles, where bores cross, are replaced by simpler ones within 5 um.

    The time of the exact algorithm grows steeply with the number of poles and the degree: with the 74 poles of nine
    such edges the views of the base take 9.6 s instead of 1 s.
    """
    if not any(True for _ in _complex_edges(shape)):
        return shape
    copy = occ.BRepBuilderAPI_Copy(shape).Shape()
    for edge in list(_complex_edges(copy)):
        _simplify(edge)
    return copy


def _complex_edges(shape: Any) -> Iterator[Any]:
    """Edges that are splines of more than `MOST_POLES` poles."""
    for edge in _each(shape, "Edge"):
        curve = occ.BRepAdaptor_Curve(edge)
        if curve.GetType() == occ.GeomAbs_BSplineCurve and curve.NbPoles() > MOST_POLES:
            yield edge


def _is_swept_far(shape: Any) -> bool:
    """Whether a face is a spline surface of more than `MOST_POLES` poles each way, as a coil, of which the exact
    algorithm takes 7 s a view and that on triangles 1 s."""
    surfaces = (occ.BRepAdaptor_Surface(face) for face in _each(shape, "Face"))
    splines = (one.BSpline() for one in surfaces if one.GetType() == occ.GeomAbs_BSplineSurface)
    return any(one.NbUPoles() * one.NbVPoles() > MOST_POLES**2 for one in splines)


def _simplify(edge: Any) -> None:
    """Replace the spline of an edge by one of few poles, if it is near enough."""
    segments, degree, tolerance = 32, 3, 0.5 * CHORD
    fit = occ.GeomConvert_ApproxCurve(
        occ.BRep_Tool.Curve_s(edge, 0.0, 1.0), tolerance, occ.GeomAbs_C0, segments, degree
    )
    if fit.HasResult() and fit.MaxError() < CHORD:
        occ.BRep_Builder().UpdateEdge(edge, fit.Curve(), occ.TopLoc_Location(), fit.MaxError())


def _each(shape: Any, kind: str) -> Iterator[Any]:
    """Each `Edge` or `Face` once, in the order of the kernel."""
    found = occ.TopTools_IndexedMapOfShape()
    occ.TopExp.MapShapes_s(shape, getattr(occ.TopAbs_ShapeEnum, f"TopAbs_{kind.upper()}"), found)
    for index in range(1, found.Extent() + 1):
        yield getattr(occ.TopoDS, f"{kind}_s")(found.FindKey(index))


def _curves(compounds: Iterable[Any], chord: float = CHORD) -> Iterator[Curve]:
    for compound in compounds:
        if compound is None or compound.IsNull():
            continue
        occ.BRepLib.BuildCurves3d_s(compound)
        for edge in _each(compound, "Edge"):
            if drawn := _drawn(occ.BRepAdaptor_Curve(edge), chord):
                yield drawn


def _drawn(curve: Any, chord: float) -> Curve | None:
    """A curve in the plane z = 0; None if it has no length there."""
    first, last = curve.FirstParameter(), curve.LastParameter()
    if curve.GetType() == occ.GeomAbs_Line:
        start, end = _at(curve, first), _at(curve, last)
        return Segment(start, end) if math.dist(start, end) >= FLAT else None
    if curve.GetType() == occ.GeomAbs_Circle:
        circle = curve.Circle()
        axis = circle.Axis().Direction().Z()
        if abs(axis) > 1 - 1e-9:
            centre = (circle.Location().X(), circle.Location().Y())
            if last - first > 2 * math.pi - 1e-9:
                return Arc(centre, circle.Radius())
            ends = [_at(curve, end) for end in ((first, last) if axis > 0 else (last, first))]
            start, end = (degrees_of((u - centre[0], v - centre[1])) % 360.0 for u, v in ends)
            return Arc(centre, circle.Radius(), start, end if end > start else end + 360.0)
    points = occ.GCPnts_QuasiUniformDeflection(curve, chord, first, last)
    found = [points.Value(i) for i in range(1, points.NbPoints() + 1)]
    places = [(point.X(), point.Y()) for point in found]
    long = max(math.dist(places[0], place) for place in places) > FLAT
    return _segment(places) or (Polyline(tuple(places)) if long else None)


def _at(curve: Any, parameter: float) -> Point2:
    point = curve.Value(parameter)
    return (point.X(), point.Y())


def _segment(points: list[Point2]) -> Segment | None:
    """The straight line through points, between the farthest of them; None if they are not collinear or coincide."""
    ends = max(((a, b) for a in (points[0], points[-1]) for b in points), key=lambda pair: math.dist(*pair))
    length = math.dist(*ends)
    if length < FLAT:
        return None
    (x, y), (p, q) = ends
    if max(abs((u - x) * (q - y) - (v - y) * (p - x)) / length for u, v in points) > FLAT:
        return None
    return Segment(*ends)
