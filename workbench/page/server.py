"""The server of the page: its routes, its jobs, and the events that tell the page what changed."""

import asyncio
import json
import os
import threading
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager, suppress
from importlib.resources import files
from pathlib import Path
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, Response, StreamingResponse
from starlette.exceptions import HTTPException
from starlette.staticfiles import StaticFiles

from stagecad import __version__
from stagecad.parameters.errors import InputError, one_line
from workbench.operations.result import finite
from workbench.page.curves import extremes, read_curves, sampled
from workbench.page.jobs import Job, JobRunner
from workbench.page.machine_session import ChangedElsewhereError, MachineSession
from workbench.page.project import Project
from workbench.page.routes import experiments, machine, measurement, simulation
from workbench.page.security import EVERY_ADDRESS, Guard, allowed_hosts

HEARTBEAT = 15.0
"""Interval of the events that keep a connection open, s."""


class Events:
    """Hands the state of jobs to every page that listens."""

    def __init__(self) -> None:
        self.loop: asyncio.AbstractEventLoop | None = None
        self._listeners: set[asyncio.Queue[dict[str, Any] | None]] = set()

    def job_changed(self, job: Job) -> None:
        """Called from any thread."""
        self._publish(finite(job.as_json()))

    def end(self) -> None:
        """End every connection: the server stops."""
        self._publish(None)

    def _publish(self, message: dict[str, Any] | None) -> None:
        if self.loop is not None:
            with suppress(RuntimeError):
                self.loop.call_soon_threadsafe(self._deliver, message)

    def _deliver(self, message: dict[str, Any] | None) -> None:
        for listener in self._listeners:
            listener.put_nowait(message)

    async def stream(self) -> AsyncIterator[str]:
        """Server-sent events, one for each change of a job."""
        queue: asyncio.Queue[dict[str, Any] | None] = asyncio.Queue()
        self._listeners.add(queue)
        try:
            yield ": connected\n\n"
            while True:
                try:
                    message = await asyncio.wait_for(queue.get(), HEARTBEAT)
                except TimeoutError:
                    yield ": still here\n\n"
                    continue
                if message is None:
                    return
                yield f"data: {json.dumps(message)}\n\n"
        finally:
            self._listeners.discard(queue)


def create_app(project: Project) -> FastAPI:
    """The application without its guard (`workbench.page.security`)."""
    events = Events()
    jobs = JobRunner(project.state / "jobs", project.folder, events.job_changed)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        events.loop = asyncio.get_running_loop()
        threading.Thread(target=_warm_up, args=(app,), daemon=True).start()
        yield
        events.end()
        jobs.close()

    app = FastAPI(title="stagecad workbench", version=__version__, lifespan=lifespan, docs_url=None, redoc_url=None)
    app.state.project, app.state.events, app.state.jobs = project, events, jobs
    app.state.machine = MachineSession(project)
    app.state.previews = asyncio.Semaphore(1)
    for module in (machine, experiments, measurement, simulation):
        app.include_router(module.router)
    _add_common_routes(app)
    _add_errors(app)
    static = Path(str(files("workbench.page") / "static"))
    app.mount("/", StaticFiles(directory=static, html=True), name="static")
    return app


