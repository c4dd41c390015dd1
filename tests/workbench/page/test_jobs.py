"""Jobs in processes of their own and how each may end; what they compute, and curves that lose no spike."""

import os
import shutil
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.process_state import running, wait_until
from tests.refusals import refused
from workbench.page import job_process
from workbench.page.curves import extremes, read_curves, sampled, write_curves
from workbench.page.jobs import KEPT_PASSING, Job, JobRunner
from workbench.page.tasks import measurement

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
    assert runner.result(_ended(_submit(runner, "double", value=1)).number)["process"] == result["process"]
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


EXAMPLE = Path(__file__).parents[3] / "examples" / "own_rig"


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(shutil.copytree(EXAMPLE, tmp_path_factory.mktemp("project") / "rig"))


def _common(rig: Path, folder: str) -> dict[str, Any]:
    places = {"experiment": str(rig), "out": str(rig.parent / "build"), "folder": str(rig.parent / folder)}
    return {**places, "params": None, "report": lambda *step: None}


def test_a_slider_changes_the_prediction_as_the_law_says(rig: Path, monkeypatch) -> None:
    # The figures of the report take longer than all the rest.
    written = "workbench.operations.measurement.compare.Comparison.write_report"
    monkeypatch.setattr(written, lambda *rest: rig / "report.html")
    compared = measurement.compare(**_common(rig, "compare"))
    force = {one["key"]: one for one in compared["sliders"]}["coulomb.force"]
    assert force["low"] == pytest.approx(0.5 * force["value"]) and force["high"] == pytest.approx(1.5 * force["value"])
    first = compared["overlays"][0]
    where = {"record": first["record"], "channel": first["channel"]}
    same = measurement.predict(values={}, **where, **_common(rig, "same"))
    before = compared["document"]["before"]["fit"]["drive_force"]["over_noise"]
    assert same["over_noise"]["fit"]["drive_force"] == pytest.approx(before, rel=1e-6)
    wider = {"coulomb.force": force["value"] + 0.1, "unknown.key": 3.0}
    found = measurement.predict(values=wider, **where, **_common(rig, "moved"))
    (overlay,) = found["overlays"]
    series = dict(zip(overlay["series"], read_curves(rig.parent / "moved", overlay["curves"]), strict=True))
    change = (series["moved"] - series["model"])[np.isfinite(series["moved"])]
    # Coulomb friction of 0.1 N more has the sign of the velocity; filtering smooths its reversals.
    assert np.quantile(np.abs(change), 0.5) == pytest.approx(0.1, rel=0.05)
    assert change.min() < -0.09 and change.max() > 0.09
    assert found["over_noise"]["fit"]["drive_force"] > 2.0 * same["over_noise"]["fit"]["drive_force"]


def test_curves_by_extremes_samples_and_pairs(tmp_path: Path) -> None:
    time = np.linspace(0.0, 100.0, 1_000_000)
    values = np.sin(time)
    values[123_456], values[765_432] = 50.0, -40.0
    described = write_curves(tmp_path, 0, {"time": time, "force": values})
    assert described["rows"] == 1_000_000 and described["series"] == ["time", "force"]
    curves = read_curves(tmp_path, 0)
    found = extremes(curves, [1], None, None, 1200)
    assert found.shape == (2, 2400) and found[1].max() == 50.0 and found[1].min() == -40.0
    assert np.all(np.diff(found[0]) > 0.0)
    random = np.random.default_rng(4)
    time, values = np.arange(400_001.0), random.normal(size=400_001)
    values[1000:9000] = np.nan
    write_curves(tmp_path, 0, {"time": time, "force": values})
    curves = read_curves(tmp_path, 0)
    found = extremes(curves, [1], 100_000.5, 399_000.0, 300)
    ends = np.append(found[0, 0::2], 399_002.0).astype(int)
    assert ends[0] == 100_000
    for k, (a, b) in enumerate(pairwise(ends)):
        assert (found[1, 2 * k], found[1, 2 * k + 1]) == (values[a:b].min(), values[a:b].max())
    whole = extremes(curves, [1], None, None, 400)
    assert np.nanmin(whole[1]) == np.nanmin(values) and np.nanmax(whole[1]) == np.nanmax(values)
    assert np.isnan(whole[1]).any()
    refused("curves 3", read_curves, tmp_path, 3)
    time = np.arange(100_000.0)
    values = time.copy()
    values[50_010:50_020] = np.nan
    found = extremes(np.vstack([time, values]), [1], 50_000.0, 50_100.0, 800)
    assert found[0][0] == 49_999.0 and found[0][-1] == 50_101.0 and np.isnan(found[1]).sum() == 10
    assert np.isnan(extremes(np.vstack([time, np.full(time.size, np.nan)]), [1], None, None, 100)[1]).all()
    time = np.linspace(0.0, 1.0, 5001)
    found = sampled(np.vstack([time, time**2, time**3]), [1, 2], 0.2, 0.8, 400)
    assert found.shape[1] <= 400 and found[0][0] >= 0.2 and found[0][-1] <= 0.8
    assert found[1] == pytest.approx(found[0] ** 2) and found[2] == pytest.approx(found[0] ** 3)
