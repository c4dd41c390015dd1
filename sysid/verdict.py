"""The verdict on a model and the effects tried on it: one is missing, nothing is, or what is missing has no name here.

The questions stand in the order in which they are asked (`verdict_on`); docs/theory.md section 9 tells them in words,
`sysid/verdict_limits.py` holds the limits.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from sysid.balance import Balance
from sysid.base_fit import ranking_error
from sysid.case import Case
from sysid.case_fit import BaseFit
from sysid.misfit import ChannelMisfit, away_from_turns, blocks, excess, huber_square, misfit
from sysid.model import Model
from sysid.pairs import Pair, best_pairs, pairs_on_top
from sysid.residual_maps import residual_maps
from sysid.trials import Search, Trial, explained_share, parameter_count, share_of_error, significance_of
from sysid.verdict_limits import (
    ADEQUATE_OVER_NOISE,
    AT_REST,
    AT_REVERSALS,
    AT_STARTS,
    BENT,
    CLEARLY_ABOVE,
    CLEARLY_AWAY,
    HARDLY_MORE,
    LATE,
    LEANS,
    LEAST_AWAY,
    LEAST_GAIN,
    LEAST_PATTERN,
    LEAST_PATTERN_LEFT,
    LEAST_PERSISTENCE,
    LEAST_SIGNIFICANCE,
    LEAST_STEADINESS,
    MOST_OF_IT,
    MUCH_OF_IT,
    NEARLY_NOISE,
    NOISE_ALONE,
    NOTHING_ABOVE,
    RESTORING,
    SHARE_AWAY,
    SHARE_ENOUGH,
    SHARE_OF_A_PART,
    SHARE_OF_NOISE,
    SHARE_OF_TWO,
    SHARE_WITH_THE_PATTERN,
    UNDERRATED,
    VARIANCE_ENOUGH,
    VARIANCE_OF_TWO,
)


@dataclass(frozen=True)
class Verdict:
    """What is missing.

    Args:
        verdict: `missing-effect`, `adequate` or `unexplained`.
        best: the trial named, for `missing-effect`.
        ties: families that these records cannot tell from it.
        left: of the variance above the noise, the share that stays.
        reason: why, in words.
    """

    verdict: str
    best: Trial | None
    ties: tuple[str, ...]
    left: float
    reason: str


@dataclass(frozen=True)
class Evidence:
    """What a verdict is made from.

    Args:
        case, base: records and scales, and the model fitted to them.
        search: every effect tried on it.
        ranked: the best law of each effect, best first.
        over: error over noise of the base model, the worst of its records.
        pattern: share of its residual that the best coordinate explains.
        all_effects: second effects too are looked for in the whole library.
    """

    case: Case
    base: BaseFit
    search: Search
    ranked: Sequence[Trial]
    over: float
    pattern: float
    all_effects: bool

    @property
    def allowance(self) -> float:
        """Error over noise up to which a model of this form is adequate."""
        return ADEQUATE_OVER_NOISE[self.case.form]

    @property
    def balance(self) -> bool:
        """Whether the records are compared as a force balance."""
        return self.case.form == "force_balance"

    @property
    def error(self) -> float:
        """Ranking error of the base model on the held-out records, in deviations."""
        return ranking_error(self.base.residual)

    def left_by(self, trial: Trial) -> float:
        """Share of the variance above the noise that an effect leaves."""
        return _left(self.over, excess(*misfits_of(self.case, trial)))


@dataclass(frozen=True)
class _Named:
    """An effect that gains: its trial, what ties with it, and what it takes and leaves.

    Args:
        trial: the effect.
        ties: families that the records cannot tell from it.
        share: of the loss above the noise that it takes.
        left: of the variance above the noise that it leaves.
        away: its share of the loss away from the turns of a driven mass; none where there are no turns.
    """

    trial: Trial
    ties: tuple[str, ...]
    share: float
    left: float
    away: float | None

    @property
    def enough_alone(self) -> bool:
        away = self.away is not None and self.away >= SHARE_AWAY
        return self.share >= SHARE_ENOUGH or 1.0 - self.left >= VARIANCE_ENOUGH or away

    @property
    def part(self) -> float:
        return max(self.share, 1.0 - self.left)

    def missing(self, reason: str) -> Verdict:
        return Verdict("missing-effect", self.trial, self.ties, self.left, reason)


EXPLAINS_ALL = "explains what can be explained"


def verdict_on(evidence: Evidence, quantised: Trial | None) -> Verdict:
    """The verdict on a base model and the effects tried on it.

    Args:
        evidence: the base model's misfit, and the effects tried.
        quantised: the sensor's grid as an effect, where the values lie on one coarser than their noise.
    """
    if quantised is not None:
        left = evidence.left_by(quantised)
        return Verdict(
            "missing-effect", quantised, (), left, "the measured values lie on a grid coarser than the noise"
        )
    best = evidence.ranked[0] if evidence.ranked else None
    if best is None or not is_worthwhile(evidence.base, best):
        return _nothing_gains(evidence, best)
    ties, best = tied(evidence.case, evidence.base, evidence.ranked)
    named = _named(evidence, best, ties)
    noise = _only_noise(evidence, named)
    if noise is not None:
        return _adequate(noise)
    if excess(best.after_fit, best.after_validate) <= NEARLY_NOISE:
        return named.missing(EXPLAINS_ALL)
    bent = named.enough_alone and _bent(evidence, best)
    pair, first = _beside(evidence, best)
    if first is not best:
        named = _named(evidence, first, ())
    elif named.enough_alone and not bent:
        return named.missing(EXPLAINS_ALL)
    if pair is not None and _explains(evidence, pair, bent):
        return named.missing(f"explains its share; {pair.partner(first.family)} the rest")
    return _of_a_part(evidence, named, bent)


def _named(evidence: Evidence, trial: Trial, ties: tuple[str, ...]) -> _Named:
    return _Named(
        trial, ties, explained_share(evidence.base, trial), evidence.left_by(trial), _share_away(evidence, trial)
    )


def _share_away(evidence: Evidence, trial: Trial) -> float | None:
    """Share of the held-out loss above the noise, away from the turns of a driven mass, that an effect takes."""
    away = away_from_turns(evidence.case.validate_records, evidence.base.weights)
    if np.mean(away) < LEAST_AWAY:
        return None
    before, after = (float(np.mean(huber_square(r[away]))) for r in (evidence.base.residual, trial.residual))
    # Where there is little above the noise a share of it says nothing.
    return (before - after) / (before - min(1.0, after)) if before > CLEARLY_AWAY else 0.0


def _adequate(reason: str) -> Verdict:
    return Verdict("adequate", None, (), 0.0, reason)


def _unexplained(left: float, reason: str) -> Verdict:
    return Verdict("unexplained", None, (), left, reason)


def _nothing_gains(evidence: Evidence, best: Trial | None) -> Verdict:
    """Where no single effect lowers the held-out loss by more than chance."""
    if evidence.over <= evidence.allowance or evidence.error <= NOISE_ALONE:
        return _adequate("what is left is noise; no effect lowers it by more than chance")
    if evidence.over <= UNDERRATED and not _patterned(evidence):
        return _adequate(
            "no effect lowers what is left, and it follows no coordinate: noise, though more than was thought"
        )
    for pair in _only_together(evidence, best):
        first = next((trial for trial in evidence.ranked if trial.family in pair.names), None)
        if first is not None and _explains(evidence, pair):
            reason = f"does little alone; with {pair.partner(first.family)} it explains what can be explained"
            return Verdict("missing-effect", first, (), evidence.left_by(first), reason)
    return _unexplained(
        1.0, "the misfit is above the noise, and no effect lowers it on held-out records by more than chance"
    )


def _only_noise(evidence: Evidence, named: _Named) -> str | None:
    """Why the gain of an effect is none to believe, in words; none where it is one."""
    best = named.trial
    taken = best.gain / evidence.error**2
    clear = not evidence.balance or evidence.over >= CLEARLY_ABOVE or taken >= MUCH_OF_IT
    to_the_noise = clear and best.error <= NOISE_ALONE and best.significance >= LEAST_SIGNIFICANCE
    to_the_noise |= taken >= MOST_OF_IT and best.significance >= 2.0 * LEAST_SIGNIFICANCE
    of_starts = _of_turns(evidence.case, best) or best.family in AT_STARTS
    nothing_above = evidence.balance and evidence.over <= NOTHING_ABOVE and evidence.error <= 1.0
    little = nothing_above or named.share < 0.5 or (of_starts and not to_the_noise)
    if evidence.over <= evidence.allowance and little:
        return "what is left is noise; no effect is worth its parameters"
    turn_like = evidence.balance and _of_turns(evidence.case, best) and not to_the_noise
    if turn_like and (evidence.error <= 1.0 or not _patterned(evidence)):
        return "what is left follows no coordinate: the timing of the axis's turns"
    return None


def _of_a_part(evidence: Evidence, named: _Named, bent: bool) -> Verdict:
    """Where neither one effect nor two of the best-scored ones explain the misfit."""
    case, best = evidence.case, named.trial
    remaining = _pattern_of(evidence, best.candidate.fitted.model)
    turn_like = evidence.balance and _of_turns(case, best)
    had_a_pattern = evidence.pattern >= LEAST_PATTERN > remaining
    little_left = excess(*misfits_of(case, best)) <= UNDERRATED
    took_the_pattern = named.part >= SHARE_WITH_THE_PATTERN and had_a_pattern and little_left and not turn_like
    # What an effect that takes little elsewhere takes at the turns is their time.
    beside_turns = little_left or named.away is None or named.away >= SHARE_OF_A_PART
    if took_the_pattern or (named.part >= SHARE_OF_A_PART and remaining < LEAST_PATTERN_LEFT and beside_turns):
        return named.missing("explains its share; what it leaves follows no coordinate closely")
    patterned = _patterned(evidence)
    for first in [] if bent or not patterned else _as_good(evidence, best):
        above = pairs_on_top(case, evidence.base, first.candidate, evidence.all_effects)[:1]
        if above and _explains(evidence, above[0]):
            reason = f"explains its share; {above[0].partner(first.family)} the rest"
            return Verdict("missing-effect", first, (), evidence.left_by(first), reason)
    if not patterned and evidence.over <= UNDERRATED and named.share < SHARE_OF_NOISE:
        return _adequate(
            "no effect explains what is left, and it follows no coordinate: noise, though more than was thought"
        )
    if bent:
        return _unexplained(
            named.left,
            f"{best.family} takes {100 * named.part:.0f} % of the misfit, but what it leaves still follows "
            f"{best.candidate.effect.coordinates[0]}: the law is another than its own",
        )
    return _unexplained(
        1.0 - max(named.share, 0.0),
        f"the best effect, {best.family}, takes only {100 * named.share:.0f} % of the misfit, "
        "and no second one the rest",
    )


def _as_good(evidence: Evidence, best: Trial) -> list[Trial]:
    """The effect named, and the next best that leave hardly more: any of them may be one of two."""
    others = [trial for trial in evidence.ranked if trial is not best and trial.error <= HARDLY_MORE * best.error]
    return [best, *others[:2]]


def _patterned(evidence: Evidence) -> bool:
    """Whether the base model's residual follows some coordinate, known or not."""
    return evidence.pattern >= LEAST_PATTERN or persistence(evidence.case, evidence.base) >= LEAST_PERSISTENCE


