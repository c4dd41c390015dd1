"""A forked process does its work while this one goes on."""

from __future__ import annotations

import sys
import threading
from pathlib import Path

import pytest

from stagecad import background
from stagecad.background import forked


@pytest.mark.skipif(sys.platform != "linux", reason="forks on Linux alone")
def test_the_process_works_beside_this_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background, "processors", lambda: 2)
    monkeypatch.setattr(background, "inside_worker", lambda: False)
    begin, end = tmp_path / "begin", tmp_path / "end"
    found = threading.Event()

    def work() -> None:
        while not begin.exists():
            found.wait(0.01)
        end.write_text("done")

    process = forked(work)
    assert process is not None and not end.exists()
    begin.touch()
    process.join()
    assert end.read_text() == "done"


def test_no_process_where_it_saves_no_time_or_is_not_safe(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background, "processors", lambda: 1)
    assert forked(lambda: None) is None
    monkeypatch.setattr(background, "processors", lambda: 2)
    monkeypatch.setattr(background, "inside_worker", lambda: True)
    assert forked(lambda: None) is None
    monkeypatch.setattr(background, "inside_worker", lambda: False)
    found: list[object] = []
    thread = threading.Thread(target=lambda: found.append(forked(lambda: None)))
    thread.start()
    thread.join()
    assert found == [None]
