"""At the true values nothing is left: the prediction against a generator with an integrator of its own.

What goes by the speed must be looked up at the speed of the moment, or a slip of a few milliseconds leaves a hundred
times the noise.
"""

import numpy as np
import pytest

from benchmarks.generators.driven_stage import write_case
from sim.effects.catalogue import find
from sim.numerics.record_operators import bouc_wen
from sysid.estimation.driven_stage_search import lowest_minimum, truncated
from sysid.estimation.fit import fit_model
from sysid.estimation.misfit import misfit, weighted_residual
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.model import with_effect
from sysid.prediction.observable import candidate_effects
from sysid.prediction.problem import load_problem

ROWS = 2000
OF_THE_RIG = {
    "rig.gain": "gain",
    "rig.contact_stiffness": "stiffness",
    "rig.contact_damping": "damping",
    "rig.press": "press",
    "coulomb.force": "pads",
    "contact.coulomb.force": "slip",
    "contact.load_dependent_friction.sensitivity": "load_exponent",
}


def at_truth(model, truth, own):
    values = {key: truth[name] for key, name in OF_THE_RIG.items()} | {
        key: truth[value] if isinstance(value, str) else value for key, value in own.items()
    }
    return model.at({key: value for key, value in values.items() if key in model.values})


@pytest.mark.parametrize(
    ("hidden", "motion", "seed", "law", "own", "most"),
    [
        # Tips that slow down while they slip, turn round, and slip and hold within a row.
        ("contact.stribeck", "sawtooth", 2, "contact.stribeck:rational",
         {"force": "contact_stribeck", "velocity": "contact_stribeck_velocity", "exponent": 2.0}, 1.1),
        ("contact.stribeck", "sawtooth", 3, "contact.stribeck:rational",
         {"force": "contact_stribeck", "velocity": "contact_stribeck_velocity", "exponent": 2.0}, 1.1),
        ("contact.viscous", "sawtooth", 1, "contact.viscous", {"coefficient": "contact_viscous"}, 1.1),
        # A level that falls with the load lets the tip slip on as it turns round.
        ("contact.load_dependent_friction", "walk", 1, "contact.load_dependent_friction:power",
         {"exponent": "load_exponent"}, 1.1),
        ("contact.direction_asymmetry", "there_and_back", 1, "contact.direction_asymmetry",
         {"coulomb": "contact_asymmetry"}, 1.1),
        ("direction_asymmetry", "lean", 1, "direction_asymmetry", {"coulomb": "asymmetry"}, 1.1),
        # A level that falls with the speed drives what it moves: whatever a step gets wrong grows.
        ("stribeck", "lean", 1, "stribeck:rational",
         {"force": "stribeck", "velocity": "stribeck_velocity", "exponent": 2.0}, 1.05),
    ],
)  # fmt: skip
def test_a_law_at_its_true_values_leaves_the_noise(tmp_path, hidden, motion, seed, law, own, most):
    truth = write_case(tmp_path, hidden, motion, seed, ROWS)
    problem = load_problem(tmp_path)
    records = (*problem.fit_records, *problem.validate_records)
    missing = misfit(at_truth(problem.start, truth, {}), records)["position"].over_noise
    model = with_effect(problem.start, find(law), problem.scales)
    model = at_truth(model, truth, {f"{law}.{key}": value for key, value in own.items()})
    left = misfit(model, problem.validate_records)["position"].over_noise
    assert left < most and missing > 4.0 * left


def test_a_press_under_which_the_tip_stays_does_not_hide_those_under_which_it_leaves(tmp_path):
    """Slips close to lift-off: a fit that begins where the tip never leaves finds no slope that leads out."""
    write_case(tmp_path, "nothing_walking", "walk", 1, ROWS)
    problem = load_problem(tmp_path)
    base = fit_stated_model(problem)
    assert misfit(base.fitted.model, problem.validate_records)["position"].over_noise < 1.1


def test_a_fit_leaves_the_valley_of_a_contact_far_too_stiff(tmp_path):
    """Forces over stiffness are right at any stiffness; inertia alone tells which."""
    truth = write_case(tmp_path, "nothing", "lift", 1, ROWS)
    problem = load_problem(tmp_path)
    model = at_truth(problem.start, truth, {})
    far = model.at({"rig.contact_stiffness": 1.9e8, "coulomb.force": 1.9e8 / truth["stiffness"] * truth["pads"]})
    found = lowest_minimum(fit_model(far, problem.fit_records, iterations=2), problem.fit_records)
    assert found.model.values["rig.contact_stiffness"] == pytest.approx(truth["stiffness"], rel=0.02)


def test_first_looks_see_the_beginning_of_a_long_record(tmp_path):
    truth = write_case(tmp_path, "nothing", "lift", 1, ROWS)
    problem = load_problem(tmp_path)
    whole = fit_model(at_truth(problem.start, truth, {}), problem.fit_records, iterations=1)
    same, records = truncated(whole, problem.fit_records, ROWS)
    assert same is whole
    cut, records = truncated(whole, problem.fit_records, 700)
    assert [record.size for record in records] == [700]
    residual = weighted_residual(cut.model, records, cut.weights)
    assert residual.size == cut.fit.residual.size == cut.fit.jacobian.shape[0] == 699
    # Where a record begins is read off its mean: the residuals differ by a constant, and that by little.
    difference = residual - cut.fit.residual
    assert np.ptp(difference) < 1e-6 and abs(difference).max() < 0.5


@pytest.mark.parametrize("turning", [0.5, 0.8, 1.0, 1.4])
def test_a_loop_by_bouc_and_wen_solves_its_equation(turning):
    """Against plain Euler steps, 4000 to a row: dh = du - (turning |du| h + (1 - turning) du |h|)/width."""
    volts = np.cumsum(np.random.default_rng(0).normal(0.0, 0.3, 60))
    fine, width, h = 4000, 0.8, 0.0
    expected = [0.0]
    for du in np.diff(volts) / fine:
        for _ in range(fine):
            h += du - (turning * abs(du) * h + (1.0 - turning) * du * abs(h)) / width
        expected.append(h)
    assert np.abs(bouc_wen(volts, width, turning) - expected).max() < 2e-4


def test_every_law_of_a_lag_is_tried(tmp_path):
    """A friction that follows the speed as a first-order lag, taken for a pure one, leaves 1.3 times the noise."""
    write_case(tmp_path, "frictional_lag", "lean", 1, 500)
    names = {effect.name for effect in candidate_effects(load_problem(tmp_path), ["coulomb", "stribeck"])}
    assert {"frictional_lag", "frictional_lag:relaxation"} <= names


def test_a_level_that_grows_at_rest_is_read_off_the_predicted_motion(tmp_path):
    """The measured one rests some rows late and creeps by its noise: read off that, a fit left 1.5 times the noise."""
    truth = write_case(tmp_path, "dwell_strengthening", "rests", 1, ROWS)
    problem = load_problem(tmp_path)
    law = "dwell_strengthening:fading"
    start = at_truth(
        with_effect(problem.start, find(law), problem.scales), truth,
        {f"{law}.force": 0.16, f"{law}.cut_off": 6e-3, f"{law}.memory_length": 1e-7},
    )  # fmt: skip
    fitted = fit_model(start, problem.fit_records, iterations=8)
    assert misfit(fitted.model, problem.validate_records)["position"].over_noise < 1.15
    assert fitted.model.values["coulomb.force"] == pytest.approx(truth["pads"], rel=0.01)
