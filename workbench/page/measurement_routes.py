"""Routes of the measurement view: experiments, files dropped on the page, and the jobs of the identification."""

from __future__ import annotations

import filecmp
import os
from collections.abc import AsyncIterator
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Request
from fastapi.responses import FileResponse
from pydantic import Field
from starlette.concurrency import run_in_threadpool

from stagecad.parameters.atomic import atomic_path, atomic_write_text
from stagecad.parameters.errors import InputError
from workbench.options import finite
from workbench.page.machine_routes import Body, Text
from workbench.page.project import EXPERIMENT, RECORD_SUFFIXES, Project, plain_name
from workbench.page.security import REPORT_POLICY

router = APIRouter(prefix="/api")


class RecordBody(Body):
    """A `[[record]]` of a new experiment."""

    file: Text
    role: Literal["fit", "validate"]
    columns: dict[Text, Text] = {}
    units: dict[Text, Text] = {}
    sign: dict[Text, Literal[-1]] = {}


class ExperimentBody(Body):
    """A new `experiment.toml`."""

    name: Text
    kind: Text
    known: dict[Text, Text] = {}
    effects: list[Text] = Field(default=[], max_length=40)
    records: list[RecordBody] = Field(min_length=1, max_length=100)
    noise: dict[Text, Text] = {}


class DiagnoseBody(Body):
    """Options of a diagnosis."""

    all_effects: bool = False


class AddBody(Body):
    """Effects to add, and to remove first."""

    effects: Annotated[list[Text], Field(max_length=20)] = []
    drop: Annotated[list[Text], Field(max_length=20)] = []


def _project(request: Request) -> Project:
    return request.app.state.project


@router.get("/experiments")
def experiments(request: Request) -> list[dict[str, Any]]:
    """Experiments of the project."""
    return _project(request).experiments()


@router.get("/rigs")
def rigs() -> dict[str, Any]:
    """Kinds of rig with their channels and known quantities, and the units of channels."""
    from sysid.experiment.rigs import CHANNELS, RIGS

    kinds = {
        rig.name: {
            "inputs": [list(group) for group in rig.inputs],
            "measured": [list(group) for group in rig.measured],
            "channels": list(rig.channels),
            "known": {name: one.unit for name, one in rig.known.items()},
        }
        for rig in RIGS.values()
    }
    units = {name: {"unit": one.unit, "rotary": one.rotary_unit} for name, one in CHANNELS.items()}
    return {"kinds": kinds, "channels": units}


@router.get("/effects")
def effects() -> list[dict[str, Any]]:
    """The library of effects: name, meaning, law, how it shows, source."""
    from sim.effects.catalogue import library

    names = ("name", "meaning", "equation", "shows", "source")
    return [{name: getattr(effect, name) for name in names} for effect in library().values()]


@router.post("/upload/{experiment}/{file}")
async def upload(request: Request, experiment: str, file: str) -> dict[str, Any]:
    """Store a dropped record file in the folder of an experiment, which may be new; nothing is left half written."""
    project = _project(request)
    name = plain_name(file)
    if Path(name).suffix.lower() not in RECORD_SUFFIXES:
        raise InputError(f"{name}: no record format; allowed: {', '.join(RECORD_SUFFIXES)}")
    target = project.inside(f"{plain_name(experiment)}/{name}")
    made, known = not target.parent.exists(), target.exists()
    try:
        with atomic_path(target) as temporary:
            await _write(request.stream(), temporary)
            if known and not await run_in_threadpool(filecmp.cmp, temporary, target, False):
                raise InputError(f"{experiment}/{name}: another file of that name is there; rename one of them")
    except BaseException:
        if made:
            with suppress(OSError):
                target.parent.rmdir()
        raise
    try:
        return {"file": name, **await run_in_threadpool(_columns, target, name)}
    except InputError:
        # A file that cannot be read is not kept: it would only be in the way.
        if not known:
            target.unlink(missing_ok=True)
        if made:
            with suppress(OSError):
                target.parent.rmdir()
        raise


async def _write(chunks: AsyncIterator[bytes], path: Path) -> None:
    with path.open("wb") as stream:
        async for chunk in chunks:
            await run_in_threadpool(stream.write, chunk)
        stream.flush()
        os.fsync(stream.fileno())


