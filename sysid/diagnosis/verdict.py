"""Decision of a diagnosis: an effect is missing, the model is adequate, or the misfit is unexplained.

`verdict_on` applies the rules of docs/theory.md, section 9, in their order to the evaluated candidates; the limits are
in `sysid/diagnosis/verdict_limits.py`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from sysid.diagnosis.evidence import Evidence, is_worthwhile
from sysid.diagnosis.pairs import Pair, best_pairs
from sysid.diagnosis.ties import tied, tied_beside
from sysid.diagnosis.trials import CandidateFit, explained_share, share_of_error
from sysid.diagnosis.verdict_limits import (
    AT_REST,
    AT_STARTS,
    BENT,
    BENT_TOGETHER,
    CLEARLY_ABOVE,
    HARDLY_MORE,
    LEANS,
    LEAST_PATTERN,
    LEAST_PATTERN_LEFT,
    LEAST_SIGNIFICANCE,
    MOST_OF_IT,
    MUCH_OF_IT,
    NEARLY_ALL_OF_TWO,
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
    SURE_PART,
    SURE_SIGNIFICANCE,
    SURE_STEADINESS,
    UNDERRATED,
    VARIANCE_ENOUGH,
    VARIANCE_OF_TWO,
)
from sysid.estimation.misfit import misfit, worst_over_noise


@dataclass(frozen=True)
class Verdict:
    """Decision of a diagnosis.

    Args:
        verdict: `missing-effect`, `adequate` or `unexplained`.
        best: the candidate named, for `missing-effect`.
        ties: effects that these records cannot distinguish from it.
        left: remaining share of the variance above the noise.
        reason: of the decision, in words.
        detected_by: how the effect was detected, in words, where it was not by a reduction of the error.
    """

    verdict: str
    best: CandidateFit | None
    ties: tuple[str, ...]
    left: float
    reason: str
    detected_by: str = ""


@dataclass(frozen=True)
class _Named:
    """A candidate with a gain that counts, its ties, and the shares that it removes and leaves.

    Args:
        trial: the candidate.
        ties: effects that the records cannot distinguish from it.
        share: of the loss above the noise that it removes.
        left: remaining share of the variance above the noise.
        away: share removed of the loss away from the reversals of a driven mass; none without reversals.
    """

    trial: CandidateFit
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


EXPLAINS_ALL = "explains the residual"


def verdict_on(evidence: Evidence, quantised: CandidateFit | None) -> Verdict:
    """The verdict on a base model and the candidates evaluated on it.

    Args:
        evidence: statistics of the base model and of the candidates.
        quantised: quantisation of a channel as a candidate, where its step is larger than the noise.
    """
    if quantised is not None:
        left = evidence.left_by(quantised)
        on_a_grid = "the measured values lie on a grid coarser than the noise"
        return Verdict("missing-effect", quantised, (), left, on_a_grid, on_a_grid)
    best = evidence.ranked[0] if evidence.ranked else None
    if best is None or not is_worthwhile(evidence.problem, evidence.base, best):
        return _nothing_gains(evidence, best)
    ties, best = tied(evidence.problem, evidence.base, evidence.ranked)
    named = _named(evidence, best, ties)
    noise = _only_noise(evidence, named)
    if noise is not None:
        return _adequate(noise)
    if worst_over_noise(best.after_fit, best.after_validate) <= NEARLY_NOISE:
        return named.missing(EXPLAINS_ALL)
    bent = named.enough_alone and evidence.bent(best)
    pairs = best_pairs(evidence.problem, evidence.base, evidence.search.screening)
    pair, first = _beside(evidence, best, pairs)
    if first is not best:
        named = _named(evidence, first, ())
    elif named.enough_alone and not bent:
        return named.missing(EXPLAINS_ALL)
    if pair is not None and _explains(evidence, pair, bent):
        partner = pair.partner(first.public_name)
        beside = tied_beside(evidence.problem, evidence.base, pair, pairs, partner)
        ties = tuple(dict.fromkeys(name for name in (*beside, *named.ties) if name != partner))[:2]
        return replace(named, ties=ties).missing(f"explains its share; {partner} explains the rest")
    return _of_a_part(evidence, named, bent)


def _named(evidence: Evidence, trial: CandidateFit, ties: tuple[str, ...]) -> _Named:
    return _Named(
        trial, ties, explained_share(evidence.base, trial), evidence.left_by(trial), evidence.share_away(trial)
    )


def _adequate(reason: str) -> Verdict:
    return Verdict("adequate", None, (), 0.0, reason)


def _unexplained(left: float, reason: str) -> Verdict:
    return Verdict("unexplained", None, (), left, reason)


def _nothing_gains(evidence: Evidence, best: CandidateFit | None) -> Verdict:
    """The verdict where no single effect lowers the held-out loss significantly."""
    at_the_noise = evidence.over <= evidence.allowance or evidence.error <= NOISE_ALONE
    if at_the_noise and not evidence.in_spells:
        return _adequate("the residual is noise; no effect lowers the error significantly")
    if evidence.over <= UNDERRATED and not evidence.patterned:
        return _adequate(
            "no effect lowers the residual and no coordinate explains it: noise, with a larger deviation than estimated"
        )
    for pair in _only_together(evidence, best):
        first = next((trial for trial in evidence.ranked if trial.public_name in pair.names), None)
        if first is not None and _explains(evidence, pair):
            reason = f"explains little alone; with {pair.partner(first.public_name)} it explains the residual"
            return Verdict("missing-effect", first, (), evidence.left_by(first), reason)
    where = "above the noise in some stretches" if at_the_noise else "above the noise"
    return _unexplained(1.0, f"the residual is {where}, and no effect lowers it significantly on the held-out records")


def _only_noise(evidence: Evidence, named: _Named) -> str | None:
    """Why the gain of an effect is attributed to noise or event times, in words; none where it is accepted."""
    best = named.trial
    taken = best.gain / evidence.error**2
    clear = not evidence.balance or evidence.over >= CLEARLY_ABOVE or taken >= MUCH_OF_IT
    to_the_noise = clear and best.error <= NOISE_ALONE and best.significance >= LEAST_SIGNIFICANCE
    # With a ranking error at the noise, a few samples at reversals may still be above it.
    to_the_noise &= evidence.error > 1.0 or taken >= MUCH_OF_IT
    to_the_noise |= taken >= MOST_OF_IT and best.significance >= 2.0 * LEAST_SIGNIFICANCE
    steady = best.steadiness >= SURE_STEADINESS and best.significance >= LEAST_SIGNIFICANCE
    to_the_noise |= steady and (taken >= SURE_PART or best.significance >= SURE_SIGNIFICANCE)
    of_starts = evidence.like_turns(best) or best.public_name in AT_STARTS
    certain = taken >= MUCH_OF_IT and best.significance >= 2.0 * LEAST_SIGNIFICANCE
    nothing_above = evidence.balance and evidence.over <= NOTHING_ABOVE and evidence.error <= 1.0 and not certain
    little = nothing_above or named.share < 0.5 or (of_starts and not to_the_noise)
    if evidence.over <= evidence.allowance and little:
        return "the residual is noise; no effect justifies its parameters"
    if evidence.balance and of_starts and not to_the_noise and (evidence.error <= 1.0 or not evidence.patterned):
        return "the residual depends on no coordinate: it is caused by the timing of reversals and starts"
    return None


def _of_a_part(evidence: Evidence, named: _Named, bent: bool) -> Verdict:
    """The verdict where neither one effect nor a pair of the best-scored ones explains the misfit."""
    best = named.trial
    remaining = evidence.pattern_left(best.fitted.model)
    turn_like = evidence.balance and evidence.like_turns(best)
    had_a_pattern = evidence.pattern >= LEAST_PATTERN > remaining
    little_left = worst_over_noise(best.after_fit, best.after_validate) <= UNDERRATED
    took_the_pattern = named.part >= SHARE_WITH_THE_PATTERN and had_a_pattern and little_left and not turn_like
    quiet = remaining < LEAST_PATTERN_LEFT and not bent and not evidence.bent(best)
    # A gain at reversals only is due to errors of their times, unless it comes from stick phases.
    at_rest = best.share_at_rest >= AT_REST
    beside_turns = little_left or named.away is None or named.away >= SHARE_OF_A_PART or at_rest
    if took_the_pattern or (named.part >= SHARE_OF_A_PART and quiet and beside_turns):
        return named.missing("explains its share; its residual does not depend closely on a coordinate")
    apart = _apart_from_patterns(evidence)
    if apart is not None:
        reason = "explains the residual except its dependence on the coordinates of effects added before"
        return Verdict("missing-effect", apart, (), evidence.left_by(apart), reason)
    patterned = evidence.patterned
    for first in _as_good(evidence, best, bent) if patterned else []:
        above = evidence.on_top(first)[:1]
        if above and _explains(evidence, above[0], bent):
            reason = f"explains its share; {above[0].partner(first.public_name)} explains the rest"
            return Verdict("missing-effect", first, (), evidence.left_by(first), reason)
    if not patterned and evidence.over <= UNDERRATED and named.share < SHARE_OF_NOISE:
        return _adequate(
            "no effect explains the residual, nor does a coordinate: noise, with a larger deviation than estimated"
        )
    if bent:
        return _unexplained(
            named.left,
            f"{best.public_name} explains {100 * named.part:.0f} % of the misfit, but its residual still depends on "
            f"{best.effect.coordinates[0]}: its law has another form",
        )
    return _unexplained(
        1.0 - max(named.share, 0.0),
        f"the best effect, {best.public_name}, explains only {100 * named.share:.0f} % of the misfit, "
        "and no second effect explains the rest",
    )


def _apart_from_patterns(evidence: Evidence) -> CandidateFit | None:
    """The effect that explains the residual after subtracting the patterns of effects added earlier."""
    if not evidence.added:
        return None
    able = [
        t
        for t in evidence.ranked[:6]
        if is_worthwhile(evidence.problem, evidence.base, t) and not evidence.like_turns(t)
    ]
    best = max(able, key=evidence.share_apart, default=None)
    return best if best is not None and evidence.share_apart(best) >= SHARE_ENOUGH else None


def _as_good(evidence: Evidence, best: CandidateFit, bent: bool) -> list[CandidateFit]:
    """The best effect and the next ones with nearly equal errors: each of them may be one of a pair.

    For a `bent` effect its other variants, one of which may fit beside a second effect.
    """
    among = evidence.search.trials if bent else evidence.ranked
    others = [
        trial
        for trial in among
        if trial is not best
        and trial.error <= HARDLY_MORE * best.error
        and (not bent or trial.public_name == best.public_name)
    ]
    return [best, *others[:2]]


def _explains(evidence: Evidence, pair: Pair, bent: bool = False) -> bool:
    """Whether two effects together explain the misfit; after a `bent` one only if their residual depends on no
    coordinate."""
    if set(pair.names) <= RESTORING:
        return False
    problem = evidence.problem
    after = worst_over_noise(misfit(pair.model, problem.fit_records), misfit(pair.model, problem.validate_records))
    rest_left = evidence.left_at(after)
    rest = share_of_error(evidence.base, pair.error)
    patterns = evidence.patterns_left(pair.model)
    pattern_left = max(patterns.values(), default=0.0)
    own = {name for effect in pair.effects for name in effect.coordinates if len(effect.coordinates) == 1}
    some_left = rest < NEARLY_ALL_OF_TWO
    bent_together = some_left and any(patterns.get(name, 0.0) >= BENT_TOGETHER for name in own & set(BENT))
    # A linear restoring force and another effect together resemble a nonlinear one.
    pulled = some_left and bool(RESTORING & set(pair.names))
    bent |= pulled and patterns.get("position", 0.0) >= BENT["position"]
    quiet = rest >= SHARE_ENOUGH and pattern_left < (min(BENT.values()) if bent else LEAST_PATTERN_LEFT)
    silent = rest >= SHARE_OF_A_PART and evidence.pattern >= LEAST_PATTERN > pattern_left
    much = not bent and not bent_together and (rest >= SHARE_OF_TWO or 1.0 - rest_left >= VARIANCE_OF_TWO)
    return quiet or silent or much


def _only_together(evidence: Evidence, best: CandidateFit | None) -> Iterator[Pair]:
    """Pairs of effects where no single one has a gain: the best by joint score, then the best effect with another."""
    problem, base, search = evidence.problem, evidence.base, evidence.search
    yield from best_pairs(problem, base, search.screening)[:1]
    if best is not None:
        yield from evidence.on_top(best)[:1]


def _beside(evidence: Evidence, best: CandidateFit, pairs: list[Pair]) -> tuple[Pair | None, CandidateFit]:
    """The pair of effects that explains most, and the one of the two to name first.

    A pair without the best single effect is taken where it leaves far less than any pair with it: then that effect
    is partially confounded with the two.
    """
    if not pairs:
        return None, best
    with_best = [pair for pair in pairs if best.public_name in pair.names]
    least = min([best.error, *(pair.error for pair in with_best)])
    if max(pairs[0].error ** 2 - 1.0, 0.0) < LEANS * (least**2 - 1.0):
        members = [trial for trial in evidence.ranked if trial.public_name in pairs[0].names]
        if members and best not in members:
            return pairs[0], members[0]
    return (with_best[0] if with_best else None), best
