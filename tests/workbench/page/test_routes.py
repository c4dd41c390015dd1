"""The JSON of the page, over the routes that it uses; checks while a parameter is dragged."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from served_page import client_of, refused, result_of
from starlette.testclient import TestClient

import stagecad
from designcalc.checks import run as checks
from designcalc.checks.run import run_checks
from stagecad.consent import give_consent
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties
from sysid.experiment.experiment import load_experiment
from sysid.experiment.rig_kinds.declaration import find_rig
from tests.experiments import write_rig
from tests.reference.tables import cases
from workbench.operations.live_checks import LiveChecks
from workbench.page.project import Project
from workbench.page.server import create_app

CHANGES = (["stage.length=240 mm", "pads.length=24 mm"], ["pads.length=24 mm", "stage.material=invar_36"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("project")


@pytest.fixture(scope="module")
def client(folder: Path):
    with client_of(folder) as made:
        yield made


def _preview(client: TestClient, changes: dict[str, str], **more: Any) -> Any:
    return client.post("/api/machine/preview", json={"changes": changes, **more})


def test_the_page_and_its_libraries_are_served_from_the_package(client: TestClient) -> None:
    page = client.get("/")
    assert page.status_code == 200 and "app.js" in page.text
    for file in ("app.js", "vendor/three.min.js", "vendor/uplot.min.js", "vendor/uplot.min.css"):
        found = client.get(f"/{file}")
        assert found.status_code == 200 and len(found.content) > 500, file
    assert client.get("/../server.py").status_code == 404 and client.get("/%2e%2e/server.py").status_code == 404


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


def test_a_machine_of_the_users_own_has_its_checks_and_its_parameters_first(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr(checks, "OWN", {})
    monkeypatch.setattr("stagecad.consent._consented", set())
    slide = tmp_path / "slide"
    shutil.copytree(Path(__file__).parents[3] / "examples" / "ball_screw_slide", slide)
    project = Project(slide, Path("build"), slide / "stage.toml")
    with TestClient(create_app(project)) as own:
        assert _preview(own, {}, limit=30.0).json()["count"] == 0
    give_consent((slide / "checks" / "critical_speed.py", *slide.glob("*.py")))
    with TestClient(create_app(project)) as own:
        (check,) = _preview(own, {}, limit=30.0).json()["checks"]
        assert check["subject"] == "ball screw"
        keys = [row["key"] for row in own.get("/api/machine/parameters").json()]
        assert own.get("/api/machine/optimize").json() == {}  # the packaged machine's parameters may not change
        _, found = result_of(own, "/api/machine/optimize", free={"screw.journal": "8 mm:14 mm"}, budget=20)
        assert found["required"] == 1  # the user's own check
    assert keys[0] == "bed.length" and "stop_bar.reach" not in keys and "requirements.speed" in keys


@pytest.mark.parametrize("changes, words", cases("mistakes", "page_values"))
def test_a_wrong_value_is_one_clear_line(client: TestClient, changes: dict[str, str], words: str) -> None:
    refused(_preview(client, changes), words)


def test_commit_undo_redo_difference_and_save(client: TestClient, folder: Path) -> None:
    state = client.post("/api/machine/commit", json={"changes": {"stage.thickness": "13 mm"}}).json()
    assert state["undo"] == 1 and state["changes"] == {"stage.thickness": "13 mm"}
    differences = {row["key"]: row for row in client.get("/api/machine/differences").json()}
    before = stagecad.load_design()
    found = stagecad.diff(before, before.with_values({"stage.thickness": "13 mm"}), solids=False, margins=False)
    assert list(differences) == list(found.parameters.index)
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


def test_formats_parameters_and_free_ranges_are_those_of_the_file(client: TestClient) -> None:
    parameters = {one["key"]: one for one in client.get("/api/machine/parameters").json()}
    stroke = parameters["actuator.stroke_amplitude"]
    assert (stroke["number"], stroke["unit"], stroke["low"]) == (10.0, "um", 0.0)
    assert stroke["origin"] == "thesis 4.1" and stroke["meaning"]
    assert "invar_36" in parameters["stage.material"]["allowed"]
    found = client.get("/api/formats").json()
    assert {".csv", ".csv.gz", ".lvm", ".tdms", ".npz"} <= set(found["suffixes"])
    assert {"velocity-drive", "motor-current", "pneumatic-cylinder"} <= set(found["kinds"])
    for kind in found["kinds"]:
        assert find_rig(kind, "kind").name == kind
    free = client.get("/api/machine/optimize").json()
    assert free["stage.thickness"] == "10 mm:30 mm" and "|" in free["tip.material"]
    for body, words in (
        ({"free": {"stage.thickness": "10 mm"}}, "LOW:HIGH"),
        ({"free": {"stage.thicknes": "1 mm:2 mm"}}, "did you mean"),
        ({"free": {}}, "free"),
    ):
        refused(client.post("/api/machine/optimize", json=body), words)


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
    assert answer.json() == {"file": "run.csv", "rows": 2000}
    proposed = client.post("/api/propose", json={"name": "rig", "files": ["run.csv"]}).json()
    assert [one["label"] for one in proposed["columns"]] == ["t", "speed", "F"]
    # What the columns are is guessed; their units are requested.
    assert [one["channel"] for one in proposed["columns"]] == ["time", "velocity", "friction_force"]
    assert all("unit" in one["question"] for one in proposed["columns"])
    channels: dict[str, Any] = {one["channel"]: {"column": one["column"]} for one in proposed["columns"]}
    record = {"file": "run.csv", "role": "fit"}
    body = {"name": "rig", "kind": "velocity-drive", "effects": ["coulomb"], "channels": channels, "records": [record]}
    refused(client.post("/api/experiments", json=body), "unit")
    assert not (folder / "rig" / "experiment.toml").exists()
    for channel, unit in (("time", "s"), ("velocity", "m/s"), ("friction_force", "N")):
        channels[channel]["unit"] = unit
    channels["friction_force"]["sign"] = -1
    assert client.post("/api/experiments", json=body).json() == {"name": "rig"}
    stated = load_experiment(folder / "rig").records[0].sources["friction_force"].terms[0]
    assert (stated.column.label, stated.factor) == ("F", -1.0)
    assert [one["name"] for one in client.get("/api/experiments").json()] == ["rig"]
    assert client.get("/api/experiment/rig/ladder").json()["effects"] == ["coulomb"]
    (folder / "two").mkdir()
    (folder / "two" / "run.csv").write_text("time [s];velocity [m/s];left [N];right [N]\n" + "0;1;2;3\n1;2;2;4\n")
    channels = {"time": {"column": "time [s]"}, "velocity": {"column": "velocity [m/s]"}}
    channels["friction_force"] = [{"column": "left [N]"}, {"column": "right [N]", "sign": -1}]
    assert client.post("/api/experiments", json={**body, "name": "two", "channels": channels}).json() == {"name": "two"}
    terms = load_experiment(folder / "two").records[0].sources["friction_force"].terms
    assert [(one.column.label, one.factor) for one in terms] == [("left [N]", 1.0), ("right [N]", -1.0)]


@pytest.mark.parametrize("name, content, words", [
    ("run.exe", b"x", "record format"), ("run.csv", b"", "empty"),
    ("run.csv", b"time [s];velocity [m/s]\n", "no rows"), ("run.h5", b"no HDF5", "run.h5"),
    (".run.csv", b"time [s]\n", "name"),
])  # fmt: skip
def test_a_refused_file_leaves_nothing_behind(client, folder: Path, name: str, content: bytes, words: str) -> None:
    headers = {"content-type": "application/octet-stream"}
    refused(client.post(f"/api/upload/other/{name}", content=content, headers=headers), words)
    assert not (folder / "other").exists()


def test_an_example_is_copied_and_never_over_another_folder(client: TestClient, folder: Path) -> None:
    names = [one["name"] for one in client.get("/api/examples").json()]
    assert names[:3] == ["demo", "own_effect", "own_rig"]
    assert client.post("/api/examples/own_rig", json={}).json() == {"name": "own_rig"}
    text = (folder / "own_rig" / "experiment.toml").read_text("utf-8")
    assert client.post("/api/examples/own_rig", json={}).json() == {"name": "own_rig_2"}
    assert (folder / "own_rig_2" / "experiment.toml").read_text("utf-8") == text
    assert load_experiment(folder / "own_rig_2").effects == ("coulomb", "viscous")
    assert "own_rig" in client.post("/api/examples/own_rug", json={}).json()["error"]


def test_python_code_runs_after_the_consent_to_its_content(tmp_path: Path) -> None:
    app = create_app(Project(tmp_path, Path("build"), trust=True))
    with TestClient(app) as client:
        assert client.post("/api/examples/own_effect", json={}).json() == {"name": "own_effect"}
        file = tmp_path / "own_effect" / "bellows.py"
        file.write_text(file.read_text("utf-8") + f"# {tmp_path}\n", "utf-8")
        refused(client.get("/api/experiment/own_effect/ladder"), "Python code")
        shown = client.get("/api/experiment/own_effect/code").json()
        (one,) = shown["files"]
        assert shown["offered"] and not one["consented"] and one["text"] == file.read_text("utf-8")
        consent = {"files": {"bellows.py": one["sha256"]}}
        file.write_text(one["text"] + "# changed\n", "utf-8")
        refused(client.post("/api/experiment/own_effect/consent", json=consent), "has changed since it was shown")
        file.write_text(one["text"], "utf-8")
        assert client.post("/api/experiment/own_effect/consent", json=consent).json()["files"][0]["consented"]
        assert client.get("/api/experiment/own_effect/ladder").status_code == 200
    with TestClient(create_app(Project(tmp_path, Path("build")))) as client:
        assert client.get("/api/experiment/own_effect/code").json()["offered"] is False
        refused(client.get("/api/experiment/own_effect/ladder"), "stagecad workbench --trust")
        refused(client.post("/api/experiment/own_effect/consent", json=consent), "stagecad workbench --trust")


@pytest.mark.slow
def test_a_simulation_is_a_job_with_curves(client: TestClient) -> None:
    body = {"experiment": "presliding", "models": ["lugre"], "changes": {"friction.mass": "2 kg"}}
    job, result = result_of(client, "/api/simulation/run", **body)
    row = result["curves"][0]["series"].index("position [m]")
    answer = client.get(f"/api/jobs/{job['number']}/curves/0", params={"series": str(row), "columns": 300})
    time_, position = np.frombuffer(answer.content).reshape(int(answer.headers["x-rows"]), -1)
    assert time_[0] == 0.0 and time_[-1] == pytest.approx(4.0, abs=0.05)
    peak = result["document"]["presliding"]["lugre"]["position_max"]["value"]
    assert np.nanmax(position) == pytest.approx(peak, rel=1e-3)
    assert client.get(f"/api/jobs/{job['number']}/curves/0", params={"series": "99"}).status_code == 422


def test_incremental_checks_equal_a_full_run_also_with_masses_of_solids() -> None:
    live = LiveChecks()
    live.update(load_design(), 1e9)
    for overrides in CHANGES:
        design = load_design(None, overrides, rules=False)
        assert live.update(design, 1e9).pending == ()
        known, full = live.all_known(), run_checks(design)
        assert [known[k].margin for k in range(len(full))] == pytest.approx([one.margin for one in full], nan_ok=True)
        assert [known[k].name for k in range(len(full))] == [one.name for one in full]
    design, live = load_design(), LiveChecks()
    live.update(design, 1e9)
    # A plate of 230 x 270 x 12 mm on the ways, somewhat heavier than one of aluminium.
    inertia = 2.5 / 12.0 * np.diag([0.27**2 + 0.012**2, 0.23**2 + 0.012**2, 0.23**2 + 0.27**2])
    box = ((-0.115, -0.135, 0.034), (0.115, 0.135, 0.046))
    body = MassProperties(7.5e-4, 2.5, (0.0, 0.0, 0.04), inertia, box)
    masses = BodyMasses(body, replace(body, mass=0.023))
    live.set_masses(design, masses)
    live.update(design, 1e9)
    full, known = run_checks(design, masses), live.all_known()
    assert [known[k].margin for k in range(len(full))] == [one.margin for one in full]


def test_an_answer_within_a_limit_is_completed_by_the_next() -> None:
    live = LiveChecks()
    base = live.update(load_design(), 1e9)
    changed = load_design(None, ["stage.thickness=13 mm"], rules=False)
    first = live.update(changed, 0.0, base.version)
    assert 0 < len(first.checks) < base.count and first.pending and set(first.checks).isdisjoint(first.pending)
    second = live.update(changed, 1e9, first.version)
    assert second.pending == () and set(second.checks) == set(first.pending)
    # A page that knows nothing yet is answered with everything.
    assert len(live.update(changed, 0.0).checks) == base.count


def test_faults_of_the_rows_and_their_picture_are_seen_before_any_fit(client: TestClient, folder: Path) -> None:
    seconds = np.arange(1500) * 0.01
    position, noise = 0.02 * np.sin(seconds), 0.01 * np.random.default_rng(1).standard_normal(1500)
    force = np.clip(np.sign(np.cos(seconds)) + 0.8 * np.cos(seconds) + noise, -1.6, 1.6)
    force[200] = 0.0
    columns = {"time": seconds, "position": position, "friction_force": force}
    write_rig(folder / "seen", "velocity-drive", {"fit": columns}, ["coulomb"])
    answer = client.get("/api/experiment/seen/look").json()
    assert any("clipped at -1.6 N and 1.6 N" in line for line in answer["warnings"])
    assert answer["figure"].startswith("<svg") and "clipped" in answer["figure"]
    _, found = result_of(client, "/api/experiment/seen/compare")
    assert set(answer["warnings"]) <= set(found["document"]["warnings"])
