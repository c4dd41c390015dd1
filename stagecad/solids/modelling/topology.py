"""Parts, compounds, places and boxes of the kernel's shapes (`Shape.wrapped` of cadquery)."""

from collections.abc import Iterable, Iterator
from typing import Any

from stagecad.solids.modelling.frame import Frame
from stagecad.solids.modelling.kernel import occ


def parts_of(shape: Any, kind: str) -> Iterator[Any]:
    """Each `Solid`, `Face`, `Wire` or `Edge` of a shape in the order of the kernel, as often as it occurs."""
    explorer = occ.TopExp_Explorer(shape, getattr(occ.TopAbs_ShapeEnum, f"TopAbs_{kind.upper()}"))
    while explorer.More():
        yield getattr(occ.TopoDS, f"{kind}_s")(explorer.Current())
        explorer.Next()


def compound_of(shapes: Iterable[Any]) -> Any:
    """A compound of shapes."""
    compound, builder = occ.TopoDS_Compound(), occ.BRep_Builder()
    builder.MakeCompound(compound)
    for shape in shapes:
        builder.Add(compound, shape)
    return compound


def transformation(frame: Frame) -> Any:
    """The rigid transformation as the kernel's ``gp_Trsf``."""
    move = occ.gp_Trsf()
    rows = [value for row, shift in zip(frame.rotation, frame.shift, strict=True) for value in (*row, shift)]
    move.SetValues(*rows)
    return move


def moved(shape: Any, frame: Frame) -> Any:
    """A shape placed by a frame."""
    return shape.Moved(occ.TopLoc_Location(transformation(frame)))


def box_of(shape: Any) -> Any:
    """Bounding box of a shape, without that of its triangles."""
    box = occ.Bnd_Box()
    occ.BRepBndLib.Add_s(shape, box, False)
    return box
