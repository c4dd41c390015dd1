"""Friction-drive experiments: records of a rig in code of its own, with something hidden in it."""

import json
from dataclasses import replace

import pytest

from benchmarks.generators.friction_drive_rig import GAIN, MASS, NOISE, STIFFNESS, Truth, write_experiment
from sim.effects.catalogue import find
from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import fit_stated_model
from sysid.estimation.screening import profiled_residual, screen_and_refit
from sysid.prediction.observable import candidate_effects
from sysid.prediction.problem import load_problem
from tests.refusals import refused
from workbench.cli import run


def over_noise(problem, model) -> float:
    return misfit(model, problem.validate_records)["position"].over_noise


def tried(problem, base, name: str):
    """The model with one effect more, fitted, and its misfit on the record held out; that of the base if it does
    nothing."""
    basis, target = profiled_residual(base.fitted)
    found = screen_and_refit(base.fitted, find(name), problem.fit_records, problem.scales, (basis, target))
    if found is None:
        return base.fitted.model, over_noise(problem, base.fitted.model)
    return found.fitted.model, over_noise(problem, found.fitted.model)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Nothing hidden: the model has all that the rig does."""
    problem = load_problem(write_experiment(tmp_path_factory.mktemp("plain"), Truth(), ["coulomb"]))
    return problem, fit_stated_model(problem)


def test_a_complete_model_is_down_to_the_noise_and_its_effects_are_tried_where_they_show(plain):
    problem, base = plain
    values = base.fitted.model.values
    assert over_noise(problem, base.fitted.model) < 1.1
    assert values["rig.gain"] == pytest.approx(GAIN, rel=2e-3)
    assert values["coulomb.force"] == pytest.approx(1.5, rel=0.01)
    problem, _ = plain
    names = [effect.name for effect in candidate_effects(problem, ["coulomb"])]
    assert {"contact.coulomb", "contact.presliding", "piezo_hysteresis", "gain_mismatch", "sensor_lag"} <= set(names)
    # The tip goes neither up nor down in these records, and nothing slips yet.
    assert "contact.load_dependent_friction" not in names and "flexible_mode" in names
    slipping = [effect.name for effect in candidate_effects(problem, ["coulomb", "contact.coulomb"])]
    assert "contact.stribeck" in slipping and "contact.coulomb" not in slipping and "coulomb" not in slipping
    # The motion tells forces over stiffness only: with half of it known, all forces and the mass come out halved.
    problem, base = plain
    half = {"rig.contact_stiffness": 0.5 * STIFFNESS, "rig.mass": 0.5 * MASS}
    values = {key: 0.5 * value for key, value in base.fitted.model.values.items() if key.endswith(("force", "damping"))}
    scaled = replace(base.fitted.model, values={**base.fitted.model.values, **half, **values})
    assert over_noise(problem, scaled) == pytest.approx(over_noise(problem, base.fitted.model), rel=1e-6)


@pytest.mark.parametrize(
    ("hidden", "effect", "value", "expected"),
    [
        ({"mismatch": 0.08}, "gain_mismatch", "gain_mismatch.mismatch", 0.08),
        # An effect of the piezos as the mismatch is, with a state of its own.
        pytest.param(
            *({"hysteresis": 0.12}, "piezo_hysteresis:bouc_wen", "piezo_hysteresis:bouc_wen.strength", 0.12),
            marks=pytest.mark.slow,
        ),
        ({"slip": 1.6}, "contact.coulomb", "contact.coulomb.force", 1.6),
    ],
)
def test_a_hidden_effect_explains_and_its_rivals_do_not(tmp_path, hidden, effect, value, expected):
    # Voltages that only oppose each other cannot tell a weaker stack from a smaller gain.
    lift = 15.0 if "mismatch" in hidden else 0.0
    problem = load_problem(write_experiment(tmp_path, Truth(**hidden), ["coulomb"], lift))
    base = fit_stated_model(problem)
    assert over_noise(problem, base.fitted.model) > 5.0
    model, after = tried(problem, base, effect)
    assert after < 2.0
    assert model.values[value] == pytest.approx(expected, rel=0.05)
    for rival in {"piezo_creep", "sensor_lag", "viscous", "gain_mismatch"} - {effect}:
        assert tried(problem, base, rival)[1] > 3.0 * after


@pytest.mark.slow
def test_slip_that_goes_with_the_load(tmp_path):
    folder = write_experiment(tmp_path, Truth(slip=2.2, load_exponent=1.0), ["coulomb", "contact.coulomb"], lift=15.0)
    problem = load_problem(folder)
    base = fit_stated_model(problem)
    assert over_noise(problem, base.fitted.model) > 20.0
    model, after = tried(problem, base, "contact.load_dependent_friction")
    assert after < 2.0
    assert model.values["contact.load_dependent_friction.sensitivity"] == pytest.approx(1.0, abs=0.03)
    assert model.values["contact.coulomb.force"] == pytest.approx(2.2, rel=0.02)
    assert tried(problem, base, "contact.stribeck")[1] > 5.0 * after


def test_tips_without_lengths_and_cores_without_bristles_are_refused(tmp_path, command):
    folder = write_experiment(tmp_path, Truth(), ["lugre"])
    refused("allowed: 'coulomb' and 'presliding'", fit_stated_model, load_problem(folder))
    folder = write_experiment(tmp_path / "rig", Truth(), ["coulomb"])
    file = folder / "experiment.toml"
    file.write_text("\n".join(line for line in file.read_text().splitlines() if "piezo_spacing" not in line))
    assert "rig.known.piezo_spacing is missing" in command.refused("compare", folder, "--out", tmp_path / "out")


def test_compare_as_a_user_runs_it(tmp_path, capsys):
    folder = write_experiment(tmp_path / "rig", Truth(mismatch=0.08), ["coulomb"], lift=15.0)
    target = tmp_path / "compare.json"
    assert run(["compare", str(folder), "--out", str(tmp_path / "out"), "--json", str(target)]) == 0
    found = json.loads(target.read_text())
    assert found["form"] == "output"
    assert found["noise"]["position"] == {"value": NOISE, "unit": "m", "from": "given"}
    assert found["before"]["validate"]["position"]["over_noise"] > 5.0
