"""The process pool: order, errors, time limits, ended workers, Ctrl-C, and workers that outlive nothing."""

import multiprocessing
import os
import signal
import sys
import threading
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from stagecad import processes
from stagecad.parameters.errors import InputError
from stagecad.processes import TimeLimit, fork_map, inside_worker, parallel_map, processors
from tests.process_state import begun, python, running, wait_until
from tests.stagecad.pool_functions import die_once, square

LINUX = sys.platform.startswith("linux")
forks = pytest.mark.skipif(not LINUX or processors() == 1, reason="needs fork and two processors")


def fail(n: int) -> int:
    if n == 1:
        raise InputError("no such thing")
    return n


class TwoArgumentsError(Exception):
    """Pickles, but cannot be read back."""

    def __init__(self, one: str, two: str) -> None:
        super().__init__(one)


def fail_unpicklably(n: int) -> int:
    raise TwoArgumentsError("one", "two")


def give_unpicklable(n: int) -> threading.Lock:
    return threading.Lock()


def die(n: int) -> int:
    if inside_worker():
        os._exit(3)
    return n


def loop(folder: Path, name: str) -> str:
    (folder / name).touch()
    while name == "slow":
        pass
    return "first"


def fallback(folder: Path, name: str) -> str:
    (folder / f"{name} fallback").touch()
    return "fallback"


def sleep(seconds: float) -> float:
    time.sleep(seconds)
    return seconds


def noted(folder: Path, name: str) -> list[str]:
    done = sorted(path.name for path in folder.iterdir())
    (folder / name).touch()
    return done


def mapped_inside(n: int) -> tuple[bool, list[int], list[int]]:
    here = os.getpid()
    pids = [*parallel_map(pid_of, [1, 2], workers=2), *fork_map(pid_of, [1, 2])]
    return inside_worker(), [pid - here for pid in pids], parallel_map(square, [n, n + 1], workers=2)


def pid_of(n: int) -> int:
    return os.getpid()


def threads_of(n: int) -> set[int]:
    np.linalg.solve(np.eye(3), np.ones(3))
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_results_in_order_and_exceptions_of_tasks() -> None:
    completed: list[int] = []
    assert parallel_map(square, range(11), progress=completed.append, workers=2) == [n * n for n in range(11)]
    assert sorted(completed) == list(range(11))
    assert parallel_map(square, []) == []
    with pytest.raises(InputError, match=r"^no such thing") as caught:
        parallel_map(fail, [0, 1, 2], workers=2)
    assert "in fail" in caught.value.__notes__[0]
    assert len(parallel_map(give_unpicklable, [1, 2], workers=2)) == 2
    with pytest.raises(TwoArgumentsError, match="one"):
        parallel_map(fail_unpicklably, [1, 2], workers=2)


