"""What reaches the routes, what the page may touch, and what its code may import."""

import ast
import os
import re
import socket
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Route
from starlette.testclient import TestClient

import workbench.page
from stagecad.parameters.errors import InputError
from tests.experiments import record_text, state
from tests.refusals import refused
from workbench.cli import run
from workbench.cli.commands.workbench import LEAST_TOKEN
from workbench.page.project import Project
from workbench.page.security import COOKIE, Guard, allowed_hosts
from workbench.page.server import serve

HOSTS = allowed_hosts("127.0.0.1", 8321)
TOKEN = "a-secret-of-enough-length"


async def _length(request: Request) -> PlainTextResponse:
    return PlainTextResponse(str(sum([len(chunk) async for chunk in request.stream()])))


ROUTES = [Route("/", _length), Route("/{path:path}", _length, methods=["GET", "POST"])]


def _client(token: str | None = None, upload_limit: int = 10_000) -> TestClient:
    guarded = Guard(Starlette(routes=ROUTES), HOSTS, token, upload_limit)
    return TestClient(guarded, base_url="http://127.0.0.1:8321", follow_redirects=False)


def test_the_page_of_this_computer_has_a_strict_policy_and_no_form_of_another_site_posts() -> None:
    answer = _client().get("/")
    assert answer.status_code == 200
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy and "script-src 'self'" in policy and "unsafe" not in policy
    assert answer.headers["x-content-type-options"] == "nosniff"
    client = _client()
    for kind in ("application/x-www-form-urlencoded", "text/plain", "multipart/form-data"):
        assert client.post("/api/machine/undo", content=b"{}", headers={"content-type": kind}).status_code == 415
    assert client.post("/api/machine/undo", json={}).status_code == 200


@pytest.mark.parametrize(
    "headers, status",
    [
        ({"host": "rebound.example:8321"}, 421),
        ({"host": "127.0.0.1:9999"}, 421),
        ({"origin": "http://other.example"}, 403),
        ({"origin": "http://127.0.0.1:9999"}, 403),
        ({"origin": "null"}, 403),
        ({"sec-fetch-site": "cross-site"}, 403),
        ({"sec-fetch-site": "same-site"}, 403),
        ({"origin": "http://127.0.0.1:8321", "sec-fetch-site": "same-origin"}, 200),
    ],
)
def test_other_hosts_and_other_sites_are_refused(headers: dict[str, str], status: int) -> None:
    assert _client().get("/api/about", headers=headers).status_code == status


def test_the_addresses_of_this_computer_are_permitted_where_all_are_listened_on() -> None:
    for every, expected in ((True, 200), (False, 421)):
        guard: Any = Guard(Starlette(routes=ROUTES), allowed_hosts("0.0.0.0", 8321), every_address=every)
        reached = TestClient(guard, base_url="http://192.0.2.2:8321")
        assert reached.get("/").status_code == expected
        assert reached.get("/", headers={"host": "rebound.example:8321"}).status_code == 421


@pytest.mark.parametrize("path", ["/%E2%82%AC", "/%0d%0a", "/%5Cevil.example", "//evil.example"])
def test_a_token_leads_to_an_address_of_this_server(path: str) -> None:
    entered = _client(TOKEN).get(f"http://127.0.0.1:8321{path}", params={"token": TOKEN})
    assert entered.status_code == 303
    place = entered.headers["location"]
    assert place.isascii() and place.startswith("/") and not place.startswith(("//", "/\\")) and "\n" not in place


def test_a_token_is_wanted_once_and_becomes_a_cookie() -> None:
    client = _client(TOKEN)
    assert client.get("/").status_code == 401 and client.get("/", params={"token": "wrong"}).status_code == 401
    entered = client.get("/", params={"token": TOKEN})
    assert "HttpOnly" in entered.headers["set-cookie"] and "samesite=strict" in entered.headers["set-cookie"].lower()
    client.cookies.set(COOKIE, TOKEN)
    assert client.get("/").status_code == 200


