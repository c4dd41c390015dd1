"""Routes of the machine view: parameters, checks, rules, solids, drawings, differences, optimisation."""

import json
from typing import Annotated, Any

from fastapi import APIRouter, Request
from fastapi.responses import FileResponse
from pydantic import BaseModel, ConfigDict, Field
from starlette.concurrency import run_in_threadpool

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import require
from stagecad.parameters.mass_properties import masses_from_json
from workbench.operations.drawings import cached_file, chosen_sheets, sheet_names
from workbench.operations.optimise import marked_free, need_free
from workbench.operations.parameters import parameter_rows
from workbench.operations.result import finite
from workbench.page.machine_session import Changes, MachineSession
from workbench.page.tasks.machine import BEST, STOP

FULL = 1e9
"""Limit of time for an answer that has all checks, s."""

ARTEFACTS = {".glb": "model/gltf-binary", ".svg": "image/svg+xml", ".pdf": "application/pdf", ".png": "image/png"}
ARTEFACTS |= {".dxf": "image/vnd.dxf", ".step": "model/step", ".stl": "model/stl"}
IMMUTABLE = {"cache-control": "private, max-age=31536000, immutable"}

Text = Annotated[str, Field(max_length=300)]


class Body(BaseModel):
    """Body of a request; keys that are not known are refused."""

    model_config = ConfigDict(extra="forbid")


class ChangesBody(Body):
    """Values that differ from the saved file."""

    changes: dict[Text, Text] = Field(max_length=600)
    limit: float = Field(default=0.05, ge=0.0, le=60.0)
    since: int = Field(default=0, ge=0)


class SeenBody(Body):
    """Digest of the design that the page shows: a design that was changed elsewhere since is left as it is (409)."""

    seen: Text | None = None


class CommitBody(SeenBody):
    """Values that differ from the saved file."""

    changes: dict[Text, Text] = Field(max_length=600)


class NameBody(SeenBody):
    """Name of a file; None: the packaged design."""

    name: Text | None


class SolidsBody(Body):
    """`saved`: of the saved file, without the present changes."""

    saved: bool = False


router = APIRouter(prefix="/api/machine")


def session_of(request: Request) -> MachineSession:
    """The design that the page shows."""
    return request.app.state.machine


@router.get("")
def state(request: Request) -> dict[str, Any]:
    """File, changes, and the steps that can be undone."""
    return session_of(request).as_json()


@router.get("/parameters")
def parameters(request: Request) -> list[dict[str, Any]]:
    """Every parameter of the saved file, with bounds and origin."""
    return finite(parameter_rows(session_of(request).saved.values))


@router.post("/preview")
async def preview(request: Request, body: ChangesBody) -> dict[str, Any]:
    """Checks that a change concerns, as many as the limit of time allows, and all violated rules."""
    session, changes = session_of(request), _changes(body)
    # Previews wait for one another; the threads of all other requests stay free.
    async with request.app.state.previews:
        return finite(await run_in_threadpool(session.preview, changes, body.limit, body.since))


@router.post("/commit")
def commit(request: Request, body: CommitBody) -> dict[str, Any]:
    """Make changes the present ones, as a step that can be undone."""
    session_of(request).commit(_changes(body), body.seen)
    return session_of(request).as_json()


@router.post("/undo")
def undo(request: Request, body: SeenBody | None = None) -> dict[str, Any]:
    """Go back one step."""
    session_of(request).step(-1, body and body.seen)
    return session_of(request).as_json()


@router.post("/redo")
def redo(request: Request, body: SeenBody | None = None) -> dict[str, Any]:
    """Repeat the step that was undone last."""
    session_of(request).step(+1, body and body.seen)
    return session_of(request).as_json()


@router.post("/open")
def open_file(request: Request, body: NameBody) -> dict[str, Any]:
    """Open a parameter file of the project, or the packaged design."""
    session_of(request).open(body.name, body.seen)
    return session_of(request).as_json()


@router.post("/save")
def save(request: Request, body: NameBody) -> dict[str, Any]:
    """Write a new parameter file."""
    session_of(request).save(body.name or "", body.seen)
    return session_of(request).as_json()


@router.get("/differences")
def differences(request: Request, other: str | None = None) -> list[dict[str, Any]]:
    """Keys that differ from the saved file, or from another one."""
    return finite(session_of(request).differences(other))


