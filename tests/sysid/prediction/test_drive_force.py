"""A drive force: its jitter as noise or as feedback, and its course between the rows, as exact motions show them."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.signal import cont2discrete, dlsim

import stagecad

MASS, DAMPING, STEP, ROWS = 2.0, 15.0, 1e-3, 6000
ENCODER, SENSOR = 2e-7, 0.05
"""Noise of the position, m, and of a force sensor, N."""
NEAR = 4e-8
"""Noise of a better encoder, m."""
HOLD_STEP, HOLD_ROWS = 2.5e-3, 4000
_STATE = np.array([[0.0, 1.0], [0.0, -DAMPING / MASS]]), np.array([[0.0], [1.0 / MASS]])


def _log(feedback: float, sensor: float, seed: int) -> pd.DataFrame:
    """A command held from row to row that follows a reference, in part by feedback of the measured position."""
    random, time = np.random.default_rng(seed), STEP * np.arange(ROWS)
    free = np.array([[0.0, 1.0], [0.0, -DAMPING / MASS]]), np.array([[0.0], [1.0 / MASS]])
    step, push, *_ = cont2discrete((*free, np.eye(2), np.zeros((2, 1))), STEP)
    reference = 0.01 * np.sin(7.0 * time) * np.sin(1.3 * time + seed)
    rate = np.gradient(reference, STEP)
    ahead = MASS * np.gradient(rate, STEP) + DAMPING * rate
    state, seen = np.zeros(2), random.normal(0.0, ENCODER, ROWS)
    force, before = np.empty(ROWS), 0.0
    for k in range(ROWS):
        seen[k] += state[0]
        error = reference[k] - seen[k]
        force[k] = ahead[k] + feedback * (2e4 * error + 200.0 * (error - before) / STEP)
        before, state = error, step @ state + push[:, 0] * force[k]
    logged = force + random.normal(0.0, sensor, ROWS)
    return pd.DataFrame({"time [s]": time, "drive_force [N]": logged, "position [m]": seen})


def _compared(logs: list[pd.DataFrame], hold: Any, noise: dict[str, str] | None = None) -> Any:
    rig = stagecad.Rig("force-drive", {"mass": f"{MASS} kg"}, hold)
    records = dict(zip(("fit", "validate"), logs))
    given = {"rig": rig, "model": ["viscous"], "noise": noise, "validate": ["validate"]}
    return stagecad.compare(stagecad.Experiment.from_dataframes(records, **given))


@pytest.mark.parametrize(("feedback", "sensor"), [(1.0, 0.0), (0.0, SENSOR), (1e-2, SENSOR), (1.0, SENSOR)])
def test_only_what_a_sensor_adds_is_noise(feedback: float, sensor: float) -> None:
    result = _compared([_log(feedback, sensor, seed) for seed in (1, 2)], "zero")
    found = result.computed.problem.noise["drive_force"].value
    assert found == pytest.approx(sensor, rel=0.15) if sensor else found < 1e-6
    over = result.errors["over_noise"]
    assert 0.85 < over.min() <= over.max() < 1.15


def test_steps_of_a_held_force_are_no_error() -> None:
    """A tenth of a percent of a step beside it would be seen."""
    random, free = np.random.default_rng(3), np.array([[0.0, 1.0], [0.0, -DAMPING / MASS]])
    step, push, *_ = cont2discrete((free, np.array([[0.0], [1.0 / MASS]]), np.eye(2), np.zeros((2, 1))), STEP)
    logs = []
    for _ in ("fit", "validate"):
        force, state, places = np.repeat(random.uniform(-20.0, 20.0, ROWS // 40), 40), np.zeros(2), []
        for value in force:
            places.append(state[0])
            state = step @ state + push[:, 0] * value
        seen = np.array(places) + random.normal(0.0, NEAR, force.size)
        columns = {"time [s]": STEP * np.arange(force.size), "drive_force [N]": force, "position [m]": seen}
        logs.append(pd.DataFrame(columns))
    result = _compared(logs, "zero", {"position": f"{NEAR} m", "drive_force": "1 mN"})
    assert result.errors["over_noise"].max() < 1.1


def _force(time: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Sines of 0.5 to 8 Hz, N, and the motion under them in closed form, m: x = sum A e^(iwt) / (i c w - m w^2)."""
    random = np.random.default_rng(seed)
    omega = 2.0 * np.pi * random.uniform(0.5, 8.0, 12)
    waves = random.uniform(1.0, 3.0, 12) * np.exp(1j * (np.outer(time, omega) + random.uniform(0.0, 6.0, 12)))
    return waves.real.sum(axis=1), (waves / (1j * DAMPING * omega - MASS * omega**2)).real.sum(axis=1)


def _course(course: str, seed: int, spread: float) -> pd.DataFrame:
    random = np.random.default_rng(seed)
    time = HOLD_STEP * (np.arange(HOLD_ROWS) + spread * random.uniform(-0.5, 0.5, HOLD_ROWS))
    force, position = _force(time, seed)
    if course == "held":
        system = cont2discrete((*_STATE, np.eye(2)[:1], np.zeros((1, 1))), HOLD_STEP)
        position = dlsim(system, force)[1][:, 0]
    logged = force + random.normal(0.0, 0.02, HOLD_ROWS), position + random.normal(0.0, 2e-8, HOLD_ROWS)
    return pd.DataFrame({"time [s]": time, "drive_force [N]": logged[0], "position [m]": logged[1]})


@pytest.mark.parametrize(("course", "stated", "spread", "found"), [
    ("held", None, 0.0, "zero"), ("sampled", None, 0.0, "linear"), ("sampled", None, 0.8, "linear"),
    ("sampled", "zero", 0.0, "zero"),
])  # fmt: skip
def test_course_of_the_force_is_read_off_the_records(course, stated, spread, found) -> None:
    noise = {"drive_force": "0.02 N", "position": "20 nm"}
    result = _compared([_course(course, seed, spread) for seed in (1, 2)], stated, noise)
    assert result.computed.problem.experiment.rig.input_hold == found
    over = result.errors["over_noise"]
    assert over.max() > 1.3 if stated else 0.9 < over.min() <= over.max() < 1.1