def _of_turns(case: Case, trial: Trial) -> bool:
    """Whether a small error in the time of the turns would look like this effect."""
    # On a driven mass a late sensor of its motion is a late drive.
    late = case.kind == "force-drive" and trial.family in LATE
    return (late or trial.family in AT_REVERSALS) and trial.share_at_rest < AT_REST


def _left(before: float, after: float) -> float:
    """Share of the variance above the noise that is left."""
    return float(min(1.0, max(0.0, after**2 - 1.0) / max(before**2 - 1.0, 1e-9)))


def persistence(case: Case, base: BaseFit) -> float:
    """Correlation of the held-out residual with itself four scored samples on, less that of the sensors' noise: what is
    left between 1 (a slow pattern, of whatever coordinate) and 0 (noise)."""
    lag, best = 4, 0.0
    start = 0
    for record, picks in zip(case.validate_records, base.weights.picks, strict=True):
        for channel, pick in picks.items():
            r = np.clip(base.residual[start : start + pick.size], -8.0, 8.0)
            start += pick.size
            if r.size < 50:
                continue
            noise = case.noise.get(channel)
            own = noise.correlation**lag if noise is not None and case.form == "output" else 0.0
            if isinstance(record, Balance) and record.whole is not None:
                # Filtered white noise; a record is thinned to a sample per filter width, rounded down.
                apart = lag * max(1, int(record.whole.width / record.step)) * record.step
                own = float(np.exp(-0.25 * (apart / record.whole.width) ** 2))
            best = max(best, float(np.corrcoef(r[lag:], r[:-lag])[0, 1]) - own)
    return best


