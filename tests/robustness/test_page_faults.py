"""The page: nothing outside the project is read or written, no change is lost, no request breaks it."""

import json
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient

from stagecad.parameters.errors import InputError
from tests.experiments import record_text
from tests.workbench.page.served_page import client_of, refused
from workbench.page.jobs import SCHEMA, Job, JobRunner
from workbench.page.project import Project
from workbench.page.server import create_app

RIG = 'schema = 1\n[rig]\nkind = "velocity-drive"\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "project").mkdir()
    return tmp_path / "project"


@pytest.fixture
def client(folder: Path):
    with client_of(folder, raise_server_exceptions=False) as made:
        yield made


def stated(rig: Path, text: str = RIG + record_text()) -> None:
    rig.mkdir(parents=True)
    (rig / "experiment.toml").write_bytes(text.encode("utf-8", "surrogateescape"))


def every_route(client: TestClient, name: str, words: str) -> None:
    for route in ("ladder", "report"):
        refused(client.get(f"/api/experiment/{name}/{route}"), words)
    for route, body in (("compare", {}), ("diagnose", {}), ("add", {"effects": ["coulomb"]}), ("undo", {})):
        refused(client.post(f"/api/experiment/{name}/{route}", json=body), words)


def test_a_linked_experiment_or_ladder_is_neither_read_nor_written(client: TestClient, folder: Path) -> None:
    outside = folder.parent / "secret.toml"
    outside.write_text(RIG)
    (folder / "rig").mkdir()
    (folder / "rig" / "experiment.toml").symlink_to(outside)
    every_route(client, "rig", "outside the project")
    refused(client.get("/api/experiment/rig/code"), "outside the project")
    assert outside.read_text() == RIG
    (folder.parent / "elsewhere").mkdir()
    stated(folder / "other")
    (folder / "other" / "ladder").symlink_to(folder.parent / "elsewhere")
    every_route(client, "other", "outside the project")


@pytest.mark.parametrize("file", ["/etc/hostname", "../../secret.csv", "linked.csv", "a/../../../secret.csv"])
def test_records_outside_of_the_project_are_refused(client: TestClient, folder: Path, file: str) -> None:
    (folder.parent / "secret.csv").write_text("time [s],force [N]\n0,0\n1,1\n")
    stated(folder / "rig", RIG + record_text(file))
    (folder / "rig" / "linked.csv").symlink_to(folder.parent / "secret.csv")
    every_route(client, "rig", "project")


def test_code_behind_a_mark_is_seen_and_an_unreadable_experiment_refused(client: TestClient, folder: Path) -> None:
    stated(folder / "rig", f'\ufeff{RIG}[model]\ncustom = ["own.py"]\n')
    every_route(client, "rig", "names Python code")
    stated(folder / "other", "\udcff\udcfe")
    every_route(client, "other", "is not UTF-8")


def test_a_linked_parameter_file_is_not_offered(client: TestClient, folder: Path) -> None:
    (folder.parent / "stage.toml").write_text('extends = "thesis"\n')
    (folder / "other.toml").symlink_to(folder.parent / "stage.toml")
    os.mkfifo(folder / "pipe.toml")
    assert client.get("/api/machine").json()["files"] == []
    refused(client.post("/api/machine/open", json={"name": "other.toml"}), "no parameter file")
    refused(client.get("/api/machine/differences?other=other.toml"), "outside the project")


@pytest.mark.parametrize(
    "name, words",
    [("pipe.toml", "is not a regular file"), ("latin.toml", "not UTF-8"), ("none.toml", "no such"), (".", "a folder")],
)
def test_what_is_no_parameter_file_is_refused(client: TestClient, folder: Path, name: str, words: str) -> None:
    os.mkfifo(folder / "pipe.toml")
    (folder / "latin.toml").write_bytes(b'extends = "thesis"  # \xe4\n')
    refused(client.get(f"/api/machine/differences?other={name}"), words)
    refused(client.post("/api/machine/open", json={"name": name}), words if name == "latin.toml" else "no parameter")


@pytest.mark.parametrize("target", ["../stage.toml", "/dev/zero", "missing.toml"])
def test_the_default_parameter_file_is_no_link_out_of_the_folder(folder, monkeypatch, command, target: str) -> None:
    (folder.parent / "stage.toml").write_text('extends = "thesis"\n')
    (folder / "stage.toml").symlink_to(target)
    monkeypatch.chdir(folder)
    assert "stage.toml" in command.refused("workbench", "--no-browser", "--port", "0")


