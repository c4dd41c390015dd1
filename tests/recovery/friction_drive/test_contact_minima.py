"""An effect between tip and stage whose fit promised nothing goes on to its lowest valley, and is found there."""

from benchmarks.generators.driven_stage import write_case
from sim.effects.catalogue import find
from sysid.estimation.fit import fit_model, root_mean_huber
from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import fit_stated_model
from sysid.estimation.screening import RefittedEffect, search_lower_minimum
from sysid.prediction.model import with_effect
from sysid.prediction.problem import load_problem


def test_a_contact_that_holds_differently_both_ways_is_found_from_a_fit_that_shows_none_of_it(tmp_path):
    """The base model bent pads and stiffness by a third to make up for it: from there no step leads out."""
    write_case(tmp_path, "contact.direction_asymmetry", "there_and_back", 1, 2000)
    problem = load_problem(tmp_path)
    base = fit_stated_model(problem).fitted
    effect = find("contact.direction_asymmetry")
    near = fit_model(with_effect(base.model, effect, problem.scales), problem.fit_records, base.weights)
    assert root_mean_huber(near.fit.residual) > 0.9 * root_mean_huber(base.fit.residual)
    candidate = RefittedEffect(effect, 0.0, near)
    assert search_lower_minimum(base, candidate, problem.fit_records) is candidate
    found = search_lower_minimum(base, candidate, problem.fit_records, of_contact=True).fitted
    assert misfit(found.model, problem.validate_records)["position"].over_noise < 1.15
