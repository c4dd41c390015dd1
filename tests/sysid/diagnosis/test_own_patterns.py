"""Residual after subtracting the patterns of effects that are in the model."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sim.effects.catalogue import find
from sysid.diagnosis.own_patterns import apart_from, own_coordinates
from sysid.estimation.fit import fit_model
from sysid.estimation.misfit import residual_weights, weighted_residual
from tests.sysid.slide import NOISE, SIGN, TIME, slide

RINGING = 3.0 * NOISE * np.sin(2 * np.pi * 140.0 * TIME)
SETTLING = 0.3 / (1.0 + TIME / 0.2) * SIGN


def left(folder: Path, missing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Held-out residual of Coulomb friction, and the same apart from what follows the distance travelled."""
    problem = slide(folder, 1.5 * SIGN + missing, '"coulomb"', held_out=True)
    model = fit_model(problem.start, problem.fit_records).model
    weights = residual_weights(model, problem.validate_records)
    residual = weighted_residual(model, problem.validate_records, weights)
    return residual, apart_from(residual, problem.validate_records, weights, own_coordinates([find("run_in")]))


def test_pattern_of_a_coordinate_is_removed_and_the_rest_stays(tmp_path: Path) -> None:
    residual, apart = left(tmp_path, SETTLING + RINGING)
    _, ringing = left(tmp_path, RINGING)
    assert np.std(np.clip(residual, -8.0, 8.0)) > 1.5 * np.std(np.clip(ringing, -8.0, 8.0))
    # Steps of a bin's width are left of a curve.
    assert np.median(np.abs(apart)) < 1.15 * np.median(np.abs(ringing))
    assert np.corrcoef(np.clip(apart, -8.0, 8.0), np.clip(ringing, -8.0, 8.0))[0, 1] > 0.8


def test_noise_is_nearly_unchanged(tmp_path: Path) -> None:
    residual, apart = left(tmp_path, np.zeros(TIME.size))
    assert 0.9 < np.std(apart) / np.std(residual) <= 1.0


def test_effect_of_velocity_has_no_own_coordinate() -> None:
    assert own_coordinates([find("stribeck")]) == ()
    assert own_coordinates([find("run_in"), find("sensor_drift")]) == ("distance_travelled", "time")