def is_worthwhile(base: BaseFit, trial: Trial) -> bool:
    """Whether an effect lowers the held-out loss by more than chance, and by enough to matter."""
    before = ranking_error(base.residual) ** 2
    before_fit = ranking_error(base.fitted.fit.residual) ** 2
    certain = trial.significance >= LEAST_SIGNIFICANCE or trial.steadiness >= LEAST_STEADINESS
    return certain and trial.gain >= LEAST_GAIN * before and trial.fit_gain >= LEAST_GAIN * before_fit


def tied(case: Case, base: BaseFit, ranked: Sequence[Trial]) -> tuple[tuple[str, ...], Trial]:
    """The effect to name, and those that these records cannot tell from it.

    Tied are effects whose held-out loss differs from the best one's by chance only. Named is the simplest of them, or a
    simpler effect that leaves as little in the robust figure: what it lacks are a few samples beside reversals.
    """
    numbers = blocks(case.validate_records, base.weights)
    first = ranked[0]
    before = ranking_error(base.residual) ** 2
    gained = before - first.error**2
    group = [first]
    for other in ranked[1:]:
        behind = other.error**2 - first.error**2
        # Along a filtered motion a lag and a delay differ by less than what the filter costs.
        alike = case.kind == "force-drive" and {first.family, other.family} <= LATE and other.error <= 1.0
        if behind <= 0.03 * gained and (alike or significance_of(other.residual, first.residual, numbers) < 2.5):
            group.append(other)
    best = min(group, key=lambda t: (parameter_count(t), t.error))
    least = excess(best.after_fit, best.after_validate)
    for other in ranked[1:]:
        simpler = parameter_count(other) < parameter_count(best) and other.after_fit
        as_good = simpler and excess(other.after_fit, other.after_validate) <= 1.03 * least
        if as_good and before - other.error**2 >= 0.97 * gained:
            best = other
    names = [t.family for t in group if t is not best and (t is first or parameter_count(t) <= parameter_count(best))][
        :2
    ]
    return tuple(names), best


