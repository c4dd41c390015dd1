"""Common volume and least distance of two solids, measured in the coordinates of the first.

The result depends on the two solids and on the position of the second relative to the first alone, so that it can be
kept while the pair moves together.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from stagecad.solids.modelling.frame import Frame, dot, subtract

if TYPE_CHECKING:
    import cadquery as cq

DIGITS = 9
"""Digits after the point to which a relative position is rounded, mm; its directions have three more."""


def relative_frame(one: Frame, two: Frame) -> Frame:
    """Frame from the coordinates of the second part to those of the first, R_1^T (R_2 x + t_2 - t_1).

    It is rounded to `DIGITS`, so that two positions that differ by rounding errors are one.
    """
    columns = list(zip(*one.rotation, strict=True))
    others = list(zip(*two.rotation, strict=True))
    apart = subtract(two.shift, one.shift)
    rows = [[round(dot(a, b), DIGITS + 3) + 0.0 for b in others] for a in columns]
    x, y, z = (round(dot(a, apart), DIGITS) + 0.0 for a in columns)
    r1, r2, r3 = ((a, b, c) for a, b, c in rows)
    return Frame((r1, r2, r3), (x, y, z))


def common_volume(one: cq.Shape, two: cq.Shape, frame: Frame) -> float:
    """Common volume of two solids, mm^3.

    Args:
        one, two: the solids.
        frame: of the second in the coordinates of the first.
    """
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    common = BRepAlgoAPI_Common(one.wrapped, _placed(two, frame))
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(common.Shape(), properties)
    return abs(properties.Mass())


MARGIN = 0.37
"""Distance by which the piece exceeds the box of the others, mm; hardly a dimension of a part ends there."""


def piece_near(one: cq.Shape, others: Sequence[tuple[cq.Shape, Frame]]) -> cq.Shape:
    """The piece of a solid within the bounding box of several others: it has the same common volumes with them.

    The time of a common volume grows with the number of faces, since each that is not cut is classified as inside or
    outside the other solid. The solid itself is returned where the piece would save little.

    Args:
        one: the solid.
        others: with their places in its coordinates.
    """
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

    if len(others) < 2:
        return one
    reach, *more = (_box(_placed(other, frame)) for other, frame in others)
    for box in more:
        reach.Add(box)
    reach.Enlarge(MARGIN)
    boxes = [_box(face) for face in _faces(one.wrapped)]
    if 2 * sum(not reach.IsOut(box) for box in boxes) > len(boxes):
        return one
    block = BRepPrimAPI_MakeBox(reach.CornerMin(), reach.CornerMax()).Shape()
    return type(one).cast(BRepAlgoAPI_Common(one.wrapped, block).Shape())


def least_distance(one: cq.Shape, two: cq.Shape, frame: Frame, gap: float) -> float | None:
    """Least distance of two solids without a common volume, mm; None if the kernel fails.

    Only the faces of each within `gap` of the bounding box of the other are compared: exact up to `gap`; above it, the
    result is larger than `gap`.

    Args:
        one, two: the solids.
        frame: of the second in the coordinates of the first.
        gap: mm.
    """
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape

    first, second = one.wrapped, _placed(two, frame)
    distance = BRepExtrema_DistShapeShape(_faces_near(first, second, gap), _faces_near(second, first, gap))
    return float(distance.Value()) if distance.IsDone() else None


def _placed(solid: cq.Shape, frame: Frame) -> Any:
    from OCP.TopLoc import TopLoc_Location

    from stagecad.solids.export.step_stl_glb import transformation

    return solid.wrapped.Moved(TopLoc_Location(transformation(frame)))


def _faces_near(shape: Any, other: Any, gap: float) -> Any:
    """The faces of a shape whose bounding boxes are within a gap of that of another, as a compound; all where none
    is."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    reach = _box(other)
    reach.Enlarge(gap)
    near = [face for face in _faces(shape) if not reach.IsOut(_box(face))]
    if not near:
        return shape
    compound, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(compound)
    for face in near:
        builder.Add(compound, face)
    return compound


def _faces(shape: Any) -> Iterator[Any]:
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def _box(shape: Any) -> Any:
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    return box
