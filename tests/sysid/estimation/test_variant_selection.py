"""Variants: replacement of an effect by another one, selection in the fit of the stated model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim.effects.catalogue import find
from sysid.estimation.fit import fit_model
from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import fit_stated_model
from sysid.estimation.variant_selection import (
    fit_replacement,
    fits_clearly_better,
    select_variants,
    selectable_effects,
    without_effect,
)
from sysid.prediction.problem import Problem, load_problem
from tests.experiments import replace_in, write_rig
from tests.sysid.slide import POSITION, VELOCITY, slide, slipping_spring


@pytest.fixture
def curve(tmp_path: Path) -> Problem:
    level = 1.5 + 0.6 * np.exp(-((VELOCITY / 4e-3) ** 2))
    return slide(tmp_path, level * np.sign(VELOCITY) + 8.0 * VELOCITY, "coulomb", "viscous", "stribeck")


def test_variants_and_starts_of_a_stribeck_curve(curve: Problem) -> None:
    stuck = fit_model(curve.start.at({"stribeck.velocity": 0.04}), curve.fit_records)
    assert stuck.model.values["stribeck.force"] == pytest.approx(0.0, abs=0.05)  # what this is for
    found = fit_replacement(stuck, find("stribeck"), curve.fit_records, curve.scales).model.values
    assert found["stribeck.force"] == pytest.approx(0.6, rel=0.01)
    assert found["stribeck.velocity"] == pytest.approx(4e-3, rel=0.02)
    assert found["viscous.coefficient"] == pytest.approx(8.0, rel=0.01)
    stuck = fit_model(curve.start, curve.fit_records)
    other = fit_replacement(stuck, find("stribeck:rational"), curve.fit_records, curve.scales)
    found, chosen = select_variants(curve, other)
    assert chosen == ()
    assert {e.name for e in found.model.effects} == {"coulomb", "viscous", "stribeck"}
    assert fits_clearly_better(found, other)
    assert not fits_clearly_better(other, found)
    # A fit gains nothing by larger deviations of its own.
    wide = dict.fromkeys(curve.fit_records[0].measured, 2.0)
    easier = replace(found.fit, residual=0.5 * found.fit.residual, cost=0.25 * found.fit.cost)
    assert not fits_clearly_better(replace(found, weights=found.weights.scaled(wide), fit=easier), found)
    rest = without_effect(curve.start, "stribeck:rational")
    assert [e.name for e in rest.effects] == ["coulomb", "viscous"]
    assert not any(key.startswith("stribeck") for key in [*rest.values, *(u.key for u in rest.unknowns)])


def test_variant_of_the_true_curve_is_selected(tmp_path: Path) -> None:
    level = 1.5 + 0.6 / (1.0 + np.abs(VELOCITY / 2e-3))
    problem = slide(tmp_path, level * np.sign(VELOCITY), "coulomb", "stribeck")
    _, chosen = select_variants(problem, fit_model(problem.start, problem.fit_records))
    assert chosen == ("stribeck:rational",)


def test_cogging_pitch_is_found_on_the_grid(tmp_path: Path) -> None:
    force = 1.5 * np.sign(VELOCITY) + 0.2 * np.sin(2 * np.pi * POSITION / 0.83e-3 + 0.4)
    problem = slide(tmp_path, force, "coulomb")
    alone = fit_model(problem.start, problem.fit_records)
    found = fit_replacement(alone, find("magnetic_cogging"), problem.fit_records, problem.scales).model.values
    assert found["magnetic_cogging.pitch"] == pytest.approx(0.83e-3, rel=1e-3)
    assert found["magnetic_cogging.amplitude"] == pytest.approx(0.2, rel=0.01)


def test_stated_starts_and_bounds_are_kept_by_the_search(tmp_path: Path) -> None:
    force = (1.5 + 0.6 * np.exp(-((VELOCITY / 4e-3) ** 2))) * np.sign(VELOCITY)
    found = []
    for settings in ({"stribeck.velocity": {"start": "9 mm/s", "fixed": True}}, {"stribeck.force": {"high": "0.5 N"}}):
        problem = slide(tmp_path, force, "coulomb", "stribeck", parameters=settings)
        assert selectable_effects(problem) == ()
        fitted = fit_model(problem.start, problem.fit_records)
        found.append(fit_replacement(fitted, find("stribeck"), problem.fit_records, problem.scales))
    assert "stribeck.velocity" not in {u.key for u in found[0].model.unknowns}
    assert found[0].model.values["stribeck.velocity"] == 9e-3
    assert found[1].model.values["stribeck.force"] == pytest.approx(0.5)
    assert found[1].fit.at_bound == ("stribeck.force",)


N, STEP, NOISE = 3000, 2e-3, 0.004
STRETCHES = np.array([0.4e-6, 0.9e-6, 4e-6, 30e-6])
LEVELS = np.array([0.5, 0.1, 0.3, 0.7])
VISCOUS = 12.0


def _record(seed: int) -> dict[str, np.ndarray]:
    """Four ideal springs side by side that slip one after another, and a viscous drag, N."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(N)
    size = 10.0 ** rng.uniform(-6.0, -4.0, 12)
    frequency, phase = rng.uniform(0.2, 3.0, 12), rng.uniform(0.0, 6.28, 12)
    position = size @ np.sin(2.0 * np.pi * np.outer(frequency, t) + phase[:, None])
    velocity = np.gradient(position, STEP)
    springs = [slipping_spring(position, stretch, np.sign(position[1] - position[0])) for stretch in STRETCHES]
    force = LEVELS @ springs + VISCOUS * velocity + NOISE * rng.standard_normal(N)
    return {"time": t, "position": position, "velocity": velocity, "friction_force": force}


@pytest.fixture
def rig(tmp_path):
    records = {"fit": _record(1), "validate": _record(2)}
    return write_rig(tmp_path, "velocity-drive", records, ["presliding", "viscous"], noise={"friction_force": NOISE})


def test_variants_of_maxwell_slip_and_those_named_by_the_user(rig):
    problem = load_problem(rig)
    base = fit_stated_model(problem)
    assert base.laws == ("presliding:free_maxwell_slip",)
    values = base.fitted.model.values
    assert values["viscous.coefficient"] == pytest.approx(VISCOUS, rel=0.05)
    assert values["presliding:free_maxwell_slip.force"] == pytest.approx(LEVELS.sum(), rel=0.03)
    over = misfit(base.fitted.model, problem.validate_records)["friction_force"].over_noise
    assert over < 3.0
    replace_in(rig / "experiment.toml", "presliding", "presliding:maxwell_slip")
    base = fit_stated_model(load_problem(rig))
    assert base.laws == ()
