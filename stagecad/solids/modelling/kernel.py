"""Imports the CAD kernel without what no solid needs: about a second less in every run that makes one.

- OCP's bridge to VTK does `import vtk` merely to have VTK's types registered, and goes on without it. That one name
  loads some 150 modules, of which nothing here is used: pictures are drawn by this project itself. What cadquery needs
  of VTK it imports by name, and gets.
- cadquery's DXF files bring in the whole of ezdxf. The drawings use ezdxf themselves; cadquery's own reader and writer
  of DXF come in when somebody calls them.
- The bindings make a hundred thousand objects that stay: the garbage collector would walk over them again and again.
"""

from __future__ import annotations

import gc
import sys
import types
from importlib import import_module
from typing import Any

_DXF = {
    "cadquery.occ_impl.exporters.dxf": ("exportDXF", "DxfDocument"),
    "cadquery.occ_impl.importers.dxf": ("_importDXF",),
}
"""cadquery's modules that need ezdxf, and what its other modules take from them."""


def import_kernel() -> None:
    """Import cadquery, unless it is there already; a later `import vtk` still finds the real one."""
    if "cadquery" in sys.modules:
        return
    stand_ins = {name: _stand_in(name, wanted) for name, wanted in _DXF.items()}
    stand_ins["vtk"] = types.ModuleType("vtk")
    stand_ins = {name: module for name, module in stand_ins.items() if name not in sys.modules}
    collecting = gc.isenabled()
    sys.modules.update(stand_ins)
    gc.disable()
    try:
        import cadquery  # noqa: F401

        gc.freeze()
    finally:
        if collecting:
            gc.enable()
        for name in stand_ins:
            sys.modules.pop(name, None)


def _stand_in(module: str, names: tuple[str, ...]) -> types.ModuleType:
    """A module whose functions import the real one when they are called."""
    stand_in = types.ModuleType(module)
    for name in names:
        setattr(stand_in, name, _later(module, name))
    return stand_in


def _later(module: str, name: str) -> Any:
    def call(*arguments: Any, **options: Any) -> Any:
        return getattr(import_module(module), name)(*arguments, **options)

    return call
