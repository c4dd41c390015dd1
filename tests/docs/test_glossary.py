"""The glossary names classes, functions and constants that exist in the files it gives."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LINES = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").splitlines()
ENTRIES = [line for line in LINES if line.startswith("| ") and not line.startswith(("| term", "| ---"))]


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.split("|")[1].strip())
def test_the_symbols_of_an_entry_exist(entry: str) -> None:
    names: list[str] = []
    for token in re.findall(r"`([^`]+)`", entry.strip("| ").rsplit(" | ", 1)[1]):
        if not token.endswith(".py"):
            names.append(token)
            continue
        text = (ROOT / token).read_text(encoding="utf-8")
        for name in names:
            assert re.search(rf"^\s*(?:(?:def|class) )?{name}\b\s*[(:=,\[]", text, re.MULTILINE), f"{token}: no {name}"
        names = []


def test_the_glossary_has_entries() -> None:
    assert len(ENTRIES) > 50
