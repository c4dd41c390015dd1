"""Random requests of two clients at once to every route of the page, with bodies made of the routes' own schemas: each
is answered in time and, if refused, in one line; no file outside of the project is touched, and no change is lost."""

import json
import logging
import threading
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import pytest
import uvicorn

from tests.robustness.mutation import count, mutated, mutated_bytes
from tests.robustness.test_written_files import content
from tests.sysid.slide import SIGN, VELOCITY, slide
from workbench.page.jobs import JobRunner
from workbench.page.project import Project
from workbench.page.security import Guard
from workbench.page.server import create_app

SLOW = 10.0
"""Processor time of an answer, with all that happens beside it, that is taken for a hang, s."""
TOKEN = "token-of-the-random-requests"
TEXTS = (
    "rig", "a/rig", "fit.csv", "validate.csv", "stage.toml", "own.toml", "stage.length", "tip.material", "12 mm", "3 N",
    "coulomb", "viscous", "friction_force", "fit", "stick-slip", "lugre", "magnet", "demo", "own_effect", "python", "1",
    "velocity-drive", "time", "s", "0", "10 mm:30 mm", "", " ", ".", "..", "../rig", "/etc/passwd", "%2e%2e%2f", "a\\b",
    "\x00", "\n", "\ud800", "\u202e", "ü", "<b>", "=1", "nan", "1e400", "9" * 300, "x" * 300, "rig/" * 200, "[" * 300,
)  # fmt: skip
VALUES = (None, True, 0, -1, 1, 7, 10**30, 1e308, -1e-320, 0.5, [], {}, [[]], {"": None}, [1] * 1000, *TEXTS)
JOB = {"number": 1, "lane": "simulation", "task": "simulate", "title": "", "subject": "", "arguments": {}, "schema": 1}


