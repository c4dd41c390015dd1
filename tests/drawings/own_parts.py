"""Parts of a user's own for the tests, from the files in `tests/drawings/parts`."""

from pathlib import Path
from typing import Any

from workbench.operations.design import Design
from workbench.operations.drawings import draw_part as draw

PARTS = Path(__file__).with_name("parts")


def draw_part(folder: Path, name: str, *changes: tuple[str, str]) -> dict[str, Any]:
    """Draw the part of a file, its text changed first; its document."""
    text = (PARTS / f"{name}.py").read_text("utf-8")
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    path = folder / "source" / f"{name}.py"
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, "utf-8")
    return draw(path, folder, Design(), trust=True)


def hits_of(folder: Path, name: str, *changes: tuple[str, str]) -> list[str]:
    """What lint and the check of definition say of a part."""
    return [hit for sheet in draw_part(folder, name, *changes)["sheets"] for hit in sheet["hits"]]
