"""Jobs in processes of their own: result, fault of the input, failure, death of the process, cancel, a new start."""

import os
from pathlib import Path

import pytest

from tests.process_state import running, wait_until
from tests.refusals import refused
from workbench.page import job_process
from workbench.page.jobs import KEPT_PASSING, Job, JobRunner

TASKS = """
import os, subprocess, sys, time
from stagecad.parameters.errors import InputError

def double(value, folder, report):
    report("doubling", 1, 2)
    return {"value": 2 * value, "nothing": float("nan"), "process": os.getpid()}

def refuse(folder, report):
    raise InputError("rig.csv: row 3: is not a number")

def fail(folder, report):
    raise ZeroDivisionError("by zero")

def die(folder, report):
    os._exit(7)

def work(folder, report):
    report(str(os.getpid()), 0, 0)
    while True:
        time.sleep(0.01)
"""


@pytest.fixture
def runner(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    # The tasks are a module of the page's package for the processes that are started, too.
    package = tmp_path / "package"
    package.mkdir()
    (package / "page_test_tasks.py").write_text(TASKS)
    (package / "sitecustomize.py").write_text(
        "import workbench.page.job_process as p\n"
        "p.TASKS.update(dict.fromkeys(('double', 'refuse', 'fail', 'die', 'work'), 'test_tasks'))\n"
        "import sys, page_test_tasks\nsys.modules['workbench.page.test_tasks'] = page_test_tasks\n"
    )
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(package), str(Path.cwd()), os.environ.get("PYTHONPATH", "")]))
    made = JobRunner(tmp_path / "jobs", tmp_path)
    yield made
    made.close()


def _submit(runner: JobRunner, task: str, **arguments) -> Job:
    return runner.submit("simulation", task, arguments, title=task)


def _ended(job: Job, seconds: float = 240.0) -> Job:
    wait_until(lambda: job.state not in ("waiting", "running"), seconds)
    return job


def _running(job: Job) -> int:
    """Process id of a job `work`, once it runs."""
    wait_until(lambda: job.step)
    return int(job.step)


def test_every_end_of_a_job_and_the_process_serves_the_next(runner: JobRunner, tmp_path: Path) -> None:
    first = _ended(_submit(runner, "double", value=21))
    assert (first.state, first.step, first.done, first.total) == ("done", "doubling", 1, 2)
    result = runner.result(first.number)
    assert result["value"] == 42 and result["nothing"] is None and result["process"] != os.getpid()
    faulty = _ended(_submit(runner, "refuse"))
    assert (faulty.state, faulty.error, faulty.details) == ("failed", "rig.csv: row 3: is not a number", "")
    failed = _ended(_submit(runner, "fail"))
    assert failed.state == "failed" and failed.error == "ZeroDivisionError: by zero" and "Traceback" in failed.details
    again = runner.result(_ended(_submit(runner, "double", value=1)).number)
    assert again["process"] == result["process"]
    dead = _ended(_submit(runner, "die"))
    ended = "its process ended without a result"
    # The status is lost where two threads ask for it at once.
    assert dead.state == "failed" and dead.error in (f"{ended} (exit status 7)", ended)
    assert runner.result(_ended(_submit(runner, "double", value=2)).number)["process"] != result["process"]
    refused("no result", runner.result, dead.number)
    # A new server finds what was finished.
    later = JobRunner(tmp_path / "jobs", tmp_path)
    assert later.result(first.number) == result and later.get(dead.number).error == dead.error
    later.close()


def test_cancel_ends_the_process_and_the_queue_goes_on(runner: JobRunner) -> None:
    job = _submit(runner, "work")
    process = _running(job)
    replaced = runner.submit("simulation", "double", {"value": 1}, title="double", replaces=True)
    waiting = runner.submit("simulation", "double", {"value": 3}, title="double", replaces=True)
    assert replaced.state == "cancelled" and waiting.state == "waiting"
    runner.cancel(job.number)
    assert job.state == "cancelled"
    assert runner.result(_ended(waiting).number)["value"] == 6
    assert not running(process)
    assert runner.cancel(waiting.number).state == "done"


def test_closing_ends_all_processes(runner: JobRunner) -> None:
    job = _submit(runner, "work")
    process = _running(job)
    runner.close()
    wait_until(lambda: not running(process))
    assert job.state == "cancelled"


def test_a_lane_survives_that_no_process_can_be_started(runner: JobRunner, tmp_path: Path) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    here = Path.cwd()
    os.chdir(gone)
    gone.rmdir()
    try:
        failed = _ended(_submit(runner, "double", value=1))
    finally:
        os.chdir(here)
    assert failed.state == "failed" and "no process can be started" in failed.error
    assert runner.result(_ended(_submit(runner, "double", value=4)).number)["value"] == 8


def test_a_result_that_cannot_be_written_is_a_failure(runner: JobRunner) -> None:
    job = _submit(runner, "work")
    _running(job)
    after = _submit(runner, "double", value=1)
    # A file stands where the folder of the job belongs.
    runner.folder.mkdir(exist_ok=True)
    runner.job_folder(after).write_text("")
    runner.cancel(job.number)
    assert "cannot be written" in _ended(after).error


def test_every_task_exists_and_answers_to_a_slider_are_not_kept(runner: JobRunner) -> None:
    for value in range(KEPT_PASSING + 2):
        job = _ended(runner.submit("simulation", "double", {"value": value}, title="Slider", passing=True))
        assert runner.result(job.number)["value"] == 2 * value
    # The folder of the oldest answer goes after the newest answer has been reported.
    wait_until(lambda: len(list(runner.folder.iterdir())) == KEPT_PASSING)
    assert len(runner.jobs) == KEPT_PASSING
    assert not [folder for folder in runner.folder.iterdir() if (folder / "job.json").exists()]
    from importlib import import_module

    for task, module in job_process.TASKS.items():
        assert callable(getattr(import_module(f"workbench.page.{module}"), task)), task
