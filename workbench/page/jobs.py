"""Jobs: work that takes longer than a request, in processes of their own, one for each kind of work.

A lane is a process and its queue. The process stays for the next job, since loading the CAD kernel or the compiled
effects takes seconds; to cancel a running job, its process is killed, with all processes that it started, and the next
job gets a new one. Finished jobs are kept as files, so that a page finds them after a reload or a new start.
"""

from __future__ import annotations

import itertools
import json
import multiprocessing
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from workbench.operations.result import finite
from workbench.page.job_process import serve

State = Literal["waiting", "running", "done", "failed", "cancelled"]
LANES = ("solids", "optimisation", "identification", "simulation")
SCHEMA = 1
"""Schema of the results; those of another version of the program are not shown."""
KEPT = 60
"""Finished jobs that are kept."""
KEPT_PASSING = 3
"""Finished answers to a slider that are kept: the page may still be reading the last ones."""


@dataclass
class Job:
    """One piece of work.

    Args:
        number: counts the jobs.
        lane: the process it runs in.
        task: name in `job_process.TASKS`.
        title: for the page.
        subject: what it is about, such as the name of an experiment.
        arguments: of the task.
        passing: an answer to a slider, which is soon replaced and not kept.
        error: one line, when it failed.
        details: traceback of an unexpected failure.
    """

    number: int
    lane: str
    task: str
    title: str
    subject: str
    arguments: dict[str, Any]
    passing: bool = False
    state: State = "waiting"
    step: str = ""
    done: int = 0
    total: int = 0
    error: str = ""
    details: str = ""
    created: float = field(default_factory=time.time)
    began: float | None = None
    ended: float | None = None

    def as_json(self) -> dict[str, Any]:
        """Everything but the result, which is a document of its own."""
        return {one.name: getattr(self, one.name) for one in fields(self) if one.name != "arguments"}


