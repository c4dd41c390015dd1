"""Write the table of the constants of a diagnosis in theory.md from the modules: python docs/make_thresholds.py."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

from stagecad.parameters.atomic import atomic_write_text
from sysid import signals
from sysid.diagnosis import candidate, constants
from sysid.estimation import misfit

PAGE = Path(__file__).parent / "theory.md"
TABLE = re.compile(r"(<!-- constants: .*? -->\n).*?(<!-- end of constants -->)", re.DOTALL)
OTHERS = ((candidate, "TIE"), (signals, "KEPT"), (misfit, "LOSS_CORNER"))
"""Constants of ties and of the measure of misfit, with their modules."""


def with_thresholds(text: str) -> str:
    """The page with the values and docstrings of the constants as they are now."""
    head = "| constant | value | meaning |\n| --- | --- | --- |\n"
    others = (row for module, name in OTHERS for row in _documented(module) if row[0] == name)
    rows = [*_documented(constants), *others]
    lines = [f"| `{name}` | {value:g} | {meaning} |\n" for name, value, meaning in rows]
    return TABLE.sub(lambda found: found[1] + head + "".join(lines) + found[2], text)


def _documented(module: ModuleType) -> Iterator[tuple[str, float, str]]:
    """Name, value and docstring of each numeric constant of a module; one docstring serves the constants above it."""
    assert module.__file__ is not None
    names: list[str] = []
    for node in ast.parse(Path(module.__file__).read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            names.append(node.targets[0].id)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and names:
            meaning = " ".join(str(node.value.value).split())
            numbers = [name for name in names if isinstance(getattr(module, name), int | float)]
            yield from ((name, float(getattr(module, name)), meaning) for name in numbers)
            names = []
        else:
            names = []


if __name__ == "__main__":
    atomic_write_text(PAGE, with_thresholds(PAGE.read_text(encoding="utf-8")))
