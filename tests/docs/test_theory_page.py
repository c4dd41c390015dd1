"""The theory page lists the constants of a diagnosis with their values in the code."""

import importlib.util
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_constants_are_those_of_the_code() -> None:
    spec = importlib.util.spec_from_file_location("make_thresholds", DOCS / "make_thresholds.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    text = (DOCS / "theory.md").read_text(encoding="utf-8")
    assert text.count("| `CERTAIN_Z` |") == 1
    assert module.with_thresholds(text) == text, "constants have changed: run 'python docs/make_thresholds.py'"