class Requests:
    """Random requests that follow, or break, the description of the routes."""

    def __init__(self, description: dict[str, Any], seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.schemas = description["components"]["schemas"]
        paths = {path: methods for path, methods in description["paths"].items() if path != "/api/events"}
        self.routes = [(path, *one) for path, methods in paths.items() for one in methods.items()]

    def one_of(self, values: Any) -> Any:
        return values[int(self.random.integers(len(values)))]

    def value(self, schema: dict[str, Any]) -> Any:
        """A value of a schema; one in ten is of any other type."""
        if self.random.random() < 0.1:
            return self.one_of(VALUES)
        if "$ref" in schema:
            schema = self.schemas[schema["$ref"].rpartition("/")[2]]
        if "anyOf" in schema:
            return self.value(self.one_of(schema["anyOf"]))
        if "enum" in schema:
            return self.one_of(schema["enum"])
        kind, most = schema.get("type"), int(self.random.integers(0, 4))
        if kind == "object" and "properties" in schema:
            need = schema.get("required", ())
            chosen = {k: v for k, v in schema["properties"].items() if k in need or self.random.random() < 0.5}
            return {key: self.value(one) for key, one in chosen.items()}
        if kind == "object":
            return {str(self.one_of(TEXTS)): self.value(schema["additionalProperties"]) for _ in range(most)}
        if kind == "array":
            return [self.value(schema["items"]) for _ in range(most)]
        numbers = [value for value in VALUES if isinstance(value, int | float)]
        return None if kind == "null" else self.one_of(TEXTS if kind == "string" else numbers)

    def word(self) -> str:
        """A part of an address."""
        text = str(self.one_of(TEXTS)).encode("utf-8", "replace").decode()
        return text if self.random.random() < 0.5 else str(int(self.random.integers(0, 3)))

    def request(self) -> dict[str, Any]:
        path, method, operation = self.one_of(self.routes)
        headers, data = {"content-type": "application/json"}, b""
        query = {}
        for one in operation.get("parameters", ()):
            if one["in"] == "query" and self.random.random() < 0.7:
                query[one["name"]] = str(self.value(one["schema"])).encode("utf-8", "replace").decode()
            path = path.replace("{" + one["name"] + "}", self.word().replace("%", "%25").replace("?", "%3F"))
        if "{name}" in path or "requestBody" in operation:
            schema = operation.get("requestBody", {}).get("content", {}).get("application/json", {}).get("schema", {})
            data = json.dumps(self.value(schema or {"type": "null"})).encode()
        if "/upload/" in path:
            headers, data = {"content-type": "application/octet-stream"}, b"time [s],x [m]\n0,1\n1,2\n"
            path = f"/api/upload/{self.one_of(['new', 'rig', self.word()])}/{self.one_of(['a.csv', 'b.json', 'c.txt'])}"
        if data and self.random.random() < 0.2:
            mutate = mutated_bytes if self.random.random() < 0.5 else lambda d, r: mutated(d.decode(), r)
            data = mutate(data, self.random)
        if self.random.random() < 0.05:
            method = self.one_of(("get", "post", "put", "delete", "head", "options", "patch"))
        return {"method": method.upper(), "url": path, "params": query, "headers": headers, "content": data}


@pytest.fixture
def served(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[str, Any]]:
    """Address of a server of a project with an experiment, parameter files and a finished job; jobs do not begin."""
    project = tmp_path / "project"
    for place in ("rig", "a/rig"):
        slide(project / place, 1.3 * SIGN + 20.0 * VELOCITY, "coulomb", held_out=True)
    for name in ("stage.toml", "own.toml"):
        (project / name).write_text('extends = "thesis"\n')
    kept = project / "build" / "workbench" / "jobs" / "00001"
    kept.mkdir(parents=True)
    (kept / "job.json").write_text(json.dumps({**JOB, "state": "done", "created": 1.0}))
    (kept / "result.json").write_text("{}")
    np.save(kept / "curves_0.npy", np.arange(5000.0).reshape(2, -1))
    monkeypatch.chdir(project)
    monkeypatch.setattr(JobRunner, "_begin", lambda self, job: None)
    app = create_app(Project(project, Path("build")))
    server = uvicorn.Server(uvicorn.Config(app, port=0, log_level="error", access_log=False, timeout_keep_alive=600))
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    port = server.servers[0].sockets[0].getsockname()[1]
    server.config.loaded_app = Guard(app, frozenset({f"127.0.0.1:{port}"}), TOKEN)  # type: ignore[assignment]
    yield f"http://127.0.0.1:{port}", app
    server.should_exit = True
    thread.join()
    app.state.jobs.close()


def client_of(address: str) -> httpx2.Client:
    return httpx2.Client(base_url=address, cookies={"stagecad": TOKEN}, timeout=60.0)


def ask(address: str, description: dict[str, Any], number: int, seed: int) -> Counter[str]:
    requests, found = Requests(description, seed), Counter[str]()
    with client_of(address) as client:
        for _ in range(number):
            request, began = requests.request(), time.process_time()
            try:
                answer = client.request(**request)
            except (httpx2.InvalidURL, UnicodeEncodeError):
                continue
            assert time.process_time() - began < SLOW, request
            assert answer.status_code < 500, (request, answer.text)
            found[f"{answer.status_code}"] += 1
            if answer.status_code >= 400 and request["method"] != "HEAD":
                error = answer.json()["error"]
                assert error.isprintable() and 0 < len(error) < 1000, (request, error)
    return found


def exchange(served: tuple[str, Any], outer: Path, number: int, seed: int) -> Counter[str]:
    """Counts of the answers to two clients that ask at once; nothing beside the project is touched."""
    address, app = served
    outside = {path: text for path, text in content(outer).items() if "/project/" not in path}
    with ThreadPoolExecutor(2) as clients:
        asked = [clients.submit(ask, address, app.openapi(), number // 2, 2 * seed + k) for k in range(2)]
        found = sum((one.result() for one in asked), Counter[str]())
    assert {path: text for path, text in content(outer).items() if "/project/" not in path} == outside
    return found


def test_requests(served: tuple[str, Any], tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.ERROR):
        found = exchange(served, tmp_path, 150, 5)
    assert not caplog.records and found["200"] > 10 and found["422"] > 10, found


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10, 20))
def test_many_requests(served, tmp_path: Path, caplog, capsys: pytest.CaptureFixture[str], seed: int) -> None:
    with caplog.at_level(logging.ERROR):
        found = exchange(served, tmp_path, count(2_000), seed)
    assert not caplog.records
    with capsys.disabled():
        print(f"\nrequests to the page, seed {seed}: {sum(found.values())}: {dict(found)}")  # noqa: T201


def test_no_change_of_two_clients_is_lost(served: tuple[str, Any]) -> None:
    """Each client changes a value of its own in a state that both have read; one is refused, and repeats its change."""
    address, _ = served
    keys, rounds = ("stage.edge_chamfer", "stage.hole_chamfer"), 12
    both_have_read = threading.Barrier(len(keys))

    def change(key: str) -> int:
        statuses = []
        with client_of(address) as client:
            for step in range(rounds):
                state = client.get("/api/machine").json()
                both_have_read.wait(60.0)
                while True:
                    changes = {**state["changes"], key: f"{0.4 + 0.01 * step:.2f} mm"}
                    body = {"changes": changes, "seen": state["digest"]}
                    answer = client.post("/api/machine/commit", json=body)
                    statuses.append(answer.status_code)
                    if answer.status_code != 409:
                        break
                    state = answer.json()["state"]
                both_have_read.wait(60.0)
        assert statuses.count(200) == rounds
        return statuses.count(409)

    with ThreadPoolExecutor(len(keys)) as clients:
        assert sum(clients.map(change, keys)) == rounds
    with client_of(address) as client:
        assert client.get("/api/machine").json()["changes"] == dict.fromkeys(keys, "0.51 mm")
