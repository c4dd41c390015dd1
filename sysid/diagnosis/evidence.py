"""Statistics that the verdict is based on: misfit of the base model, and gain of each candidate effect.

Computed are the share of the loss above the noise that a candidate removes (in total, away from reversals, and after
subtracting the patterns of effects added earlier), the dependence of a residual on its coordinates, and its
autocorrelation. `is_worthwhile` decides whether a gain is significant and large enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from sim.library.effect import Effect
from sysid.diagnosis.own_patterns import apart_from, own_coordinates
from sysid.diagnosis.pairs import Pair, pairs_on_top
from sysid.diagnosis.residual_maps import dependence_by_coordinate
from sysid.diagnosis.trials import CandidateFit, CandidateSearch, significance_of
from sysid.diagnosis.verdict_limits import (
    ADEQUATE_OVER_NOISE,
    ALIKE,
    AT_REST,
    AT_REVERSALS,
    BENT,
    CLEARLY_AWAY,
    LATE,
    LEAST_AWAY,
    LEAST_GAIN,
    LEAST_OF_MOST,
    LEAST_PATTERN,
    LEAST_PERSISTENCE,
    LEAST_SIGNIFICANCE,
    LEAST_STEADINESS,
    MOST_OF_IT,
    SHARE_AWAY,
    SPELLS,
)
from sysid.estimation.fit import root_mean_huber
from sysid.estimation.misfit import (
    ResidualWeights,
    away_from_events,
    blocks,
    huber_square,
    worst_over_noise,
)
from sysid.estimation.reference_fit import ReferenceFit
from sysid.estimation.variant_selection import predicts_clearly_better, select_variants
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model, PreparedRecord, variant_group
from sysid.prediction.problem import Problem


@dataclass(frozen=True)
class Evidence:
    """Statistics that the verdict is based on.

    Args:
        problem, base: records and scales, and the model fitted to them.
        search: every candidate evaluated on it.
        ranked: the best variant of each effect, best first.
        over: error over noise of the base model, largest over the records.
        pattern: largest share of its residual that one coordinate explains.
        all_effects: second effects too are searched in the whole library.
        added: effects of the model that were added since the first revision.
        textured: whether the position predicts part of the residual in cross-validation.
    """

    problem: Problem
    base: ReferenceFit
    search: CandidateSearch
    ranked: Sequence[CandidateFit]
    over: float
    pattern: float
    all_effects: bool
    added: Sequence[Effect] = ()
    textured: bool = False

    @property
    def allowance(self) -> float:
        """Error over noise up to which a model of this form is adequate."""
        return ADEQUATE_OVER_NOISE[self.problem.form]

    @property
    def balance(self) -> bool:
        """Whether the records are compared as a force balance."""
        return self.problem.form == "force_balance"

    @property
    def error(self) -> float:
        """Ranking error of the base model on the held-out records, in deviations."""
        return root_mean_huber(self.base.residual)

    def left_by(self, trial: CandidateFit) -> float:
        """Share of the variance above the noise that remains with an effect."""
        return self.left_at(worst_over_noise(trial.after_fit, trial.after_validate))

    def left_at(self, over: float) -> float:
        """Share of the variance above the noise that remains if the error over noise is `over`."""
        return float(min(1.0, max(0.0, over**2 - 1.0) / max(self.over**2 - 1.0, 1e-9)))

    @property
    def patterned(self) -> bool:
        """Whether the residual of the base model depends on a coordinate or is autocorrelated."""
        return self.pattern >= LEAST_PATTERN or self.textured or self._persistence() >= LEAST_PERSISTENCE

    @property
    def in_spells(self) -> bool:
        """Whether the residual is far above the noise in some stretches of any record, which the robust error leaves
        out."""
        fitted = self.base.fitted
        in_fit = root_mean_huber(fitted.fit.residual) >= SPELLS
        return (self.error >= SPELLS and self._persistence() >= LEAST_PERSISTENCE) or (
            in_fit
            and persistence(self.problem, self.problem.fit_records, fitted.weights, fitted.fit.residual)
            >= LEAST_PERSISTENCE
        )

    def _persistence(self) -> float:
        return persistence(self.problem, self.problem.validate_records, self.base.weights, self.base.residual)

    def patterns_left(self, model: Model) -> dict[str, float]:
        """Share of a model's residual that each coordinate explains."""
        problem, base = self.problem, self.base
        return dependence_by_coordinate(
            model, problem.fit_records, base.fitted.weights, problem.validate_records, base.weights
        )

    def pattern_left(self, model: Model, coordinates: Sequence[str] = ()) -> float:
        """Largest share of a model's residual that one coordinate explains, of all or of some."""
        shares = self.patterns_left(model)
        return max((share for name, share in shares.items() if not coordinates or name in coordinates), default=0.0)

    def bent(self, trial: CandidateFit) -> bool:
        """Whether the residual with an effect of position or time still depends on that coordinate in every variant of
        the effect: the true law is a different one."""
        own = trial.effect.coordinates
        if len(own) != 1 or own[0] not in BENT:
            return False
        fitted = trial.fitted
        if self.pattern_left(fitted.model, own) < BENT[own[0]]:
            return False
        best, _ = select_variants(
            self.problem, fitted, [variant_group(trial.name)], partial(predicts_clearly_better, self.problem)
        )
        return best is fitted or self.pattern_left(best.model, own) >= BENT[own[0]]

    def on_top(self, trial: CandidateFit) -> list[Pair]:
        """Pairs of an effect with each of the best-scored others on top of it, best first."""
        return pairs_on_top(self.problem, self.base, trial.refit, self.all_effects, self.search.screening.jacobians)

    def share_away(self, trial: CandidateFit) -> float | None:
        """Share of the loss above the noise, away from the reversals of a driven mass, that an effect removes.

        On the held-out records, or on those of the fit where the held-out ones have too small a loss there.
        """
        held_out, fitted = away_of(self.problem, self.base, trial)
        if held_out is None:
            return None
        # Close to the noise the share is not significant.
        clear = next((loss for loss in (held_out, fitted) if loss is not None and loss.clear), None)
        return clear.share if clear is not None else 0.0

    def share_apart(self, trial: CandidateFit) -> float:
        """Share of the held-out loss above the noise that an effect removes, after subtracting the patterns of added
        effects."""
        own = own_coordinates(self.added)
        if not own:
            return 0.0
        records, weights = self.problem.validate_records, self.base.weights
        before, after = (
            float(np.mean(huber_square(apart_from(r, records, weights, own))))
            for r in (self.base.residual, trial.residual)
        )
        return (before - after) / max(before - min(1.0, after), 1e-9)

    def like_turns(self, trial: CandidateFit) -> bool:
        """Whether a small error in the time of reversals would resemble this effect."""
        # On a driven mass a delay of the motion sensor is equivalent to a delay of the drive.
        late = self.problem.kind == "force-drive" and trial.public_name in LATE
        return (late or trial.public_name in AT_REVERSALS) and trial.share_at_rest < AT_REST


