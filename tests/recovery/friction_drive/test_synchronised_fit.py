"""A fit held to the measured motion finds its way from where a fit of a stage on its own does not."""

import pytest

from benchmarks.generators.driven_stage import write_case
from sim.effects.catalogue import find
from sysid.estimation.driven_stage_search import synchronised_starts
from sysid.estimation.fit import fit_model
from sysid.estimation.misfit import misfit
from sysid.prediction.model import with_effect
from sysid.prediction.problem import load_problem

LAW = "stribeck:rational"


def test_a_stage_that_rings_on_its_pads_is_found_from_afar(tmp_path):
    truth = write_case(tmp_path, "stribeck", "lean", 1, 2000)
    problem = load_problem(tmp_path)
    model = with_effect(problem.start, find(LAW), problem.scales)
    far = model.at(
        {
            "rig.gain": truth["gain"],
            "rig.contact_stiffness": 1.4 * truth["stiffness"],
            "rig.contact_damping": truth["damping"],
            "coulomb.force": truth["pads"],
            f"{LAW}.force": 0.8 * truth["stribeck"],
            f"{LAW}.velocity": 0.5 * truth["stribeck_velocity"],
        }
    )
    on_its_own = fit_model(far, problem.fit_records)
    (nearer,) = synchronised_starts([far], problem.fit_records, None, 15)
    after = fit_model(nearer, problem.fit_records)
    assert misfit(after.model, problem.fit_records)["position"].over_noise < 1.2
    assert misfit(on_its_own.model, problem.fit_records)["position"].over_noise > 3.0
    assert after.model.values[f"{LAW}.velocity"] == pytest.approx(truth["stribeck_velocity"], rel=0.05)
