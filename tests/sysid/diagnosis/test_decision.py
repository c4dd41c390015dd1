"""Verdict on synthetic candidates: each of its results, and the uncertainty of the noise level."""

from dataclasses import dataclass, field, replace
from typing import Self, cast

import numpy as np
import pytest

from sim.effects.catalogue import find
from sim.effects.effect import Coordinate, Effect
from sysid.diagnosis.candidate import Candidate, is_tied, simplest
from sysid.diagnosis.constants import NOISE_FACTOR, STEP_Z
from sysid.diagnosis.decision import Decision, NoiseLevel, decide
from sysid.diagnosis.held_out import HeldOut, evenness
from sysid.diagnosis.ledger import Entry, Ledger, State, is_step
from sysid.diagnosis.model_search import ModelSearch
from sysid.estimation.fit import FittedModel
from sysid.estimation.least_squares import FitResult
from sysid.estimation.misfit import ResidualWeights
from sysid.experiment.known import Unknown
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem

BLOCKS, LENGTH = 24, 200
SIZE = BLOCKS * LENGTH
BLOCK = np.repeat(np.arange(BLOCKS), LENGTH)
NOISE = np.random.default_rng(0).normal(size=SIZE)
INDEX = np.arange(SIZE)
# Orthogonal parts of a misfit, of mean square 1: one in each half of the samples of every block.
ONE, OTHER = np.sqrt(2.0) * (INDEX % 2 == 0), np.sqrt(2.0) * (INDEX % 2 == 1)


def _fitted(effects: tuple[Effect, ...], count: int, residual: np.ndarray = NOISE) -> FittedModel:
    """A model with `count` unknowns; nothing of it is evaluated."""
    unknowns = tuple(Unknown(f"effect.p{k}", 0.0, -1.0, 1.0, 1.0) for k in range(count))
    empty = np.empty(0)
    fit = FitResult({}, 0.0, np.empty((0, count)), residual, empty, tuple(u.key for u in unknowns))
    return FittedModel(Model(effects, {}, unknowns), fit, ResidualWeights((), ()))


def _curve(coordinate: Coordinate) -> Effect:
    return Effect(f"free_force_of_{coordinate}", "", coordinates=(coordinate,))


@dataclass
class Case:
    """A stated model with a residual (n,) in standard deviations, and candidates with theirs.

    It stands for the search over models, of which a decision reads these lists only.
    """

    stated: np.ndarray
    ranked: list[Candidate] = field(default_factory=list)
    curves: list[Candidate] = field(default_factory=list)

    @property
    def reference(self) -> Self:
        return self

    @property
    def held_out(self) -> HeldOut:
        return HeldOut(self.stated, BLOCK)

    def candidate(self, residual: np.ndarray, *effects: Effect, count: int = 1, fit_gain: float = 1.0) -> Candidate:
        """A candidate that leaves this residual (n,) on the held-out records."""
        after = HeldOut(residual, BLOCK)
        gain = self.held_out.gain_of(after)
        return Candidate(cast(Problem, None), effects, _fitted(effects, count), after, gain, fit_gain)

    def effect(self, name: str, residual: np.ndarray, count: int = 1) -> Self:
        """The case with one more effect."""
        self.ranked.append(self.candidate(residual, find(name), count=count))
        self.ranked.sort(key=lambda c: c.held_out.loss)
        return self

    def decide(self, noise: NoiseLevel | None = None, state: State | None = None) -> Decision:
        """The decision with the best effect in a state; by default the noise level is exact, and there is no entry."""
        entries, model, explained = (), self.candidate(self.stated), 0.0
        if state is not None:
            model = self.ranked[0]
            entries = (Entry(model.effect, state, "a reason", model),)
            explained = 0.9
        noise = noise or NoiseLevel(adequate_loss=self.held_out.loss)
        ledger = Ledger(entries, model, explained, "position")
        return decide(cast(ModelSearch, self), ledger, noise, frozenset({"position", "temperature"}))


def test_an_effect_is_missing_if_established_and_stated_with_its_reason_if_not() -> None:
    found = Case(NOISE + 2.0 * ONE).effect("cable_spring", NOISE + 0.2 * ONE).decide(state="established")
    assert (found.verdict, found.indistinguishable, found.reason) == ("missing-effect", (), "explains the residual")
    assert found.best is not None and found.best.public_name == "cable_spring"
    assert found.unexplained_share == pytest.approx(0.1)
    assert found.best_named is not None and found.best_named[0] == "cable_spring"
    found = Case(NOISE + 2.0 * ONE).effect("cable_spring", NOISE + 1.7 * ONE).decide(state="possible")
    assert (found.verdict, found.best) == ("unexplained", None)
    assert found.reason == "cable_spring is possible: a reason"