@router.get("/checks")
def checks(request: Request) -> list[dict[str, Any]]:
    """Every check of the present design: the document of `stagecad check --json` without proposals evaluated."""
    session = session_of(request)
    session.checks.update(session.design().values, FULL)
    return finite([check.as_json() for check in session.checks.all_known().values()])


@router.get("/checks/{position}")
def check(request: Request, position: int) -> dict[str, Any]:
    """One check as last evaluated."""
    known = session_of(request).checks.all_known()
    require(position in known, f"check {position}: there is none")
    return finite(known[position].as_json())


@router.post("/solids")
def solids(request: Request, body: SolidsBody) -> dict[str, Any]:
    """Start the job that makes the parts of the present design; its result has a key for each mesh."""
    session, jobs = session_of(request), request.app.state.jobs
    arguments = {"design": session.saved if body.saved else session.design()}
    return jobs.submit("solids", "solids", arguments, title="Solids", replaces=True).as_json()


@router.post("/masses/{number}")
def masses(request: Request, number: int) -> dict[str, Any]:
    """Take the masses of the solids of a finished job for the checks, if they are of the present design."""
    session, jobs = session_of(request), request.app.state.jobs
    result, design = jobs.result(number), session.design().values
    taken = result.get("digest") == design.digest
    if taken:
        session.checks.set_masses(design, masses_from_json(result))
    return {"taken": taken}


@router.get("/sheets")
def sheets(request: Request) -> dict[str, tuple[str, ...]]:
    """Names of the sheets by subject."""
    return sheet_names(session_of(request).design().values)


@router.post("/drawings/{subject}")
def drawings(request: Request, subject: str) -> dict[str, Any]:
    """Start the job that draws the sheets of a subject."""
    session, jobs = session_of(request), request.app.state.jobs
    arguments = {"design": session.design(), "subject": subject}
    chosen_sheets([subject], arguments["design"].values)
    return jobs.submit("solids", "drawings", arguments, title="Drawing", subject=subject, replaces=True).as_json()


@router.get("/artefacts/{key}/{name}")
def artefact(key: str, name: str) -> FileResponse:
    """A file of the cache of solids and drawings, by its key."""
    suffix = "." + name.rpartition(".")[2]
    path = cached_file(key, name)
    require(suffix in ARTEFACTS, f"{name}: no mesh, and no sheet")
    return FileResponse(path, media_type=ARTEFACTS[suffix], headers=IMMUTABLE)


class OptimizeBody(Body):
    """As the options of `stagecad optimize`; `free` holds the ranges and choices by key, all that may change."""

    free: dict[Text, Text] = Field(min_length=1, max_length=100)
    keep: Annotated[list[Text], Field(max_length=300)] = []
    budget: int = Field(default=600, ge=20, le=100_000)
    seconds: float = Field(default=300.0, ge=1.0, le=1e6)


@router.get("/optimize")
def free(request: Request) -> dict[str, str]:
    """Ranges `LOW:HIGH` and choices `A|B` of the parameters that the present file marks as free."""
    return marked_free(session_of(request).design())


@router.post("/optimize")
def optimize(request: Request, body: OptimizeBody) -> dict[str, Any]:
    """Start `stagecad optimize` on the present design."""
    session, jobs = session_of(request), request.app.state.jobs
    for key, text in body.free.items():
        require("=" not in key and text.strip(), f"{key}: a range LOW:HIGH is required, or choices A|B")
    arguments = {"design": session.design(), "search": body.model_dump()}
    need_free(arguments["design"], body.free)
    return jobs.submit("optimisation", "optimize", arguments, title="Optimize", replaces=True).as_json()


@router.get("/optimize/{number}/best")
def best(request: Request, number: int) -> Any:
    """The best design that a search has evaluated so far, also of one that was cancelled; null before the first."""
    jobs = request.app.state.jobs
    path = jobs.job_folder(jobs.get(number)) / BEST
    return json.loads(path.read_text("utf-8")) if path.is_file() else None


@router.post("/optimize/{number}/stop")
def stop(request: Request, number: int) -> dict[str, Any]:
    """End a search with what it has found."""
    jobs = request.app.state.jobs
    job = jobs.get(number)
    if job.task == "optimize" and job.state == "running":
        atomic_write_text(jobs.job_folder(job) / STOP, "")
    return job.as_json()


def _changes(body: ChangesBody | CommitBody) -> Changes:
    for key, text in body.changes.items():
        require("=" not in key and key and text.strip(), f"{key!r}: a value is required")
    return dict(body.changes)
