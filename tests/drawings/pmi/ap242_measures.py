"""What a dimension that was read back from a STEP file measures on the faces it is attached to."""

import math

import cadquery as cq
from ap242_file import ReadDimension
from OCP.BRepAdaptor import (  # pyright: ignore[reportMissingImports]
    BRepAdaptor_Curve,  # pyright: ignore[reportAttributeAccessIssue]
    BRepAdaptor_Surface,  # pyright: ignore[reportAttributeAccessIssue]
)

from stagecad.parameters.dimension import Dimension, Point


def measured(there: ReadDimension, dimension: Dimension) -> float:
    """Value of a dimension on the faces that the file gives it, mm or degrees."""
    along = dimension.direction
    match there.kind:
        case "Size_Diameter":
            radii = [radius_of(face, dimension.points[0]) for face in there.first]
            assert max(radii) - min(radii) < 1e-6
            return 2 * radii[0]
        case "Size_Radius" | "Size_SphericalRadius" | "Size_ToroidalMinorRadius":
            radii = [radius_of(face, dimension.points[0]) for face in there.first]
            assert max(radii) - min(radii) < 1e-6
            return radii[0]
        case "Location_Angular" if dimension.kind == "slope":
            sine = abs(dot(BRepAdaptor_Surface(there.first[0].wrapped).Plane().Axis().Direction(), along))
            return sine / math.sqrt(1 - sine**2)
        case "Location_Angular":
            step = [b - a for a, b in zip(centre(there.first[0]), centre(there.second[0]), strict=True)]
            return math.degrees(math.acos((step[0] * along[0] + step[1] * along[1]) / math.hypot(step[0], step[1])))
        case _:
            middle = ("dimensional note", "from the middle of the two faces") in there.texts
            assert len({round(level(s, along, dimension.points[0]), 6) for s in there.first}) == 1 or middle
            start = sum(level(s, along, dimension.points[0]) for s in there.first) / len(there.first)
            ends = [level(s, along, dimension.points[-1]) for s in there.second]
            if there.kind.startswith("Location_LinearDistance_From"):
                sides = there.kind.removeprefix("Location_LinearDistance_From").split("To")
                return between_sides(there, sides, start, ends[0])
            assert max(ends) - min(ends) < 1e-6
            return abs(ends[0] - start)


def between_sides(there: ReadDimension, sides: list[str], start: float, end: float) -> float:
    """The nearest sides of two round faces are apart as far as they can be least, the outer ones most."""
    places = [
        [middle] if name == "Center" else [middle - radius_of(shape, None), middle + radius_of(shape, None)]
        for shape, name, middle in zip((there.first[0], there.second[0]), sides, (start, end), strict=True)
    ]
    assert set(sides) - {"Center"} in ({"Inner"}, {"Outer"})
    apart = [abs(a - b) for a in places[0] for b in places[1]]
    return min(apart) if "Inner" in sides else max(apart)


def level(shape: cq.Shape, along: Point, near: Point) -> float:
    """Coordinate along a direction of a flat face (where the line through `near` meets it), an axis, a centre."""
    kind = shape.geomType()
    if kind == "PLANE":
        plane = BRepAdaptor_Surface(shape.wrapped).Plane()
        normal, origin = plane.Axis().Direction(), plane.Location()
        normals, at = (normal.X(), normal.Y(), normal.Z()), (origin.X(), origin.Y(), origin.Z())
        behind = sum(n * (o - p) for n, o, p in zip(normals, at, near, strict=True))
        return sum(a * b for a, b in zip(near, along, strict=True)) + behind / dot(normal, along)
    if kind == "LINE":
        return sum(a * b for a, b in zip(shape.Vertices()[0].toTuple(), along, strict=True))
    return sum(a * b for a, b in zip(centre(shape), along, strict=True))


def centre(shape: cq.Shape) -> Point:
    match shape.geomType():
        case "CYLINDER":
            at = BRepAdaptor_Surface(shape.wrapped).Cylinder().Location()
        case "CONE":
            at = BRepAdaptor_Surface(shape.wrapped).Cone().Location()
        case "SPHERE":
            at = BRepAdaptor_Surface(shape.wrapped).Sphere().Location()
        case "CIRCLE":
            at = BRepAdaptor_Curve(shape.wrapped).Circle().Location()
        case kind:
            raise AssertionError(f"nothing round: {kind}")
    return (at.X(), at.Y(), at.Z())


def radius_of(shape: cq.Shape, at: Point | None) -> float:
    surface = BRepAdaptor_Surface(shape.wrapped)
    match shape.geomType():
        case "CYLINDER":
            return surface.Cylinder().Radius()
        case "SPHERE":
            return surface.Sphere().Radius()
        case "TORUS":
            return surface.Torus().MinorRadius()
        case "CONE":
            assert at is not None
            cone = surface.Cone()
            apex, axis = cone.Apex(), cone.Axis().Direction()
            along, top = (axis.X(), axis.Y(), axis.Z()), (apex.X(), apex.Y(), apex.Z())
            height = sum(a * (p - q) for a, p, q in zip(along, at, top, strict=True))
            return abs(height * math.tan(cone.SemiAngle()))
        case kind:
            raise AssertionError(f"nothing round: {kind}")


def off_axis(shape: cq.Shape, point: Point) -> float:
    from OCP.gp import gp_Lin, gp_Pnt  # pyright: ignore[reportMissingImports, reportAttributeAccessIssue]

    return gp_Lin(BRepAdaptor_Surface(shape.wrapped).Cylinder().Axis()).Distance(gp_Pnt(*point))


def dot(direction, along: Point) -> float:
    return direction.X() * along[0] + direction.Y() * along[1] + direction.Z() * along[2]
