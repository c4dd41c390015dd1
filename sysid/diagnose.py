"""Which physical effect is missing: every candidate scored and refitted, judged on held-out records."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import numpy as np

from sysid.balance import Balance
from sysid.base_fit import ranking_error
from sysid.case import Case, load_case
from sysid.case_fit import BaseFit, fit_case
from sysid.coarse_steps import coarse_steps
from sysid.experiment import DesignValues
from sysid.ladder_files import read_ladder
from sysid.misfit import ChannelMisfit, blocks, excess, misfit
from sysid.model import Model, base_name
from sysid.pairs import Pair, best_pairs, pairs_on_top, searched_again
from sysid.residual_maps import ResidualMap, residual_maps
from sysid.swaps import Swap, find_swaps
from sysid.trials import (
    Progress,
    Search,
    Trial,
    explained_share,
    one_per_family,
    parameter_count,
    share_of_error,
    significance_of,
    try_all,
)
from sysid.verdict_limits import (
    ADEQUATE_OVER_NOISE,
    AT_REST,
    AT_REVERSALS,
    AT_STARTS,
    BENT,
    CLEARLY_ABOVE,
    LATE,
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
    SHARE_ENOUGH,
    SHARE_OF_A_PART,
    SHARE_OF_TWO,
    SHARE_WITH_THE_PATTERN,
    UNDERRATED,
    VARIANCE_ENOUGH,
    VARIANCE_OF_TWO,
)


@dataclass(frozen=True)
class Diagnosis:
    """What is missing, and how sure that is.

    Args:
        case, base: what was diagnosed.
        trials: every effect tried, best first; one law per effect.
        verdict: `missing-effect`, `adequate` or `unexplained`.
        best: the trial named, for `missing-effect`.
        indistinguishable: effects that these records cannot tell from it.
        maps: of the residual that the base model leaves.
        unexplained_share: of the variance above the noise that stays after the best effect.
        reason: why this verdict, in words.
        seconds: taken.
        swaps: effects added earlier that should go, or make place for others.
    """

    case: Case
    base: BaseFit
    trials: tuple[Trial, ...]
    verdict: str
    best: Trial | None
    indistinguishable: tuple[str, ...]
    maps: tuple[ResidualMap, ...]
    unexplained_share: float
    reason: str
    before_fit: dict[str, ChannelMisfit]
    before_validate: dict[str, ChannelMisfit]
    seconds: float
    swaps: tuple[Swap, ...] = ()

    @property
    def effect(self) -> str | None:
        """The name everyone uses of the effect that is missing; none otherwise."""
        return self.best.family if self.best is not None else None


def diagnose(
    source: str | Path | Case,
    all_effects: bool = False,
    design: DesignValues | None = None,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find which effect is missing from the model of an experiment.

    Args:
        source: folder of the experiment, its `experiment.toml`, or a case already made.
        all_effects: try whatever else the library has besides the names everyone uses.
        design: what a known value of `"design"` stands for.
        progress: called with a name, a count and a total.

    Raises:
        InputError: a fault in a file, in one line.
    """
    began = perf_counter()
    case = source if isinstance(source, Case) else load_case(source, design)
    base = fit_case(case)
    present = [e.name for e in case.start.effects]
    search = try_all(case, base, present, all_effects, progress)
    found = judge(case, base, search, coarse_steps(case, base, ADEQUATE_OVER_NOISE[case.form]), began, all_effects)
    # While something is missing the next round comes first; a model that is enough is asked only what it can spare.
    swaps = (
        []
        if found.effect is not None
        else find_swaps(case, base, _added(case), found.verdict == "unexplained", all_effects)
    )
    return replace(found, swaps=tuple(swaps), seconds=perf_counter() - began)


def _added(case: Case) -> list[str]:
    """Effects of the model that its ladder added."""
    rungs = read_ladder(case.experiment)
    first = {base_name(name) for name in rungs[0].effects} if rungs else set()
    return [e.name for e in case.start.effects if rungs and base_name(e.name) not in first]


