"""Fits of a driven stage: the lowest valley is found, a fit to the measured motion, slow records, and a law kept."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.generators.driven_stage import HIDDEN, write_case
from sim.effects.catalogue import find
from sim.integration.friction_drive.event_driven import simulate_event_driven
from sim.integration.friction_drive.inputs import DrivenStage, TipMotion, velocity_independent
from sim.integration.friction_drive.planar import Guide, PlanarTipMotion, simulate_planar
from sysid.add import add_effects
from sysid.diagnose import diagnose
from sysid.estimation import variant_selection
from sysid.estimation.driven_stage_search import synchronised_starts
from sysid.estimation.fit import fit_model, root_mean_huber
from sysid.estimation.misfit import ChannelMisfit, misfit
from sysid.estimation.reference_fit import fit_stated_model, reference_fit, reported_fit
from sysid.estimation.screening import search_lower_minimum
from sysid.estimation.variant_selection import select_variants, without_effect
from sysid.prediction.model import with_effect
from sysid.prediction.problem import load_problem

LAW = "stribeck:rational"
STIFFNESS, DAMPING, MASS = 6e6, 300.0, 2.0
ROWS = 2000


def test_a_contact_that_holds_differently_both_ways_is_found_from_a_fit_that_shows_none_of_it(tmp_path):
    """The base model bent pads and stiffness by a third to make up for it: from there no step leads out."""
    write_case(tmp_path, "contact.direction_asymmetry", "there_and_back", 1, 2000)
    problem = load_problem(tmp_path)
    base = fit_stated_model(problem).fitted
    effect = find("contact.direction_asymmetry")
    near = fit_model(with_effect(base.model, effect, problem.scales), problem.fit_records, base.weights)
    assert root_mean_huber(near.fit.residual) > 0.9 * root_mean_huber(base.fit.residual)
    assert search_lower_minimum(base, near, problem.fit_records) is near
    found = search_lower_minimum(base, near, problem.fit_records, of_contact=True)
    assert misfit(found.model, problem.validate_records)["position"].over_noise < 1.15


def test_a_stage_that_rings_on_its_pads_is_found_from_afar(tmp_path):
    truth = write_case(tmp_path, "stribeck", "lean", 1, 2000)
    problem = load_problem(tmp_path)
    model = with_effect(problem.start, find(LAW), problem.scales)
    true = {"rig.gain": "gain", "rig.contact_damping": "damping", "coulomb.force": "pads"}
    start = {key: truth[name] for key, name in true.items()} | {"rig.contact_stiffness": 1.4 * truth["stiffness"]}
    law = {f"{LAW}.force": 0.8 * truth["stribeck"], f"{LAW}.velocity": 0.5 * truth["stribeck_velocity"]}
    far = model.at(start | law)
    on_its_own = fit_model(far, problem.fit_records)
    (nearer,) = synchronised_starts([far], problem.fit_records, None, 15)
    after = fit_model(nearer, problem.fit_records)
    assert misfit(after.model, problem.fit_records)["position"].over_noise < 1.2
    assert misfit(on_its_own.model, problem.fit_records)["position"].over_noise > 3.0
    assert after.model.values[f"{LAW}.velocity"] == pytest.approx(truth["stribeck_velocity"], rel=0.05)


@pytest.fixture
def grown(tmp_path):
    write_case(tmp_path, "stribeck", "lean", 1, 300)
    problem = load_problem(tmp_path)
    return problem, fit_model(with_effect(problem.start, find(LAW), problem.scales), problem.fit_records, iterations=1)


def _ending_at(part):
    """A search whose fits end at a part of the squared error of the fit they are handed first."""
    first = []

    def fit_replacement(fitted, effect, records, scales):
        first.append(fitted.fit)
        model = with_effect(without_effect(fitted.model, effect.name), effect, scales)
        error = {"residual": np.sqrt(part) * first[0].residual, "cost": part * first[0].cost}
        return replace(fitted, model=model, fit=replace(fitted.fit, **error))

    return fit_replacement


def test_a_search_stays_or_goes_where_the_family_ends_better(grown, monkeypatch):
    problem, fitted = grown
    monkeypatch.setattr(variant_selection, "fit_replacement", _ending_at(20.0))
    kept, laws = select_variants(problem, fitted, ["stribeck"])
    assert kept is fitted
    assert laws == (LAW,)
    monkeypatch.setattr(variant_selection, "fit_replacement", _ending_at(0.1))
    other, laws = select_variants(problem, fitted, ["stribeck"])
    assert "stribeck" in [effect.name for effect in other.model.effects]
    assert laws == ()


def _followed(step: float, pads: float) -> tuple[np.ndarray, np.ndarray]:
    time = np.arange(400) * step
    tip = 3e-6 * np.sin(2.0 * np.pi * time / (100.0 * step))
    one = np.ones(tip.size)
    curves = [velocity_independent(level * one) for level in (np.inf, pads)]
    driven = DrivenStage(STIFFNESS, DAMPING, MASS, step)
    return tip, simulate_event_driven(TipMotion(tip, one), 0.0 * one, *curves, driven)


@pytest.mark.parametrize("step", [0.05, 0.5, 50.0])
def test_a_stage_that_no_inertia_holds_back_lags_by_its_pads_alone(step):
    """Quasi-static: the contact is stretched by F/k while the pads slide, and the stage rests until it is."""
    pads = 1.2
    tip, stage = _followed(step, pads)
    reach = pads / STIFFNESS
    expected = np.zeros(tip.size)
    for k in range(1, tip.size):
        expected[k] = min(max(expected[k - 1], tip[k] - reach), tip[k] + reach)
    assert np.abs(stage - expected).max() < 2e-3 * np.ptp(tip)
    assert np.ptp(stage) == pytest.approx(np.ptp(tip) - 2.0 * reach, rel=2e-3)


@pytest.mark.parametrize("step", [0.05, 50.0])
def test_so_does_one_that_moves_in_the_plane(step):
    """Along a line that is not an axis: the radial pull of pads at rest is that of one axis."""
    pads = 1.2
    tip, line = _followed(step, pads)
    one = np.ones(tip.size)
    motion, driven = PlanarTipMotion(0.6 * tip, 0.8 * tip, one), DrivenStage(STIFFNESS, DAMPING, MASS, step)
    along, across = simulate_planar(motion, 0.0 * one, np.inf * one, pads * one, driven, Guide(0.0, 0.0))
    assert np.abs(0.6 * along + 0.8 * across - line).max() < 2e-3 * np.ptp(tip)
    assert np.abs(0.8 * along - 0.6 * across).max() < 1e-3 * np.ptp(tip)


def _over_noise(by_channel: dict[str, ChannelMisfit]) -> float:
    return by_channel["position"].over_noise


@pytest.mark.slow
def test_where_nothing_is_hidden_the_model_is_called_adequate_though_only_the_mass_is_known(tmp_path):
    truth = write_case(tmp_path, "nothing", "lift", 1, ROWS)
    found = diagnose(tmp_path)
    assert found.verdict == "adequate" and found.effect is None
    assert _over_noise(found.before_validate) == pytest.approx(1.0, abs=0.06)
    values = found.base.fitted.model.values
    # Inertia tells the stiffness of the contact, and with it every force.
    assert values["rig.contact_stiffness"] == pytest.approx(truth["stiffness"], rel=0.02)
    assert values["coulomb.force"] == pytest.approx(truth["pads"], rel=0.02)
    assert values["rig.gain"] == pytest.approx(truth["gain"], rel=1e-3)


def test_values_are_reported_with_an_uncertain_mass(tmp_path):
    truth = write_case(tmp_path, "nothing", "lift", 1, 500)
    file = tmp_path / "experiment.toml"
    text = file.read_text()
    (stated,) = (line for line in text.splitlines() if line.startswith("mass = "))
    file.write_text(text.replace(stated, f'mass = "{1.02 * truth["mass"]} +- {0.03 * truth["mass"]} kg"'))
    problem = load_problem(tmp_path)
    near = {"gain": "gain", "contact_stiffness": "stiffness", "contact_damping": "damping", "mass": "mass"}
    known = {f"rig.{key}": truth[name] for key, name in near.items()} | {"coulomb.force": truth["pads"]}
    _, base = reported_fit(problem, reference_fit(problem, fit_model(problem.start.at(known), problem.fit_records)))
    assert "rig.mass" in base.fitted.fit.keys
    assert misfit(base.fitted.model, problem.validate_records)["position"].over_noise < 1.1


@pytest.mark.slow
@pytest.mark.parametrize(("hidden", "motion", "left"), [
    ("gain_mismatch", "lift", 0.1), ("contact.coulomb", "sawtooth", 0.1), ("piezo_hysteresis", "lean", 0.0),
    ("contact.viscous", "sawtooth", 0.0), ("presliding", "walk", 0.0),
])  # fmt: skip
def test_the_hidden_effect_is_named_added_and_the_held_out_error_falls(tmp_path, hidden, motion, left):
    write_case(tmp_path, hidden, motion, 1, ROWS)
    found = diagnose(tmp_path)
    assert found.verdict == "missing-effect"
    assert {found.effect, *found.indistinguishable} & set(HIDDEN[hidden].accept)
    start = _over_noise(found.before_validate)
    step = add_effects(tmp_path, [found.effect or ""])
    assert _over_noise(step.after_validate) < max(1.3, left * start)
