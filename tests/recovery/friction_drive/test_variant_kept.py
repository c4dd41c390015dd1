"""A law that an effect was added with stays in the model where every fit begun anew with another law ends worse."""

from dataclasses import replace

import pytest

from benchmarks.generators.driven_stage import write_case
from sim.effects.catalogue import find
from sysid.estimation import variant_selection
from sysid.estimation.fit import fit_model
from sysid.estimation.variant_selection import select_variants, without_effect
from sysid.prediction.model import with_effect
from sysid.prediction.problem import load_problem

ADDED = "stribeck:rational"


@pytest.fixture
def grown(tmp_path):
    write_case(tmp_path, "stribeck", "lean", 1, 300)
    problem = load_problem(tmp_path)
    return problem, fit_model(
        with_effect(problem.start, find(ADDED), problem.scales), problem.fit_records, iterations=1
    )


def _ending_at(part):
    """A search whose fits end at a part of the cost of the fit they are handed first."""
    costs = []

    def fit_replacement(fitted, effect, records, scales):
        costs.append(fitted.fit.cost)
        model = with_effect(without_effect(fitted.model, effect.name), effect, scales)
        return replace(fitted, model=model, fit=replace(fitted.fit, cost=part * costs[0]))

    return fit_replacement


def test_it_stays_where_the_others_end_worse(grown, monkeypatch):
    problem, fitted = grown
    monkeypatch.setattr(variant_selection, "fit_replacement", _ending_at(20.0))
    kept, laws = select_variants(problem, fitted, ["stribeck"])
    assert kept is fitted
    assert laws == (ADDED,)


def test_it_goes_where_the_family_itself_ends_better(grown, monkeypatch):
    problem, fitted = grown
    monkeypatch.setattr(variant_selection, "fit_replacement", _ending_at(0.1))
    other, laws = select_variants(problem, fitted, ["stribeck"])
    assert "stribeck" in [effect.name for effect in other.model.effects]
    assert laws == ()
