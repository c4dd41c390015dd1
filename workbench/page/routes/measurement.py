"""Routes of the measurement view: the jobs of the identification, the ladder, and the report."""

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Request
from fastapi.responses import FileResponse
from pydantic import Field

from stagecad.parameters.errors import InputError, require
from workbench.operations.result import finite
from workbench.page.project import plain_name
from workbench.page.routes.experiments import project_of
from workbench.page.routes.machine import Body, Text
from workbench.page.security import REPORT_POLICY

router = APIRouter(prefix="/api/experiment")


class DiagnoseBody(Body):
    """Options of a diagnosis."""

    all_effects: bool = False


class AddBody(Body):
    """Effects to add, and to remove first; `every`: all that a diagnosis establishes."""

    every: bool = False
    effects: Annotated[list[Text], Field(max_length=20)] = []
    drop: Annotated[list[Text], Field(max_length=20)] = []


class ExportBody(Body):
    """The language."""

    to: Literal["python", "c", "modelica", "fmu", "matlab", "table"]


class PredictBody(Body):
    """Values of parameters of the fitted model, SI; those left out keep their fitted value."""

    values: dict[Text, float] = Field(max_length=200)
    record: Text
    channel: Text


@router.get("/{name:path}/ladder")
def ladder(request: Request, name: str) -> dict[str, Any]:
    """The rungs of an experiment, and whether its model was edited by hand since."""
    from workbench.operations.measurement.add import ladder as ladder_of

    project = project_of(request)
    found = ladder_of(project.experiment(name), project.stated_design())
    stated = found.experiment.stated
    return finite(
        {"rungs": found.to_json(), "edited": found.edited, "effects": list(stated.effects), "text": stated.text}
    )


@router.get("/{name:path}/look")
def look(request: Request, name: str) -> dict[str, Any]:
    """The warnings of `stagecad look`, and its picture (SVG) of every channel as it is logged, before any fit."""
    from workbench.operations.measurement.look import look as look_at

    project = project_of(request)
    seen = look_at(project.experiment(name), project.stated_design())
    return {"warnings": seen.warnings, "figure": seen.plot().svg("channels as logged")}


@router.post("/{name:path}/compare")
def compare(request: Request, name: str) -> dict[str, Any]:
    """Start `stagecad compare`."""
    return _submit(request, name, "compare", "Compare")


@router.post("/{name:path}/predict")
def predict(request: Request, name: str, body: PredictBody) -> dict[str, Any]:
    """Start a prediction of the fitted model with other values of its parameters; a waiting one is replaced."""
    return _submit(request, name, "predict", "Predict", passing=True, **body.model_dump())


@router.post("/{name:path}/diagnose")
def diagnose(request: Request, name: str, body: DiagnoseBody) -> dict[str, Any]:
    """Start `stagecad diagnose`."""
    return _submit(request, name, "diagnose", "Diagnose", all_effects=body.all_effects)


@router.post("/{name:path}/add")
def add(request: Request, name: str, body: AddBody) -> dict[str, Any]:
    """Start `stagecad add`, or `stagecad add --all`."""
    if body.every and not (body.effects or body.drop):
        return _submit(request, name, "add", "Add all", effects=[], drop=[])
    if body.every or not (body.effects or body.drop):
        raise InputError("name at least one effect to add, or set 'every' and name none")
    words = ", ".join([*body.effects, *(f"without {one}" for one in body.drop)])
    return _submit(request, name, "add", f"Add {words}", effects=body.effects, drop=body.drop)


@router.post("/{name:path}/undo")
def undo(request: Request, name: str) -> dict[str, Any]:
    """Start `stagecad add --undo`, and fit the model that then stands."""
    return _submit(request, name, "undo", "Undo")


@router.post("/{name:path}/suggest")
def suggest(request: Request, name: str) -> dict[str, Any]:
    """Start `stagecad suggest`."""
    return _submit(request, name, "suggest", "Next measurement")


@router.post("/{name:path}/export")
def export(request: Request, name: str, body: ExportBody) -> dict[str, Any]:
    """Start `stagecad export`."""
    return _submit(request, name, "export", f"Export to {body.to}", to=body.to)


@router.get("/{name:path}/export/{file}")
def exported(request: Request, name: str, file: str) -> FileResponse:
    """A file of the exported model."""
    project = project_of(request)
    path = project.results_of(project.experiment(name)) / "export" / plain_name(file)
    require(path.is_file(), f"{name}: no exported file '{file}'")
    return FileResponse(path, media_type="application/octet-stream", filename=file)


@router.get("/{name:path}/report")
def report(request: Request, name: str) -> FileResponse:
    """The report of an experiment: one page with its pictures inside, without scripts."""
    project = project_of(request)
    path = project.results_of(project.experiment(name)) / "report.html"
    require(path.is_file(), f"{name}: no report yet; compare or diagnose first")
    return FileResponse(path, media_type="text/html", headers={"content-security-policy": REPORT_POLICY})


def _submit(
    request: Request, name: str, task: str, title: str, passing: bool = False, **arguments: Any
) -> dict[str, Any]:
    project = project_of(request)
    folder = project.experiment(name)
    given = {
        "experiment": str(folder),
        "params": None if project.params is None else str(project.params.resolve()),
        "out": str(project.results.resolve()),
        **arguments,
    }
    jobs = request.app.state.jobs
    job = jobs.submit("identification", task, given, title=title, subject=name, replaces=passing, passing=passing)
    return job.as_json()
