"""The page of the thesis names every figure and table, and only commands that exist."""

import re
from pathlib import Path

from workbench.cli.dispatch import COMMANDS

PAGE = (Path(__file__).parents[2] / "docs" / "thesis.md").read_text(encoding="utf-8")


def _numbers(heading: str) -> set[int]:
    """First column of the table of a section; `35 to 37` is three numbers."""
    rows = PAGE.split(f"## {heading}\n")[1].split("\n## ")[0].splitlines()[3:]
    found: set[int] = set()
    for row in rows:
        first = row.split("|")[1] if row.startswith("|") else ""
        for low, high in re.findall(r"(\d+)(?: to (\d+))?", first):
            found |= set(range(int(low), int(high or low) + 1))
    return found


def test_every_figure_and_table_is_listed() -> None:
    assert _numbers("Figures") == set(range(1, 43))
    assert _numbers("Tables") == {1, 2, 3}


def test_the_commands_exist() -> None:
    commands = set(re.findall(r"`stagecad ([a-z]+)", PAGE))
    assert commands and commands <= set(COMMANDS)
