"""Common volume and least distance of two solids, measured in the coordinates of the first.

The result depends on the two solids and on the position of the second relative to the first alone, so that it can be
kept while the pair moves together.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from stagecad.solids.modelling.frame import Frame, dot, subtract

if TYPE_CHECKING:
    import cadquery as cq

DIGITS = 9
"""Digits after the point to which a relative position is rounded, mm; its directions have three more."""


def relative_frame(one: Frame, two: Frame) -> Frame:
    """Frame from the coordinates of the second part to those of the first, R_1^T (R_2 x + t_2 - t_1), to `DIGITS`."""
    columns = list(zip(*one.rotation, strict=True))
    others = list(zip(*two.rotation, strict=True))
    apart = subtract(two.shift, one.shift)
    rows = [[round(dot(a, b), DIGITS + 3) + 0.0 for b in others] for a in columns]
    x, y, z = (round(dot(a, apart), DIGITS) + 0.0 for a in columns)
    r1, r2, r3 = ((a, b, c) for a, b, c in rows)
    return Frame((r1, r2, r3), (x, y, z))


def common_volume(one: cq.Shape, two: cq.Shape, frame: Frame) -> float:
    """Common volume of two solids, mm^3."""
    return common_volumes(one, [(two, frame)])[0]


def common_volumes(one: cq.Shape, others: Sequence[tuple[cq.Shape, Frame]]) -> list[float]:
    """Common volumes of a solid and each of several others, mm^3.

    Others whose bounding boxes are apart are intersected with the solid in one operation, since its time grows with the
    number of faces of the solid. A solid of the result belongs to the other whose box contains its centre of mass.
    Several operations are made with the piece of the solid within the box of all others.
    """
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
    from OCP.TopAbs import TopAbs_SOLID

    placed = [_placed(other, frame) for other, frame in others]
    boxes = [_box(shape) for shape in placed]
    groups = _apart(boxes)
    solid = _piece_near(one.wrapped, boxes) if len(groups) > 1 else one.wrapped
    volumes = [0.0] * len(others)
    for group in groups:
        common = BRepAlgoAPI_Common(solid, _compound(placed[number] for number in group)).Shape()
        for piece in _explored(common, TopAbs_SOLID):
            volume, centre = _volume(piece)
            number = next((n for n in group if not boxes[n].IsOut(centre)), group[0])
            volumes[number] += volume
    return volumes


def _apart(boxes: Sequence[Any]) -> list[list[int]]:
    """Indices of boxes in groups, in each of which no two boxes touch."""
    groups: list[list[int]] = []
    for number, box in enumerate(boxes):
        free = (group for group in groups if all(boxes[other].IsOut(box) for other in group))
        group = next(free, None)
        if group is None:
            groups.append(group := [])
        group.append(number)
    return groups


def _volume(solid: Any) -> tuple[float, Any]:
    """Volume of a solid and its centre of mass."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(solid, properties)
    return abs(properties.Mass()), properties.CentreOfMass()


MARGIN = 0.37
"""Distance by which the piece exceeds the box of the others, mm; hardly a dimension of a part ends there."""


def _piece_near(solid: Any, boxes: Sequence[Any]) -> Any:
    """The piece of a solid within the bounding box of several boxes, or the solid where that would save little.

    It has the same common volumes with what the boxes contain, and fewer faces: each face that is not cut is
    classified as inside or outside the other solid.
    """
    from OCP.Bnd import Bnd_Box
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

    reach = Bnd_Box()
    for box in boxes:
        reach.Add(box)
    reach.Enlarge(MARGIN)
    faces = [_box(face) for face in _faces(solid)]
    if 2 * sum(not reach.IsOut(face) for face in faces) > len(faces):
        return solid
    block = BRepPrimAPI_MakeBox(reach.CornerMin(), reach.CornerMax()).Shape()
    return BRepAlgoAPI_Common(solid, block).Shape()


def least_distance(one: cq.Shape, two: cq.Shape, frame: Frame, gap: float) -> float | None:
    """Least distance of two solids without a common volume, mm; None if the kernel fails.

    Only the faces of each within `gap` of the bounding box of the other are compared: exact up to `gap`; above it, the
    result is larger than `gap`.
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
    reach = _box(other)
    reach.Enlarge(gap)
    near = [face for face in _faces(shape) if not reach.IsOut(_box(face))]
    return _compound(near) if near else shape


def _compound(shapes: Iterable[Any]) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    compound, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(compound)
    for shape in shapes:
        builder.Add(compound, shape)
    return compound


def _faces(shape: Any) -> Iterator[Any]:
    from OCP.TopAbs import TopAbs_FACE

    return _explored(shape, TopAbs_FACE)


def _explored(shape: Any, kind: Any) -> Iterator[Any]:
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def _box(shape: Any) -> Any:
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    return box
