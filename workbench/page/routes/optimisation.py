"""Routes of the optimisation of the design: what is free, and the job that searches."""

import json
from typing import Annotated, Any

from fastapi import APIRouter, Request
from pydantic import Field

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from workbench.operations.optimise import marked_free, need_free
from workbench.page.routes.machine import Body, Text, session_of
from workbench.page.tasks.machine import BEST, STOP

router = APIRouter(prefix="/api/machine/optimize")


class OptimizeBody(Body):
    """As the options of `stagecad optimize`; `free` holds the ranges and choices by key, all that may change."""

    free: dict[Text, Text] = Field(min_length=1, max_length=100)
    keep: Annotated[list[Text], Field(max_length=300)] = []
    budget: int = Field(default=600, ge=20, le=100_000)
    seconds: float = Field(default=300.0, ge=1.0, le=1e6)


@router.get("")
def free(request: Request) -> dict[str, str]:
    """Ranges `LOW:HIGH` and choices `A|B` of the parameters that the present file marks as free."""
    return marked_free(session_of(request).design())


@router.post("")
def optimize(request: Request, body: OptimizeBody) -> dict[str, Any]:
    """Start `stagecad optimize` on the present design."""
    session, jobs = session_of(request), request.app.state.jobs
    for key, text in body.free.items():
        if "=" in key or not text.strip():
            raise InputError(f"{key}: a range LOW:HIGH is required, or choices A|B")
    need_free(session.design(), body.free)
    arguments = {**session.source(), "search": body.model_dump()}
    return jobs.submit("optimisation", "optimize", arguments, title="Optimize", replaces=True).as_json()


@router.get("/{number}/best")
def best(request: Request, number: int) -> Any:
    """The best design that a search has evaluated so far, also of one that was cancelled; null before the first."""
    jobs = request.app.state.jobs
    path = jobs.job_folder(jobs.get(number)) / BEST
    return json.loads(path.read_text("utf-8")) if path.is_file() else None


@router.post("/{number}/stop")
def stop(request: Request, number: int) -> dict[str, Any]:
    """End a search with what it has found."""
    jobs = request.app.state.jobs
    job = jobs.get(number)
    if job.task == "optimize" and job.state == "running":
        atomic_write_text(jobs.job_folder(job) / STOP, "")
    return job.as_json()
