"""Routes of experiments: those of the folder, files dropped on the page, examples, and consent to Python code."""

from __future__ import annotations

import filecmp
import os
from collections.abc import AsyncIterator
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Request
from pydantic import Field
from starlette.concurrency import run_in_threadpool

from stagecad.parameters.atomic import atomic_path, atomic_write_text
from stagecad.parameters.errors import InputError
from workbench.options import finite
from workbench.page.project import EXPERIMENT, Project, plain_name
from workbench.page.routes.machine import Body, Text

router = APIRouter(prefix="/api")

SHOWN_ROWS = 4
"""First values of a column that the page shows."""


class ChannelBody(Body):
    """An entry of `[channels]`."""

    column: Text | int
    unit: Text = ""
    scale: Text = ""
    sign: Literal[1, -1] = 1


class RecordBody(Body):
    """A `[[record]]` of a new experiment."""

    file: Text
    role: Literal["fit", "validate"]


class ExperimentBody(Body):
    """A new `experiment.toml`."""

    name: Text
    kind: Text
    known: dict[Text, Text] = {}
    effects: list[Text] = Field(default=[], max_length=40)
    channels: dict[Text, ChannelBody] = Field(default={}, max_length=100)
    records: list[RecordBody] = Field(min_length=1, max_length=100)
    noise: dict[Text, Text] = {}


class ProposalBody(Body):
    """Uploaded files of an experiment, and the kind of rig where the user has chosen it."""

    name: Text
    files: Annotated[list[Text], Field(min_length=1, max_length=100)]
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
    from sysid.experiment.readers.open import SUFFIXES
    from sysid.experiment.rig_kinds.declaration import kinds

    return {"suffixes": list(SUFFIXES), "kinds": list(kinds())}


@router.get("/effects")
def effects() -> list[dict[str, Any]]:
    """The library of effects: name, meaning, law, how it shows, source."""
    from sim.effects.catalogue import library

    names = ("name", "meaning", "equation", "shows", "source")
    return [{name: getattr(effect, name) for name in names} for effect in library().values()]


@router.post("/upload/{experiment}/{file}")
async def upload(request: Request, experiment: str, file: str) -> dict[str, Any]:
    """Store a dropped record file in the folder of an experiment, which may be new; nothing is left half written."""
    from sysid.experiment.readers.open import record_suffix, unknown_format

    project = project_of(request)
    name = plain_name(file)
    if record_suffix(name) is None:
        raise InputError(f"{name}: {unknown_format(name)}")
    target = project.inside(f"{plain_name(experiment)}/{name}")
    made, known = not target.parent.exists(), target.exists()
    try:
        with atomic_path(target) as temporary:
            await _write(request.stream(), temporary)
            if known and not await run_in_threadpool(filecmp.cmp, temporary, target, False):
                raise InputError(f"{experiment}/{name}: another file of that name is there; rename one of them")
        rows = await run_in_threadpool(_rows, target, name)
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


def _rows(path: Path, name: str) -> int:
    """Rows of a record file."""
    from sysid.experiment.columns.proposal import number_columns
    from sysid.experiment.readers.open import open_record_file

    columns = number_columns(open_record_file(path, name))
    if not columns:
        raise InputError(f"{name}: has no column of numbers")
    rows = int(next(iter(columns.values())).size)
    if rows == 0:
        raise InputError(f"{name}: has a header and no rows of numbers")
    return rows


