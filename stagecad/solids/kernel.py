"""Imports the CAD kernel without the whole of VTK: half a second less in every run that makes a solid.

OCP's bridge to VTK does `import vtk` merely to have VTK's types registered, and goes on without it. That one name loads
some 150 modules, of which nothing here is used: pictures are drawn by this project itself. What cadquery needs of VTK
it imports by name, and gets.
"""

from __future__ import annotations

import sys
import types


def import_kernel() -> None:
    """Import cadquery, unless it is there already; a later `import vtk` still finds the real one."""
    if "cadquery" in sys.modules:
        return
    stand_in = "vtk" not in sys.modules
    if stand_in:
        sys.modules["vtk"] = types.ModuleType("vtk")
    try:
        import cadquery  # noqa: F401
    finally:
        if stand_in:
            sys.modules.pop("vtk", None)
