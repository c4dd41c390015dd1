"""Free curves: the shape of an unknown law is reproduced; knots, priors, and the rigs that have such curves."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.generators.friction_drive_rig import Truth, write_experiment
from sysid.diagnosis.candidate import Candidate
from sysid.diagnosis.free_curves import LEAST_KNOTS, PRIOR_SCALE, free_curves, with_curve
from sysid.diagnosis.model_search import ModelSearch
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.problem import Problem, load_problem
from tests.sysid.slide import NOISE, POSITION, SIGN, TIME, VELOCITY, slide
from tests.sysid.tip import GAIN, TIP_NOISE, tip_record, write_tip


def _curves(problem: Problem) -> list[Candidate]:
    return ModelSearch(problem, fit_stated_model(problem)).curves


def _share(candidate: Candidate) -> float:
    """Part of the loss above the noise that is removed."""
    before = candidate.held_out.loss + candidate.gain.loss
    return candidate.gain.loss / (before - min(1.0, candidate.held_out.loss))


def _value(candidate: Candidate, at: np.ndarray) -> np.ndarray:
    """The fitted force or level (n,) of a free curve whose knots are even over `at` (n,)."""
    values = candidate.fitted.model.values
    name = candidate.effect.name
    heights = [values[f"{name}.a{k}"] for k in range(len(candidate.effect.parameters))]
    return np.interp(at, np.linspace(at.min(), at.max(), len(heights)), heights)


def _apart_from(signal: np.ndarray, *columns: np.ndarray) -> np.ndarray:
    """Rest (n,) of a signal after a least-squares fit of the columns (n,)."""
    matrix = np.column_stack(columns)
    return signal - matrix @ np.linalg.lstsq(matrix, signal, rcond=None)[0]


def test_force_and_level_of_the_position_are_free_curves(tmp_path: Path) -> None:
    middle = POSITION - POSITION.mean()
    cubic = 0.4 * (middle / np.max(np.abs(middle))) ** 3
    problem = slide(tmp_path, 1.5 * SIGN + 25.0 * VELOCITY + cubic, "coulomb", "viscous", held_out=True)
    curves = _curves(problem)
    best = curves[0]
    assert best.name == "free_force_of_position"
    assert best.effect.coordinates == ("position",)
    assert _share(best) > 0.98
    # In this motion the distance since reversal is nearly a function of the position; its curve leaves a residual.
    assert min(c.held_out.loss for c in curves[1:]) > 1.5
    assert best.held_out.loss == pytest.approx(1.0, abs=0.1)
    # Linear interpolation of a cubic of amplitude 0.4 N over twelve intervals errs by 0.4 * 6/8 * (1/6)^2 = 0.0083 N.
    assert _value(best, POSITION) == pytest.approx(cubic, abs=0.0083 + NOISE)
    uneven = 0.3 * np.exp(-(((POSITION - POSITION.mean()) / 2e-3) ** 2))
    problem = slide(tmp_path, (1.5 + uneven) * SIGN, "coulomb", held_out=True)
    best = _curves(problem)[0]
    assert best.name == "free_friction_of_position"
    assert _share(best) > 0.9
    one = np.ones(POSITION.size)
    assert _apart_from(_value(best, POSITION), one) == pytest.approx(_apart_from(uneven, one), abs=0.03)


def test_curves_need_varying_coordinates_and_a_friction_state(tmp_path: Path) -> None:
    plain = {effect.coordinates[0] for effect in free_curves(slide(tmp_path / "a", 1.5 * SIGN, "coulomb"))}
    assert {"position", "velocity", "acceleration", "distance_since_reversal"} <= plain
    assert not plain & {"temperature", "normal_load", "input"}
    warmth = {"temperature": 21.0 + 3.0 * np.sin(2 * np.pi * TIME / 1.7)}
    warm = free_curves(slide(tmp_path / "b", 1.5 * SIGN, "coulomb", extra=warmth))
    assert {effect.coordinates[0] for effect in warm} == plain | {"temperature"}
    with_state = free_curves(slide(tmp_path / "a", 1.5 * SIGN, "coulomb"))
    without = free_curves(slide(tmp_path / "b", 25.0 * VELOCITY, "viscous"))
    assert any(effect.level is not None for effect in with_state)
    assert all(effect.level is None for effect in without)
    # Along a measured motion a force of the velocity and a level of the velocity are the same change of the residual.
    assert "free_force_of_velocity" not in {effect.name for effect in with_state}
    assert "free_force_of_velocity" in {effect.name for effect in without}
    assert free_curves(load_problem(write_experiment(tmp_path, Truth(), ["coulomb"]))) == []


def test_knots_are_even_and_heights_have_a_prior(tmp_path: Path) -> None:
    problem = slide(tmp_path, 1.5 * SIGN, "coulomb", held_out=True)
    for effect in free_curves(problem):
        assert len(effect.parameters) >= LEAST_KNOTS
        assert len({p.name for p in effect.parameters}) == len(effect.parameters)
    position = next(e for e in free_curves(problem) if e.name == "free_force_of_position")
    assert position.force is not None
    axis = problem.fit_records[0].axis  # pyright: ignore[reportAttributeAccessIssue]
    count = len(position.parameters)
    heights = np.arange(count, dtype=float)
    # Heights that rise by one from knot to knot: even knots make the curve a straight line over the range.
    line = position.force(axis, tuple(heights))
    span = (axis.position - axis.position.min()) / np.ptp(axis.position)
    assert np.allclose(line, (count - 1) * span, atol=1e-9)
    problem = slide(tmp_path, 1.5 * SIGN, "coulomb")
    base = fit_stated_model(problem)
    for effect in free_curves(problem):
        model = with_curve(base.fitted.model, effect, problem.scales)
        own = [u for u in model.unknowns if u.key.startswith(f"{effect.name}.")]
        assert len(own) == len(effect.parameters)
        for unknown in own:
            assert unknown.start == 0.0
            assert unknown.prior is not None
            assert (unknown.prior.value, unknown.prior.std) == (0.0, PRIOR_SCALE * problem.scales.force)
        assert all(u.prior is None for u in model.unknowns if u not in own)
    assert problem.scales.force == pytest.approx(1.5, rel=0.02)


def _bent(voltage: np.ndarray) -> np.ndarray:
    """What a piezo adds to its voltage (n,), V: no law of the library."""
    return 3.0 * np.cos(voltage / 11.0)


def _tip(folder: Path) -> Problem:
    """Two records of a tip on two piezos with the same unknown static nonlinearity."""
    records = {}
    for seed, role in enumerate(("fit", "validate")):
        rng = np.random.default_rng(seed)
        phase = rng.uniform(0.0, 6.0, 4)
        first = 28.0 * np.sin(2 * np.pi * 3.1 * TIME + phase[0]) + 18.0 * np.sin(2 * np.pi * 0.9 * TIME + phase[1])
        second = 28.0 * np.sin(2 * np.pi * 2.3 * TIME + phase[2]) + 18.0 * np.sin(2 * np.pi * 1.7 * TIME + phase[3])
        moved = [GAIN * (u + _bent(u)) for u in (first, second)]
        records[role] = tip_record(TIME, (first, second), moved, TIP_NOISE * rng.standard_normal((2, TIME.size)))
    return load_problem(write_tip(folder, records))


def test_nonlinear_piezo_is_a_voltage_of_its_input(tmp_path: Path) -> None:
    problem = _tip(tmp_path)
    found = _curves(problem)
    assert {c.name for c in found} == {"free_voltage_of_input", "free_voltage_of_velocity"}
    best = found[0]
    assert best.name == "free_voltage_of_input"
    assert _share(best) > 0.95
    drives = np.concatenate([d for r in (*problem.fit_records, *problem.validate_records) for d in r.drives])  # pyright: ignore[reportAttributeAccessIssue]
    # Gain and offsets are fitted: the curve is determined up to a straight line. Nine knots, spacing 11.5 V: linear
    # interpolation of the cosine errs by 3/121 * 11.5^2/8 = 0.4 V.
    line = np.ones(drives.size), drives
    assert _apart_from(_value(best, drives), *line) == pytest.approx(_apart_from(_bent(drives), *line), abs=0.45)