@dataclass(frozen=True)
class LossAway:
    """Mean Huber loss of some records away from the reversals of a driven mass, without and with an effect.

    Args:
        before, after: in noise deviations squared.
        significance: z of the reduction, if the residual with the effect is only noise.
    """

    before: float
    after: float
    significance: float

    @property
    def clear(self) -> bool:
        """Whether the loss is large enough for its share to be significant."""
        return self.before > CLEARLY_AWAY

    @property
    def share(self) -> float:
        """Share of the loss above the noise that is removed."""
        return (self.before - self.after) / max(self.before - min(1.0, self.after), 1e-9)


def away_of(problem: Problem, base: ReferenceFit, trial: CandidateFit) -> tuple[LossAway | None, LossAway | None]:
    """Loss away from reversals on the held-out records and on those of the fit; none where too few samples are."""
    held_out = _away(problem.validate_records, base.weights, base.residual, trial.residual)
    after = trial.fitted.fit.residual
    whole = after.size == base.fitted.fit.residual.size
    fitted = _away(problem.fit_records, base.fitted.weights, base.fitted.fit.residual, after) if whole else None
    return held_out, fitted


def _away(
    records: Sequence[PreparedRecord], weights: ResidualWeights, before: np.ndarray, after: np.ndarray
) -> LossAway | None:
    away = away_from_events(records, weights)
    if np.mean(away) < LEAST_AWAY:
        return None
    worse, better = before[away], after[away]
    return LossAway(
        float(np.mean(huber_square(worse))),
        float(np.mean(huber_square(better))),
        significance_of(worse, better, blocks(records, weights)[away]),
    )


def persistence(
    problem: Problem, records: Sequence[PreparedRecord], weights: ResidualWeights, residual: np.ndarray
) -> float:
    """Autocorrelation of a residual (n,) at a lag of four scored samples, less that of the sensor noise: from 0 (noise)
    to 1 (slow dependence on any coordinate)."""
    lag, best = 4, 0.0
    start = 0
    for record, samples in zip(records, weights.samples, strict=True):
        for channel, pick in samples.items():
            r = np.clip(residual[start : start + pick.size], -8.0, 8.0)
            start += pick.size
            if r.size < 50:
                continue
            noise = problem.noise.get(channel)
            own = noise.correlation**lag if noise is not None and problem.form == "output" else 0.0
            if isinstance(record, ForceBalanceRecord) and record.full_filter is not None:
                # Filtered white noise; a record is thinned to a sample per filter width, rounded down.
                apart = lag * max(1, int(record.full_filter.width / record.step)) * record.step
                own = float(np.exp(-0.25 * (apart / record.full_filter.width) ** 2))
            best = max(best, float(np.corrcoef(r[lag:], r[:-lag])[0, 1]) - own)
    return best


def is_worthwhile(problem: Problem, base: ReferenceFit, trial: CandidateFit) -> bool:
    """Whether the gain of an effect on the held-out records is significant and large enough.

    On a driven mass the residuals at stops may hide the gain. It then counts away from reversals, where the effect has
    to remove nearly all of a clear loss, on all records.
    """
    return _takes_enough(base, trial) or _takes_all_away(problem, base, trial)


def _takes_all_away(problem: Problem, base: ReferenceFit, trial: CandidateFit) -> bool:
    losses = away_of(problem, base, trial)
    known = [loss for loss in losses if loss is not None]
    return (
        len(known) == len(losses)
        and any(loss.clear for loss in known)
        and all(loss.share >= SHARE_AWAY and loss.significance >= LEAST_SIGNIFICANCE for loss in known)
    )


def _takes_enough(base: ReferenceFit, trial: CandidateFit) -> bool:
    before = root_mean_huber(base.residual) ** 2
    before_fit = root_mean_huber(base.fitted.fit.residual) ** 2
    alike = trial.fit_gain * before >= ALIKE * trial.gain * before_fit
    certain = trial.significance >= LEAST_SIGNIFICANCE or (trial.steadiness >= LEAST_STEADINESS and alike)
    # A gain at a few break-aways only is never steady: there it must be most of the loss, on all records.
    most = trial.gain >= MOST_OF_IT * before and trial.fit_gain >= MOST_OF_IT * before_fit
    certain |= most and trial.significance >= LEAST_OF_MOST
    return certain and trial.gain >= LEAST_GAIN * before and trial.fit_gain >= LEAST_GAIN * before_fit
