"""Routes of the simulation view: the tip's path at once, the other experiments as jobs."""

from typing import Annotated, Any

from fastapi import APIRouter, Request
from pydantic import Field

from stagecad.parameters.errors import require_known
from workbench.operations.parameters import entry_row
from workbench.operations.result import finite
from workbench.operations.simulation.simulate import MODELS, NO_MODEL, TITLES, chosen_names, tip_ellipse
from workbench.page.routes.machine import Body, Text

router = APIRouter(prefix="/api/simulation")

EXPERIMENTS = {
    "stick-slip": "A mass pulled by a soft spring at constant speed sticks and slips",
    "presliding": "A force below break-away moves the mass by micrometres",
    "hysteresis": "Friction over velocity while the velocity oscillates",
    "passivity": "Energy that a friction model takes from, or gives to, an imposed motion",
    "stage-steps": "The stage on one actuator: staircases of single steps",
    "stage-speed": "The stage on one actuator: speed over drive frequency",
    "stage-coupling": "The stage on one actuator: motion in the other directions",
    "stage-positioning": "The stage on one actuator: moves to a target in closed loop",
    "stage-hunting": "The stage on one actuator: held at a target in closed loop",
}
"""Experiments on one body with friction, and studies of the driven stage."""

BODY_KEYS = tuple(
    f"friction.{name}"
    for name in ("mass", "coulomb", "breakaway", "stribeck_velocity", "bristle_stiffness", "bristle_damping", "viscous")
)
STAGE_KEYS = (
    "actuator.frequency",
    "actuator.stroke_amplitude",
    "actuator.phase",
    "preload.force",
    "payload.mass",
    "bearing.dynamic_friction",
    "bearing.static_friction",
)


class TipBody(Body):
    """Dimensions of the tip, and the drive of its piezos; SI."""

    piezo_spacing: float = Field(gt=0.0, le=10.0)
    tip_height: float = Field(gt=0.0, le=10.0)
    stroke: float = Field(gt=0.0, le=1e-3)
    phase: float = Field(ge=-100.0, le=100.0)


class SimulateBody(Body):
    """An experiment, its models, and values that differ from the design."""

    experiment: Text
    models: Annotated[list[Text], Field(min_length=1, max_length=8)]
    changes: dict[Text, Text] = {}


@router.get("")
def overview(request: Request) -> dict[str, Any]:
    """Experiments, friction models, and the parameters that they read."""
    design = request.app.state.machine.design().values
    tip = ("actuator.piezo_spacing", "actuator.tip_height", "actuator.stroke_amplitude", "actuator.phase")
    return finite(
        {
            "experiments": EXPERIMENTS,
            "models": {model: TITLES[model] for model in MODELS},
            "parameters": {
                name: [entry_row(design.entry(key)) for key in keys]
                for name, keys in (("body", BODY_KEYS), ("stage", STAGE_KEYS))
            },
            "tip": {key: {**entry_row(design.entry(key)), "si": design.si(key)} for key in tip},
        }
    )


@router.post("/tip")
def tip(body: TipBody) -> dict[str, Any]:
    """Path of the tip about its rest, with its half axes and tilt."""
    path = tip_ellipse(body.piezo_spacing, body.tip_height, body.stroke, body.phase)
    every = 2
    features = {name: {"value": value, "unit": unit} for name, (value, unit) in path.features().items()}
    return {"x": path.x[::every].tolist(), "y": path.y[::every].tolist(), "features": features}


@router.post("/run")
def run(request: Request, body: SimulateBody) -> dict[str, Any]:
    """Start an experiment; a waiting one is replaced."""
    session, jobs = request.app.state.machine, request.app.state.jobs
    require_known(body.experiment, EXPERIMENTS, f"no experiment '{body.experiment}'")
    chosen_names(body.models, MODELS, NO_MODEL)
    design = session.design({**session.changes, **body.changes})
    arguments = {"design": design, "experiment": body.experiment, "models": body.models}
    job = jobs.submit("simulation", "simulate", arguments, title="Simulate", subject=body.experiment, replaces=True)
    return job.as_json()