def test_without_a_given_token_one_is_chosen_once_for_the_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    given: list[str] = []
    monkeypatch.setattr("workbench.page.server.serve", lambda _project, _host, _port, token, *_: given.append(token))
    for _ in range(2):
        assert run(["workbench", "--no-browser"]) == 0
    assert given[0] == given[1] and len(given[0]) >= LEAST_TOKEN
    file = tmp_path / "stagecad" / "workbench" / "token"
    assert file.read_text() == given[0] and (os.name == "nt" or file.parent.stat().st_mode & 0o077 == 0)
    assert run(["workbench", "--token", "short"]) == 2


def test_a_body_that_is_too_large_is_refused_while_it_comes() -> None:
    client = _client()
    headers = {"content-type": "application/octet-stream"}
    assert client.post("/api/upload/rig/a.csv", content=b"x" * 10_000, headers=headers).text == "10000"
    assert client.post("/api/upload/rig/a.csv", content=b"x" * 10_001, headers=headers).status_code == 413

    def chunks():
        # Without a length in its head, the limit can only be noticed on the way.
        for _ in range(11):
            yield b"x" * 1000

    assert client.post("/api/upload/rig/a.csv", content=chunks(), headers=headers).status_code == 413


@pytest.mark.parametrize("path", ["../out", "/etc/passwd", "rig/../../outside", ".git/config", "a\\b", "a\0b", "link"])
def test_nothing_outside_the_project_is_reached(tmp_path: Path, path: str) -> None:
    folder = tmp_path / "project"
    folder.mkdir()
    (folder / "link").symlink_to(tmp_path)
    refused("project", Project(folder, Path("build")).inside, path)
    assert Project(folder, Path("build")).inside("rig/fit.csv") == folder / "rig" / "fit.csv"


@pytest.mark.parametrize("file", ["../fit.csv", "fit.csv", "../../fit.csv", "../link/fit.csv"])
def test_records_beside_the_folder_of_an_experiment_are_of_the_project(tmp_path: Path, file: str) -> None:
    """As `stagecad new experiment rig fit.csv` names them."""
    folder = tmp_path / "project"
    (folder / "rig").mkdir(parents=True)
    (folder / "link").symlink_to(tmp_path)
    state(folder / "rig", record_text(file))
    with nullcontext() if file in ("../fit.csv", "fit.csv") else pytest.raises(InputError, match="project"):
        assert Project(folder, Path("build")).experiment("rig") == folder / "rig"


def test_a_connection_waits_as_soon_as_the_address_is_printed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uvicorn.Server, "run", lambda server, sockets: None)
    printed = []

    def note(text: str) -> None:
        found = re.search(r"http://127\.0\.0\.1:(\d+)/", text)
        assert found
        socket.create_connection(("127.0.0.1", int(found[1])), 5.0).close()
        printed.append(text)

    serve(Project(tmp_path, tmp_path / "build", None, False), "127.0.0.1", 0, None, note, browser=False)
    assert len(printed) == 1


PAGE = Path(workbench.page.__file__).parent
PROJECT = ("stagecad", "designcalc", "drawings", "sim", "sysid", "workbench")
ALLOWED = ("workbench.operations", "workbench.figures", "workbench.page", "stagecad.parameters")
"""The parameter file is the input of the interface, and its errors are those of all layers."""
EXCEPTIONS = {"stagecad.__version__": "shown on the page", "stagecad.processes": "jobs run in processes of their own"}
FILES = sorted(PAGE.rglob("*.py"))


def _imports(file: Path) -> Iterator[str]:
    """Full names of what a file imports from the project, inside functions too."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative imports are not looked at"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def _under(name: str, prefix: str) -> bool:
    return name == prefix or name.startswith(f"{prefix}.")


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.relative_to(PAGE).as_posix())
def test_the_page_imports_the_python_interface_alone(file: Path) -> None:
    own = [name for name in _imports(file) if name.split(".")[0] in PROJECT]
    assert [name for name in own if not any(_under(name, one) for one in (*ALLOWED, *EXCEPTIONS))] == []


def test_every_exception_is_used() -> None:
    found = [name for file in FILES for name in _imports(file)]
    assert [one for one in EXCEPTIONS if not any(_under(name, one) for name in found)] == []
