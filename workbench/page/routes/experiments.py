"""Routes of experiments: those of the folder, files dropped on the page, examples, and consent to Python code."""

import filecmp
import os
from collections.abc import AsyncIterator
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import APIRouter, Request
from pydantic import ConfigDict, Field
from starlette.concurrency import run_in_threadpool

from stagecad.parameters.atomic import atomic_path
from stagecad.parameters.errors import InputError, require
from workbench.operations.measurement import new_experiment as operation
from workbench.operations.measurement.experiment import consent as consent_to
from workbench.operations.measurement.experiment import python_files
from workbench.operations.result import finite
from workbench.operations.templates import EXAMPLES, copy_example
from workbench.operations.templates import examples as examples_of
from workbench.page.curves import extremes
from workbench.page.project import Project, plain_name
from workbench.page.routes.machine import Body, Text

router = APIRouter(prefix="/api")

SPARKS = 240
"""Stretches of a record in which a column is drawn before the fit."""


class ChannelBody(Body):
    """An entry of `[channels]`."""

    column: Text | int
    unit: Text = ""
    scale: Text = ""
    sign: Literal[1, -1] = 1


class RecordBody(Body):
    """A `[[record]]` of a new experiment; `from` and `to` bound the time."""

    model_config = ConfigDict(extra="forbid", populate_by_name=True)

    file: Text
    role: Literal["fit", "validate"]
    start: Text | None = Field(default=None, alias="from")
    stop: Text | None = Field(default=None, alias="to")


class ExperimentBody(Body):
    """A new `experiment.toml`."""

    name: Text
    kind: Text
    known: dict[Text, Text] = {}
    effects: list[Text] = Field(default=[], max_length=40)
    # several columns of one channel are added
    channels: dict[Text, ChannelBody | list[ChannelBody]] = Field(default={}, max_length=100)
    records: list[RecordBody] = Field(min_length=1, max_length=100)
    noise: dict[Text, Text] = {}


class FilesBody(Body):
    """Record files, by name, and their experiment."""

    name: Text
    files: Annotated[list[Text], Field(min_length=1, max_length=100)]


class ProposalBody(FilesBody):
    """Uploaded files of an experiment, and the kind of rig where the user has chosen it."""

    kind: Text | None = None


class ConsentBody(Body):
    """Hashes (sha256) of the files whose code the user has read, and lets run."""

    files: dict[Text, Text] = Field(min_length=1, max_length=50)


def project_of(request: Request) -> Project:
    """The folder that the server works in."""
    return request.app.state.project


@router.get("/experiments")
def experiments(request: Request) -> list[dict[str, Any]]:
    """Experiments of the project."""
    return project_of(request).experiments()


@router.get("/formats")
def formats() -> dict[str, list[str]]:
    """Suffixes of the record files that are read, and the kinds of rig."""
    return {"suffixes": list(operation.SUFFIXES), "kinds": list(operation.kinds())}


@router.get("/effects")
def effects() -> list[dict[str, Any]]:
    """The library of effects: name, meaning, law, how it shows, source."""
    names = ("name", "meaning", "equation", "shows", "source")
    return [{name: getattr(effect, name) for name in names} for effect in operation.library().values()]


@router.post("/upload/{experiment}/{file}")
async def upload(request: Request, experiment: str, file: str) -> dict[str, Any]:
    """Store a dropped record file in the folder of an experiment, which may be new; nothing is left half written."""
    return await _store(project_of(request), experiment, file, request.stream())


@router.get("/records")
def records(request: Request) -> list[str]:
    """Record files directly in the project's folder."""
    return project_of(request).records()


@router.post("/records")
async def take_records(request: Request, body: FilesBody) -> list[dict[str, Any]]:
    """Copy record files of the project's folder into that of an experiment, as if they were dropped on the page."""
    project, stored = project_of(request), []
    for file in body.files:
        source = project.inside(plain_name(file))
        require(source.is_file(), f"{file}: no such file in this folder")
        stored.append(await _store(project, body.name, file, _pieces(source)))
    return stored


async def _pieces(path: Path) -> AsyncIterator[bytes]:
    with path.open("rb") as stream:
        while piece := await run_in_threadpool(stream.read, 1 << 20):
            yield piece


