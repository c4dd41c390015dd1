"""The documents of the page are those of the commands and of the Python interface, for the same input."""

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from served_page import client_of, result_of
from starlette.testclient import TestClient

import stagecad
from stagecad.parameters.file import packaged_text
from tests.experiments import thin
from tests.sysid.slide import SIGN, VELOCITY, slide
from workbench.cli import run

FORCE = SIGN * (1.3 + 0.6 * np.exp(-((VELOCITY / 0.004) ** 2))) + 20.0 * VELOCITY
PASSING = {"seconds"}
"""What differs from run to run."""
FILES = {"file", "kept"}
"""Paths: the page has its folder as a whole path, the command as it was given."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("project")
    slide(made / "rig", FORCE, "coulomb", held_out=True)
    thin(made / "rig", 4)
    return made


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[TestClient]:
    with client_of(folder) as made:
        yield made


def _command(folder: Path, *words: str) -> Any:
    """The document of `--json`, of a command that runs in the folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert run([*words, "--json", "found.json"]) in (0, 1)
    return json.loads((folder / "found.json").read_text("utf-8"))


def _compared(one: Any, other: Any, where: str = "") -> None:
    """Equal, but for what differs from run to run; numbers to the last digits, in which sums of threads may differ."""
    if isinstance(one, dict) and isinstance(other, dict):
        assert one.keys() == other.keys(), where
        for key in one.keys() - PASSING:
            if key in FILES:
                assert Path(one[key]).name == Path(other[key]).name, where
            else:
                _compared(one[key], other[key], f"{where}.{key}")
    elif isinstance(one, list) and isinstance(other, list):
        assert len(one) == len(other), where
        for k, (a, b) in enumerate(zip(one, other, strict=True)):
            _compared(a, b, f"{where}[{k}]")
    elif isinstance(one, float) and isinstance(other, float):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-300), where
    else:
        assert one == other, where


def test_comparison_diagnosis_addition_and_ladder(client: TestClient, folder: Path, tmp_path: Path) -> None:
    """Protects that page, command and Python interface give one document of each step of the loop."""
    shutil.copytree(folder / "rig", tmp_path / "rig")
    compared = result_of(client, "/api/experiment/rig/compare")[1]["document"]
    _compared(compared, _command(tmp_path, "compare", "rig", "--no-figures"))
    _compared(compared, stagecad.compare(tmp_path / "rig").to_json())
    diagnosed = result_of(client, "/api/experiment/rig/diagnose", all_effects=False)[1]["document"]
    _compared(diagnosed, _command(tmp_path, "diagnose", "rig", "--no-figures"))
    added = result_of(client, "/api/experiment/rig/add", effects=["viscous"], drop=[])[1]["document"]
    _compared(added, _command(tmp_path, "add", "rig", "viscous"))
    rungs = client.get("/api/experiment/rig/ladder").json()["rungs"]
    _compared(rungs, _command(tmp_path, "ladder", "rig", "--no-figures"))
    _compared(rungs, stagecad.ladder(tmp_path / "rig").to_json())
    undone = result_of(client, "/api/experiment/rig/undo")[1]["document"]
    _compared(undone, _command(tmp_path, "add", "rig", "--undo"))
    every = result_of(client, "/api/experiment/rig/add", every=True)[1]["document"]
    assert every["verdict"] == diagnosed["verdict"] and every["ledger"]
    _compared(every, _command(tmp_path, "add", "rig", "--all"))


@pytest.mark.slow
def test_suggested_motions(client: TestClient, folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder / "rig", tmp_path / "rig")
    found = result_of(client, "/api/experiment/rig/suggest")[1]["document"]
    document = _command(tmp_path, "suggest", "rig", "--out", "build")
    _compared(found, document)
    rates = [motion["deviations_squared_per_second"] for motion in document[:-1]]
    assert rates == sorted(rates, reverse=True) and document[-1]["motion"] == "space-filling"
    assert document[0]["motion"] in (tmp_path / "build" / "rig" / "report.html").read_text("utf-8")
    table = pd.read_csv(tmp_path / document[0]["file"])
    assert table["time [s]"].iloc[-1] == pytest.approx(document[0]["seconds"], rel=1e-3)
    assert all((folder / "build" / "rig" / "suggest" / Path(row["file"]).name).is_file() for row in found)