class JobRunner:
    """The lanes and all jobs.

    Args:
        folder: in which finished jobs are kept.
        working: folder in which the processes run.
        changed: called with a job whenever it changed, from any thread.
    """

    def __init__(self, folder: Path, working: Path, changed: Callable[[Job], None] = lambda job: None) -> None:
        self.folder, self.working, self.changed = folder, working, changed
        self.jobs: dict[int, Job] = {}
        self._lock = threading.Condition()
        self._closed = False
        self._read()
        self._numbers = itertools.count(1 + max(self.jobs, default=0))
        self._lanes = {name: _Lane(self, name) for name in LANES}

    def submit(
        self,
        lane: str,
        task: str,
        arguments: dict[str, Any],
        *,
        title: str,
        subject: str = "",
        replaces: bool = False,
        passing: bool = False,
    ) -> Job:
        """A new job at the end of its lane's queue; `replaces` cancels those of the task that still wait."""
        with self._lock:
            if replaces:
                for other in list(self.jobs.values()):
                    if other.task == task and other.state == "waiting":
                        self._end(other, "cancelled", "replaced by a newer one")
            job = Job(next(self._numbers), lane, task, title, subject, arguments, passing)
            self.jobs[job.number] = job
            self._lock.notify_all()
        self.changed(job)
        return job

    def get(self, number: int) -> Job:
        """A job by number.

        Raises:
            InputError: there is none.
        """
        if number not in self.jobs:
            raise InputError(f"job {number}: there is none")
        return self.jobs[number]

    def result(self, number: int) -> Any:
        """The document of a finished job.

        Raises:
            InputError: there is none.
        """
        path = self.folder / f"{number:05d}" / "result.json"
        if self.get(number).state != "done" or not path.is_file():
            raise InputError(f"job {number}: has no result")
        return json.loads(path.read_text("utf-8"))

    def cancel(self, number: int) -> Job:
        """Cancel a waiting or running job; a finished one stays as it is."""
        job = self.get(number)
        with self._lock:
            if job.state in ("waiting", "running"):
                running = job.state == "running"
                self._end(job, "cancelled", "")
                if running:
                    self._lanes[job.lane].kill()
        return job

    def close(self) -> None:
        """End all processes."""
        with self._lock:
            self._closed = True
            for job in self.jobs.values():
                if job.state in ("waiting", "running"):
                    self._end(job, "cancelled", "the server ended")
            for lane in self._lanes.values():
                lane.kill()
            self._lock.notify_all()

    def job_folder(self, job: Job) -> Path:
        """Folder for the files of a job."""
        return self.folder / f"{job.number:05d}"

    def _next(self, lane: str) -> Job | None:
        """The next job of a lane, now running; waits for one; None when the runner is closed."""
        with self._lock:
            while not self._closed:
                waiting = [job for job in self.jobs.values() if job.lane == lane and job.state == "waiting"]
                if waiting:
                    waiting[0].state, waiting[0].began = "running", time.time()
                    return waiting[0]
                self._lock.wait()
        return None

    def _progress(self, job: Job, step: str, done: int, total: int) -> None:
        job.step, job.done, job.total = step, done, total
        self.changed(job)

    def _finish(self, job: Job, kind: str, content: Any) -> None:
        with self._lock:
            if job.state != "running":
                return
            if kind == "result":
                text = json.dumps(finite(content), allow_nan=False)
                try:
                    atomic_write_text(self.job_folder(job) / "result.json", text)
                except OSError as error:
                    self._end(job, "failed", f"its result cannot be written: {error.strerror or error}")
                else:
                    self._end(job, "done", "")
            else:
                message, _, details = content.replace(f"{self.working}{os.sep}", "").partition("\n")
                job.details = details
                self._end(job, "failed", message)

    def _end(self, job: Job, state: State, error: str) -> None:
        job.state, job.error, job.ended = state, error, time.time()
        if not job.passing:
            kept = {"schema": SCHEMA, **job.as_json(), "arguments": job.arguments}
            with suppress(OSError):
                atomic_write_text(self.job_folder(job) / "job.json", json.dumps(finite(kept)))
        self._forget(job)
        self.changed(job)

    def _forget(self, ended: Job) -> None:
        import shutil

        finished = [
            n
            for n, job in sorted(self.jobs.items())
            if job.state in ("done", "failed", "cancelled") and job.passing == ended.passing
        ]
        for number in finished[: max(len(finished) - (KEPT_PASSING if ended.passing else KEPT), 0)]:
            shutil.rmtree(self.job_folder(self.jobs.pop(number)), ignore_errors=True)

    def _read(self) -> None:
        for path in sorted(self.folder.glob("*/job.json")):
            with suppress(OSError, ValueError, TypeError, KeyError):
                kept = json.loads(path.read_text("utf-8"))
                if kept.pop("schema") == SCHEMA:
                    job = Job(**kept)
                    self.jobs[job.number] = job


class _Lane:
    """A thread that hands jobs to a process, and starts a new process after one that ended."""

    def __init__(self, runner: JobRunner, name: str) -> None:
        self.runner, self.name = runner, name
        self._process: Any = None
        self._pipe: Any = None
        # On Linux a process dies with the thread that started it: this one lives as long as the server.
        threading.Thread(target=self._run, name=f"jobs: {name}", daemon=True).start()

    def kill(self) -> None:
        """End the process; its pipe then reads as closed."""
        process = self._process
        if process is not None:
            process.kill()

    def _run(self) -> None:
        while (job := self.runner._next(self.name)) is not None:
            self.runner.changed(job)
            kind, content = self._perform(job)
            self.runner._finish(job, kind, content)
        self.kill()

    def _perform(self, job: Job) -> tuple[str, Any]:
        arguments = {**job.arguments, "folder": str(self.runner.job_folder(job))}
        try:
            if self._process is None or not self._process.is_alive():
                self._start()
        except (OSError, RuntimeError) as error:
            self._process = None
            return "failure", f"no process can be started: {error}"
        try:
            if job.state != "running":
                return "failure", "cancelled"
            self._pipe.send((job.task, arguments))
            while True:
                kind, content = self._pipe.recv()
                if kind != "progress":
                    return kind, content
                self.runner._progress(job, *content)
        except (EOFError, OSError):
            process: Any = self._process
            self._process = None
            process.join(5.0)
            return "failure", f"its process ended without a result (exit status {process.exitcode})"

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=serve, args=(other, os.getpid(), str(self.runner.working)))
        self._process.start()
        other.close()
