"""Parts of a user's own for the tests, from the files in `tests/drawings/parts`."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

from tests.drawings.drawn import thesis
from workbench.machine.own_part import OwnPart, draw_part, own_design

PARTS = Path(__file__).with_name("parts")


def own_part(name: str, *changes: tuple[str, str]) -> OwnPart:
    """The part of a file, its text changed first."""
    path = PARTS / f"{name}.py"
    text = path.read_text("utf-8")
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    module: Any = ModuleType(name)
    exec(compile(text, str(path), "exec"), vars(module))
    return OwnPart(path, module, own_design(thesis(), module.NAME, module.PARAMETERS, path))


def hits_of(part: OwnPart, folder: Path) -> list[str]:
    """What lint and the check of definition say of a part."""
    return [hit for sheet in draw_part(part, folder)["sheets"] for hit in sheet["hits"]]