def test_results_belong_to_the_path_of_an_experiment(client: TestClient, folder: Path) -> None:
    for place in ("a", "b"):
        stated(folder / place / "rig")
    (folder / "build" / "a" / "rig").mkdir(parents=True)
    (folder / "build" / "a" / "rig" / "report.html").write_text("of a")
    assert client.get("/api/experiment/a/rig/report").text == "of a"
    refused(client.get("/api/experiment/b/rig/report"), "no report yet")


def test_a_change_of_an_older_state_is_refused_and_nothing_is_lost(client: TestClient) -> None:
    seen = client.get("/api/machine").json()["digest"]
    first = {"changes": {"stage.thickness": "13 mm"}, "seen": seen}
    assert client.post("/api/machine/commit", json=first).status_code == 200
    second = client.post("/api/machine/commit", json={"changes": {"stage.length": "231 mm"}, "seen": seen})
    assert second.status_code == 409 and "stage.thickness = 13 mm" in second.json()["error"]
    state = client.get("/api/machine").json()
    assert second.json()["state"] == state and state["changes"] == first["changes"]
    for route, more in (("open", {"name": None}), ("undo", {}), ("redo", {}), ("save", {"name": "mine"})):
        assert client.post(f"/api/machine/{route}", json={**more, "seen": seen}).status_code == 409
    assert client.get("/api/machine").json() == state
    both = {**state["changes"], "stage.length": "231 mm"}
    last = client.post("/api/machine/commit", json={"changes": both, "seen": state["digest"]}).json()
    assert last["changes"] == both
    opened = client.post("/api/machine/open", json={"name": None, "seen": last["digest"]})
    assert (opened.status_code, opened.json()["changes"]) == (200, {})


def test_a_state_that_this_version_does_not_know_is_left_out(client: TestClient, folder: Path) -> None:
    client.post("/api/machine/commit", json={"changes": {"stage.thickness": "13 mm"}})
    file = folder / "build" / "workbench" / "machine.json"
    kept = json.loads(file.read_text())
    wrong = (
        {"history": [{}, {"stage.no_such_key": "1 mm"}], "place": 1},
        {"history": [{}], "place": 99},
        {"history": 5, "place": 0},
        {"history": [5], "place": 0},
        {"history": [{"stage.thickness": 5}], "place": "0"},
    )
    for text in (*(json.dumps({**kept, **one}) for one in wrong), "[]", "pipe"):
        file.unlink()
        os.mkfifo(file) if text == "pipe" else file.write_text(text)
        with client_of(folder) as again:
            found = again.get("/api/machine")
            assert (found.status_code, found.json()["changes"]) == (200, {}), text


JOB = {
    "schema": SCHEMA, "number": 7, "lane": "simulation", "task": "simulate", "title": "", "subject": "",
    "state": "done", "error": "", "created": 1.0, "began": 1.0, "ended": 2.0, "arguments": {},
}  # fmt: skip
CURVES = "curves/0?series="
DEEP = "[" * 100_000


def kept_job(folder: Path, text: str | None = None, number: int = 7, files: dict[str, bytes] | None = None) -> None:
    """Write what is kept of a job: this text, or that of a job that is done."""
    place = folder / "build" / "workbench" / "jobs" / f"{number:05}"
    place.mkdir(parents=True)
    text = json.dumps({**JOB, "number": number}) if text is None else text
    for name, data in {"job.json": text.encode(), "result.json": b"{}", **(files or {})}.items():
        (place / name).write_bytes(data)


def test_a_job_that_is_not_one_is_left_out(folder: Path) -> None:
    wrong = ({"number": 10**30}, {"number": -1}, {"number": 99}, {"state": "no"}, {"title": {}}, {"schema": 0})
    kept_job(folder)
    for number, one in enumerate(("5", "null", "[]", DEEP, *wrong), start=8):
        kept_job(folder, one if isinstance(one, str) else json.dumps({**JOB, "number": number, **one}), number)
    with client_of(folder) as again:
        assert [job["number"] for job in again.get("/api/jobs").json()] == [7]


def test_damaged_results_of_a_job_are_said(folder: Path) -> None:
    damaged = dict(enumerate((b"{", b"\xff\xfe", DEEP.encode(), b"\x93NUMPY")))
    for number, data in damaged.items():
        kept_job(folder, number=number, files={"result.json": data, "curves_0.npy": data})
    with client_of(folder, raise_server_exceptions=False) as again:
        for number in damaged:
            refused(again.get(f"/api/jobs/{number}/result"), "damaged")
            refused(again.get(f"/api/jobs/{number}/{CURVES}0"), "damaged")


