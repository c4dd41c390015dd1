"""Simulation of a driven mass in time: mass x'' = force of spring or drive - friction."""

from collections.abc import Mapping, Sequence

import numpy as np

from sim.effects.catalogue import Model
from sim.effects.effect import Effect
from sim.effects.friction.viscous import EFFECT as DAMPER
from sim.integration.drive import Drive, force, held_force, pulled_spring
from sim.integration.simulate import simulate
from sysid.experiment.experiment import Rig
from sysid.prediction.effect_terms import Values, values_of
from sysid.prediction.rig_model import Start
from sysid.prediction.sensors import sensed


def simulate_driven_mass(
    rig: Rig,
    time: np.ndarray,
    inputs: Mapping[str, np.ndarray],
    effects: Sequence[Effect],
    values: Values,
    at: Start,
    tolerance: float = 1e-7,
) -> dict[str, np.ndarray]:
    """Measured channels (n,) of a driven mass: position, velocity, and the force of the pulling spring."""
    kept = tuple(e for e in effects if e.acts_on != "sensor")
    finer, step = FINER if len(kept) < len(effects) else 1, float(time[1] - time[0])
    damping = values.get("rig.pull_damping", 0.0)
    laws = [values_of(e, values) for e in kept]
    if damping:
        kept, laws = (*kept, DAMPER), [*laws, DAMPER.values_type(damping)]
    run = simulate(
        Model(kept, tuple(laws)),
        _drive(rig, time, inputs, values),
        time[0] + step / finer * np.arange(finer * (time.size - 1) + 1),
        mass=values["rig.mass"],
        position=at.position,
        velocity=at.velocity,
        bristle=at.bristle,
        travelled=at.travelled,
        contact_age=at.contact_age,
        load=inputs.get("normal_load", 1.0),
        temperature=inputs.get("temperature", 0.0),
        tolerance=tolerance,
        most_steps=MOST_STEPS_PER_ROW * time.size,
    )
    channels = {"position": run.position, "velocity": run.velocity}
    if "pull_position" in inputs:
        channels = {"position": run.position, "spring_force": run.drive - damping * run.velocity}
    return {name: signal[::finer] for name, signal in sensed(effects, values, channels, step / finer).items()}


FINER = 8
"""Instants per row at which a sensor's effect is evaluated: the motion is not linear from row to row."""

MOST_STEPS_PER_ROW = 200
"""Attempted steps per row, on average, after which an integration is given up."""


def _drive(rig: Rig, time: np.ndarray, inputs: Mapping[str, np.ndarray], values: Values) -> Drive:
    if "pull_position" in inputs:
        pull, stiffness = inputs["pull_position"], values["rig.pull_stiffness"]
        lead = values.get("rig.pull_damping", 0.0) / stiffness
        return pulled_spring(time, pull + lead * np.gradient(pull, time), stiffness)
    return (force if rig.input_hold == "linear" else held_force)(time, inputs["drive_force"])
