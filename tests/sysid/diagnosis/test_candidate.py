"""Candidates: gain over the reference, one variant of each effect, and the count of parameters."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim.effects.catalogue import find
from sim.effects.effect import Effect
from sysid.diagnosis.candidate import Candidate, Reference, one_per_family
from sysid.diagnosis.held_out import HeldOut
from sysid.estimation.fit import fit_model
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.model import with_effect
from tests.sysid.slide import POSITION, SIGN, VELOCITY, slide


def _reference(folder: Path) -> Reference:
    problem = slide(folder, 1.5 * SIGN + 5.0 * VELOCITY + 3.0 * POSITION, '"coulomb"', held_out=True)
    return Reference.of(problem, fit_stated_model(problem))


def _with(reference: Reference, *effects: Effect) -> Candidate:
    problem, base = reference.problem, reference.base
    model = base.fitted.model
    for effect in effects:
        model = with_effect(model, effect, problem.scales)
    fitted = fit_model(model, problem.fit_records, base.fitted.weights)
    found = reference.evaluate(fitted, effects)
    assert found is not None
    return found


def test_gain_is_the_reduction_of_both_losses(tmp_path: Path) -> None:
    reference = _reference(tmp_path)
    both = _with(reference, find("viscous"), find("cable_spring"))
    assert both.held_out.loss == pytest.approx(1.0, abs=0.1)
    assert both.gain.loss == pytest.approx(reference.held_out.loss - both.held_out.loss)
    assert both.fit_gain > 0.0
    assert both.error == pytest.approx(np.sqrt(both.held_out.loss))
    assert both.families == ("viscous", "cable_spring")
    assert both.after_validate["friction_force"].over_noise == pytest.approx(1.0, abs=0.1)
    # Coulomb level, drag, stiffness; the rest position only shifts the law along the axis.
    assert both.parameter_count == 3
    assert len(both.fitted.model.unknowns) == 4


def test_model_without_a_finite_prediction_is_no_candidate(tmp_path: Path) -> None:
    reference = _reference(tmp_path)
    fitted = _with(reference, find("viscous")).fitted
    undefined = replace(fitted, model=fitted.model.at({"viscous.coefficient": np.nan}))
    assert reference.evaluate(undefined, (find("viscous"),)) is None


def test_best_variant_of_each_effect_is_kept_and_the_simpler_one_if_nearly_as_good(tmp_path: Path) -> None:
    reference = _reference(tmp_path)
    plain = _with(reference, find("viscous"))
    other = _with(reference, find("cable_spring"))
    count = plain.parameter_count

    def variant(factor: float, parameters: int) -> Candidate:
        """A variant of the drag with an error larger by a factor, and another number of parameters."""
        unknowns = plain.fitted.model.unknowns[:1] * parameters
        fitted = replace(plain.fitted, model=replace(plain.fitted.model, unknowns=unknowns))
        block = plain.held_out.block
        return replace(plain, fitted=fitted, held_out=HeldOut(factor * plain.held_out.residual, block))

    simpler, richer = variant(1.004, count - 1), variant(0.995, count + 1)
    assert set(one_per_family([plain, simpler, other])) == {simpler, other}
    assert set(one_per_family([plain, richer, other])) == {plain, other}
    worse = variant(1.2, count - 1)
    assert set(one_per_family([worse, plain, other])) == {plain, other}
    assert set(one_per_family([replace(simpler, implausible="at its bound"), plain, other])) == {plain, other}
    kept = one_per_family([other, plain])
    assert [c.held_out.loss for c in kept] == sorted(c.held_out.loss for c in kept)
