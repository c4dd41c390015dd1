"""Waves along the travel, and a force at one place that waves can describe."""

from pathlib import Path

import numpy as np
import pytest

from sysid.diagnosis.residual_maps import coordinates_of, is_local
from sysid.estimation.misfit import residual_weights
from sysid.prediction.problem import load_problem
from tests.experiments import write_rig

TRAVEL = 0.1  # m


@pytest.mark.parametrize(
    ("pitches", "local"),
    [
        ((0.03,), False),
        ((0.03, 0.027), False),
        ((TRAVEL, TRAVEL / 2), False),
        ((0.0286, 0.014, 0.0085, 0.0071), False),
        ((), True),
    ],
)
def test_only_what_acts_at_one_place_is_local(tmp_path: Path, pitches: tuple[float, ...], local: bool) -> None:
    """Without pitches: a detent of 6 mm, a force to both sides of one place."""
    time = np.arange(4000) * 0.01
    position = 0.5 * TRAVEL * np.sin(0.7 * time)
    velocity = np.gradient(position, time)
    columns = {"time": time, "position": position, "velocity": velocity, "friction_force": np.sign(velocity)}
    rig = write_rig(tmp_path, "velocity-drive", {"fit": columns, "validate": columns}, ["coulomb"])
    problem = load_problem(rig)
    weights = residual_weights(problem.start, problem.validate_records)
    (record,), (samples,) = problem.validate_records, weights.samples
    x = np.concatenate([coordinates_of(record)["position"][pick] for pick in samples.values()])
    waves = sum((np.cos(2.0 * np.pi * x / pitch + k) for k, pitch in enumerate(pitches)), np.zeros(x.size))
    away = (x - 0.011) / 0.006
    change = waves if pitches else -away * np.exp(0.5 - 0.5 * away**2)
    assert is_local(change, problem.validate_records, weights) == local