def _columns(path: Path, name: str) -> dict[str, Any]:
    """Labels of a record file, its units, and the first values of each column."""
    from sysid.experiment.readers.open import open_record_file

    opened = open_record_file(path, name)
    shown = []
    for index, label in enumerate(opened.header.labels):
        try:
            values = opened.columns([index])[0].values
            first, rows = [float(v) for v in values[:4]], int(values.size)
        except InputError as error:
            shown.append({"label": label.strip(), "error": str(error)})
            continue
        shown.append({"label": label.strip(), "unit": opened.header.units.get(label), "first": first, "rows": rows})
    return finite({"columns": shown})


@router.post("/experiments")
def new_experiment(request: Request, body: ExperimentBody) -> dict[str, Any]:
    """Write `experiment.toml` for records in a folder; it is read back, and removed when it is not valid."""
    from sysid.experiment.experiment import load_experiment

    project = _project(request)
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
    records = tomlkit.aot()
    for record in body.records:
        kept = {key: value for key, value in record.model_dump().items() if value}
        records.append(tomlkit.item(kept))
    document["record"] = records
    if body.noise:
        document["noise"] = body.noise
    return tomlkit.dumps(document)


@router.post("/demo")
def demo(request: Request) -> dict[str, Any]:
    """Copy the packaged records with hidden effects into a folder `demo` of the project, or into the next free one."""
    from workbench.commands.demo import free_folder, fresh_copy

    return {"name": fresh_copy(free_folder(_project(request).inside("demo"))).name}


@router.get("/experiment/{name:path}/ladder")
def ladder(request: Request, name: str) -> dict[str, Any]:
    """The rungs of an experiment, and whether its model was edited by hand since."""
    from sysid.experiment.experiment import load_experiment
    from sysid.ladder import current_ladder

    experiment = load_experiment(_project(request).experiment(name), request.app.state.design_values())
    rungs, edited = current_ladder(experiment)
    return finite({"rungs": rungs, "edited": edited, "effects": list(experiment.effects), "text": experiment.text})


@router.post("/experiment/{name:path}/compare")
def compare(request: Request, name: str) -> dict[str, Any]:
    """Start `stagecad compare`."""
    return _submit(request, name, "compare", "Compare")


@router.post("/experiment/{name:path}/diagnose")
def diagnose(request: Request, name: str, body: DiagnoseBody) -> dict[str, Any]:
    """Start `stagecad diagnose`."""
    return _submit(request, name, "diagnose", "Diagnose", all_effects=body.all_effects)


@router.post("/experiment/{name:path}/add")
def add(request: Request, name: str, body: AddBody) -> dict[str, Any]:
    """Start `stagecad add`."""
    if not body.effects and not body.drop:
        raise InputError("name at least one effect to add")
    words = ", ".join([*body.effects, *(f"without {one}" for one in body.drop)])
    return _submit(request, name, "add", f"Add {words}", effects=body.effects, drop=body.drop)


@router.post("/experiment/{name:path}/undo")
def undo(request: Request, name: str) -> dict[str, Any]:
    """Start `stagecad add --undo`, and fit the model that then stands."""
    return _submit(request, name, "undo", "Undo")


@router.post("/experiment/{name:path}/suggest")
def suggest(request: Request, name: str) -> dict[str, Any]:
    """Start `stagecad suggest`."""
    return _submit(request, name, "suggest", "Next measurement")


@router.get("/experiment/{name:path}/report")
def report(request: Request, name: str) -> FileResponse:
    """The report of an experiment: one page with its pictures inside, without scripts."""
    project = _project(request)
    folder = project.experiment(name).resolve()
    path = project.results / folder.name / "report.html"
    if not path.is_file():
        raise InputError(f"{name}: no report yet; compare or diagnose first")
    return FileResponse(path, media_type="text/html", headers={"content-security-policy": REPORT_POLICY})


def _submit(request: Request, name: str, task: str, title: str, **arguments: Any) -> dict[str, Any]:
    project = _project(request)
    folder = project.experiment(name)
    given = {
        "experiment": str(folder),
        "params": None if project.params is None else str(project.params.resolve()),
        "out": str(project.results),
        **arguments,
    }
    job = request.app.state.jobs.submit("identification", task, given, title=title, subject=name)
    return job.as_json()
