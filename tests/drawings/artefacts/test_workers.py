"""Tasks in other processes: results, errors as they were raised, and a task that hangs."""

from __future__ import annotations

import os
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from drawings.artefacts.workers import run_tasks
from stagecad.parameters.errors import InputError


def double(name: str, late: bool) -> str:
    return name * 2


def fail(name: str, late: bool) -> str:
    if name == "b":
        raise InputError("no such thing")
    return name


def hang(folder: Path, name: str, late: bool) -> str:
    (folder / f"{name}_{late}").touch()
    while name == "slow" and not late:
        pass
    return "late" if late else "in time"


def die(name: str, late: bool) -> str:
    os._exit(3)


def test_results_come_back_by_name_and_are_told_as_they_come() -> None:
    told: list[str] = []
    assert run_tasks(["a", "b", "c"], double, told.append, workers=2) == {"a": "aa", "b": "bb", "c": "cc"}
    assert sorted(told) == ["a", "b", "c"]
    assert run_tasks([], double) == {}


def test_an_error_is_the_task_s_own() -> None:
    with pytest.raises(InputError, match="no such thing"):
        run_tasks(["a", "b"], fail, workers=1)


def test_a_task_that_hangs_is_given_once_more_as_late(tmp_path: Path) -> None:
    results = run_tasks(["slow", "quick"], partial(hang, tmp_path), workers=1, limit=2.0)
    assert results == {"slow": "late", "quick": "in time"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["quick_False", "slow_False", "slow_True"]


def noted(folder: Path, name: str, late: bool) -> list[str]:
    done = sorted(path.name for path in folder.iterdir())
    (folder / name).touch()
    return done


def test_a_task_waits_for_what_it_needs_while_others_go_on(tmp_path: Path) -> None:
    needs = {"sheet": ("picture", "part"), "picture": ("part",)}
    found = run_tasks(["sheet", "picture", "part", "other"], partial(noted, tmp_path), workers=2, needs=needs)
    assert {"picture", "part"} <= set(found["sheet"])
    assert "part" in found["picture"]
    assert list(found) == ["sheet", "picture", "part", "other"]


def test_a_process_that_ends_is_an_error() -> None:
    with pytest.raises(RuntimeError, match="ended without a result"):
        run_tasks(["a"], die)


def wait_long(name: str, late: bool) -> bool:
    time.sleep(3.0)
    return late


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="time of day is what there is elsewhere")
def test_waiting_is_not_hanging() -> None:
    assert run_tasks(["a"], wait_long, limit=2.0) == {"a": False}