@pytest.mark.parametrize("coordinate,recurs", [("position", True), ("velocity", False)])
def test_curve_of_a_coordinate_that_does_not_recur_decides_nothing(coordinate: Coordinate, recurs: bool) -> None:
    case = Case(NOISE + 0.8 * ONE)
    case.curves = [case.candidate(NOISE, _curve(coordinate))]
    found = case.decide()
    assert found.verdict == ("unexplained" if recurs else "adequate")
    assert found.free_curve is not None and found.free_curve.recurs == recurs
    assert found.free_curve.share > 0.95
    assert ("a free curve of position explains" in found.reason) == recurs


@pytest.mark.parametrize("on_fit", [True, False])
def test_step_that_is_not_significant_beside_other_missing_effects_is_made_where_it_gains_on_both_sets(
    on_fit: bool,
) -> None:
    phase = 2.0 * np.pi * INDEX / SIZE
    rest, part = NOISE + 3.0 * np.sin(3.0 * phase), 2.0 * np.sin(2.0 * phase)
    case = Case(rest + part)
    model, larger = case.candidate(rest + part), case.candidate(rest, find("cable_spring"))
    model = replace(model, fitted=_fitted((), 1, rest + part))
    larger = replace(larger, fitted=_fitted((), 1, rest if on_fit else rest + 0.98 * part))
    assert model.held_out.gain_of(larger.held_out).z < STEP_Z
    assert is_step(model, larger) == on_fit


@pytest.mark.parametrize("fit_gain,verdict", [(0.05, "adequate"), (0.6, "unexplained")])
def test_curve_of_one_set_of_records_is_no_missing_effect(fit_gain: float, verdict: str) -> None:
    case = Case(NOISE + 0.8 * ONE)
    case.curves = [case.candidate(NOISE, _curve("position"), fit_gain=fit_gain)]
    assert case.decide().verdict == verdict


def test_simplest_of_equivalent_effects_is_chosen() -> None:
    other = np.random.default_rng(1).normal(size=SIZE)
    small = 0.02 * (other - NOISE * (other @ NOISE) / (NOISE @ NOISE))
    case = Case(NOISE + 2.0 * ONE)
    case.effect("stribeck", NOISE, count=3).effect("viscous", NOISE + small, count=1)
    case.effect("cable_spring", NOISE + 0.9 * ONE, count=1)
    stated = case.candidate(case.stated)
    assert simplest(stated, case.ranked).public_name == "viscous"
    clear = Case(case.stated).effect("stribeck", NOISE, count=3).effect("viscous", NOISE + 0.5 * ONE, count=1)
    assert simplest(stated, clear.ranked).public_name == "stribeck"
    assert not is_tied(clear.ranked[1], clear.ranked[0], 4.0)


def test_law_whose_values_are_known_together_only_is_not_the_simplest() -> None:
    case = Case(NOISE + 2.0 * ONE).effect("presliding", NOISE, count=2).effect("cable_spring", NOISE, count=2)
    keys, columns = ("presliding.force", "presliding.stretch"), np.column_stack([ONE, ONE])
    fit = FitResult({}, 0.0, columns, NOISE, np.ones(SIZE), keys)
    friction = replace(case.ranked[0], fitted=replace(case.ranked[0].fitted, fit=fit))
    assert simplest(case.candidate(case.stated), [friction, case.ranked[1]]).public_name == "cable_spring"
    fit = replace(fit, jacobian=np.column_stack([ONE, NOISE]))
    friction = replace(friction, fitted=replace(friction.fitted, fit=fit))
    assert simplest(case.candidate(case.stated), [friction, case.ranked[1]]).public_name == "presliding"


def test_noise_alone_and_no_candidates_are_adequate() -> None:
    case = Case(NOISE).effect("cable_spring", 0.999 * NOISE)
    case.curves = [case.candidate(0.998 * NOISE, _curve("position"))]
    found = case.decide()
    assert (found.verdict, found.best) == ("adequate", None)
    assert found.reason == "no effect and no coordinate explains the residual"
    assert Case(NOISE).decide().verdict == "adequate"
    assert Case(NOISE + 5.0 * ONE).decide().verdict == "unexplained"


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