def _explains(evidence: Evidence, pair: Pair, bent: bool = False) -> bool:
    """Whether two effects together explain the misfit; after a `bent` one, only if they leave no pattern."""
    if set(pair.names) <= RESTORING:
        return False
    case = evidence.case
    after = excess(misfit(pair.model, case.fit_records), misfit(pair.model, case.validate_records))
    rest_left = _left(evidence.over, after)
    rest = share_of_error(evidence.base, pair.error)
    pattern_left = _pattern_of(evidence, pair.model)
    quiet = rest >= SHARE_ENOUGH and pattern_left < LEAST_PATTERN_LEFT
    silent = rest >= SHARE_OF_A_PART and evidence.pattern >= LEAST_PATTERN > pattern_left
    much = not bent and (rest >= SHARE_OF_TWO or 1.0 - rest_left >= VARIANCE_OF_TWO)
    return quiet or silent or much


def _pattern_of(evidence: Evidence, model: Model, coordinates: Sequence[str] = ()) -> float:
    """Largest share of a model's residual that one coordinate explains, of all or of some."""
    case, base = evidence.case, evidence.base
    maps = residual_maps(model, case.fit_records, base.fitted.weights, case.validate_records, base.weights)
    return max((m.share for m in maps if not coordinates or m.coordinate in coordinates), default=0.0)


def _bent(evidence: Evidence, trial: Trial) -> bool:
    """Whether an effect of the position, or of time, leaves a residual that still follows it: the law is another."""
    own = trial.candidate.effect.coordinates
    if own not in (("position",), ("time",)):
        return False
    return _pattern_of(evidence, trial.candidate.fitted.model, own) >= BENT


def misfits_of(case: Case, trial: Trial) -> tuple[dict[str, ChannelMisfit], dict[str, ChannelMisfit]]:
    """Misfits with an effect in, kept with its trial."""
    if not trial.after_fit:
        trial.after_fit = misfit(trial.candidate.fitted.model, case.fit_records)
        trial.after_validate = misfit(trial.candidate.fitted.model, case.validate_records)
    return trial.after_fit, trial.after_validate


def _only_together(evidence: Evidence, best: Trial | None) -> Iterator[Pair]:
    """Two effects that do much together where none does alone: by their scores, then one on top of the best."""
    case, base, search = evidence.case, evidence.base, evidence.search
    yield from best_pairs(case, base, search.looks, search.target)[:1]
    if best is not None:
        yield from pairs_on_top(case, base, best.candidate, evidence.all_effects)[:1]


def _beside(evidence: Evidence, best: Trial) -> tuple[Pair | None, Trial]:
    """The pair of effects that explains most, and the one of the two to name first.

    A pair without the best single effect is taken where it leaves far less than any pair with it: then that effect
    only leans on the two.
    """
    pairs = best_pairs(evidence.case, evidence.base, evidence.search.looks, evidence.search.target)
    if not pairs:
        return None, best
    with_best = [pair for pair in pairs if best.family in pair.names]
    least = min([best.error, *(pair.error for pair in with_best)])
    if max(pairs[0].error ** 2 - 1.0, 0.0) < LEANS * (least**2 - 1.0):
        members = [trial for trial in evidence.ranked if trial.family in pairs[0].names]
        if members and best not in members:
            return pairs[0], members[0]
    return (with_best[0] if with_best else None), best
