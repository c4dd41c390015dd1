"""The server of the page, as it starts."""

import re
import socket
from pathlib import Path

import pytest
import uvicorn

from workbench.page.project import Project
from workbench.page.server import serve


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