def judge(
    case: Case, base: BaseFit, search: Search, quantised: Trial | None, began: float, all_effects: bool = False
) -> Diagnosis:
    """The verdict on a base model and the effects tried on it."""
    before_fit = misfit(base.fitted.model, case.fit_records)
    before_validate = misfit(base.fitted.model, case.validate_records)
    best_of_family = _ranked(case, base, search, all_effects)
    for trial in best_of_family[:6]:
        _misfits(case, trial)
    over = excess(before_fit, before_validate)
    maps = residual_maps(base.fitted.model, case.fit_records, base.fitted.weights, case.validate_records, base.weights)

    def done(verdict: str, best: Trial | None, ties: tuple[str, ...], left: float, reason: str) -> Diagnosis:
        ranked = ([best] if best is not None and best not in best_of_family else []) + best_of_family
        return Diagnosis(
            case, base, tuple(ranked), verdict, best, ties, tuple(maps), left, reason, before_fit, before_validate,
            perf_counter() - began,
        )  # fmt: skip

    if quantised is not None:
        left = _left(over, excess(quantised.after_fit, quantised.after_validate))
        return done("missing-effect", quantised, (), left, "the measured values lie on a grid coarser than the noise")
    best = best_of_family[0] if best_of_family else None
    worthwhile = best is not None and is_worthwhile(base, best)
    enough = ADEQUATE_OVER_NOISE[case.form]
    pattern = max((m.share for m in maps), default=0.0)
    if best is None or not worthwhile:
        if over <= enough or ranking_error(base.residual) <= NOISE_ALONE:
            return done(
                "adequate",
                None,
                (),
                0.0,
                "what is left is noise; no effect lowers it by more than chance",
            )
        if over <= UNDERRATED and pattern < LEAST_PATTERN and persistence(case, base) < LEAST_PERSISTENCE:
            return done(
                "adequate", None, (), 0.0,
                "no effect lowers what is left, and it follows no coordinate: noise, though more than was thought",
            )  # fmt: skip
        for pair in _only_together(case, base, search, best, all_effects):
            first = next((trial for trial in best_of_family if trial.family in pair.names), None)
            if first is not None and _explains(case, base, pair, over, pattern):
                left = _left(over, excess(*_misfits(case, first)))
                reason = f"does little alone; with {pair.partner(first.family)} it explains what can be explained"
                return done("missing-effect", first, (), left, reason)
        return done(
            "unexplained",
            None,
            (),
            1.0,
            "the misfit is above the noise, and no effect lowers it on held-out records by more than chance",
        )
    ties, best = tied(case, base, best_of_family)
    after = excess(best.after_fit, best.after_validate)
    left = _left(over, after)
    share = explained_share(base, best)
    taken = best.gain / ranking_error(base.residual) ** 2
    clear = case.form == "output" or over >= CLEARLY_ABOVE or taken >= MUCH_OF_IT
    to_the_noise = clear and best.error <= NOISE_ALONE and best.significance >= LEAST_SIGNIFICANCE
    to_the_noise |= taken >= MOST_OF_IT and best.significance >= 2.0 * LEAST_SIGNIFICANCE
    of_starts = _of_turns(case, best) or best.family in AT_STARTS
    at_noise = over <= NOTHING_ABOVE and ranking_error(base.residual) <= 1.0
    nothing_above = case.form == "force_balance" and at_noise
    if over <= enough and (nothing_above or share < 0.5 or (of_starts and not to_the_noise)):
        return done("adequate", None, (), 0.0, "what is left is noise; no effect is worth its parameters")
    patterned = pattern >= LEAST_PATTERN or persistence(case, base) >= LEAST_PERSISTENCE
    within_timing = not patterned or ranking_error(base.residual) <= 1.0
    if case.form == "force_balance" and _of_turns(case, best) and within_timing and not to_the_noise:
        return done("adequate", None, (), 0.0, "what is left follows no coordinate: the timing of the axis's turns")
    if after <= NEARLY_NOISE:
        return done("missing-effect", best, ties, left, "explains what can be explained")
    enough_alone = share >= SHARE_ENOUGH or 1.0 - left >= VARIANCE_ENOUGH
    bent = enough_alone and _bent(case, base, best)
    pair, first = _beside(case, base, search, best, best_of_family)
    if first is not best:
        best, ties = first, ()
        share = explained_share(base, best)
        left = _left(over, excess(*_misfits(case, best)))
    elif enough_alone and not bent:
        return done("missing-effect", best, ties, left, "explains what can be explained")
    if pair is not None and _explains(case, base, pair, over, pattern, bent):
        return done("missing-effect", best, ties, left, f"explains its share; {pair.partner(best.family)} the rest")
    remaining = _pattern_of(case, base, best.candidate.fitted.model)
    part = max(share, 1.0 - left)
    turn_like = case.form == "force_balance" and _of_turns(case, best)
    took_the_pattern = part >= SHARE_WITH_THE_PATTERN and pattern >= LEAST_PATTERN > remaining and not turn_like
    if took_the_pattern or (part >= SHARE_OF_A_PART and remaining < LEAST_PATTERN_LEFT):
        return done(
            "missing-effect", best, ties, left, "explains its share; what it leaves follows no coordinate closely"
        )
    above = [] if bent or not patterned else pairs_on_top(case, base, best.candidate, all_effects)
    if above and _explains(case, base, above[0], over, pattern):
        return done("missing-effect", best, (), left, f"explains its share; {above[0].partner(best.family)} the rest")
    if not patterned and over <= UNDERRATED:
        return done(
            "adequate", None, (), 0.0,
            "no effect explains what is left, and it follows no coordinate: noise, though more than was thought",
        )  # fmt: skip
    if bent:
        return done(
            "unexplained", None, (), left,
            f"{best.family} takes {100 * part:.0f} % of the misfit, but what it leaves still follows "
            "position: the law is another than its own",
        )  # fmt: skip
    return done(
        "unexplained", None, (), 1.0 - max(share, 0.0),
        f"the best effect, {best.family}, takes only {100 * share:.0f} % of the misfit, and no second one the rest",
    )  # fmt: skip


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


