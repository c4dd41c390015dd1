"""Parts, compounds, places and boxes of the kernel's shapes (`Shape.wrapped` of cadquery)."""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from stagecad.solids.modelling.frame import Frame


def parts_of(shape: Any, kind: str) -> Iterator[Any]:
    """Each `Solid`, `Face`, `Wire` or `Edge` of a shape in the order of the kernel, as often as it occurs."""
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    explorer = TopExp_Explorer(shape, getattr(TopAbs_ShapeEnum, f"TopAbs_{kind.upper()}"))
    while explorer.More():
        yield getattr(TopoDS, f"{kind}_s")(explorer.Current())
        explorer.Next()


def compound_of(shapes: Iterable[Any]) -> Any:
    """A compound of shapes."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    compound, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(compound)
    for shape in shapes:
        builder.Add(compound, shape)
    return compound


def transformation(frame: Frame) -> Any:
    """The rigid transformation as the kernel's ``gp_Trsf``."""
    from OCP.gp import gp_Trsf

    move = gp_Trsf()
    rows = [value for row, shift in zip(frame.rotation, frame.shift, strict=True) for value in (*row, shift)]
    move.SetValues(*rows)
    return move


def moved(shape: Any, frame: Frame) -> Any:
    """A shape placed by a frame."""
    from OCP.TopLoc import TopLoc_Location

    return shape.Moved(TopLoc_Location(transformation(frame)))


def box_of(shape: Any) -> Any:
    """Bounding box of a shape, without that of its triangles."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    return box
