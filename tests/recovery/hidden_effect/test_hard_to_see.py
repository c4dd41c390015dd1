"""Effects that leave little where one looks first: at rest, after a rest, at one frequency, within the bristles."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from generator import Plan, make_case

from sim.effects.catalogue import find
from sysid.diagnose import diagnose
from sysid.diagnosis.evidence import is_worthwhile
from sysid.diagnosis.trials import evaluate_all, evaluate_candidate
from sysid.estimation.misfit import away_from_events
from sysid.estimation.reference_fit import fit_stated_model
from sysid.estimation.score_test import profiled_residual
from sysid.estimation.screening import screen_and_refit
from sysid.prediction.problem import load_problem


@pytest.mark.parametrize(
    "rig,effect,seed",
    [
        pytest.param("spring-pull", "presliding", 2, marks=pytest.mark.slow),
        ("force-drive", "dwell_strengthening", 3),
        ("force-drive", "flexible_mode", 4),
        ("velocity-drive", "bristle_damping", 7),
        ("actuator-tip", "flexible_mode", 6),
    ],
)
def test_it_is_named_first(tmp_path: Path, rig: str, effect: str, seed: int) -> None:
    case = make_case(Plan(rig, (effect,), "moderate", rows=10000), np.random.default_rng(seed))
    case.write(tmp_path)
    found = diagnose(tmp_path)
    assert found.verdict == "missing-effect"
    assert effect in (found.effect, *found.indistinguishable)


def test_what_stops_leave_does_not_hide_an_effect_of_the_motion_between(tmp_path: Path) -> None:
    plan = Plan("force-drive", ("quadratic_drag",), "moderate", rows=5000)
    make_case(plan, np.random.default_rng(2)).write(tmp_path)
    case = load_problem(tmp_path)
    base = fit_stated_model(case)
    basis, target = profiled_residual(base.fitted)
    trials = {}
    for name in ("quadratic_drag", "run_in"):
        tried = screen_and_refit(base.fitted, find(name), case.fit_records, case.scales, (basis, target))
        assert tried is not None
        trial = evaluate_candidate(case, base, tried)
        assert trial is not None
        # Shocks at the stops, the same before and after, that no effect takes away.
        trials[name] = replace(trial, significance=1.0, steadiness=0.5)
    assert is_worthwhile(case, base, trials["quadratic_drag"])
    assert not is_worthwhile(case, base, trials["run_in"])
    near = ~away_from_events(case.validate_records, base.weights)
    drag = trials["quadratic_drag"]
    only_near = np.where(near, drag.residual, base.residual)
    assert not is_worthwhile(case, base, replace(drag, residual=only_near))


def test_a_law_that_made_up_for_the_effect_is_chosen_anew_beside_it(tmp_path: Path) -> None:
    make_case(Plan("velocity-drive", ("quadratic_drag",), "moderate", rows=6000), np.random.default_rng(3)).write(
        tmp_path
    )
    case = load_problem(tmp_path)
    base = fit_stated_model(case)
    # Without the drag another curve than the true one bends as the friction seems to.
    assert base.laws == ("stribeck:rational",)
    found = evaluate_all(case, base, [e.name for e in case.start.effects]).trials[0]
    assert found.public_name == "quadratic_drag"
    assert "stribeck" in [e.name for e in found.fitted.model.effects]
    tried = screen_and_refit(
        base.fitted, find("quadratic_drag"), case.fit_records, case.scales, profiled_residual(base.fitted)
    )
    assert tried is not None
    kept = evaluate_candidate(case, base, tried)
    assert kept is not None
    assert found.error < 1.1 < 1.5 < kept.error


def test_a_wave_of_the_friction_and_a_pull_are_two_though_the_wave_is_no_sine(tmp_path: Path) -> None:
    # The generator's wave has overtones: what the two leave follows the position, as it does where one pull is curved.
    effects = ("position_dependent_friction", "gravity_torque")
    plan = Plan("velocity-drive", effects, "strong", rows=5000)
    make_case(plan, np.random.default_rng(6)).write(tmp_path)
    found = diagnose(tmp_path)
    assert found.verdict == "missing-effect"
    assert found.effect in effects