def _explains(case: Case, base: BaseFit, pair: Pair, over: float, pattern: float, bent: bool = False) -> bool:
    """Whether two effects together explain the misfit; after a `bent` one, only if they leave no pattern."""
    rest_left = _left(over, excess(misfit(pair.model, case.fit_records), misfit(pair.model, case.validate_records)))
    rest = share_of_error(base, pair.error)
    pattern_left = _pattern_of(case, base, pair.model)
    quiet = rest >= SHARE_ENOUGH and pattern_left < LEAST_PATTERN_LEFT
    silent = rest >= SHARE_OF_A_PART and pattern >= LEAST_PATTERN > pattern_left
    much = not bent and (rest >= SHARE_OF_TWO or 1.0 - rest_left >= VARIANCE_OF_TWO)
    return quiet or silent or much


def _pattern_of(case: Case, base: BaseFit, model: Model, coordinates: Sequence[str] = ()) -> float:
    """Largest share of a model's residual that one coordinate explains, of all or of some."""
    weights = base.fitted.weights
    maps = residual_maps(model, case.fit_records, weights, case.validate_records, base.weights)
    return max((m.share for m in maps if not coordinates or m.coordinate in coordinates), default=0.0)


def _bent(case: Case, base: BaseFit, trial: Trial) -> bool:
    """Whether a force of the position with one law leaves a residual that still follows the position."""
    effect = trial.candidate.effect
    one_law = not effect.variants and all(p.role != "shape" for p in effect.parameters)
    if not one_law or effect.force is None or effect.coordinates != ("position",):
        return False
    model = trial.candidate.fitted.model
    return _pattern_of(case, base, model, effect.coordinates) >= BENT


def _ranked(case: Case, base: BaseFit, search: Search, all_effects: bool) -> list[Trial]:
    """The best law of each effect, best first; where none does much, effects of the model are searched for anew too."""
    ranked = one_per_family(search.trials)
    before = ranking_error(base.residual)
    nothing = not ranked or not is_worthwhile(base, ranked[0]) or explained_share(base, ranked[0]) < SHARE_OF_A_PART
    if nothing and before > NEARLY_NOISE:
        present = [e.name for e in case.start.effects]
        again = searched_again(case, base, present, all_effects)
        return one_per_family([*again, *search.trials])
    return ranked


def _misfits(case: Case, trial: Trial) -> tuple[dict[str, ChannelMisfit], dict[str, ChannelMisfit]]:
    """Misfits with an effect in, kept with its trial."""
    if not trial.after_fit:
        trial.after_fit = misfit(trial.candidate.fitted.model, case.fit_records)
        trial.after_validate = misfit(trial.candidate.fitted.model, case.validate_records)
    return trial.after_fit, trial.after_validate


def _only_together(case: Case, base: BaseFit, search: Search, best: Trial | None, all_effects: bool) -> Iterator[Pair]:
    """Two effects that do much together where none does alone: by their scores, then one on top of the best."""
    yield from best_pairs(case, base, search.looks, search.target)[:1]
    if best is not None:
        yield from pairs_on_top(case, base, best.candidate, all_effects)[:1]


def _beside(
    case: Case, base: BaseFit, search: Search, best: Trial, ranked: Sequence[Trial]
) -> tuple[Pair | None, Trial]:
    """The pair of effects that explains most, and the one of the two to name first.

    A pair without the best single effect is taken where it leaves far less than any pair with it: then that effect
    only leans on the two.
    """
    pairs = best_pairs(case, base, search.looks, search.target)
    if not pairs:
        return None, best
    with_best = [pair for pair in pairs if best.family in pair.names]
    least = min([best.error, *(pair.error for pair in with_best)])
    if max(pairs[0].error ** 2 - 1.0, 0.0) < LEANS * (least**2 - 1.0):
        members = [trial for trial in ranked if trial.family in pairs[0].names]
        if members and best not in members:
            return pairs[0], members[0]
    return (with_best[0] if with_best else None), best


LEANS = 0.5
"""Part of the loss above the noise, left beside the best effect, that another pair must fall below to unseat it."""
