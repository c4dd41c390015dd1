"""Scores of candidates: transfer, gain over the reference, and the joint score of two effects."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from sim.effects.catalogue import find
from sim.effects.effect import Effect
from sysid.diagnosis.candidate import Candidate, Reference, one_per_family
from sysid.diagnosis.candidate_screening import ScreeningResult, scored_pairs, screen_all
from sysid.diagnosis.held_out import HeldOut, correlation_time, transfer
from sysid.estimation.fit import fit_model
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model
from sysid.estimation.screening import IN_PAIRS
from sysid.prediction.model import public_name, with_effect
from sysid.prediction.problem import Problem, load_problem
from tests.sysid.autoregression import BLOCK
from tests.sysid.autoregression import noise_of_blocks as _noise
from tests.sysid.axis_with_pitch import uneven, with_cogging, write
from tests.sysid.slide import POSITION, SIGN, VELOCITY, slide


def _reference(folder: Path) -> Reference:
    problem = slide(folder, 1.5 * SIGN + 5.0 * VELOCITY + 3.0 * POSITION, "coulomb", held_out=True)
    return Reference.of(problem, fit_stated_model(problem))


def _with(reference: Reference, *effects: Effect) -> Candidate:
    problem, base = reference.problem, reference.base
    model = base.fitted.model
    for effect in effects:
        model = with_effect(model, effect, problem.scales)
    fitted = fit_model(model, problem.fit_records, base.fitted.weights)
    found = reference.evaluate(fitted, effects)
    assert found is not None
    return found


def test_gain_is_the_reduction_of_both_losses_of_a_finite_prediction(tmp_path: Path) -> None:
    reference = _reference(tmp_path)
    both = _with(reference, find("viscous"), find("cable_spring"))
    assert both.held_out.loss == pytest.approx(1.0, abs=0.1)
    assert both.gain.loss == pytest.approx(reference.held_out.loss - both.held_out.loss)
    assert both.fit_gain > 0.0
    assert both.error == pytest.approx(np.sqrt(both.held_out.loss))
    assert both.families == ("viscous", "cable_spring")
    assert both.after_validate["friction_force"].over_noise == pytest.approx(1.0, abs=0.1)
    # Coulomb level, drag, stiffness; the rest position only shifts the law along the axis.
    assert both.parameter_count == 3
    assert len(both.fitted.model.unknowns) == 4
    reference = _reference(tmp_path)
    fitted = _with(reference, find("viscous")).fitted
    undefined = replace(fitted, model=fitted.model.at({"viscous.coefficient": np.nan}))
    assert reference.evaluate(undefined, (find("viscous"),)) is None


def test_best_variant_of_each_effect_is_kept_and_the_simpler_one_if_nearly_as_good(tmp_path: Path) -> None:
    reference = _reference(tmp_path)
    plain = _with(reference, find("viscous"))
    other = _with(reference, find("cable_spring"))
    count = plain.parameter_count

    def variant(factor: float, parameters: int) -> Candidate:
        """A variant of the drag with an error larger by a factor, and another number of parameters."""
        unknowns = plain.fitted.model.unknowns[:1] * parameters
        fitted = replace(plain.fitted, model=replace(plain.fitted.model, unknowns=unknowns))
        block = plain.held_out.block
        return replace(plain, fitted=fitted, held_out=HeldOut(factor * plain.held_out.residual, block))

    simpler, richer = variant(1.004, count - 1), variant(0.995, count + 1)
    assert set(one_per_family([plain, simpler, other])) == {simpler, other}
    assert set(one_per_family([plain, richer, other])) == {plain, other}
    worse = variant(1.2, count - 1)
    assert set(one_per_family([worse, plain, other])) == {plain, other}
    assert set(one_per_family([replace(simpler, implausible="at its bound"), plain, other])) == {plain, other}
    kept = one_per_family([other, plain])
    assert [c.held_out.loss for c in kept] == sorted(c.held_out.loss for c in kept)


ALL = 10_000


def _screened(folder: Path) -> tuple[Problem, ReferenceFit, ScreeningResult]:
    problem = load_problem(folder)
    base = fit_stated_model(problem)
    return problem, base, screen_all(problem, base)


def test_pairs_of_grid_points_start_at_their_weights(tmp_path: Path) -> None:
    """Their reductions, their amplitudes, and which of all pairs is the best, by direct least squares."""
    _, base, screening = _screened(write(tmp_path, uneven))
    target, pairs = screening.target, scored_pairs(base.fitted, screening, ALL)
    assert len(pairs) > 20 and len({pair.families for pair in pairs}) == len(pairs)
    assert all(len(pair.families) == 2 for pair in pairs)
    assert [pair.reduction for pair in pairs] == sorted((pair.reduction for pair in pairs), reverse=True)
    solutions = []
    for pair in pairs[:20]:
        columns = np.hstack([score.columns for score in pair.scores])
        solutions.append(np.linalg.lstsq(columns, target, rcond=None)[0])
        rest = target - columns @ solutions[-1]
        assert pair.reduction == pytest.approx(target @ target - rest @ rest, rel=1e-3)
    best = pairs[0]
    assert best.families == {"position_dependent_friction", "cable_spring"}
    assert np.concatenate(best.weights) == pytest.approx(solutions[0], rel=1e-3, abs=1e-6)
    scores = [
        (public_name(one.effect.name), score.columns)
        for one in (*screening.fits, *screening.unfitted)
        if public_name(one.effect.name) in best.families
        for score in one.scores[:IN_PAIRS]
    ]
    direct = []
    for (name, columns), (other, others) in combinations(scores, 2):
        if name != other:
            both = np.hstack([columns, others])
            rest = target - both @ np.linalg.lstsq(both, target, rcond=None)[0]
            direct.append(float(target @ target - rest @ rest))
    assert best.reduction == pytest.approx(max(direct), rel=1e-3)
    # A negative Stribeck force resembles a drag, but is out of bounds; such pairs must not displace valid ones.
    problem, base, screening = _screened(write(tmp_path, with_cogging, "coulomb"))
    pairs = scored_pairs(base.fitted, screening, 6)
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


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9])
def test_correlation_time_of_autoregressive_noise(correlation: float) -> None:
    found = np.median([correlation_time(_noise(seed, correlation)) for seed in range(20)])
    assert found == pytest.approx((1.0 + correlation) / (1.0 - correlation), rel=0.15)


@pytest.mark.parametrize("correlation", [0.0, 0.9, 0.97])
def test_significance_has_unit_standard_error(correlation: float) -> None:
    """With a constant change c the amplitude of n samples of noise of correlation time T has the deviation
    sqrt(T/n)/c."""
    expected = 6.0
    time = (1.0 + correlation) / (1.0 - correlation)
    size = expected * np.sqrt(time / BLOCK.size)
    found = [transfer(_noise(s, correlation) + size, _noise(s, correlation), BLOCK).z for s in range(200)]
    assert np.median(found) == pytest.approx(expected, rel=0.15)
    assert np.std(found) == pytest.approx(1.0, rel=0.35)


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_change_unrelated_to_the_noise_is_not_significant(correlation: float) -> None:
    wave = 0.3 * np.sin(0.05 * np.arange(BLOCK.size))
    found = [transfer(noise, noise - wave, BLOCK) for noise in (_noise(seed, correlation) for seed in range(100))]
    assert max(abs(one.z) for one in found) < 3.5
    assert np.mean([one.amplitude for one in found]) == pytest.approx(0.0, abs=0.1)


def test_amplitude_blocks_and_significance_of_no_change() -> None:
    noise, wave = _noise(1), np.sin(0.05 * np.arange(BLOCK.size))
    half = transfer(noise + 0.5 * wave, noise - 0.5 * wave, BLOCK)
    assert half.amplitude == pytest.approx(0.5, abs=0.03)
    assert half.blocks > 500
    slow = _noise(2, 0.99)
    once = transfer(slow + np.where(BLOCK == 7, 3.0, 0.0), slow, BLOCK)
    assert once.blocks < 8
    assert once.z < 6.0
    everywhere = transfer(noise + 1.0, noise, BLOCK)
    assert everywhere.p_value < 1e-6
    noise = _noise(3)
    assert transfer(noise, noise, BLOCK).z == 0.0
    assert transfer(noise, np.where(BLOCK == 0, np.nan, noise), BLOCK).z == 0.0
