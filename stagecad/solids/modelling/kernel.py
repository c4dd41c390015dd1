"""Loading of the CAD kernel."""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType


def load_kernel() -> None:
    """Import cadquery without the 150 modules of VTK for windows and rendering, which take a third of the time.

    The kernel's bindings import the package `vtk` only to have it loaded; cadquery imports the modules of VTK that it
    calls (`vtkmodules`) by itself. An empty module stands for the package meanwhile; `import vtk` afterwards gives the
    real one. For processes of this program alone, since another thread could see the empty module.
    """
    if "vtk" in sys.modules:
        return
    sys.modules["vtk"] = ModuleType("vtk")
    try:
        import_module("cadquery")
    finally:
        del sys.modules["vtk"]
