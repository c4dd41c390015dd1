"""Jobs: work that takes longer than a request, in processes of their own, one for each kind of work.

A lane is a pool of one process. The process stays for the next job, since loading the CAD kernel or the compiled
effects takes seconds; to cancel a running job, its process is ended, with all processes that it started, and the next
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
from concurrent.futures import CancelledError, Future
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from pydantic import TypeAdapter

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError, require
from stagecad.parameters.input_file import read_input
from stagecad.processes import started_pool
from workbench.operations.result import json_text
from workbench.page.job_process import begin_jobs, perform

if TYPE_CHECKING:
    from pebble import ProcessFuture, ProcessPool

State = Literal["waiting", "running", "done", "failed", "cancelled"]
SCHEMA = 2
"""Schema of the results; those of another version of the program are not shown."""
KEPT = 60
"""Finished jobs that are kept."""
KEPT_PASSING = 3
"""Finished answers to a slider that are kept: the page may still be reading the last ones."""


@dataclass
class Job:
    """One piece of work."""

    number: int  # counts the jobs
    lane: str  # the process it runs in
    task: str  # name in `job_process.TASKS`
    title: str  # for the page
    subject: str  # what it is about, such as the name of an experiment
    arguments: dict[str, Any] = field(default_factory=dict)  # of the task; a kept job has none
    passing: bool = False  # an answer to a slider, which is soon replaced and not kept
    state: State = "waiting"
    step: str = ""
    done: int = 0
    total: int = 0
    error: str = ""  # one line, when it failed
    details: str = ""  # traceback of an unexpected failure
    created: float = field(default_factory=time.time)
    began: float | None = None
    ended: float | None = None

    def as_json(self) -> dict[str, Any]:
        """Everything but the result, which is a document of its own."""
        return {one.name: getattr(self, one.name) for one in fields(self) if one.name != "arguments"}


class JobRunner:
    """The lanes and all jobs. Finished ones are kept in `folder`, the processes run in `working`, and `changed` is
    called with a job whenever it changed, from any thread."""

    def __init__(self, folder: Path, working: Path, changed: Callable[[Job], None] = lambda job: None) -> None:
        self.folder, self.working, self.changed = folder, working, changed
        self.jobs: dict[int, Job] = {}
        self._lock = threading.RLock()
        self._lanes: dict[str, ProcessPool] = {}
        self._pools = ExitStack()
        self._futures: dict[int, ProcessFuture[Any]] = {}
        self._read()
        self._numbers = itertools.count(1 + max(self.jobs, default=0))
        self._reports, self._reporting = multiprocessing.Pipe(duplex=False)
        threading.Thread(target=self._receive, daemon=True).start()

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
        self.changed(job)
        self._begin(job)
        return job

    def get(self, number: int) -> Job:
        """A job by number."""
        require(number in self.jobs, f"job {number}: there is none")
        return self.jobs[number]

    def result(self, number: int) -> Any:
        """The document of a finished job."""
        path = self.folder / f"{number:05d}" / "result.json"
        require(self.get(number).state == "done" and path.is_file(), f"job {number}: has no result")
        try:
            return json.loads(path.read_text("utf-8"))
        except (ValueError, RecursionError):
            raise InputError(f"job {number}: its result is damaged; start it again") from None

    def cancel(self, number: int) -> Job:
        """Cancel a waiting or running job; a finished one stays as it is."""
        job = self.get(number)
        with self._lock:
            if job.state in ("waiting", "running"):
                self._end(job, "cancelled", "")
        return job

    def close(self) -> None:
        """End all processes."""
        with self._lock:
            for job in self.jobs.values():
                if job.state in ("waiting", "running"):
                    self._end(job, "cancelled", "the server ended")
        self._pools.close()

    def job_folder(self, job: Job) -> Path:
        """Folder for the files of a job."""
        return self.folder / f"{job.number:05d}"

    def _begin(self, job: Job) -> None:
        """Hand a job to the process of its lane, a new one where the last ended."""
        arguments = {**job.arguments, "folder": str(self.job_folder(job))}
        try:
            with self._lock:
                if job.state != "waiting":
                    return
                if job.lane not in self._lanes or not self._lanes[job.lane].active:
                    pool = started_pool(1, begin=begin_jobs, arguments=(self._reporting, str(self.working)))
                    self._lanes[job.lane] = self._pools.enter_context(pool)
                future = self._lanes[job.lane].schedule(perform, (job.number, job.task, arguments))
                self._futures[job.number] = future
        except (OSError, RuntimeError) as error:
            self._finish(job, "failure", f"no process can be started: {error}")
        else:
            future.add_done_callback(partial(self._completed, job))

    def _receive(self) -> None:
        """Take what the processes report of the jobs that they run."""
        with suppress(EOFError, OSError):
            while True:
                number, step, done, total = self._reports.recv()
                with self._lock:
                    job = self.jobs.get(number)
                    if job is None or job.state not in ("waiting", "running"):
                        continue
                    if job.state == "waiting":
                        job.state, job.began = "running", time.time()
                        self._note(job)
                    job.step, job.done, job.total = step, done, total
                self.changed(job)

    def _completed(self, job: Job, future: Future[Any]) -> None:
        self._futures.pop(job.number, None)
        try:
            kind, content, last = future.result()
            with self._lock:
                # A report that arrives later finds the job ended.
                job.step, job.done, job.total = last
                self._finish(job, kind, content)
        except CancelledError:
            pass
        except (OSError, RuntimeError) as error:
            # Two threads that ask for the status at once may leave one of them without it.
            status = getattr(error, "exitcode", None)
            known = "" if status is None else f" (exit status {status})"
            self._finish(job, "failure", f"its process ended without a result{known}")

    def _finish(self, job: Job, kind: str, content: Any) -> None:
        with self._lock:
            if job.state not in ("waiting", "running"):
                return
            job.began = job.began or time.time()
            if kind == "result":
                text = json_text(content)
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
        if state == "cancelled" and job.number in self._futures:
            self._futures[job.number].cancel()
        self._note(job)
        self._forget(job)
        self.changed(job)

    def _note(self, job: Job) -> None:
        """Write the state of a job, for a new server."""
        if not job.passing:
            kept = {"schema": SCHEMA, **job.as_json()}
            with suppress(OSError):
                atomic_write_text(self.job_folder(job) / "job.json", json_text(kept))

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
            with suppress(OSError, ValueError, TypeError, LookupError, RecursionError):
                text = read_input(path)
                job = TypeAdapter(Job).validate_json(text)
                if json.loads(text)["schema"] == SCHEMA and self.job_folder(job) == path.parent:
                    if job.state in ("waiting", "running"):
                        job.state, job.error = "cancelled", "the server ended"
                    self.jobs[job.number] = job
