"""Channels of a rig as a model simulates them from the inputs of a record, without noise.

velocity-drive, actuator-tip    the prediction along the given motion or voltages is the simulation
spring-pull, force-drive        mass x'' = force of spring or drive - friction, integrated by `sim`
friction-drive                  the predicted motion; laws that depend on the motion are evaluated along the
                                predicted one, by iteration
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.effects.model import Model
from sim.integration.drive import Drive, force, held_force, pulled_spring
from sim.integration.simulate import simulate
from sim.library.effect import Effect
from sysid.experiment.experiment import Rig
from sysid.experiment.record import Record
from sysid.noise.estimate import Noise
from sysid.prediction.actuator_tip import predict_tip, tip_record
from sysid.prediction.effect_terms import Values, values_of
from sysid.prediction.force_balance.imposed_motion import velocity_drive
from sysid.prediction.force_balance.predict import predict_balance
from sysid.prediction.friction_drive.record import friction_drive_record, predict_friction_drive
from sysid.prediction.sensors import sensed
from sysid.signals.masks import filled
from sysid.signals.resampling import uniform

ROUNDS = 12
"""Most iterations of a friction drive's motion."""

SETTLED = 1e-4
"""Change from one iteration to the next, over the range of the motion, at which the motion is taken as found."""


@dataclass(frozen=True)
class Start:
    """State of a driven mass at the first row: position (m), velocity (m/s), states of the friction state model (zero
    where none), distance travelled (m) and contact age (s)."""

    position: float
    velocity: float = 0.0
    bristle: np.ndarray | None = None
    travelled: float = 0.0
    contact_age: float = 0.0


def simulated_channels(
    rig: Rig, record: Record, effects: Sequence[Effect], values: Values, start: Start | None = None
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time (n,), s, from zero at a uniform step, and the inputs and measured channels of a rig, each (n,), SI.

    Args:
        rig: of the experiment.
        record: with the inputs; gaps are interpolated. Measured channels in it are not used.
        effects, values: of the model.
        start: of a driven mass; by default at rest, on a spring without force.

    Raises:
        InputError: an effect that cannot be integrated in time.
        SimulationError: the integration could not be continued.
    """
    time, _, inputs = uniform_inputs(rig, record)
    simulated = _SIMULATED.get(rig.kind)
    if simulated is None:
        given = start or Start(float(inputs["pull_position"][0]) if "pull_position" in inputs else 0.0)
        found = simulate_driven_mass(rig, time, inputs, effects, values, given)
    else:
        at_rows = replace(record, time=time, channels=inputs, step=float(time[1] - time[0]), uniform=True)
        found = simulated(rig, at_rows, effects, values, start)
    return time, {**inputs, **found}


def uniform_inputs(rig: Rig, record: Record) -> tuple[np.ndarray, dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Time (n,), s, from zero at a uniform step; every channel there, (n,); and the inputs with their gaps filled."""
    time, _, channels, _ = uniform(record)
    used = ("normal_load", "temperature", *rig.declaration.input_channels)
    return time, channels, {name: filled(channels[name])[0] for name in used if name in channels}


def simulate_driven_mass(
    rig: Rig,
    time: np.ndarray,
    inputs: Mapping[str, np.ndarray],
    effects: Sequence[Effect],
    values: Values,
    at: Start,
    tolerance: float = 1e-7,
) -> dict[str, np.ndarray]:
    """Measured channels (n,) of a driven mass: position, velocity, and the force of the pulling spring.

    Args:
        rig: spring-pull or force-drive.
        time: s, (n,), from the start of the record.
        inputs: by channel, (n,), without gaps.
        effects, values: of the model.
        at: the state at the first instant.
        tolerance: relative error of a step of the integrator.

    Raises:
        InputError: an effect that cannot be integrated in time.
        SimulationError: the integration could not be continued.
    """
    kept = tuple(e for e in effects if e.acts_on != "sensor")
    finer, step = FINER if len(kept) < len(effects) else 1, float(time[1] - time[0])
    run = simulate(
        Model(kept, tuple(values_of(e, values) for e in kept)),
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
        channels = {"position": run.position, "spring_force": run.drive}
    return {name: signal[::finer] for name, signal in sensed(effects, values, channels, step / finer).items()}


FINER = 8
"""Instants per row at which a sensor's effect is evaluated: the motion is not linear from row to row."""

MOST_STEPS_PER_ROW = 200
"""Attempted steps per row, on average, after which an integration is given up."""


def _drive(rig: Rig, time: np.ndarray, inputs: Mapping[str, np.ndarray], values: Values) -> Drive:
    if "pull_position" in inputs:
        return pulled_spring(time, inputs["pull_position"], values["rig.pull_stiffness"])
    return (force if rig.input_hold == "linear" else held_force)(time, inputs["drive_force"])


def _along_motion(
    rig: Rig, record: Record, effects: Sequence[Effect], values: Values, start: Start | None
) -> dict[str, np.ndarray]:
    still = _with_constant(record, {"friction_force": 0.0})
    return predict_balance(velocity_drive(still, _no_noise(still)), effects, values)


def _of_tip(
    rig: Rig, record: Record, effects: Sequence[Effect], values: Values, start: Start | None
) -> dict[str, np.ndarray]:
    names = [name.removeprefix("rig.offset_") for name in values if name.startswith("rig.offset_")]
    still = _with_constant(record, dict.fromkeys(names, 0.0))
    return predict_tip(tip_record(still, _known(rig), _no_noise(still)), effects, values)


def _of_driven_stage(
    rig: Rig, record: Record, effects: Sequence[Effect], values: Values, start: Start | None
) -> dict[str, np.ndarray]:
    names = ["position", *(["position_y"] if "rig.turn" in values else [])]
    at = start.position if start is not None else 0.0
    along = _with_constant(record, dict.fromkeys(names, at))
    change = np.inf
    for _ in range(ROUNDS):
        found = predict_friction_drive(friction_drive_record(along, _known(rig), _no_noise(along)), effects, values)
        change = max(float(np.max(np.abs(found[n] - along.channels[n]))) for n in names)
        along = replace(along, channels={**along.channels, **found})
        if change <= SETTLED * float(np.ptp(found["position"])):
            break
    return found


def _with_constant(record: Record, constants: Mapping[str, float]) -> Record:
    added = {name: np.full(record.size, value) for name, value in constants.items()}
    return replace(record, channels={**record.channels, **added})


def _no_noise(record: Record) -> dict[str, Noise]:
    return {name: Noise(1e-300, "", "given") for name in record.channels}


def _known(rig: Rig) -> dict[str, float]:
    return {name: known.value for name, known in rig.known.items()}


_SIMULATED = {"velocity-drive": _along_motion, "actuator-tip": _of_tip, "friction-drive": _of_driven_stage}
