"""A drive force between its rows: held or sampled, as a mass against exact viscous friction shows it."""

from typing import Literal

import numpy as np
import pandas as pd
import pytest
from scipy.signal import cont2discrete, dlsim

import stagecad

MASS, DAMPING, STEP, ROWS = 2.0, 15.0, 2.5e-3, 4000
"""kg, N*s/m, s."""


def _force(time: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Sines of 0.5 to 8 Hz, N, and the motion under them in closed form, m: x = sum A e^(iwt) / (i c w - m w^2)."""
    random = np.random.default_rng(seed)
    omega = 2.0 * np.pi * random.uniform(0.5, 8.0, 12)
    waves = random.uniform(1.0, 3.0, 12) * np.exp(1j * (np.outer(time, omega) + random.uniform(0.0, 6.0, 12)))
    return waves.real.sum(axis=1), (waves / (1j * DAMPING * omega - MASS * omega**2)).real.sum(axis=1)


def _log(course: str, seed: int, spread: float) -> pd.DataFrame:
    random = np.random.default_rng(seed)
    time = STEP * (np.arange(ROWS) + spread * random.uniform(-0.5, 0.5, ROWS))
    force, position = _force(time, seed)
    if course == "held":
        system = cont2discrete((*_STATE, np.eye(2)[:1], np.zeros((1, 1))), STEP)
        position = dlsim(system, force)[1][:, 0]
    logged = force + random.normal(0.0, 0.02, ROWS), position + random.normal(0.0, 2e-8, ROWS)
    return pd.DataFrame({"time [s]": time, "drive_force [N]": logged[0], "position [m]": logged[1]})


_STATE = np.array([[0.0, 1.0], [0.0, -DAMPING / MASS]]), np.array([[0.0], [1.0 / MASS]])


@pytest.mark.parametrize(
    ("course", "stated", "spread", "found"),
    [
        ("held", None, 0.0, "zero"),
        ("sampled", None, 0.0, "linear"),
        ("sampled", None, 0.8, "linear"),
        ("sampled", "zero", 0.0, "zero"),
    ],
)
def test_course_of_the_force_is_read_off_the_records(
    course: str, stated: Literal["zero", "linear"] | None, spread: float, found: str
) -> None:
    experiment = stagecad.Experiment.from_dataframes(
        {"fit": _log(course, 1, spread), "validate": _log(course, 2, spread)},
        rig=stagecad.Rig("force-drive", {"mass": f"{MASS} kg"}, stated),
        model=["viscous"],
        noise={"drive_force": "0.02 N", "position": "20 nm"},
        validate=["validate"],
    )
    result = stagecad.compare(experiment)
    assert result.computed.problem.experiment.rig.input_hold == found
    over = result.errors["over_noise"]
    assert over.max() > 1.3 if stated else 0.9 < over.min() <= over.max() < 1.1
