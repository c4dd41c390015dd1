"""The CAD kernel: `cq` is cadquery, `occ` has the names of the kernel's bindings; both are imported when first used.

And parts, compounds, places and boxes of the kernel's shapes (`Shape.wrapped` of cadquery).
"""

from __future__ import annotations

import mmap
import sys
from collections.abc import Iterable, Iterator
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from stagecad.deferred import DeferredModule
from stagecad.parameters.errors import InputError
from stagecad.solids.modelling.frame import Frame

if TYPE_CHECKING:
    import cadquery as cq
else:
    cq = DeferredModule("cadquery")


class Bindings:
    """The names of the kernel's bindings: `gp_Pnt` is that of the module `OCP.gp`. They are compiled, without types."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        value = getattr(import_module(f"OCP.{name.partition('_')[0]}"), name)
        setattr(self, name, value)
        return value


occ: Any = Bindings()
KernelShape = Any
"""A shape of the kernel: `Shape.wrapped` of cadquery."""
ADDRESS_SPACE = 900
"""Of the kernel's libraries (760) and of the solids of a part, MB: with less they wait for a lock and never end."""


def load_kernel() -> None:
    """Import cadquery without the 150 modules of VTK for windows and rendering, which take a third of the time.

    The kernel's bindings import the package `vtk` only to have it loaded; cadquery imports the modules of VTK that it
    calls (`vtkmodules`) by itself. An empty module stands for the package meanwhile; `import vtk` afterwards gives the
    real one. For processes of this program alone, since another thread could see the empty module.
    """
    if "vtk" in sys.modules or "cadquery" in sys.modules:
        return
    try:
        mmap.mmap(-1, ADDRESS_SPACE * 1_000_000, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, mmap.PROT_READ).close()
    except OSError:
        raise InputError(
            f"there is not enough memory: the CAD kernel takes {ADDRESS_SPACE} MB of addresses (ulimit -v)"
        ) from None
    sys.modules["vtk"] = ModuleType("vtk")
    try:
        import_module("cadquery")
    finally:
        del sys.modules["vtk"]


def unlocated(solid: cq.Solid) -> cq.Solid:
    """The same solid with its placement in its geometry: the writer of product information finds no faces of a placed
    one."""
    place = solid.wrapped.Location()
    if place.IsIdentity():
        return solid
    bare = solid.wrapped.Located(occ.TopLoc_Location())
    return cq.Solid(occ.BRepBuilderAPI_Transform(bare, place.Transformation(), True).Shape())


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
    move.SetValues(*[value for row, shift in zip(frame.rotation, frame.shift, strict=True) for value in (*row, shift)])
    return move


def moved(shape: Any, frame: Frame) -> Any:
    """A shape placed by a frame."""
    return shape.Moved(occ.TopLoc_Location(transformation(frame)))


def box_of(shape: Any) -> Any:
    """Bounding box of a shape, without that of its triangles."""
    box = occ.Bnd_Box()
    occ.BRepBndLib.Add_s(shape, box, False)
    return box
