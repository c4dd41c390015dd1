"""Processes started ahead of a pool: loaded once, forked, ended together, and none left."""

from __future__ import annotations

import os
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from stagecad.parallel import TimeLimit, parallel_map, processors
from stagecad.schedule import Order
from stagecad.worker_process import started_ahead
from tests.stagecad.pool_functions import die_once, square, wait_until_ended

forks = pytest.mark.skipif(
    not sys.platform.startswith("linux") or processors() == 1, reason="needs fork and two processors"
)

LOADED: list[int] = []


def load() -> None:
    LOADED.append(os.getpid())


def load_and_die() -> None:
    os._exit(3)


def cannot_load() -> None:
    raise ImportError("no such library")


def process_and_loaded(n: int) -> tuple[int, list[int]]:
    return os.getpid(), LOADED


def letter(n: int) -> str:
    return "b" if n == 2 else "a"


def test_a_process_started_ahead_takes_the_items_of_its_kind() -> None:
    with started_ahead(load, "a") as ahead:
        order = Order(kind=letter, ahead=ahead)
        (first, loaded), (other, nothing) = parallel_map(process_and_loaded, [0, 2], workers=2, order=order)
    assert loaded == [first] and other != first and nothing == []
    assert not ahead[0].waits


def test_it_is_taken_also_for_items_of_another_kind() -> None:
    with started_ahead(load, "a") as ahead:
        order = Order(kind=letter, ahead=ahead)
        results = parallel_map(process_and_loaded, [2, 2], workers=1, order=order, limit=TimeLimit(60.0))
    assert all(loaded == [process] for process, loaded in results)


def meet(folder: Path, n: int) -> tuple[int, list[int]]:
    """Waits until the other item has begun, too."""
    (folder / str(n)).touch()
    while not (folder / str(1 - n)).exists():
        time.sleep(0.01)
    return os.getpid(), LOADED


@forks
def test_processes_started_ahead_load_once(tmp_path: Path) -> None:
    with started_ahead(load, "a", 2) as ahead:
        order = Order(kind=lambda _: "a", ahead=ahead)
        (one, loaded), (two, there) = parallel_map(partial(meet, tmp_path), [0, 1], workers=2, order=order)
    assert one != two and loaded == there and len(loaded) == 1 and loaded[0] in (one, two)
    wait_until_ended(one, two)


@pytest.mark.parametrize("loading", [load_and_die, cannot_load])
@pytest.mark.parametrize("count", [1, 2])
def test_items_are_computed_whatever_becomes_of_the_processes_started_ahead(loading, count: int) -> None:
    with started_ahead(loading, "a", count) as ahead:
        assert parallel_map(square, [2, 3], workers=2, order=Order(kind=lambda _: "a", ahead=ahead)) == [4, 9]


@forks
@pytest.mark.parametrize("died", [0, 1])
def test_an_item_is_computed_again_where_one_of_the_processes_started_ahead_ends(tmp_path: Path, died: int) -> None:
    with started_ahead(load, "a", 2) as ahead:
        order = Order(kind=lambda _: "a", ahead=ahead)
        assert parallel_map(partial(die_once, tmp_path), [died, 1 - died, 2], workers=2, order=order) == [
            died,
            1 - died,
            2,
        ]


def die_beside_another(folder: Path, n: int) -> int:
    """Item 1 ends its process the first time, while item 0 is computed; item 0 ends only once it is begun again."""
    if n == 0:
        begun = len(list(folder.glob("begun*")))
        (folder / f"begun {begun}").touch()
        deadline = time.monotonic() + 60.0
        while begun == 0 and time.monotonic() < deadline:
            time.sleep(0.01)
        return begun
    while not (folder / "begun 0").exists():
        time.sleep(0.01)
    return die_once(folder, n)


@forks
@pytest.mark.parametrize("items", [[0, 1], [1, 0]])
def test_processes_started_ahead_end_together_and_their_items_are_begun_again(tmp_path: Path, items: list[int]) -> None:
    with started_ahead(load, "a", 2) as ahead:
        order = Order(kind=lambda _: "a", ahead=ahead)
        assert parallel_map(partial(die_beside_another, tmp_path), items, workers=2, order=order) == [1, 1]


def sleep_if_first(n: int) -> int:
    if n == 0:
        start = time.process_time()
        while time.process_time() - start < 60.0:
            pass
    return n


@forks
@pytest.mark.parametrize("items", [[0, 1], [1, 0]])
def test_the_time_limit_ends_processes_started_ahead(items: list[int]) -> None:
    limit = TimeLimit(0.5, fallback=square)
    with started_ahead(load, "a", 2) as ahead:
        order = Order(kind=lambda _: "a", ahead=ahead)
        assert parallel_map(sleep_if_first, items, workers=2, order=order, limit=limit) == items


def test_processes_started_ahead_that_no_pool_takes_are_ended() -> None:
    with started_ahead(load, "a", 2) as ahead:
        assert all(one.waits for one in ahead)
    assert not any(one.waits for one in ahead)
    assert ahead[0]._process is not None and not ahead[0]._process.is_alive()


@forks
def test_a_forked_process_that_no_pool_takes_is_ended() -> None:
    with started_ahead(load, "a", 2) as ahead:
        process = ahead[1]._pipe.recv()
        assert Path(f"/proc/{process}").exists()
    wait_until_ended(process)