async def _store(project: Project, experiment: str, file: str, pieces: AsyncIterator[bytes]) -> dict[str, Any]:
    name = plain_name(file)
    if operation.record_suffix(name) is None:
        raise InputError(f"{name}: {operation.unknown_format(name)}")
    target = project.inside(f"{plain_name(experiment)}/{name}")
    made, known = not target.parent.exists(), target.exists()
    try:
        with atomic_path(target) as temporary:
            await _write(pieces, temporary)
            if known and not await run_in_threadpool(filecmp.cmp, temporary, target, False):
                raise InputError(f"{experiment}/{name}: another file of that name is there; rename one of them")
        rows = await run_in_threadpool(operation.record_rows, target, name)
    except BaseException:
        # A file that cannot be read is not kept: it would only be in the way.
        if not known:
            target.unlink(missing_ok=True)
        if made:
            with suppress(OSError):
                target.parent.rmdir()
        raise
    return {"file": name, "rows": rows}


async def _write(chunks: AsyncIterator[bytes], path: Path) -> None:
    with path.open("wb") as stream:
        async for chunk in chunks:
            await run_in_threadpool(stream.write, chunk)
        stream.flush()
        os.fsync(stream.fileno())


@router.post("/propose")
def propose(request: Request, body: ProposalBody) -> dict[str, Any]:
    """What `stagecad new experiment` makes of uploaded files: kind of rig, channels, units, and its questions."""
    folder = project_of(request).inside(plain_name(body.name))
    return operation.propose([folder / plain_name(file) for file in body.files], body.kind).to_json()


@router.post("/preview")
def preview(request: Request, body: FilesBody) -> list[dict[str, Any]]:
    """Every column of uploaded files as it is logged: the least and the largest value of equal stretches of rows."""
    project, found = project_of(request), []
    for file in body.files:
        columns = operation.record_columns(project.inside(f"{plain_name(body.name)}/{plain_name(file)}"))
        size = next((values.size for values in columns.values()), 0)
        table = np.vstack([np.arange(size), *columns.values()])
        drawn = extremes(table, range(1, len(table)), None, None, SPARKS)[1:]
        found.append({"file": file, "rows": size, "columns": dict(zip(columns, drawn.tolist()))})
    return finite(found)


@router.post("/experiments")
def new_experiment(request: Request, body: ExperimentBody) -> dict[str, Any]:
    """Write `experiment.toml` for records in a folder; it is read back, and removed when it is not valid."""
    folder = project_of(request).inside(plain_name(body.name))
    for record in body.records:
        plain_name(record.file)
    document = {
        "rig": {"kind": body.kind, "known": body.known},
        "model": {"effects": body.effects},
        "channels": body.model_dump(include={"channels"}, exclude_defaults=True).get("channels", {}),
        "record": [record.model_dump(by_alias=True, exclude_none=True) for record in body.records],
        "noise": body.noise,
    }
    operation.write_experiment(folder, document, project_of(request).stated_design())
    return {"name": body.name}


@router.get("/examples")
def examples() -> list[dict[str, str]]:
    """Experiments that can be copied into the project: the demonstration, and the examples of the project."""
    return [{"name": name, "meaning": EXAMPLES[name]} for name in examples_of(experiments=True)]


@router.post("/examples/{name}")
def example(request: Request, name: str) -> dict[str, Any]:
    """Copy an example into a folder of its name in the project, or into the next free one."""
    return {"name": copy_example(name, project_of(request).inside(plain_name(name))).name}


@router.get("/experiment/{name:path}/code")
def code(request: Request, name: str) -> dict[str, Any]:
    """Python files that an experiment names, and whether the user has consented to their present content."""
    project = project_of(request)
    return {"offered": project.trust, "files": python_files(project.experiment_folder(name))}


@router.post("/experiment/{name:path}/consent")
def consent(request: Request, name: str, body: ConsentBody) -> dict[str, Any]:
    """Let the Python files of an experiment run with the content that the user has read, by name and hash."""
    project = project_of(request)
    folder = project.experiment_folder(name)
    require(project.trust, f"{name}: {NOT_STARTED_WITH_TRUST}")
    consent_to(folder, body.files)
    return code(request, name)


NOT_STARTED_WITH_TRUST = (
    "Python code runs only where the server was started with it: 'stagecad workbench --trust' asks here, for each file"
)
"""What a user does who wants the code of an experiment to run."""