@router.post("/propose")
def propose(request: Request, body: ProposalBody) -> dict[str, Any]:
    """What `stagecad new experiment` makes of uploaded files: kind of rig, channels, units, and its questions."""
    from sysid.experiment.columns.proposal import number_columns
    from sysid.experiment.rig_kinds.declaration import find_rig
    from workbench.identification.new_experiment import inspect, missing_channels, usual_effects

    folder = project_of(request).inside(plain_name(body.name))
    opened, found = inspect([folder / plain_name(file) for file in body.files], body.kind)
    rig, header, numbers = find_rig(found.kind, "kind"), opened[0].header, number_columns(opened[0])
    rotary = found.rotary
    columns = [
        {
            "column": one.number if header.numbered else one.label,
            "label": one.label,
            "channel": one.channel,
            "unit": "" if one.unit in (None, "?") else one.unit,
            "scale": one.scale and f"? {one.scale}",
            "question": one.question,
            "first": numbers[k][:SHOWN_ROWS] if k in numbers else None,
            "unit_in_file": one.unit is None,
        }
        for k, one in enumerate(found.columns)
    ]
    known = {key: one.rotary_unit if rotary else one.unit for key, one in rig.known.items()}
    known.pop("mass" if rotary else "inertia", None)
    return finite(
        {
            "kind": found.kind,
            "question": found.question,
            "read_as": list(header.remarks),
            "columns": columns,
            "channels": {name: rig.declared(name).si_unit(rotary) for name in rig.channels},
            "missing": list(missing_channels(found)),
            "known": known,
            "effects": usual_effects(found.kind),
        }
    )


@router.post("/experiments")
def new_experiment(request: Request, body: ExperimentBody) -> dict[str, Any]:
    """Write `experiment.toml` for records in a folder; it is read back, and removed when it is not valid."""
    from sysid.experiment.experiment import load_experiment

    project = project_of(request)
    path = project.inside(f"{plain_name(body.name)}/{EXPERIMENT}")
    if path.exists():
        raise InputError(f"{body.name}/{EXPERIMENT}: is there already; choose another name")
    for record in body.records:
        plain_name(record.file)
    atomic_write_text(path, _experiment_text(body))
    try:
        load_experiment(path.parent, request.app.state.design_values())
    except InputError:
        path.unlink(missing_ok=True)
        raise
    return {"name": body.name}


def _experiment_text(body: ExperimentBody) -> str:
    import tomlkit

    document = tomlkit.document()
    document["schema"] = 1
    document["rig"] = {"kind": body.kind, **({"known": body.known} if body.known else {})}
    document["model"] = {"effects": body.effects}
    if body.channels:
        table = tomlkit.table()
        for channel, given in body.channels.items():
            entry = tomlkit.inline_table()
            entry.update(given.model_dump(exclude_defaults=True))
            table[channel] = entry
        document["channels"] = table
    records = tomlkit.aot()
    for record in body.records:
        records.append(tomlkit.item(record.model_dump()))
    document["record"] = records
    if body.noise:
        document["noise"] = body.noise
    return tomlkit.dumps(document)


@router.get("/examples")
def examples() -> list[dict[str, str]]:
    """Experiments that can be copied into the project: the demonstration, and the examples of the project."""
    from workbench.page.examples import EXAMPLES, available

    return [{"name": name, "meaning": EXAMPLES[name]} for name in available()]


@router.post("/examples/{name}")
def example(request: Request, name: str) -> dict[str, Any]:
    """Copy an example into a folder of its name in the project, or into the next free one."""
    from workbench.page.examples import copied

    return {"name": copied(name, project_of(request).inside(plain_name(name))).name}


@router.get("/experiment/{name:path}/code")
def code(request: Request, name: str) -> dict[str, Any]:
    """Python files that an experiment names, and whether the user has consented to their present content."""
    from sysid.experiment.consent import python_files

    project = project_of(request)
    return {"offered": project.trust, "files": python_files(project.experiment_folder(name))}


@router.post("/experiment/{name:path}/consent")
def consent(request: Request, name: str, body: ConsentBody) -> dict[str, Any]:
    """Let the Python files of an experiment run with the content that the user has read, by name and hash."""
    from sysid.experiment.consent import python_files, store_consent

    project = project_of(request)
    folder = project.experiment_folder(name)
    if not project.trust:
        raise InputError(f"{name}: {NOT_STARTED_WITH_TRUST}")
    present = [one for one in python_files(folder) if one["name"] in body.files]
    for one in present:
        if body.files[one["name"]] != one["sha256"]:
            raise InputError(f"{name}/{one['name']}: has changed since it was shown; read it again")
    for one in present:
        store_consent(folder / one["name"], one["sha256"])
    return code(request, name)


NOT_STARTED_WITH_TRUST = (
    "Python code runs only where the server was started with it: 'stagecad workbench --trust' asks here, for each file"
)
"""What a user does who wants the code of an experiment to run."""
