"""The JSON of the page, over the routes that it uses."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient

from stagecad.parameters.load import load_design
from workbench.page.project import Project
from workbench.page.security import Guard
from workbench.page.server import create_app


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("project")


@pytest.fixture(scope="module")
def client(folder: Path):
    guarded: Any = Guard(create_app(Project(folder, Path("build"))), frozenset({"127.0.0.1:8321"}))
    with TestClient(guarded, base_url="http://127.0.0.1:8321") as made:
        yield made


def _preview(client: TestClient, changes: dict[str, str], **more: Any) -> Any:
    return client.post("/api/machine/preview", json={"changes": changes, **more})


def test_the_page_and_its_libraries_are_served_from_the_package(client: TestClient) -> None:
    page = client.get("/")
    assert page.status_code == 200 and "app.js" in page.text
    for file in ("app.js", "vendor/three.min.js", "vendor/uplot.min.js", "vendor/uplot.min.css"):
        found = client.get(f"/{file}")
        assert found.status_code == 200 and len(found.content) > 500, file
    assert client.get("/../server.py").status_code == 404
    assert client.get("/%2e%2e/server.py").status_code == 404


def test_a_drag_moves_margins_and_shows_every_violated_rule(client: TestClient) -> None:
    base = _preview(client, {}, limit=30.0).json()
    assert base["count"] == len(base["checks"]) > 100 and base["violations"] == [] and base["pending"] == []
    moved = _preview(client, {"stage.thickness": "13 mm"}, limit=30.0, since=base["version"]).json()
    sag = "sag of the drive surface over the travel"
    before, after = (next(c["margin"] for c in one["checks"] if c["name"] == sag) for one in (base, moved))
    assert after > before
    assert moved["changed"]["stage.payload_thread_depth"] == "8 mm"
    bad = _preview(client, {"stage.thickness": "6.1 mm", "stage.length": "150 mm"}).json()
    assert len(bad["violations"]) > 1 and all(one["message"] for one in bad["violations"])


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"stage.thickness": "-1 mm"}, "stage.thickness"),
        ({"stage.thickness": "13"}, "stage.thickness"),
        ({"stage.thicknes": "13 mm"}, "did you mean 'stage.thickness'"),
        ({"stage.thickness": ""}, "a value is wanted"),
    ],
)
def test_a_wrong_value_is_one_clear_line(client: TestClient, changes: dict[str, str], words: str) -> None:
    answer = _preview(client, changes)
    assert answer.status_code == 422
    assert words in answer.json()["error"] and "\n" not in answer.json()["error"]


def test_commit_undo_redo_difference_and_save(client: TestClient, folder: Path) -> None:
    state = client.post("/api/machine/commit", json={"changes": {"stage.thickness": "13 mm"}}).json()
    assert state["undo"] == 1 and state["changes"] == {"stage.thickness": "13 mm"}
    differences = {row["key"]: row for row in client.get("/api/machine/differences").json()}
    assert differences["stage.thickness"]["before"]["text"] == "12 mm"
    assert differences["stage.thickness"]["after"]["text"] == "13 mm"
    assert client.post("/api/machine/undo", json={}).json()["changes"] == {}
    assert client.post("/api/machine/redo", json={}).json()["changes"] == {"stage.thickness": "13 mm"}

    # Another server of the same folder continues there.
    restarted = create_app(Project(folder, Path("build"))).state
    assert restarted.machine.changes == {"stage.thickness": "13 mm"}
    restarted.jobs.close()

    assert client.post("/api/machine/save", json={"name": "../thick"}).status_code == 422
    saved = client.post("/api/machine/save", json={"name": "thick"}).json()
    assert saved["file"] == "thick.toml" and saved["changes"] == {} and "thick.toml" in saved["files"]
    entry = load_design(folder / "thick.toml").entry("stage.thickness")
    assert entry.text == "13 mm" and entry.origin == "assumed: changed in the workbench"
    assert "is there already" in client.post("/api/machine/save", json={"name": "thick"}).json()["error"]
    assert client.post("/api/machine/open", json={"name": None}).json()["file"] is None


def test_parameters_have_unit_bounds_and_origin(client: TestClient) -> None:
    parameters = {one["key"]: one for one in client.get("/api/machine/parameters").json()}
    stroke = parameters["actuator.stroke_amplitude"]
    assert (stroke["number"], stroke["unit"], stroke["low"]) == (10.0, "um", 0.0)
    assert stroke["origin"] == "thesis 4.1" and stroke["meaning"]
    assert "invar_36" in parameters["stage.material"]["allowed"]


def test_the_tip_draws_the_ellipse_of_the_equations(client: TestClient) -> None:
    body = {"piezo_spacing": 0.046, "tip_height": 0.02, "stroke": 1e-5, "phase": np.pi / 2}
    path = client.post("/api/simulation/tip", json=body).json()
    # d1, d2 in quadrature: x = h (d1 - d2)/D and y = (d1 + d2)/2 have the amplitudes sqrt(2) h d/D and d/sqrt(2).
    assert max(path["x"]) == pytest.approx(np.sqrt(2.0) * 0.02 * 1e-5 / 0.046, rel=1e-3)
    assert path["features"]["semi_major"]["value"] == pytest.approx(1e-5 / np.sqrt(2.0), rel=1e-3)


def test_files_dropped_on_the_page_become_an_experiment(client: TestClient, folder: Path) -> None:
    headers = {"content-type": "application/octet-stream"}
    rows = "".join(f"{0.001 * k},{np.sin(0.01 * k):.6f},{np.sign(np.cos(0.01 * k)):.1f}\n" for k in range(2000))
    text = "t,speed,F\n" + rows
    answer = client.post("/api/upload/rig/run.csv", content=text.encode(), headers=headers)
    assert [column["label"] for column in answer.json()["columns"]] == ["t", "speed", "F"]
    assert answer.json()["columns"][0]["rows"] == 2000
    columns = {"time": "t", "velocity": "speed", "friction_force": "F"}
    record = {"file": "run.csv", "role": "fit", "columns": columns}
    body = {"name": "rig", "kind": "velocity-drive", "effects": ["coulomb"], "records": [record]}
    refused = client.post("/api/experiments", json=body)
    assert refused.status_code == 422 and "unit" in refused.json()["error"]
    assert not (folder / "rig" / "experiment.toml").exists()
    record["units"] = {"time": "s", "velocity": "m/s", "friction_force": "N"}
    assert client.post("/api/experiments", json=body).json() == {"name": "rig"}
    assert [one["name"] for one in client.get("/api/experiments").json()] == ["rig"]
    assert client.get("/api/experiment/rig/ladder").json()["effects"] == ["coulomb"]


@pytest.mark.parametrize(
    "name, content, words",
    [
        ("run.exe", b"x", "no record format"),
        ("run.csv", b"", "empty"),
        (".run.csv", b"time [s]\n", "name"),
    ],
)
def test_a_refused_file_leaves_nothing_behind(
    client: TestClient, folder: Path, name: str, content: bytes, words: str
) -> None:
    headers = {"content-type": "application/octet-stream"}
    answer = client.post(f"/api/upload/other/{name}", content=content, headers=headers)
    assert answer.status_code == 422
    assert words in answer.json()["error"]
    assert not (folder / "other").exists()


@pytest.mark.slow
def test_a_simulation_is_a_job_with_curves(client: TestClient) -> None:
    body = {"experiment": "presliding", "models": ["lugre"], "changes": {"friction.mass": "2 kg"}}
    job = client.post("/api/simulation/run", json=body).json()
    deadline = time.monotonic() + 100.0
    while job["state"] in ("waiting", "running"):
        assert time.monotonic() < deadline
        time.sleep(0.1)
        job = next(one for one in client.get("/api/jobs").json() if one["number"] == job["number"])
    assert (job["state"], job["error"]) == ("done", "")
    result = client.get(f"/api/jobs/{job['number']}/result").json()
    series = result["curves"][0]["series"]
    row = series.index("position [m]")
    answer = client.get(f"/api/jobs/{job['number']}/curves/0", params={"series": str(row), "columns": 300})
    time_, position = np.frombuffer(answer.content).reshape(int(answer.headers["x-rows"]), -1)
    assert time_[0] == 0.0 and time_[-1] == pytest.approx(4.0, abs=0.05)
    peak = result["document"]["presliding"]["lugre"]["position_max"]["value"]
    assert np.nanmax(position) == pytest.approx(peak, rel=1e-3)
    assert client.get(f"/api/jobs/{job['number']}/curves/0", params={"series": "99"}).status_code == 422
