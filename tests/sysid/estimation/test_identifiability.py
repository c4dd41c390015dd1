"""Identifiability: correlations, inactive values, bounds, combinations, and principal angles between effects."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import subspace_angles

from sim.effects.catalogue import find
from sysid.estimation.covariance import (
    Intervals,
    correlation_json,
    identifiability_report,
    orthogonal_sensitivities,
    principal_angles,
    public_key,
    substitution_angle,
)
from sysid.estimation.fit import FittedModel, fit_model
from sysid.estimation.least_squares import FitResult
from sysid.estimation.misfit import ResidualWeights
from sysid.prediction.model import Model, with_effect
from sysid.prediction.problem import Problem
from tests.sysid.slide import SIGN, VELOCITY, slide

KEYS = ("coulomb.force", "viscous.coefficient", "stribeck:rational.force", "constant_bias.force")


def fitted(**changes: Any) -> FittedModel:
    values = dict.fromkeys(KEYS, 1.0)
    fit = FitResult(values, 1.0, np.eye(4), np.zeros(4), np.ones(4), KEYS, **changes)
    return FittedModel(Model((), values, ()), fit, ResidualWeights((), ()))


def intervals(*pairs: tuple[int, int, float], unidentified: tuple[str, ...] = ()) -> Intervals:
    matrix = np.eye(4)
    for i, j, r in pairs:
        matrix[i, j] = matrix[j, i] = r
    return Intervals({}, KEYS, matrix, unidentified)


def test_reports_of_identifiable_correlated_and_chained_values() -> None:
    assert identifiability_report(fitted(), intervals((0, 1, 0.85))) == []
    assert identifiability_report(fitted(), intervals((0, 1, -0.97))) == [
        "coulomb.force and viscous.coefficient are strongly correlated (-0.97)."
    ]
    words = identifiability_report(fitted(), intervals((0, 1, -0.97), (1, 2, 0.95)))
    assert len(words) == 1
    assert words[0].startswith("coulomb.force, viscous.coefficient and stribeck.force are strongly correlated")
    assert "constant_bias" not in words[0]
    known = intervals((0, 1, 0.5))
    known.correlation[3, :] = known.correlation[:, 3] = np.nan
    document = correlation_json(known)
    assert document["keys"][2] == "stribeck.force"
    assert document["matrix"][0][1] == 0.5
    assert document["matrix"][3] == [None] * 4
    assert public_key("sensor_lag@position.time_constant") == "sensor_lag@position.time_constant"
    assert public_key("presliding:lugre.stiffness") == "presliding.stiffness"


@pytest.mark.parametrize(
    ("at_bound", "sentence"),
    [
        (("coulomb.force",), "coulomb.force is at its bound; it has no interval."),
        (
            ("stribeck.force", "viscous.coefficient", "coulomb.force"),
            "stribeck.force, viscous.coefficient and coulomb.force are at their bounds; they have no intervals.",
        ),
    ],
)
def test_inactive_values_bounds_and_combinations_are_reported(at_bound: tuple[str, ...], sentence: str) -> None:
    words = identifiability_report(
        fitted(inactive=("viscous.coefficient",), at_bound=at_bound, converged=False),
        intervals(unidentified=("stribeck:rational.force against constant_bias.force",)),
    )
    assert words == [
        "viscous.coefficient has no influence in these records.",
        sentence,
        "Only a combination is identifiable from these records, not each value alone: "
        "stribeck.force against constant_bias.force.",
        "The fit stopped before it converged: values and intervals are approximate; state known values, or better "
        "start values, in [model.parameters].",
    ]


ONE_GROUP = np.deg2rad(15.0)
"""Angle below which the tutorial treats two effects as equivalent on these records."""


@pytest.mark.parametrize("tilt", [1e-9, 1e-4, 0.02, 0.3, 1.2])
def test_angle_of_a_plane_rotated_about_one_of_its_lines(tilt: float) -> None:
    plane = np.eye(5)[:, :2]
    turned = np.column_stack([plane[:, 0], np.cos(tilt) * plane[:, 1] + np.sin(tilt) * np.eye(5)[:, 4]])
    assert principal_angles(plane, turned) == pytest.approx([0.0, tilt], rel=1e-6, abs=1e-12)


def test_principal_angles_and_projections(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    a, b = (np.linalg.qr(rng.standard_normal((40, k)))[0] for k in (2, 4))
    assert principal_angles(a, b) == pytest.approx(np.sort(subspace_angles(a, b)))
    assert principal_angles(b, a) == pytest.approx(principal_angles(a, b))
    assert principal_angles(np.eye(6)[:, :1], np.eye(6)[:, :3]) == pytest.approx([0.0])
    problem = slide(tmp_path, 1.5 * SIGN, "coulomb", extra={"normal_load [N]": np.full(SIGN.size, 10.0)})
    base = fit_model(problem.start, problem.fit_records)
    load = added(problem, base, "load_dependent_friction")
    assert orthogonal_sensitivities(load, base).shape[1] == 0
    assert substitution_angle(load, added(problem, base, "viscous"), base) is None


@pytest.fixture
def problem(tmp_path: Path) -> Problem:
    return slide(tmp_path, 1.5 * SIGN + 5.0 * VELOCITY, "coulomb")


def added(problem: Problem, base: FittedModel, effect: str) -> FittedModel:
    return fit_model(with_effect(base.model, find(effect), problem.scales), problem.fit_records, base.weights, 4)


def angle(problem: Problem, one: str, other: str) -> float | None:
    base = fit_model(problem.start, problem.fit_records)
    return substitution_angle(added(problem, base, one), added(problem, base, other), base)


def test_angles_of_effects_of_the_library(problem: Problem) -> None:
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
    near, far = angle(problem, "viscous", "quadratic_drag"), angle(problem, "viscous", "cable_spring")
    assert near is not None
    assert far is not None
    assert near < far
    assert far > 4.0 * ONE_GROUP


def test_angle_is_not_symmetric_for_different_numbers_of_parameters(tmp_path: Path) -> None:
    level = 1.5 + 0.3 * np.exp(-((VELOCITY / 8e-3) ** 2))
    problem = slide(tmp_path, level * SIGN, "coulomb")
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
