"""The glossary names classes, functions and constants that exist in the files it gives."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
LINES = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").splitlines()
ENTRIES = [line for line in LINES if line.startswith("| ") and not line.startswith(("| term", "| ---"))]


def _missing(entry: str) -> list[str]:
    """Symbols of an entry that do not stand in the file that follows them."""
    names: list[str] = []
    missing: list[str] = []
    for token in re.findall(r"`([^`]+)`", entry.strip("| ").rsplit(" | ", 1)[1]):
        if not token.endswith(".py"):
            names.append(token)
            continue
        path = ROOT / token
        text = path.read_text(encoding="utf-8") if path.is_file() else ""
        symbols = (rf"^\s*(?:(?:def|class) )?{name}\b\s*[(:=,\[]" for name in names)
        missing += [f"{token}: no {name}" for name, s in zip(names, symbols) if not re.search(s, text, re.MULTILINE)]
        names = []
    return missing


def test_the_symbols_of_the_glossary_exist() -> None:
    assert len(ENTRIES) > 50
    missing = [line for entry in ENTRIES for line in _missing(entry)]
    assert not missing, "\n".join(missing)