def _add_common_routes(app: FastAPI) -> None:
    jobs: JobRunner = app.state.jobs

    @app.get("/api/about")
    def about() -> dict[str, Any]:
        """Version, folder, and whether code of experiments may run."""
        project: Project = app.state.project
        known = {"folder": str(project.folder), "trust": project.trust, "begins_with": project.begins_with}
        return {"version": __version__, **known}

    @app.get("/api/jobs")
    def all_jobs() -> list[dict[str, Any]]:
        """Every job, without results."""
        return finite([job.as_json() for job in list(jobs.jobs.values())])

    @app.get("/api/jobs/{number}/result")
    def result(number: int) -> Any:
        """The document of a finished job."""
        return jobs.result(number)

    @app.post("/api/jobs/{number}/cancel")
    def cancel(number: int) -> dict[str, Any]:
        """Stop a job: its process is ended."""
        return finite(jobs.cancel(number).as_json())

    @app.get("/api/jobs/{number}/curves/{curves}")
    def curves(
        number: int,
        curves: int,
        series: str,
        start: float | None = None,
        stop: float | None = None,
        columns: int = 1200,
        pairs: bool = False,
    ) -> Response:
        """Rows `series` (their positions, with commas) over a window, as float64 numbers row by row.

        The extremes of `columns` stretches, or with `pairs` so many rows, evenly spaced.
        """
        array = read_curves(jobs.job_folder(jobs.get(number)), curves)
        try:
            rows = [int(word) for word in series.split(",")]
        except ValueError:  # Python converts no number of more than 4300 digits
            rows = [-1]
        if not all(0 <= row < len(array) for row in rows) or len(rows) > 20:
            raise InputError(f"series {series!r}: positions below {len(array)} are required")
        found = (sampled if pairs else extremes)(array, rows, start, stop, columns)
        headers = {"x-rows": str(found.shape[0])}
        return Response(found.astype("<f8").tobytes(), media_type="application/octet-stream", headers=headers)

    @app.get("/api/events")
    def events() -> StreamingResponse:
        """Server-sent events: the state of a job whenever it changes."""
        return StreamingResponse(app.state.events.stream(), media_type="text/event-stream")


def _add_errors(app: FastAPI) -> None:
    def answer(text: str, status: int, headers: Mapping[str, str] | None = None, **more: Any) -> JSONResponse:
        error = one_line(text.replace(f"{app.state.project.folder}{os.sep}", ""))
        return JSONResponse({"error": error, **more}, status, headers)

    async def refused(request: Request, error: Exception) -> JSONResponse:
        match error:
            case ChangedElsewhereError():
                return answer(str(error), 409, state=app.state.machine.as_json())
            case InputError():
                return answer(str(error), 422)
            case RequestValidationError():
                first = error.errors()[0]
                place = ".".join(str(part) for part in first["loc"] if part != "body") or "body of the request"
                return answer(f"{place}: {first['msg']}", 422)
            case HTTPException():
                return answer(str(error.detail), error.status_code, error.headers)
            case OSError():
                # A name of the request may be that of a file where a folder is required, or the reverse.
                own = isinstance(error, NotADirectoryError | IsADirectoryError | FileExistsError)
                return answer(f"{error.filename or 'file'}: {error.strerror or error}", 422 if own else 500)
        # The server writes the traceback to its standard error.
        return answer(f"unexpected {type(error).__name__}; please report it", 500)

    for kind in (InputError, RequestValidationError, HTTPException, OSError, Exception):
        app.add_exception_handler(kind, refused)


def _warm_up(app: FastAPI) -> None:
    """Evaluate every check once, so that the first slider does not wait for what they load."""
    session: MachineSession = app.state.machine
    with suppress(InputError):
        session.checks.update(session.design().values, 1e9)


def serve(
    project: Project, host: str, port: int, token: str | None, note: Callable[[str], None], browser: bool
) -> None:
    """Serve until Ctrl-C."""
    import socket

    import uvicorn

    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((host, port))
            # A browser that is opened at once waits until the server answers, and is not refused.
            listening.listen()
        except OSError as error:
            reason = error.strerror or error
            raise InputError(f"--host {host} --port {port}: {reason}; choose another with --port") from None
        port = listening.getsockname()[1]
        shown = f"[{host}]" if ":" in host else host
        address = f"http://{shown}:{port}/" + (f"?token={token}" if token is not None else "")
        app = create_app(project)
        guarded = Guard(app, allowed_hosts(host, port), token, every_address=host in EVERY_ADDRESS)
        config = uvicorn.Config(guarded, log_level="warning", access_log=False, timeout_graceful_shutdown=1)
        note(f"workbench: {address}  (Ctrl-C ends it)")
        if browser:
            import webbrowser

            threading.Timer(0.3, webbrowser.open, (address,)).start()
        try:
            uvicorn.Server(config).run(sockets=[listening])
        finally:
            app.state.jobs.close()
