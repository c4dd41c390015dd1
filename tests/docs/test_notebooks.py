"""The notebooks: their code runs, and arrives at the answers that are kept in them."""

import ast
import importlib.util
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import stagecad
from tests.docs.scripts import script

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "notebooks"
PAGES = [*sorted(FOLDER.glob("*.ipynb")), FOLDER.parent / "diagnosis_step_by_step.ipynb"]


def _design(names: dict[str, Any]) -> None:
    margins = names["margins"]
    sag = "sag of the drive surface over the travel"
    assert margins["16 mm"][sag] > margins["12 mm"][sag] > margins["8 mm"][sag]


def _measurement(names: dict[str, Any]) -> None:
    # The two effects that the records of the demo hide.
    assert names["diagnosis"].effect == "stribeck" and names["again"].effect == "magnetic_cogging"
    assert names["second"].errors.loc[("after", "held out", "friction_force"), "over_noise"] < 1.2


def _law(names: dict[str, Any]) -> None:
    assert names["diagnosis"].effect == "eyring"
    assert min(names["rows"], key=lambda name: names["rows"][name]["BIC"]) == "Eyring alone"
    assert min(names["rows"], key=lambda name: names["rows"][name]["over noise"]) == "Eyring alone"
    parameters = names["found"].parameters
    for key, true in (("eyring.strength", 1.5), ("eyring.speed", 0.002)):
        assert parameters.loc[key, "low"] < true < parameters.loc[key, "high"]


def _compensation(names: dict[str, Any]) -> None:
    # What the simulated axis has beside Coulomb and viscous friction; its bristles are stiff.
    asked = {"stribeck", "magnetic_cogging"}
    assert asked <= set(names["established"]) <= asked | {"presliding"}
    assert abs(names["step"].parameters["value"]["magnetic_cogging.pitch"] - names["PITCH"]) < 1e-3 * names["PITCH"]
    # In a stiff loop the error is the force that is not fed forward over the stiffness: both fall by the same factor,
    # as far as the largest errors, those after a reversal, are slow against the loop.
    assert 0.5 < names["factor"] * names["share"] < 2.0
    assert names["factor"] > names["table"].loc["none", "rms [um]"] / names["table"].loc["mass", "rms [um]"]


KNOWN: dict[str, Callable[[dict[str, Any]], None]] = {
    "design_and_checks": _design,
    "measurement_to_model": _measurement,
    "compensation": _compensation,
    "new_friction_law": _law,
}


def test_every_notebook_has_its_answer_and_uses_public_names() -> None:
    assert {page.stem for page in FOLDER.glob("*.ipynb")} == set(KNOWN)
    document = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    for cell in _code_cells(document):
        assert not any(word.startswith("_") for word in "".join(cell["source"]).replace(".", " ").split())
    assert NOTEBOOK.stat().st_size < 200_000


@pytest.mark.parametrize("file", PAGES, ids=lambda file: file.stem)
def test_the_names_of_a_notebook_exist(file: Path) -> None:
    """The fast part of the test below: a name that is gone is found without running what takes half a minute."""
    code = ["".join(cell["source"]) for cell in _code_cells(json.loads(file.read_text(encoding="utf-8")))]
    tree = ast.parse("\n".join(code))
    used = [
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "stagecad"
    ]
    assert set(used) <= set(stagecad.__all__)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            module = importlib.import_module(node.module)
            assert [alias.name for alias in node.names if not hasattr(module, alias.name)] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", KNOWN)
def test_a_notebook_arrives_at_the_known_answer(name: str) -> None:
    module = script("run_notebook")
    file = FOLDER / f"{name}.ipynb"
    document = json.loads(file.read_text(encoding="utf-8"))
    code = [cell for cell in document["cells"] if cell["cell_type"] == "code"]
    assert sum(bool(cell["outputs"]) for cell in code) > len(code) // 2, f"run 'python docs/run_notebook.py {file}'"
    assert file.stat().st_size < 300_000
    KNOWN[name](module.run(document))


DOCS = Path(__file__).resolve().parents[2] / "docs"
NOTEBOOK = DOCS / "diagnosis_step_by_step.ipynb"


def _code_cells(document: dict[str, Any]) -> list[dict[str, Any]]:
    return [cell for cell in document["cells"] if cell["cell_type"] == "code"]


@pytest.mark.slow
def test_the_notebook_arrives_at_the_verdict_of_a_diagnosis() -> None:
    module = script("run_notebook")
    document = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    stored = [cell["outputs"] for cell in _code_cells(document)]
    assert all(stored)
    names = module.run(document)
    decision, found = names["decision"], names["found"]
    assert (decision.verdict, decision.best.public_name) == (found.verdict, found.effect)
    assert found.verdict == "missing-effect" and abs(decision.unexplained_share - found.unexplained_share) < 1e-6
    # The stored outputs of the decision and of the call are those of today.
    assert [cell["outputs"] for cell in _code_cells(document)][-2:] == stored[-2:]
