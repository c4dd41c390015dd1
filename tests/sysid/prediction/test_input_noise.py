"""Jitter of a drive force: feedback that moves the mass, or noise of a sensor; a mass against viscous friction."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import cont2discrete

import stagecad

MASS, DAMPING, STEP, ROWS = 2.0, 15.0, 1e-3, 6000
ENCODER, SENSOR = 2e-7, 0.05
"""Noise of the position, m, and of a force sensor, N."""


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


@pytest.mark.parametrize(("feedback", "sensor"), [(1.0, 0.0), (0.0, SENSOR), (1e-2, SENSOR)])
def test_only_what_a_sensor_adds_is_noise(feedback: float, sensor: float) -> None:
    experiment = stagecad.Experiment.from_dataframes(
        {"fit": _log(feedback, sensor, 1), "validate": _log(feedback, sensor, 2)},
        rig=stagecad.Rig("force-drive", {"mass": f"{MASS} kg"}, "zero"),
        model=["viscous"],
        validate=["validate"],
    )
    result = stagecad.compare(experiment)
    found = result.computed.problem.noise["drive_force"].value
    assert found == pytest.approx(sensor, rel=0.15) if sensor else found < 1e-6
    over = result.errors["over_noise"]
    assert 0.85 < over.min() <= over.max() < 1.15