@pytest.mark.slow
def test_optimisation(client: TestClient, folder: Path) -> None:
    """Only the thickness is free, and a rule is violated, so that no solids are required."""
    text = re.sub(r',\s*free = "[^"]*"', "", packaged_text())
    (folder / "one_free.toml").write_text(text, "utf-8")
    free, keep = {"stage.thickness": "6 mm:30 mm"}, ["sag of the drive surface over the travel"]
    client.post("/api/machine/open", json={"name": "one_free.toml"})
    assert client.get("/api/machine/optimize").json() == {}
    client.post("/api/machine/commit", json={"changes": {"stage.thickness": "6.1 mm"}})
    found = result_of(client, "/api/machine/optimize", free=free, keep=keep, budget=30)[1]
    assert found["document"]["feasible"] and found["document"]["verified"]
    assert [row["key"] for row in found["document"]["changes"]] == list(found["changes"]) == ["stage.thickness"]
    words = ["--set", "stage.thickness=6.1 mm", "--free", "stage.thickness=6 mm:30 mm", "--keep", *keep]
    document = _command(folder, "optimize", "--params", "one_free.toml", *words, "--budget", "30", "--no-figures")
    _compared(found["document"], document)
    client.post("/api/machine/open", json={"name": None})


@pytest.mark.slow
def test_parts_and_drawings(client: TestClient, folder: Path) -> None:
    solids = result_of(client, "/api/machine/solids")[1]
    document = _command(folder, "parts")
    whole = document["parts"].pop("assembly")
    assert solids["parts"].keys() == document["parts"].keys()
    for name, part in document["parts"].items():
        files = part.pop("files")
        assert f"{name}.glb" in {Path(file).name for file in files}
        _compared({key: solids["parts"][name][key] for key in part}, part, name)
    _compared(solids["moving_body"], document["moving_body"])
    count = sum(solids["parts"][one["part"]]["mass"]["value"] for one in solids["instances"])
    assert count == pytest.approx(whole["mass"]["value"], rel=1e-9)
    drawn = result_of(client, "/api/machine/drawings/tip")[1]["sheets"]
    sheets = _command(folder, "drawings", "tip")["sheets"]
    assert [one["name"] for one in drawn] == list(sheets)
    for one in drawn:
        stated = sheets[one["name"]]
        assert set(one["files"]) <= {Path(file).name for file in stated.pop("files")}
        _compared({key: one[key] for key in stated}, stated)


@pytest.mark.slow
def test_a_study_of_the_stage(client: TestClient, folder: Path) -> None:
    found = result_of(client, "/api/simulation/run", experiment="stage-steps", models=["lugre"])[1]["document"]
    _compared(found, _command(folder, "simulate", "stage", "--study", "steps", "--no-figures", "--format", "none"))


def test_documents_of_simulation_and_checks(client: TestClient, folder: Path) -> None:
    body = {"experiment": "presliding", "models": ["lugre"], "changes": {}}
    found = result_of(client, "/api/simulation/run", **body)[1]["document"]
    words = ["simulate", "presliding", "--model", "lugre", "--no-figures", "--format", "none"]
    _compared(found, _command(folder, *words))
    _compared(found, stagecad.simulate("presliding", models=["lugre"]).to_json())
    found = {(one["subject"], one["name"]): one for one in client.get("/api/machine/checks").json()}
    for one in stagecad.checks(solids=False, proposals=False).to_json():
        _compared(found[one["subject"], one["name"]], one, one["name"])
