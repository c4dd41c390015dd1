"""A candidate model: the base model with effects added or removed, refitted and evaluated on the held-out records; and
which of several is taken, where the records do not distinguish their gains (ties)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sim.effects.effect import Effect
from sysid.diagnosis.constants import STEP_Z
from sysid.diagnosis.held_out import HeldOut, Transfer, held_out
from sysid.estimation.covariance import implausible, is_determined, rig_values_at_bound
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.misfit import ChannelMisfit, misfit
from sysid.estimation.reference_fit import ReferenceFit
from sysid.estimation.screening import UNSCREENED, Reductions
from sysid.prediction.model import public_name
from sysid.prediction.problem import Problem

LOCATION_PARAMETERS = ("phase", "rest_position")
"""Parameters that only shift a law along the axis; they do not count as complexity."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A candidate model and its gain over the base model."""

    problem: Problem  # the records
    added: tuple[Effect, ...]  # effects added to the base model
    fitted: FittedModel  # the model on the records of the fit
    held_out: HeldOut  # its residual on the held-out records
    gain: Transfer  # reduction of the held-out loss of the base model
    fit_gain: float  # reduction of the mean Huber loss on the records of the fit
    removed: str = ""  # public name of the effect removed from it; empty for none
    reductions: Reductions = UNSCREENED  # by the score test of the effect
    implausible: str | None = None  # why the fitted values are implausible, as text; None if they are plausible
    law: str = ""  # name where it is not that of the added effect (quantisation of one channel)

    @property
    def effect(self) -> Effect:
        """The first effect added."""
        return self.added[0]

    @property
    def name(self) -> str:
        """Name of the first effect added, with variant and channel."""
        return self.law or self.effect.name

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects added."""
        return tuple(effect.name for effect in self.added)

    @property
    def public_name(self) -> str:
        """Public name of the first effect added."""
        return public_name(self.name)

    @property
    def families(self) -> tuple[str, ...]:
        """Public names of the effects added."""
        return tuple(public_name(effect.name) for effect in self.added)

    @property
    def error(self) -> float:
        """Root mean Huber loss on the held-out records, in standard deviations of the noise."""
        return float(np.sqrt(self.held_out.loss))

    @cached_property
    def fit_loss(self) -> float:
        """Mean Huber square on the records of the fit."""
        return root_mean_huber(self.fitted.fit.residual) ** 2

    @property
    def loss(self) -> float:
        """Mean of the losses on both sets of records, each of which shows some effects better."""
        return 0.5 * (self.held_out.loss + self.fit_loss)

    @cached_property
    def after_fit(self) -> dict[str, ChannelMisfit]:
        """Misfit by channel on the records of the fit."""
        return misfit(self.fitted.model, self.problem.fit_records)

    @cached_property
    def after_validate(self) -> dict[str, ChannelMisfit]:
        """Misfit by channel on the held-out records."""
        return misfit(self.fitted.model, self.problem.validate_records)

    @property
    def parameter_count(self) -> int:
        """Number of fitted parameters, without those that only shift a law along the axis."""
        return sum(u.key.rpartition(".")[2] not in LOCATION_PARAMETERS for u in self.fitted.model.unknowns)


@dataclass(frozen=True, eq=False)
class Reference:
    """The base model with which candidates are compared."""

    problem: Problem  # the records
    base: ReferenceFit  # the fitted model, and the residual weights of the held-out records
    held_out: HeldOut  # its residual on the held-out records

    @classmethod
    def of(cls, problem: Problem, base: ReferenceFit) -> Reference:
        """The reference of a fitted model."""
        return cls(problem, base, held_out(base.fitted, problem.validate_records, base.weights))

    def evaluate(
        self, fitted: FittedModel, added: Sequence[Effect], removed: str = "", reductions: Reductions = UNSCREENED
    ) -> Candidate | None:
        """The candidate of a fitted model; none where its prediction is not finite.

        A value of the rig that the fit drives to its bound is held at that of the base model, so that the gain of the
        effect does not depend on it.
        """
        found = held_out(fitted, self.problem.validate_records, self.base.weights, self.base.fitted.model)
        fitted, found = self._with_held_rig(fitted, found)
        if not np.isfinite(found.loss):
            return None
        before = root_mean_huber(self.base.fitted.fit.residual)
        return Candidate(
            problem=self.problem,
            added=tuple(added),
            fitted=fitted,
            held_out=found,
            gain=self.held_out.gain_of(found),
            fit_gain=before**2 - root_mean_huber(fitted.fit.residual) ** 2,
            removed=removed,
            reductions=reductions,
            implausible=implausible(fitted, [effect.name for effect in added])
            or _same_pitch(self.problem, fitted, added),
        )

    def _with_held_rig(self, fitted: FittedModel, found: HeldOut) -> tuple[FittedModel, HeldOut]:
        """The fit and its residual, refitted with the values of the rig at a bound held fixed; unchanged without a
        gain, since holding a value cannot increase it."""
        problem, base = self.problem, self.base.fitted
        while found.loss < self.held_out.loss and (driven := rig_values_at_bound(fitted, base)):
            held = replace(
                fitted.model,
                values={**fitted.model.values, **{key: base.model.values[key] for key in driven}},
                unknowns=tuple(u for u in fitted.model.unknowns if u.key not in driven),
            )
            fitted = fit_model(held, problem.fit_records, base.weights)
            found = held_out(fitted, problem.validate_records, self.base.weights, base.model)
        return fitted, found


def _same_pitch(problem: Problem, fitted: FittedModel, added: Sequence[Effect]) -> str | None:
    """Reason why two copies of a periodic effect are one, as text: over the travel X waves of pitches p and q are
    distinguishable where |1/p - 1/q| X >= 1."""
    travel, values = problem.scales.position, fitted.model.values
    for effect in (e for e in added if e.is_periodic):
        for other in fitted.model.effects:
            if other is not effect and other.is_periodic and public_name(other.name) == public_name(effect.name):
                pitches = values[f"{effect.name}.pitch"], values[f"{other.name}.pitch"]
                if abs(1.0 / pitches[0] - 1.0 / pitches[1]) * travel < 1.0:
                    return f"{effect.name}.pitch is that of {other.name}, as far as the travel shows"
    return None


def one_per_family(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best variant of each effect added last, a plausible one where there is any; of variants within 1 % in error
    the one with fewer parameters."""
    kept: dict[str, Candidate] = {}
    for candidate in sorted(candidates, key=lambda c: (c.implausible is not None, c.held_out.loss)):
        family = public_name(candidate.added[-1].name)
        other = kept.setdefault(family, candidate)
        if candidate.parameter_count < other.parameter_count and candidate.error <= 1.01 * other.error:
            kept[family] = candidate if candidate.implausible is None else other
    return sorted(kept.values(), key=lambda c: c.held_out.loss)


