"""The notebook on one diagnosis: its code runs, and arrives at the verdict of the command."""

import importlib.util
import json
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
NOTEBOOK = DOCS / "diagnosis_step_by_step.ipynb"


def _code_cells(document: dict[str, Any]) -> list[dict[str, Any]]:
    return [cell for cell in document["cells"] if cell["cell_type"] == "code"]


@pytest.mark.slow
def test_the_notebook_arrives_at_the_verdict_of_a_diagnosis() -> None:
    spec = importlib.util.spec_from_file_location("run_notebook", DOCS / "run_notebook.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    document = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    stored = [cell["outputs"] for cell in _code_cells(document)]
    assert all(stored)
    names = module.run(document)
    decision, found = names["decision"], names["found"]
    assert (decision.verdict, decision.best.public_name) == (found.verdict, found.effect)
    assert found.verdict == "missing-effect"
    assert abs(decision.unexplained_share - found.unexplained_share) < 1e-6
    # The stored outputs of the decision and of the call are those of today.
    assert [cell["outputs"] for cell in _code_cells(document)][-2:] == stored[-2:]


def test_the_notebook_uses_public_names_and_small_figures() -> None:
    document = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    for cell in _code_cells(document):
        assert not any(word.startswith("_") for word in "".join(cell["source"]).replace(".", " ").split())
    assert NOTEBOOK.stat().st_size < 200_000