def test_a_task_that_exceeds_the_time_limit_is_replaced_by_the_fallback_or_an_error(tmp_path: Path) -> None:
    limit = TimeLimit(1.0, partial(fallback, tmp_path))
    assert parallel_map(partial(loop, tmp_path), ["slow", "quick"], workers=1, limit=limit) == ["fallback", "first"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["quick", "slow", "slow fallback"]
    with pytest.raises(TimeoutError, match="'slow' took more than 1 s"):
        parallel_map(partial(loop, tmp_path), ["slow"], limit=TimeLimit(1.0))


@pytest.mark.skipif(not LINUX, reason="elsewhere the limit is of elapsed time")
def test_the_limit_is_of_processor_time() -> None:
    assert parallel_map(sleep, [1.5], limit=TimeLimit(1.0)) == [1.5]


def test_a_task_waits_for_those_it_requires_while_others_go_on(tmp_path: Path) -> None:
    names = ["sheet", "picture", "part", "other"]
    requires = {"sheet": ("picture", "part"), "picture": ("part",)}
    for workers in (1, 2):
        folder = tmp_path / str(workers)
        folder.mkdir()
        sheet, picture, _, _ = parallel_map(partial(noted, folder), names, workers=workers, requires=requires)
        assert {"picture", "part"} <= set(sheet)
        assert "part" in picture


def test_a_worker_that_ends_gives_its_item_to_another_once(tmp_path: Path) -> None:
    assert parallel_map(partial(die_once, tmp_path), [0, 1, 2], workers=2) == [0, 1, 2]
    with pytest.raises(RuntimeError, match=r"[78]: its process ended without a result, twice"):
        parallel_map(die, [7, 8], workers=2)


def test_one_item_one_worker_and_calls_inside_a_worker_compute_in_one_process() -> None:
    for found in (*parallel_map(mapped_inside, [1, 2], workers=2), *fork_map(mapped_inside, [1, 2])):
        inside, other_processes, squares = found
        assert inside or processors() == 1
        assert other_processes == [0, 0, 0, 0]
        assert squares in ([1, 4], [4, 9])
    assert not inside_worker()
    assert parallel_map(pid_of, [1]) == [os.getpid()] and parallel_map(pid_of, [1, 2], workers=1) == [os.getpid()] * 2
    assert fork_map(pid_of, [1]) == [os.getpid()]


@forks
def test_workers_use_one_thread_for_linear_algebra() -> None:
    for threads in (*parallel_map(threads_of, [1, 2], workers=2), *fork_map(threads_of, [1, 2])):
        assert threads == {1}


# One cluster for all tests of it: they go to one test process.
def test_a_dask_cluster_gives_the_same_results_and_errors(cluster: str) -> None:
    completed: list[int] = []
    assert parallel_map(partial(pow, 2), range(5), scheduler=cluster, progress=completed.append) == [1, 2, 4, 8, 16]
    assert sorted(completed) == list(range(5))


def test_forked_workers_inherit_closures_and_do_each_item_once(tmp_path: Path) -> None:
    laws = {n: (lambda x, n=n: n * x) for n in range(6)}
    found = fork_map(lambda n: {"of": (laws[n], laws[n](2))}, list(laws), list(laws.values()))
    assert all(found[n]["of"][0] is laws[n] and found[n]["of"][1] == 2 * n for n in laws)

    def work(n: int) -> int:
        with (tmp_path / str(n)).open("a") as file:
            file.write("x")
        return n

    completed: list[int] = []
    assert fork_map(work, list(range(300)), progress=completed.append) == list(range(300))
    assert {file.read_text() for file in tmp_path.iterdir()} == {"x"}
    assert sorted(completed) == list(range(300))
    assert fork_map(work, []) == []


@forks
def test_whichever_worker_is_free_takes_the_next_item() -> None:
    def work(seconds: float) -> int:
        time.sleep(seconds)
        return os.getpid()

    pids = fork_map(work, [1.0, *[0.02] * 5])
    assert pids.count(pids[0]) == 1 and os.getpid() not in pids


def test_what_a_forked_worker_cannot_return_is_computed_in_this_process() -> None:
    assert [answer() for answer in fork_map(lambda n: lambda: n + 1, [1, 2, 3])] == [2, 3, 4]

    def work(n: int) -> int:
        if inside_worker():
            os.kill(os.getpid(), signal.SIGKILL)
        return -n

    assert fork_map(work, [1, 2, 3]) == [-1, -2, -3]


def test_an_exception_of_a_forked_worker_is_raised_and_nothing_is_printed(capfd: pytest.CaptureFixture[str]) -> None:
    def work(n: int) -> int:
        sys.stdout.write(f"{n}\n")
        if n == 1:
            raise ValueError("one")
        return n

    with pytest.raises(ValueError, match="one"):
        fork_map(work, [0, 1, 2])
    with pytest.raises(KeyboardInterrupt):
        fork_map(lambda n: (_ for _ in ()).throw(KeyboardInterrupt) if n == 0 else n, [0, 1])
    if processors() > 1 and LINUX:
        assert capfd.readouterr() == ("", "")


def test_fork_map_outside_of_the_main_thread_computes_there() -> None:
    found: list[int] = []
    thread = threading.Thread(target=lambda: found.extend(fork_map(pid_of, [1, 2])))
    thread.start()
    thread.join()
    assert found == [os.getpid()] * 2


PROGRAM = """
import os, sys, time
from pathlib import Path
from stagecad.processes import fork_map, parallel_map

def spin(name):
    Path(sys.argv[2], f"{name} {os.getpid()}").touch()
    while True:
        pass

if __name__ == "__main__":
    if sys.argv[1] == "fork":
        fork_map(lambda name: spin(name), ["a", "b"])
    else:
        parallel_map(spin, ["a", "b"], workers=2)
"""


@pytest.mark.skipif(not LINUX, reason="needs process groups, and processes looked up in /proc")
@pytest.mark.parametrize("method", ["spawn", pytest.param("fork", marks=forks)])
@pytest.mark.parametrize("end", ["interrupt", "kill"])
def test_no_worker_outlives_an_interrupt_or_the_death_of_its_parent(tmp_path: Path, method: str, end: str) -> None:
    """Ctrl-C as a terminal sends it: to the program and to every process it has started."""
    program, folder = tmp_path / "program.py", tmp_path / "begun"
    program.write_text(PROGRAM)
    folder.mkdir()
    started = begun(program, method, folder)
    wait_until(lambda: len(list(folder.iterdir())) == 2)
    workers = [int(path.name.split()[1]) for path in folder.iterdir()]
    if end == "interrupt":
        os.killpg(started.pid, signal.SIGINT)
    else:
        started.kill()
    errors = started.communicate(timeout=240)[1]
    wait_until(lambda: not any(map(running, workers)))
    if end == "interrupt":
        # Only the program itself reports the interrupt.
        assert errors.count("Traceback") == 1 and errors.rstrip().endswith("KeyboardInterrupt")


SCRIPT = """
import math
from stagecad.processes import parallel_map
print(parallel_map(math.sqrt, [4.0, 9.0, 16.0], workers=2))
"""
GUARDED = """
from stagecad.processes import parallel_map
def twice(x):
    return 2 * x
if __name__ == "__main__":
    print(parallel_map(twice, [4.0, 9.0, 16.0], workers=2))
"""


@pytest.mark.parametrize(("text", "printed"), [(SCRIPT, "[2.0, 3.0, 4.0]"), (GUARDED, "[8.0, 18.0, 32.0]")])
def test_a_plain_script_runs_once(tmp_path: Path, text: str, printed: str) -> None:
    """Without a guard for its main module, as notebooks and short scripts are; with one its functions are found."""
    script = tmp_path / "script.py"
    script.write_text(text)
    done = python(script)
    assert (done.stdout.strip(), done.stderr) == (printed, "")


def test_a_daemonic_process_starts_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a worker of a dask cluster with its nanny."""
    monkeypatch.setitem(multiprocessing.current_process()._config, "daemon", True)
    assert parallel_map(pid_of, [1, 2], workers=2, isolate=True) == [os.getpid()] * 2


@pytest.mark.parametrize("inside", [False, True])
def test_items_that_take_long_are_computed_in_several_threads(inside: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "processors", lambda: 2)
    monkeypatch.setattr(processes, "_inside_worker", inside)
    threads: set[int] = set()

    def slow_square(item: int) -> int:
        threads.add(threading.get_ident())
        time.sleep(2.0 * processes.LONG)
        return item**2

    assert processes.map_threads(slow_square, range(6)) == [0, 1, 4, 9, 16, 25]
    assert (len(threads) > 1) is not inside
