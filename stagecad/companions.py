"""The program's other packages are those beside `stagecad`, whatever files of a user have the same names.

A folder with a `sim.py` or `drawings.py` stands before the installed packages on the path of a script or notebook that
runs there. This finder is asked before the path is searched.
"""

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path

COMPANIONS = ("designcalc", "drawings", "sim", "sysid", "workbench")
PLACE = str(Path(__file__).resolve().parents[1])
"""Folder in which `stagecad` stands."""


class CompanionFinder:
    """Finds the packages of the program where `stagecad` stands."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: object = None) -> ModuleSpec | None:
        """Specification of a package of the program; None for every other module."""
        return PathFinder.find_spec(name, [PLACE]) if name in COMPANIONS else None


def use_companions() -> None:
    """Let the packages of the program be found beside `stagecad`."""
    for name in COMPANIONS:
        file = getattr(sys.modules.get(name), "__file__", None)
        if file is not None and PLACE not in (str(folder) for folder in Path(file).resolve().parents):
            own = Path(PLACE, name, "__init__.py")
            raise ImportError(f"'{name}' was imported from {file}; stagecad needs {own}: import stagecad first")
    if CompanionFinder not in sys.meta_path:
        sys.meta_path.insert(0, CompanionFinder)  # pyright: ignore[reportArgumentType]