def test_positions_of_series_are_decimal_numbers(folder: Path) -> None:
    kept_job(folder)
    np.save(folder / "build" / "workbench" / "jobs" / "00007" / "curves_0.npy", np.zeros((2, 9)))
    with client_of(folder, raise_server_exceptions=False) as again:
        assert again.get(f"/api/jobs/7/{CURVES}1&start=nan&stop=-inf&columns=-5").status_code == 200
        for words in ("2", "-1", "\u00b2", "0,x", "9" * 5000):
            refused(again.get(f"/api/jobs/7/{CURVES}{words}"), "series")


@pytest.mark.parametrize("name", ["build", "build/workbench", "build/workbench/jobs", "build/workbench/machine.json"])
def test_results_are_not_linked_out_of_the_folder(folder: Path, name: str) -> None:
    (folder.parent / "elsewhere").mkdir()
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).symlink_to(folder.parent / "elsewhere")
    with pytest.raises(InputError, match="leads out of the folder"):
        create_app(Project(folder, Path("build")))


def test_results_of_an_experiment_are_not_linked_out_of_the_folder(client: TestClient, folder: Path) -> None:
    (folder.parent / "elsewhere").mkdir()
    stated(folder / "rig")
    (folder / "build").mkdir(exist_ok=True)
    (folder / "build" / "rig").symlink_to(folder.parent / "elsewhere")
    every_route(client, "rig", "leads out of the folder")


def test_what_no_route_answers_has_the_form_of_errors(client: TestClient) -> None:
    tip = {"piezo_spacing": 1e308, "tip_height": 1e308, "stroke": 1e-5, "phase": 1e308}
    long = "x" * 300
    answers = [
        (client.post("/api/simulation/tip", json=tip), 422),
        (client.get(f"/api/experiment/{long}/ladder"), 422),
        (client.get(f"/api/experiment/{'x/' * 30_000}/ladder"), 422),
        (client.post("/api/experiments", json={"name": long}), 422),
        (client.post("/api/machine/commit", content=b"{", headers={"content-type": "application/json"}), 422),
        (client.get("/api/no-such-route"), 404),
        (client.put("/api/machine", json={}), 405),
    ]
    for answer, status in answers:
        assert answer.status_code == status, answer.text
        error = answer.json()["error"]
        assert error and "\n" not in error and len(error) < 400 and not error.startswith(":")


def test_a_refused_creation_leaves_nothing(client: TestClient, folder: Path) -> None:
    (folder / "notes.txt").write_text("")
    sent = {"content": b"time [s],x [m]\n0,1\n1,2\n", "headers": {"content-type": "application/octet-stream"}}
    answer = client.post("/api/upload/notes.txt/a.csv", **sent)
    assert answer.status_code == 422 and "notes.txt" in answer.json()["error"]
    body = {"name": "new", "kind": "no-such", "records": [{"file": "fit.csv", "role": "fit"}]}
    assert client.post("/api/experiments", json=body).status_code == 422
    assert [path.name for path in folder.iterdir() if path.name != "build"] == ["notes.txt"]


def test_the_job_of_a_killed_server_is_listed_as_ended(tmp_path: Path) -> None:
    runner = JobRunner(tmp_path / "jobs", tmp_path)
    runner._note(Job(7, "simulation", "simulate", "Simulate", "", {}, state="running"))
    runner.close()
    later = JobRunner(tmp_path / "jobs", tmp_path)
    assert (later.get(7).state, later.get(7).error) == ("cancelled", "the server ended")
    later.close()


def test_many_previews_leave_the_other_requests_their_threads(client: TestClient) -> None:
    """As many as there are threads, each of which would hold one."""
    session, go, waiting = client.app.app.state.machine, Event(), Event()  # type: ignore[attr-defined]

    def preview(*_: Any) -> dict[str, Any]:
        waiting.set()
        go.wait(60.0)
        return {}

    session.preview = preview
    with ThreadPoolExecutor(61) as threads:
        asked = [threads.submit(client.post, "/api/machine/preview", json={"changes": {}}) for _ in range(60)]
        assert waiting.wait(60.0)
        assert threads.submit(client.get, "/api/about").result(60.0).status_code == 200
        assert not go.is_set()
        go.set()
        assert all(one.result(60.0).status_code == 200 for one in asked)
