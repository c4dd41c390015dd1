"""Parts of a user's own for the tests: files in `tests/drawings/parts`, and the template with changes."""

from pathlib import Path
from typing import Any

from workbench.operations.design import Design
from workbench.operations.drawings import draw_part as draw
from workbench.operations.templates import template

PARTS = Path(__file__).with_name("parts")
SLOT = '.faces(">Z").workplane().center(0, 10).slot2D(20, 5).cutBlind(-3)'
BLIND = 'return plate.faces(">Z").workplane(origin=(0, 0, 0)).pushPoints([(-p.hole_spacing / 2, 0)]).hole(p.hole, 3.0)'
ONE_HOLE = [("return plate", "plate = plate"), ("(-p.hole_spacing / 2, 0), ", "")]
CHANGED = {
    "undef": [(".hole(p.hole)\n", f".hole(p.hole){SLOT}\n")],
    "three": [*ONE_HOLE, (".hole(p.hole)\n", f".hole(p.hole)\n    {BLIND}\n"), ("count=2", "count=3")],
}
"""Changes of the template: a slot that no dimension gives; a through hole and a blind one that are stated as three."""


def draw_part(folder: Path, name: str, *changes: tuple[str, str]) -> dict[str, Any]:
    """Draw the part of a file, its text changed first; its document."""
    text = template("part", name) if name in CHANGED else (PARTS / f"{name}.py").read_text("utf-8")
    for before, after in (*CHANGED.get(name, ()), *changes):
        assert before in text
        text = text.replace(before, after)
    path = folder / "source" / f"{name}.py"
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, "utf-8")
    return draw(path, folder, Design(), trust=True)


def hits_of(folder: Path, name: str, *changes: tuple[str, str]) -> list[str]:
    return [hit for sheet in draw_part(folder, name, *changes)["sheets"] for hit in sheet["hits"]]