TIE = 0.03
"""Largest loss of gain, over the gain, by another effect in the place of one that is indistinguishable from it."""


def simplest(model: Candidate, options: Sequence[Candidate]) -> Candidate:
    """The simplest of the candidates whose gain over a model hardly differs from the largest."""
    best = min(options, key=lambda c: c.loss)
    tied = [c for c in options if is_tied(c, best, max(model.loss - best.loss, 0.0))]

    def complexity(one: Candidate) -> tuple[bool, int, bool, float]:
        # A law whose values are determined only together acts in a limit that a simpler law states: a friction that
        # never slides is a spring. In one direction of motion one that depends on the position is the same as a force.
        effect = one.added[-1]
        return not is_determined(one.fitted, effect.name), one.parameter_count, effect.factor is not None, one.loss

    return min(tied, key=complexity)


def is_tied(other: Candidate, best: Candidate, gained: float) -> bool:
    """Whether the gain of another candidate differs insignificantly from the best one's, `gained`."""
    behind = other.loss - best.loss
    return behind <= 0.1 * TIE * gained or (behind <= TIE * gained and other.held_out.gain_of(best.held_out).z < STEP_Z)


def ties(rivals: Sequence[Candidate], model: Candidate, gained: float) -> tuple[str, ...]:
    """Up to two effects that tie with the one whose place in the model the rivals take, which gains `gained`."""
    # One with more parameters that gains no more contains this effect.
    simple = [c for c in rivals if c.parameter_count <= model.parameter_count or c.held_out.loss < model.held_out.loss]
    names = (public_name(c.added[-1].name) for c in simple if is_tied(c, model, gained))
    return tuple(dict.fromkeys(names))[:2]
