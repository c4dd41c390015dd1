"""Score test and screening of candidates: projection algebra, grid points and starts, pitches of periodic effects."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from sim.effects.catalogue import find
from sysid.diagnosis.model_search import ModelSearch
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber, with_final_jacobian
from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import fit_stated_model
from sysid.estimation.screening import (
    ScoredCandidate,
    candidate_directions,
    orthonormal,
    pitches,
    profiled_residual,
    refit_candidate,
    score_test,
    screen_and_refit,
    screen_scored,
)
from sysid.prediction.model import with_effect
from sysid.prediction.problem import Problem, load_problem
from tests.beside import beside
from tests.sysid.slide import POSITION, SIGN, STEP, TIME, VELOCITY, slide, slipping_spring

RNG = np.random.default_rng(0)


def fitted(problem: Problem) -> FittedModel:
    return fit_model(problem.start, problem.fit_records)


def scores(problem: Problem, effect: str) -> list:
    base = fitted(problem)
    grid = candidate_directions(base, find(effect), problem.fit_records, problem.scales)
    return score_test(find(effect), grid, *profiled_residual(base))


def test_the_basis_leaves_out_zero_and_dependent_columns() -> None:
    columns = RNG.standard_normal((200, 3)) * [1.0, 1e-9, 1e9]
    basis = orthonormal(np.column_stack([columns, np.zeros(200), columns[:, 0] + 1e9 * columns[:, 1]]))
    assert basis.shape == (200, 3)
    assert basis.T @ basis == pytest.approx(np.eye(3), abs=1e-12)
    scaled = columns / np.linalg.norm(columns, axis=0)
    assert basis @ (basis.T @ scaled) == pytest.approx(scaled, abs=1e-9)
    assert orthonormal(np.zeros((5, 2))).shape == (5, 0)


def test_a_spring_beside_the_stiffness_of_bristles_lowers_the_error(tmp_path: Path) -> None:
    """The score test takes the spring for the stiffness of all bristles: from there a short fit ends far above."""
    strokes = np.clip(1.3 * (2.0 / np.pi) * np.arcsin(np.sin(3.0 * np.pi * TIME)), -1.0, 1.0)
    position = 0.12e-3 * gaussian_filter1d(strokes, 15)
    force, state = np.empty(TIME.size), 0.0
    for k, step in enumerate(np.diff(position, prepend=position[0])):
        state += step / 4e-5 * max(1.0 - np.sign(step) * state, 0.0) ** 0.5
        state = float(np.clip(state, -1.0, 1.0))
        force[k] = 2.3 * state + 1000.0 * position[k] + 0.2
    motion = {"position": position, "velocity": np.gradient(position, STEP)}
    problem = slide(tmp_path, force, "presliding:free_maxwell_slip", extra=motion)
    base, spring = fit_stated_model(problem).fitted, find("cable_spring")
    profiled = profiled_residual(base)
    known = ScoredCandidate(
        spring, score_test(spring, candidate_directions(base, spring, problem.fit_records, problem.scales), *profiled)
    )
    found = screen_scored(known, base, problem.fit_records, problem.scales, profiled[0])
    assert found is not None and found.fitted.fit.cost <= base.fit.cost


def test_bristles_are_found_where_rigid_friction_is_fitted_as_zero(tmp_path: Path) -> None:
    """Bristles that hardly slip are a spring; a level of zero would have no gradient in their stretch."""
    problem = slide(tmp_path, 5.0 * slipping_spring(POSITION, 5e-3, 0.0) - 0.2 * SIGN, "coulomb")
    base = fitted(problem)
    assert base.model.values["coulomb.force"] == 0.0
    found = screen_and_refit(base, find("presliding"), problem.fit_records, problem.scales, profiled_residual(base))
    assert found is not None and found.error < 0.3 * root_mean_huber(base.fit.residual)


def test_profiled_residuals_are_orthogonal_to_the_base_model(tmp_path: Path) -> None:
    force = 1.5 * SIGN + 20.0 * VELOCITY
    force[700] += 1e4
    base = fitted(slide(tmp_path, force, "coulomb"))
    basis, target = profiled_residual(base)
    assert basis.T @ target == pytest.approx(0.0, abs=1e-6 * np.linalg.norm(target))
    assert np.max(np.abs(target)) < 0.01 * np.max(np.abs(base.fit.residual))
    # Under plain Coulomb friction a friction level that follows a constant load is the level itself.
    problem = slide(tmp_path, 1.5 * SIGN, "coulomb", extra={"normal_load [N]": np.full(SIGN.size, 10.0)})
    assert scores(problem, "load_dependent_friction") == []


def test_score_is_the_share_removed_by_least_squares(tmp_path: Path) -> None:
    problem = slide(tmp_path, 1.5 * SIGN + 3.0 * VELOCITY + 0.01 * np.sin(90 * POSITION / 1e-3), "coulomb")
    base = fitted(problem)
    found = scores(problem, "viscous")[0]
    # The same by hand: the residual regressed on the velocity and on what the base model moves.
    pick = base.weights.samples[0]["friction_force"]
    column = VELOCITY[pick] / base.weights.std[0]["friction_force"][pick]
    free = np.column_stack([column, base.fit.jacobian])
    _, target = profiled_residual(base)
    left = target - free @ np.linalg.lstsq(free, target, rcond=None)[0]
    assert found.predicted_reduction == pytest.approx(1.0 - (left @ left) / (target @ target), abs=1e-6)
    wanted = np.linalg.lstsq(free, target, rcond=None)[0][0]
    assert found.start["viscous.coefficient"] == pytest.approx(wanted, rel=1e-4)


def test_start_with_a_negative_drag_is_at_the_bound(tmp_path) -> None:
    # Friction that falls with the speed asks for a negative drag; physics does not have it.
    problem = slide(tmp_path, 1.5 * SIGN - 300.0 * VELOCITY * np.abs(VELOCITY), "coulomb")
    found = scores(problem, "quadratic_drag")[0]
    # What it would take with that sign is said, and not counted.
    assert found.blocked_reduction > 0.5
    assert found.predicted_reduction < 0.01
    assert found.start["quadratic_drag.coefficient"] == 0.0


def test_effect_without_amplitude_is_scored_at_finite_size(tmp_path: Path) -> None:
    tau = 8e-3
    force = 1.5 * SIGN + 20.0 * VELOCITY
    lagged = np.copy(force)
    for k in range(1, force.size):
        lagged[k] += np.exp(-STEP / tau) * (lagged[k - 1] - force[k])
    problem = slide(tmp_path, lagged, "coulomb", "viscous")
    assert scores(problem, "sensor_lag")[0].predicted_reduction > 0.5
    base = fitted(problem)
    found = screen_and_refit(base, find("sensor_lag"), problem.fit_records, problem.scales, profiled_residual(base))
    assert found is not None
    assert found.fitted.model.values["sensor_lag.time_constant"] == pytest.approx(tau, abs=0.5 * STEP)


def test_short_fit_follows_a_narrow_valley_to_its_lowest_point(tmp_path: Path) -> None:
    """Of a friction force of two levels a quadratic and a cubic part of the scale are nearly a change of its level."""
    ideal = 6.5 * SIGN + 5.0 * VELOCITY
    ratio = ideal / np.max(np.abs(ideal))
    force = ideal - 0.4 * ratio**2
    problem = slide(tmp_path, force, "coulomb", "viscous")
    base = fitted(problem)
    basis, target = profiled_residual(base)
    effect, records = find("sensor_nonlinearity"), problem.fit_records
    scores = score_test(effect, candidate_directions(base, effect, records, problem.scales), basis, target)
    short = screen_scored(ScoredCandidate(effect, scores), base, records, problem.scales, basis)
    assert short is not None
    whole = refit_candidate(base, short, records, problem.scales)
    assert short.error <= 2.0 * root_mean_huber(whole.fitted.fit.residual)


def test_fit_with_an_initial_jacobian_ends_at_the_same_values(tmp_path: Path) -> None:
    force = 1.5 * SIGN + 3.0 * VELOCITY + 0.8 * SIGN * np.exp(-((VELOCITY / 2e-3) ** 2))
    problem = slide(tmp_path, force, "coulomb", "viscous")
    base = fitted(problem)
    values = {"stribeck.velocity": 4e-3, "stribeck.force": 0.5}
    start = with_effect(base.model, find("stribeck"), problem.scales, values)
    alone = fit_model(start, problem.fit_records, base.weights)
    near = fit_model(start, problem.fit_records, base.weights, near=base)
    assert near.fit.cost == pytest.approx(alone.fit.cost, rel=1e-4)
    short = fit_model(start, problem.fit_records, base.weights, 3, near=base, final_jacobian=False)
    assert not short.fit.exact
    told = with_final_jacobian(short, problem.fit_records)
    assert told.fit.exact and with_final_jacobian(told, problem.fit_records) is told
    assert told.fit.values == short.fit.values
    measured = fit_model(short.model, problem.fit_records, base.weights, 0)
    assert told.fit.jacobian == pytest.approx(measured.fit.jacobian)


def test_weights_of_plays_start_at_their_optimum() -> None:
    problem = load_problem(beside("data", "piezo_1hz"))
    base, law = fitted(problem), find("piezo_hysteresis:free_plays")
    score = scores(problem, law.name)[0]
    found = screen_and_refit(base, law, problem.fit_records, problem.scales, profiled_residual(base))
    assert found is not None
    assert all(value >= 0.0 for key, value in score.start.items() if ".play_" in key)
    # Least squares by hand with 15 plays: 84.9 nm on the held-out loops, where the loops differ by 83 nm.
    assert misfit(found.fitted.model, problem.validate_records)["tip_y"].rms < 90e-9
    start = with_effect(base.model, law, problem.scales, score.start)
    assert fit_model(start, problem.fit_records, base.weights, 4).fit.cost < 1.1 * found.fitted.fit.cost


RANGE = float(np.ptp(POSITION))


@pytest.mark.parametrize("waves", [5.3, 35.0, 72.0, 190.0])
@pytest.mark.parametrize("effect", ["magnetic_cogging", "position_dependent_friction"])
def test_a_pitch_is_found_whatever_its_number_in_the_range(tmp_path: Path, effect: str, waves: float) -> None:
    wave = np.sin(2.0 * np.pi * POSITION * waves / RANGE + 0.7)
    force = 1.5 * SIGN + 20.0 * VELOCITY + (0.1 * wave if effect == "magnetic_cogging" else 0.1 * wave * SIGN)
    problem = slide(tmp_path, force, "coulomb", "viscous")
    base = fit_model(problem.start, problem.fit_records)
    profiled = profiled_residual(base)

    peaks = pitches(base, find(effect), problem.fit_records, problem.scales, profiled[1])
    grid = candidate_directions(base, find(effect), problem.fit_records, problem.scales)
    listed = [score.predicted_reduction for score in score_test(find(effect), grid, *profiled)]
    found = screen_and_refit(base, find(effect), problem.fit_records, problem.scales, profiled)

    assert listed == sorted(listed, reverse=True)
    if waves > 10.0:
        # Half the width of a peak, for the highest one.
        assert RANGE / peaks[0] == pytest.approx(waves, abs=0.25)
    assert found is not None and found.reductions.predicted > 0.8
    values = found.fitted.model.values
    assert values[f"{effect}.pitch"] == pytest.approx(RANGE / waves, rel=1e-3)
    level = 1.0 if effect == "magnetic_cogging" else 1.5
    assert values[f"{effect}.amplitude"] == pytest.approx(0.1 / level, rel=0.02)
    assert np.sin(values[f"{effect}.phase"]) == pytest.approx(np.sin(0.7), abs=0.05)


@pytest.mark.parametrize("effect", ["magnetic_cogging", "position_dependent_friction"])
def test_the_shortest_pitch_of_the_search_is_found(tmp_path: Path, effect: str) -> None:
    """487 periods in the range, at five rows a period and more."""
    time = np.linspace(0.0, TIME[-1], 10 * TIME.size)
    position = CubicSpline(TIME, POSITION)(time)
    velocity = np.gradient(position, time)
    pitch = np.ptp(position) / 487.0
    wave = 0.1 * np.sin(2.0 * np.pi * position / pitch + 0.7)
    force = (1.5 + (effect != "magnetic_cogging") * wave) * np.sign(velocity) + 20.0 * velocity
    force += (effect == "magnetic_cogging") * wave
    motion = {"time": time, "position": position, "velocity": velocity}
    problem = slide(tmp_path, force, "coulomb", "viscous", extra=motion)
    base = fit_model(problem.start, problem.fit_records)

    found = screen_and_refit(base, find(effect), problem.fit_records, problem.scales, profiled_residual(base))

    assert found is not None and found.reductions.predicted > 0.8
    assert found.fitted.model.values[f"{effect}.pitch"] == pytest.approx(pitch, rel=1e-4)


def test_cogging_of_a_motor_with_72_periods_a_turn_is_first() -> None:
    problem = load_problem(beside("data", "laas_cogging_static_quarter"))
    best = ModelSearch(problem, fit_stated_model(problem)).ranked[0]
    assert best.public_name == "magnetic_cogging"
    # 72 a turn, heitor-andrade/laas_anti_cogging; a record of 11 periods.
    assert 2.0 * np.pi / best.fitted.model.values["magnetic_cogging.pitch"] == pytest.approx(72.0, abs=0.3)
