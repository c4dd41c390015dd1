"""Decision on synthetic candidates: each of its results, ties, pairs, and the uncertainty of the noise level."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
import pytest

from sim.effects.catalogue import find
from sim.effects.effect import Coordinate, Effect
from sysid.diagnosis.candidate import Candidate
from sysid.diagnosis.constants import NOISE_FACTOR
from sysid.diagnosis.decision import Decision, NoiseLevel, decide, equivalent
from sysid.diagnosis.held_out import HeldOut, evenness
from sysid.diagnosis.model_search import ModelSearch
from sysid.estimation.fit import FittedModel
from sysid.estimation.least_squares import FitResult
from sysid.estimation.misfit import ResidualWeights
from sysid.experiment.unknowns import Unknown
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem

BLOCKS, LENGTH = 24, 200
SIZE = BLOCKS * LENGTH
BLOCK = np.repeat(np.arange(BLOCKS), LENGTH)
NOISE = np.random.default_rng(0).normal(size=SIZE)
INDEX = np.arange(SIZE)
# Orthogonal parts of a misfit, of mean square 1: one in each half of the samples of every block.
ONE, OTHER = np.sqrt(2.0) * (INDEX % 2 == 0), np.sqrt(2.0) * (INDEX % 2 == 1)


def _fitted(effects: tuple[Effect, ...], count: int) -> FittedModel:
    """A model with `count` unknowns; nothing of it is evaluated."""
    unknowns = tuple(Unknown(f"effect.p{k}", 0.0, -1.0, 1.0, 1.0) for k in range(count))
    empty = np.empty(0)
    fit = FitResult({}, 0.0, np.empty((0, count)), empty, empty, tuple(u.key for u in unknowns))
    return FittedModel(Model(effects, {}, unknowns), fit, ResidualWeights((), ()))


def _curve(coordinate: Coordinate) -> Effect:
    return Effect(f"free_force_of_{coordinate}", "", coordinates=(coordinate,))


@dataclass
class Case:
    """A stated model with a residual (n,) in standard deviations, and candidates with theirs.

    The candidates stand for the search over models, of which a decision reads these lists only.
    """

    stated: np.ndarray
    ranked: list[Candidate] = field(default_factory=list)
    pairs: list[Candidate] = field(default_factory=list)
    curves: list[Candidate] = field(default_factory=list)

    def candidate(self, residual: np.ndarray, *effects: Effect, count: int = 1, fit_gain: float = 1.0) -> Candidate:
        """A candidate that leaves this residual (n,) on the held-out records."""
        after = HeldOut(residual, BLOCK)
        gain = HeldOut(self.stated, BLOCK).gain_of(after)
        return Candidate(cast(Problem, None), effects, _fitted(effects, count), after, gain, fit_gain)

    def effect(self, name: str, residual: np.ndarray, count: int = 1, fit_gain: float = 1.0) -> Case:
        """The case with one more effect."""
        self.ranked.append(self.candidate(residual, find(name), count=count, fit_gain=fit_gain))
        self.ranked.sort(key=lambda c: c.held_out.loss)
        return self

    def decide(self, noise: NoiseLevel | None = None) -> Decision:
        """The decision; by default the noise level is exact."""
        reference = HeldOut(self.stated, BLOCK)
        noise = noise or NoiseLevel(adequate_loss=reference.loss)
        return decide(cast(ModelSearch, self), reference, noise)


def test_sufficient_effect_is_missing_with_its_share() -> None:
    case = Case(NOISE + 2.0 * ONE).effect("cable_spring", NOISE + 0.2 * ONE).effect("viscous", NOISE + 1.9 * ONE)
    found = case.decide()
    assert (found.verdict, found.ties) == ("missing-effect", ())
    assert found.best is case.ranked[0]
    before, after = case.ranked[0].held_out.loss + case.ranked[0].gain.loss, case.ranked[0].held_out.loss
    assert found.unexplained_share == pytest.approx(max(after - 1.0, 0.0) / (before - min(1.0, after)), abs=0.01)
    assert found.best_named == ("cable_spring", pytest.approx(1.0 - found.unexplained_share))


def test_effect_below_its_sufficient_share_is_not_missing() -> None:
    found = Case(NOISE + 2.0 * ONE).effect("cable_spring", NOISE + 1.7 * ONE).decide()
    assert found.verdict == "unexplained"
    assert found.best is None
    assert "cable_spring explains only" in found.reason


def test_free_curve_that_explains_clearly_more_leaves_the_misfit_unexplained() -> None:
    case = Case(NOISE + 2.0 * ONE).effect("cable_spring", NOISE + 1.1 * ONE)
    assert case.decide().verdict == "missing-effect"
    case.curves = [case.candidate(NOISE, _curve("position"))]
    found = case.decide()
    assert found.verdict == "unexplained"
    assert found.free_curve is not None and found.best_named is not None
    assert found.free_curve.coordinate == "position"
    assert found.free_curve.share > 0.95 > found.best_named[1] > 0.6
    assert "a free curve of position explains" in found.reason


def test_free_curve_that_explains_no_more_than_the_effect_does_not_matter() -> None:
    case = Case(NOISE + 2.0 * ONE).effect("cable_spring", NOISE)
    case.curves = [case.candidate(NOISE, _curve("position"))]
    assert case.decide().best is case.ranked[0]


def test_pair_that_is_clearly_better_is_named_by_one_of_its_members() -> None:
    case = Case(NOISE + 1.5 * ONE + 2.0 * OTHER)
    case.effect("viscous", NOISE + 2.0 * OTHER).effect("cable_spring", NOISE + 1.5 * ONE)
    case.effect("constant_bias", NOISE + 1.5 * ONE + 1.9 * OTHER)
    case.pairs = [case.candidate(NOISE, find("viscous"), find("cable_spring"))]
    found = case.decide()
    assert found.verdict == "missing-effect"
    assert found.best is not None
    assert found.best.public_name == "cable_spring"
    assert "viscous explains the rest" in found.reason
    assert found.unexplained_share == pytest.approx(2.25 / 6.25, abs=0.05)


def test_pair_is_not_preferred_to_an_effect_that_explains_as_much() -> None:
    case = Case(NOISE + 2.0 * ONE).effect("cable_spring", NOISE)
    case.pairs = [case.candidate(0.99 * NOISE, find("viscous"), find("constant_bias"))]
    found = case.decide()
    assert found.best is case.ranked[0]
    assert found.reason == "explains the residual"


def test_pair_whose_one_effect_explains_as_much_alone_is_not_named() -> None:
    case = Case(NOISE + ONE).effect("cable_spring", NOISE + 0.01 * ONE, fit_gain=-0.1)
    case.pairs.append(case.candidate(NOISE, find("cable_spring"), find("constant_bias"), count=2))
    assert case.decide().best is None
    case.ranked[0] = replace(case.ranked[0], held_out=HeldOut(NOISE + 0.6 * ONE, BLOCK))
    assert case.decide().best is not None


def test_near_the_noise_a_gain_has_to_be_twice_as_steady() -> None:
    def gained(blocks: int, size: float) -> Decision:
        rows = size * (np.arange(BLOCKS).repeat(LENGTH) < blocks)
        case = Case(NOISE + rows).effect("cable_spring", NOISE)
        return case.decide()

    # Of 24 blocks, two have a steadiness of about sqrt(2): too little at a loss of 1.08, enough at one of 1.3.
    assert gained(2, 1.0).best is None
    assert gained(2, 2.0).best is not None
    assert gained(8, 0.5).best is not None


def test_simplest_of_equivalent_effects_is_named_and_the_others_are_tied() -> None:
    other = np.random.default_rng(1).normal(size=SIZE)
    small = 0.02 * (other - NOISE * (other @ NOISE) / (NOISE @ NOISE))
    case = Case(NOISE + 2.0 * ONE)
    case.effect("stribeck", NOISE, count=3).effect("viscous", NOISE + small, count=1)
    case.effect("quadratic_drag", NOISE - 1.1 * small, count=1).effect("cable_spring", NOISE + 0.9 * ONE, count=1)
    chosen, ties = equivalent(HeldOut(case.stated, BLOCK), case.ranked, case.ranked[0])
    assert (chosen.public_name, set(ties)) == ("viscous", {"stribeck", "quadratic_drag"})
    found = case.decide()
    assert (found.best, found.ties) == (chosen, ties)


def test_effect_that_a_certain_difference_separates_is_not_tied() -> None:
    case = Case(NOISE + 2.0 * ONE).effect("stribeck", NOISE, count=3).effect("viscous", NOISE + 0.5 * ONE, count=1)
    found = case.decide()
    assert found.best is not None
    assert (found.best.public_name, found.ties) == ("stribeck", ())


@pytest.mark.parametrize(
    "left,fit_gain",
    [
        pytest.param(np.where(BLOCK == 3, ONE, 2.0 * ONE), 1.0, id="from one block of time"),
        pytest.param(NOISE * 0.0 + 2.0 * ONE - 0.02 * NOISE, 1.0, id="too small"),
        pytest.param(0.0 * ONE, -0.1, id="not on the records of the fit"),
    ],
)
def test_gain_that_is_not_certain_names_nothing(left: np.ndarray, fit_gain: float) -> None:
    found = Case(NOISE + 2.0 * ONE).effect("cable_spring", NOISE + left, fit_gain=fit_gain).decide()
    assert found.verdict == "unexplained"
    assert found.best is None


def test_noise_alone_is_adequate() -> None:
    case = Case(NOISE).effect("cable_spring", 0.999 * NOISE)
    case.curves = [case.candidate(0.998 * NOISE, _curve("position"))]
    found = case.decide()
    assert (found.verdict, found.best) == ("adequate", None)
    assert found.reason == "no effect and no coordinate explains the residual"


def test_nothing_is_named_below_the_noise() -> None:
    """A level that is stated too high: the loss of the stated model is below 1, whatever an effect removes."""
    case = Case(0.5 * NOISE + 0.3 * ONE).effect("cable_spring", 0.5 * NOISE)
    assert case.decide().verdict == "adequate"


def test_effect_is_found_where_the_estimated_level_was_too_high() -> None:
    case = Case(0.5 * NOISE + 0.5 * ONE).effect("cable_spring", 0.5 * NOISE)
    found = case.decide(NoiseLevel(loss=0.25, adequate_loss=0.5))
    assert found.best is case.ranked[0]
    assert found.unexplained_share == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize("times,verdict", [(0.8, "adequate"), (1.2, "unexplained")])
def test_level_may_be_too_low_by_a_factor_where_nothing_gains(times: float, verdict: str) -> None:
    case = Case(times * NOISE_FACTOR * NOISE).effect("cable_spring", 0.9999 * times * NOISE_FACTOR * NOISE)
    found = case.decide()
    assert found.verdict == verdict
    assert "exceeds the noise" in found.reason or verdict != "adequate"


def test_error_in_some_stretches_of_time_is_no_uncertainty_of_the_level() -> None:
    """The same loss is adequate if it is that of all blocks, and unexplained if it is that of a quarter of them."""
    case = Case(1.6 * NOISE)
    loss = HeldOut(case.stated, BLOCK).loss
    assert case.decide(NoiseLevel(adequate_loss=loss, evenness=evenness(case.stated, BLOCK))).verdict == "adequate"
    bursts = np.where(BLOCK % 4 == 0, 2.66, 1.0) * NOISE
    found = Case(bursts).decide(NoiseLevel(adequate_loss=loss, evenness=evenness(bursts, BLOCK)))
    assert found.verdict == "unexplained" and "half of the time" in found.reason
    # The same shape within the noise is adequate.
    assert Case(bursts).decide(NoiseLevel(adequate_loss=1.5, evenness=evenness(bursts, BLOCK))).verdict == "adequate"


def test_notable_free_curve_is_no_uncertainty_of_the_level() -> None:
    case = Case(NOISE + ONE)
    assert case.decide().verdict == "adequate"
    case.curves = [case.candidate(NOISE, _curve("temperature"))]
    found = case.decide()
    assert found.verdict == "unexplained"
    assert found.free_curve is not None and found.free_curve.coordinate == "temperature"


def test_form_error_of_added_laws_is_a_floor_of_the_gain() -> None:
    case = Case(NOISE + 0.7 * ONE).effect("cable_spring", NOISE)
    assert case.decide().verdict == "missing-effect"
    exact = HeldOut(case.stated, BLOCK).loss
    assert case.decide(NoiseLevel(form_error=1.0, adequate_loss=exact)).verdict == "adequate"


def test_gains_within_the_form_error_of_added_laws_are_tied() -> None:
    case = Case(NOISE + 3.0 * ONE).effect("cable_spring", NOISE + 0.5 * ONE).effect("constant_bias", NOISE + 0.8 * ONE)
    case.effect("viscous", NOISE + 1.5 * ONE).effect("presliding", NOISE + 0.6 * ONE, count=3)
    assert case.decide().ties == ()
    found = case.decide(NoiseLevel(1.6, 0.6, 9.0))
    assert found.best is not None
    assert (found.best.public_name, found.ties) == ("cable_spring", ("constant_bias",))


def test_implausible_candidate_is_neither_named_nor_tied() -> None:
    case = Case(NOISE + 2.0 * ONE).effect("sensor_lag", NOISE).effect("viscous", NOISE + 0.1 * ONE)
    case.ranked[0] = replace(case.ranked[0], implausible="sensor_lag.time_constant is at its upper bound, 0.05 s")
    found = case.decide()
    assert found.best is case.ranked[1]
    assert (found.best.public_name, found.ties) == ("viscous", ())
    alone = Case(case.stated, case.ranked[:1]).decide()
    assert (alone.verdict, alone.best) == ("unexplained", None)


def test_decision_without_candidates() -> None:
    assert Case(NOISE).decide().verdict == "adequate"
    assert Case(NOISE + 5.0 * ONE).decide().verdict == "unexplained"
