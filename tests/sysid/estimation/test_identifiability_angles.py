"""Principal angles between effects: known geometry, and equivalent, similar and different effects on a record."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import subspace_angles

from sim.effects.catalogue import find
from sysid.estimation.fit import FittedModel, fit_model
from sysid.estimation.identifiability import orthogonal_sensitivities, principal_angles, substitution_angle
from sysid.prediction.model import with_effect
from sysid.prediction.problem import Problem
from tests.sysid.slide import SIGN, VELOCITY, slide

ONE_GROUP = np.deg2rad(15.0)
"""Angle below which the tutorial treats two effects as equivalent on these records."""


@pytest.mark.parametrize("tilt", [1e-9, 1e-4, 0.02, 0.3, 1.2])
def test_angle_of_a_plane_rotated_about_one_of_its_lines(tilt: float) -> None:
    plane = np.eye(5)[:, :2]
    turned = np.column_stack([plane[:, 0], np.cos(tilt) * plane[:, 1] + np.sin(tilt) * np.eye(5)[:, 4]])
    assert principal_angles(plane, turned) == pytest.approx([0.0, tilt], rel=1e-6, abs=1e-12)


def test_principal_angles_agree_with_scipy() -> None:
    rng = np.random.default_rng(0)
    a, b = (np.linalg.qr(rng.standard_normal((40, k)))[0] for k in (2, 4))
    assert principal_angles(a, b) == pytest.approx(np.sort(subspace_angles(a, b)))
    assert principal_angles(b, a) == pytest.approx(principal_angles(a, b))


def test_angle_of_a_line_within_a_plane_is_zero() -> None:
    assert principal_angles(np.eye(6)[:, :1], np.eye(6)[:, :3]) == pytest.approx([0.0])


@pytest.fixture
def problem(tmp_path: Path) -> Problem:
    return slide(tmp_path, 1.5 * SIGN + 5.0 * VELOCITY, '"coulomb"')


def added(problem: Problem, base: FittedModel, effect: str) -> FittedModel:
    return fit_model(with_effect(base.model, find(effect), problem.scales), problem.fit_records, base.weights, 4)


def angle(problem: Problem, one: str, other: str) -> float | None:
    base = fit_model(problem.start, problem.fit_records)
    return substitution_angle(added(problem, base, one), added(problem, base, other), base)


def test_angle_of_equivalent_effects_is_zero(problem: Problem) -> None:
    # Under plain Coulomb friction a bias is an asymmetry of the level: with its viscous part held they are the same.
    base = fit_model(problem.start, problem.fit_records)
    asymmetry = with_effect(base.model, find("direction_asymmetry"), problem.scales)
    held = type(asymmetry)(
        asymmetry.effects, asymmetry.values, tuple(u for u in asymmetry.unknowns if "asymmetry.viscous" not in u.key)
    )
    one = fit_model(held, problem.fit_records, base.weights, 4)
    apart = substitution_angle(one, added(problem, base, "constant_bias"), base)
    assert apart is not None
    assert apart < 0.2 * ONE_GROUP


def test_angle_is_small_for_two_drag_laws_and_large_for_a_spring(problem: Problem) -> None:
    near, far = angle(problem, "viscous", "quadratic_drag"), angle(problem, "viscous", "cable_spring")
    assert near is not None
    assert far is not None
    assert near < far
    assert far > 4.0 * ONE_GROUP


def test_direction_of_the_base_model_is_projected_out(tmp_path: Path) -> None:
    problem = slide(tmp_path, 1.5 * SIGN, '"coulomb"', extra={"normal_load [N]": np.full(SIGN.size, 10.0)})
    base = fit_model(problem.start, problem.fit_records)
    load = added(problem, base, "load_dependent_friction")
    assert orthogonal_sensitivities(load, base).shape[1] == 0
    assert substitution_angle(load, added(problem, base, "viscous"), base) is None


def test_angle_is_not_symmetric_for_different_numbers_of_parameters(tmp_path: Path) -> None:
    level = 1.5 + 0.3 * np.exp(-((VELOCITY / 8e-3) ** 2))
    problem = slide(tmp_path, level * SIGN, '"coulomb"')
    base = fit_model(problem.start, problem.fit_records)
    curve, drag = (
        fit_model(added(problem, base, n).model, problem.fit_records, base.weights) for n in ("stribeck", "viscous")
    )
    # What the curve does is no straight line; drag cannot be negative, and does nothing here.
    could = substitution_angle(curve, drag, base)
    assert could is not None
    assert could > ONE_GROUP
    # Not only along its slope where it ended: all that it took.
    assert substitution_angle(curve, curve, base) == pytest.approx(0.0, abs=1e-3)
    assert substitution_angle(drag, curve, base) is None
