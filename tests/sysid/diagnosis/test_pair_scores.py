"""Joint score of two effects: agreement with least squares on all their columns, and pairs that are no explanation."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from sysid.diagnosis.candidate_screening import ScreeningResult, screen_all
from sysid.diagnosis.pair_scores import scored_pairs
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model
from sysid.estimation.score_test import IN_PAIRS
from sysid.prediction.model import public_name
from sysid.prediction.problem import Problem, load_problem
from tests.sysid.axis_with_pitch import uneven, with_cogging, write

ALL = 10_000


def _screened(folder: Path) -> tuple[Problem, ReferenceFit, ScreeningResult]:
    problem = load_problem(folder)
    base = fit_stated_model(problem)
    return problem, base, screen_all(problem, base, [effect.name for effect in problem.start.effects])


def test_reduction_is_that_of_a_least_squares_fit(tmp_path: Path) -> None:
    _, base, screening = _screened(write(tmp_path, uneven))
    target = screening.target
    pairs = scored_pairs(base, screening, ALL)
    assert len(pairs) > 20
    for pair in pairs[:20]:
        columns = np.hstack([part.score.columns for part in pair.parts])
        solution, *_ = np.linalg.lstsq(columns, target, rcond=None)
        rest = target - columns @ solution
        assert pair.reduction == pytest.approx(target @ target - rest @ rest, rel=1e-3)
    assert [pair.reduction for pair in pairs] == sorted((pair.reduction for pair in pairs), reverse=True)


def test_weights_are_the_amplitudes_of_the_least_squares_fit(tmp_path: Path) -> None:
    _, base, screening = _screened(write(tmp_path, uneven))
    best = scored_pairs(base, screening, 1)[0]
    assert best.families == {"position_dependent_friction", "cable_spring"}
    columns = np.hstack([part.score.columns for part in best.parts])
    solution, *_ = np.linalg.lstsq(columns, screening.target, rcond=None)
    assert np.concatenate(best.weights) == pytest.approx(solution, rel=1e-3, abs=1e-6)


def test_no_pair_of_grid_points_has_a_larger_reduction(tmp_path: Path) -> None:
    """Direct least squares on every two grid points of the families that the best pair consists of."""
    _, base, screening = _screened(write(tmp_path, uneven))
    best = scored_pairs(base, screening, 1)[0]
    scores = [
        (public_name(one.effect.name), score.columns)
        for one in (*screening.fits, *screening.unfitted)
        if public_name(one.effect.name) in best.families
        for score in one.scores[:IN_PAIRS]
    ]
    target = screening.target
    direct = []
    for (name, columns), (other, others) in combinations(scores, 2):
        if name != other:
            both = np.hstack([columns, others])
            rest = target - both @ np.linalg.lstsq(both, target, rcond=None)[0]
            direct.append(float(target @ target - rest @ rest))
    assert best.reduction == pytest.approx(max(direct), rel=1e-3)


def test_one_pair_of_each_two_families_and_the_wanted_one_in_all(tmp_path: Path) -> None:
    _, base, screening = _screened(write(tmp_path, uneven))
    pairs = scored_pairs(base, screening, ALL)
    assert len({pair.families for pair in pairs}) == len(pairs)
    assert all(len(pair.families) == 2 for pair in pairs)
    wanted = scored_pairs(base, screening, 4, "cable_spring")
    assert len(wanted) == 4
    assert all("cable_spring" in pair.families for pair in wanted)


def test_pair_starts_at_the_weights_and_none_is_out_of_bounds(tmp_path: Path) -> None:
    """A negative Stribeck force resembles a drag, but is out of bounds; such pairs must not displace valid ones."""
    problem, base, screening = _screened(write(tmp_path, with_cogging, '"coulomb"'))
    pairs = scored_pairs(base, screening, 6)
    assert pairs[0].families == {"viscous", "magnetic_cogging"}
    models = [pair.start(base.fitted.model, problem.scales) for pair in pairs]
    for model in models:
        for unknown in model.unknowns:
            rounding = 1e-12 * abs(unknown.start)
            assert unknown.low - rounding <= unknown.start <= unknown.high + rounding, unknown.key
    stribeck = [m.values[f"{e.name}.force"] for m in models for e in m.effects if e.name.startswith("stribeck")]
    assert all(force > 0.0 for force in stribeck)
    # The true values: 9 N*s/m and 0.3 N.
    assert models[0].values["viscous.coefficient"] == pytest.approx(9.0, rel=0.1)
    assert abs(models[0].values["magnetic_cogging.amplitude"]) == pytest.approx(0.3, rel=0.3)
