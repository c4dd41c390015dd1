"""What reaches the routes: hosts, origins, tokens, sizes; and what the page may touch."""

from pathlib import Path

import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Route
from starlette.testclient import TestClient

from stagecad.parameters.errors import InputError
from workbench.page.project import Project
from workbench.page.security import COOKIE, Guard, allowed_hosts

HOSTS = allowed_hosts("127.0.0.1", 8321)
TOKEN = "a-secret-of-enough-length"


async def _length(request: Request) -> PlainTextResponse:
    return PlainTextResponse(str(sum([len(chunk) async for chunk in request.stream()])))


def _client(token: str | None = None, upload_limit: int = 10_000) -> TestClient:
    routes = [Route("/", _length), Route("/{path:path}", _length, methods=["GET", "POST"])]
    guarded = Guard(Starlette(routes=routes), HOSTS, token, upload_limit)
    return TestClient(guarded, base_url="http://127.0.0.1:8321", follow_redirects=False)


def test_the_page_of_this_computer_is_answered_with_a_strict_content_policy() -> None:
    answer = _client().get("/")
    assert answer.status_code == 200
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy and "script-src 'self'" in policy and "unsafe" not in policy
    assert answer.headers["x-content-type-options"] == "nosniff"


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


def test_a_form_of_another_site_cannot_post() -> None:
    client = _client()
    for kind in ("application/x-www-form-urlencoded", "text/plain", "multipart/form-data"):
        assert client.post("/api/machine/undo", content=b"{}", headers={"content-type": kind}).status_code == 415
    assert client.post("/api/machine/undo", json={}).status_code == 200


def test_a_token_is_wanted_once_and_becomes_a_cookie() -> None:
    client = _client(TOKEN)
    assert client.get("/").status_code == 401
    assert client.get("/", params={"token": "wrong"}).status_code == 401
    entered = client.get("http://127.0.0.1:8321//evil.example", params={"token": TOKEN})
    assert entered.status_code == 303
    assert entered.headers["location"] == "/evil.example"
    assert "HttpOnly" in entered.headers["set-cookie"] and "samesite=strict" in entered.headers["set-cookie"].lower()
    client.cookies.set(COOKIE, TOKEN)
    assert client.get("/").status_code == 200


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


@pytest.mark.parametrize(
    "path", ["../outside", "/etc/passwd", "rig/../../outside", ".git/config", "a\\b", "a\0b", "link"]
)
def test_nothing_outside_the_project_is_reached(tmp_path: Path, path: str) -> None:
    folder = tmp_path / "project"
    folder.mkdir()
    (folder / "link").symlink_to(tmp_path)
    with pytest.raises(InputError, match="project"):
        Project(folder, Path("build")).inside(path)
    assert Project(folder, Path("build")).inside("rig/fit.csv") == folder / "rig" / "fit.csv"


def test_code_of_an_experiment_is_refused_without_trust(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "rig").mkdir()
    (tmp_path / "rig" / "experiment.toml").write_text('[model]\neffects = []\ncustom = ["own.py"]\n')
    with pytest.raises(InputError, match="--trust"):
        Project(tmp_path, Path("build")).experiment("rig")
    (tmp_path / "rig" / "own.py").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    assert Project(tmp_path, Path("build"), trust=True).experiment("rig").name == "rig"
