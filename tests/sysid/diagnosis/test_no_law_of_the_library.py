"""Residuals that no law of the library explains stay unexplained, though one law removes a large part."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sysid.diagnose import diagnose
from sysid.diagnosis.candidate_screening import ScreeningResult
from sysid.diagnosis.evidence import Evidence
from sysid.diagnosis.trials import CandidateSearch, evaluate_all, explained_share
from sysid.diagnosis.verdict_limits import SPELLS
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.problem import Problem
from tests.sysid.slide import NOISE, POSITION, SIGN, TIME, slide


def _wave(pitch: float) -> np.ndarray:
    return np.sin(2 * np.pi * POSITION / pitch)


def test_texture_of_several_pitches_is_not_attributed_to_one_wave(tmp_path: Path) -> None:
    texture = 0.08 * _wave(1.9e-3) + 0.035 * (_wave(1.13e-3) + _wave(0.67e-3))
    problem = slide(tmp_path, (1.5 + texture) * SIGN, '"coulomb"', held_out=True)
    found = diagnose(problem)
    assert found.trials[0].public_name == "position_dependent_friction"
    assert explained_share(found.base, found.trials[0]) > 0.5
    assert found.verdict == "unexplained"
    assert found.maps[0].coordinate == "position"


def _evidence(problem: Problem) -> Evidence:
    base = fit_stated_model(problem)
    return Evidence(problem, base, CandidateSearch([], ScreeningResult([], [], np.empty(0))), [], 1.0, 0.0, False)


def test_stretches_above_the_noise_are_detected_and_outliers_are_not(tmp_path: Path) -> None:
    stuck = sum(((begin < TIME) & (begin + 0.05 > TIME)).astype(float) for begin in (0.31, 0.78, 1.07, 1.62, 2.05))
    wild = np.random.default_rng(4).permutation(stuck)
    in_spells = _evidence(slide(tmp_path / "spells", (1.5 + 12.0 * NOISE * stuck) * SIGN, '"coulomb"', held_out=True))
    scattered = _evidence(slide(tmp_path / "wild", (1.5 + 12.0 * NOISE * wild) * SIGN, '"coulomb"', held_out=True))
    assert min(in_spells.error, scattered.error) > SPELLS
    assert in_spells.in_spells
    assert not scattered.in_spells


def test_candidate_jacobians_are_kept_for_second_screenings(tmp_path: Path) -> None:
    problem = slide(tmp_path, (1.5 + 0.08 * _wave(1.9e-3)) * SIGN, '"coulomb"', held_out=True)
    base = fit_stated_model(problem)
    seen = evaluate_all(problem, base, ["coulomb"]).screening.jacobians
    assert seen is not None
    assert seen.size == base.fitted.fit.residual.size
    wave = seen.grids["position_dependent_friction"]
    assert all(point.changes.shape[0] == len(range(seen.size)[seen.rows]) for point in wave)
