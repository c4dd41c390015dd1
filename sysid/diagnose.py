"""Which physical effect is missing: every candidate scored and refitted, judged on held-out records."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

import numpy as np

from sim.library import find
from sysid.base_fit import ranking_error
from sysid.candidate_list import candidates_of
from sysid.candidates import Candidate, as_it_looks, look_at, refined, target_of
from sysid.case import BaseFit, Case, fit_case, load_case, make_case
from sysid.experiment import DesignValues
from sysid.misfit import ChannelMisfit, blocks, huber_square, misfit, weighted_residual
from sysid.model import base_name
from sysid.residual_maps import ResidualMap, residual_maps

Progress = Callable[[str, int, int], None]


@dataclass
class Trial:
    """One effect tried: its refit, and what it does on the held-out records.

    Args:
        name: of the effect, with variant and channel.
        candidate: score and refit on the records of the fit.
        error: ranking error on the held-out records, in deviations.
        gain: drop of the mean squared loss on the held-out records.
        significance: of that gain, were what the effect leaves all noise, in standard errors.
        p_value: chance of so large a gain, by turning the sign of whole blocks' gains.
        steadiness: mean gain of a block over its standard error.
        fit_gain: drop of the mean squared loss on the records of the fit.
        after_fit, after_validate: misfit by channel.
    """

    name: str
    candidate: Candidate
    error: float
    gain: float
    significance: float
    fit_gain: float
    residual: np.ndarray
    after_fit: dict[str, ChannelMisfit] = field(default_factory=dict)
    after_validate: dict[str, ChannelMisfit] = field(default_factory=dict)

    p_value: float = 1.0
    steadiness: float = 0.0

    @property
    def family(self) -> str:
        """The name everyone uses."""
        return base_name(self.name)


REFITTED = 10
"""Effects refitted in full: those that looked best. The others keep what their first look found."""


def try_all(
    case: Case, base: BaseFit, present: Sequence[str], all_effects: bool = False, progress: Progress | None = None
) -> list[Trial]:
    """Try every candidate on top of a fitted model; best on the held-out records first."""
    basis, target = target_of(base.fitted)
    numbers = blocks(case.validate_records, base.weights)
    count = int(numbers.max()) + 1 if numbers.size else 0
    before = np.bincount(numbers, huber_square(base.residual), minlength=count)
    before_fit = ranking_error(base.fitted.fit.residual)
    effects = candidates_of(case, present, all_effects)
    looks = []
    for k, effect in enumerate(effects):
        if progress is not None:
            progress(effect.name, k, len(effects))
        look = look_at(base.fitted, effect, case.fit_records, case.scales, basis, target)
        if look is not None and np.isfinite(look.error):
            looks.append(look)
    looks.sort(key=lambda look: look.error)
    trials = []
    for k, look in enumerate(looks):
        effect = look.effect
        if k < REFITTED:
            candidate = refined(base.fitted, look, case.fit_records, case.scales)
        else:
            candidate = as_it_looks(look)
        residual = weighted_residual(candidate.fitted.model, case.validate_records, base.weights)
        if not np.isfinite(residual).all():
            continue
        loss = np.bincount(numbers, huber_square(residual), minlength=count)
        trials.append(
            Trial(
                name=effect.name,
                candidate=candidate,
                error=ranking_error(residual),
                gain=float((before.sum() - loss.sum()) / max(base.residual.size, 1)),
                significance=_significance(base.residual, residual, numbers),
                fit_gain=before_fit**2 - ranking_error(candidate.fitted.fit.residual) ** 2,
                residual=residual,
                p_value=_chance(before - loss),
                steadiness=_steadiness(before - loss),
            )
        )
    return sorted(trials, key=lambda t: t.error)


def _chance(drops: np.ndarray, flips: int = 2000) -> float:
    """Chance of so large a total drop, were each block's drop as likely a rise (sign-flip test, (m,) blocks)."""
    rng = np.random.default_rng(0)
    signs = rng.choice([-1.0, 1.0], size=(flips, drops.size))
    return float((1 + np.sum(signs @ drops >= drops.sum())) / (1 + flips))


def _steadiness(drops: np.ndarray) -> float:
    """Mean drop per block of time over its standard error, (m,) blocks: is it one lucky stretch, or throughout?"""
    spread = float(np.std(drops, ddof=1)) if drops.size > 1 else 0.0
    return float(np.mean(drops) / (spread / np.sqrt(drops.size))) if spread > 0 else 0.0


def _significance(worse: np.ndarray, better: np.ndarray, numbers: np.ndarray) -> float:
    """Drop of the squared residual over its standard error, were the better model's residual all noise.

    The drop of r^2 to (r - d)^2 is 2 r d - d^2; its noise is that of 2 r d, summed within blocks of time so that
    correlated samples count once, and with the residual's own size where d is large, so that a rough spot weighs less.
    """
    d = worse - better
    drop = float(huber_square(worse).sum() - huber_square(better).sum())
    sums = np.bincount(numbers, d * np.clip(better, -8.0, 8.0))
    # Within a block noise may cancel by luck: no less than independent samples would give.
    floor = float(np.sum((d * np.clip(better, -8.0, 8.0)) ** 2))
    spread = 2.0 * float(np.sqrt(max(float(np.sum(sums**2)), floor)))
    return drop / spread if spread > 0 else 0.0


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
    trials = try_all(case, base, present, all_effects, progress)
    quantised = _quantisation(case, base)
    return judge(case, base, trials, quantised, all_effects, began)


def judge(
    case: Case, base: BaseFit, trials: list[Trial], quantised: Trial | None, all_effects: bool, began: float
) -> Diagnosis:
    """The verdict on a base model and the effects tried on it."""
    before_fit = misfit(base.fitted.model, case.fit_records)
    before_validate = misfit(base.fitted.model, case.validate_records)
    best_of_family = one_per_family(trials)
    for trial in best_of_family[:6]:
        trial.after_fit = misfit(trial.candidate.fitted.model, case.fit_records)
        trial.after_validate = misfit(trial.candidate.fitted.model, case.validate_records)
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
        if over <= enough:
            return done(
                "adequate", None, (), 0.0, "what is left is noise, and no effect lowers it on the held-out record"
            )
        if pattern < LEAST_PATTERN and persistence(case, base) < LEAST_PERSISTENCE:
            return done(
                "adequate", None, (), 0.0,
                "no effect lowers what is left, and it follows no coordinate: noise, though more than was thought",
            )  # fmt: skip
        return done(
            "unexplained",
            None,
            (),
            1.0,
            "the misfit is above the noise, and no effect lowers it on the held-out record",
        )
    ties, best = tied(case, base, best_of_family)
    after = excess(best.after_fit, best.after_validate)
    left = _left(over, after)
    share = explained_share(base, best)
    if over <= enough and (share < 0.5 or best.family in AT_REVERSALS):
        return done("adequate", None, (), 0.0, "what is left is noise; no effect is worth its parameters")
    patterned = pattern >= LEAST_PATTERN or persistence(case, base) >= LEAST_PERSISTENCE
    if case.form == "force_balance" and best.family in AT_REVERSALS and not patterned:
        return done("adequate", None, (), 0.0, "what is left follows no coordinate: the timing of the axis's turns")
    if share >= SHARE_ENOUGH or 1.0 - left >= VARIANCE_ENOUGH or after <= 1.5:
        return done("missing-effect", best, ties, left, "explains what can be explained")
    remaining = _pattern_after(case, base, best)
    if max(share, 1.0 - left) >= SHARE_OF_A_PART and remaining < LEAST_PATTERN_LEFT:
        return done(
            "missing-effect", best, ties, left, "explains its share; what it leaves follows no coordinate closely"
        )
    rest, rest_left = _second_share(case, base, best, all_effects, over)
    if rest >= SHARE_OF_TWO or 1.0 - rest_left >= VARIANCE_OF_TWO:
        return done("missing-effect", best, ties, left, "explains its share; another effect explains the rest")
    return done(
        "unexplained", None, (), 1.0 - max(share, 0.0),
        f"the best effect, {best.family}, takes only {100 * share:.0f} % of the misfit, and no second one the rest",
    )  # fmt: skip


ADEQUATE_OVER_NOISE = {"output": 1.15, "force_balance": 1.35}
"""Robust error over noise up to which a model is adequate, by form: the noise itself is known to no better, and a force
balance has besides the errors of when exactly the axis turned."""

AT_REVERSALS = (
    "frictional_lag",
    "bristle_damping",
    "presliding",
    "backlash",
    "drive_lag",
    "drive_delay",
    "flexible_mode",
)
"""Effects that a small error in the time of a reversal looks like: not believed while the error is near the noise."""

LEAST_PERSISTENCE = 0.25
"""Correlation of the residual with itself four scored samples on, above the noise's own, that counts as a pattern."""

LEAST_PATTERN = 0.15
"""Share of the residual's variance that some coordinate must explain before it counts as a pattern."""

SHARE_ENOUGH = 0.80
"""Share of the ranking loss above the noise from which one effect is the explanation: with another law for the same
effect a true one reaches 0.85 and more, a false one that leans on it 0.65 at the most (generated records)."""

VARIANCE_ENOUGH = 0.93
"""The same in the robust variance, which a few rough samples do not weigh down: 0.95 and more, against 0.86."""

SHARE_OF_A_PART = 0.55
LEAST_PATTERN_LEFT = 0.3
"""An effect that takes this share, and leaves a residual of which no coordinate explains so much, is missing beside
others; where a coordinate still explains much of what is left, the effect only leans on one that no library has."""

SHARE_OF_TWO = 0.92
VARIANCE_OF_TWO = 0.97
"""Shares that two effects must take together, where one alone leaves much."""

LEAST_SIGNIFICANCE = 4.0
LEAST_STEADINESS = 1.5
LEAST_GAIN = 0.06
"""Of the mean squared loss, on the records of the fit and on the held-out ones."""


def excess(fit: dict[str, ChannelMisfit], validate: dict[str, ChannelMisfit]) -> float:
    """Largest error over noise of any channel, on the records of the fit or the held-out ones."""
    return max((m.over_noise for m in (*fit.values(), *validate.values())), default=1.0)


def _left(before: float, after: float) -> float:
    """Share of the variance above the noise that is left."""
    return float(min(1.0, max(0.0, after**2 - 1.0) / max(before**2 - 1.0, 1e-9)))


def persistence(case: Case, base: BaseFit) -> float:
    """Correlation of the held-out residual with itself four scored samples on, less that of the sensors' noise: what is
    left between 1 (a slow pattern, of whatever coordinate) and 0 (noise)."""
    lag, best = 4, 0.0
    start = 0
    for picks in base.weights.picks:
        for channel, pick in picks.items():
            r = np.clip(base.residual[start : start + pick.size], -8.0, 8.0)
            start += pick.size
            if r.size < 50:
                continue
            noise = case.noise.get(channel)
            # Filtered records are thinned to a sample per filter width, where even coloured noise has been forgotten.
            own = noise.correlation**lag if noise is not None and case.form == "output" else 0.0
            best = max(best, float(np.corrcoef(r[lag:], r[:-lag])[0, 1]) - own)
    return best


def one_per_family(trials: Sequence[Trial]) -> list[Trial]:
    """The best law of each effect; between laws that differ by chance only, the one with fewer parameters."""
    kept: dict[str, Trial] = {}
    for trial in trials:
        other = kept.get(trial.family)
        if other is None or (_count(trial) < _count(other) and trial.error <= 1.01 * other.error):
            kept[trial.family] = trial
    return sorted(kept.values(), key=lambda t: t.error)


def _count(trial: Trial) -> int:
    return len(trial.candidate.fitted.model.unknowns)


def is_worthwhile(base: BaseFit, trial: Trial) -> bool:
    """Whether an effect lowers the held-out loss by more than chance, and by enough to matter."""
    before = ranking_error(base.residual) ** 2
    before_fit = ranking_error(base.fitted.fit.residual) ** 2
    certain = trial.significance >= LEAST_SIGNIFICANCE or trial.steadiness >= LEAST_STEADINESS
    return certain and trial.gain >= LEAST_GAIN * before and trial.fit_gain >= LEAST_GAIN * before_fit


def explained_share(base: BaseFit, trial: Trial) -> float:
    """Share of the held-out loss above the noise that the effect takes away."""
    before = ranking_error(base.residual) ** 2
    floor = min(1.0, trial.error**2)
    return float((before - trial.error**2) / max(before - floor, 1e-9))


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
        if behind <= 0.03 * gained and _significance(other.residual, first.residual, numbers) < 2.5:
            group.append(other)
    best = min(group, key=lambda t: (_count(t), t.error))
    least = excess(best.after_fit, best.after_validate)
    for other in ranked[1:]:
        simpler = _count(other) < _count(best) and other.after_fit
        as_good = simpler and excess(other.after_fit, other.after_validate) <= 1.03 * least
        if as_good and before - other.error**2 >= 0.97 * gained:
            best = other
    names = [t.family for t in group if t is not best and _count(t) <= _count(best)][:2]
    return tuple(names), best


def _pattern_after(case: Case, base: BaseFit, best: Trial) -> float:
    """Largest share of the residual that one coordinate explains once the effect is in."""
    fitted = best.candidate.fitted
    maps = residual_maps(fitted.model, case.fit_records, fitted.weights, case.validate_records, base.weights)
    return max((m.share for m in maps), default=0.0)


def _second_share(case: Case, base: BaseFit, best: Trial, all_effects: bool, over: float) -> tuple[float, float]:
    """Share of the loss above the noise that the best pair with `best` takes away, and of the variance it leaves."""
    fitted = best.candidate.fitted
    on_top = BaseFit(fitted, base.weights, best.residual)
    present = [*(e.name for e in case.start.effects), best.name]
    trials = try_all(case, on_top, present, all_effects)
    if not trials:
        return explained_share(base, best), 1.0
    model = trials[0].candidate.fitted.model
    after = excess(misfit(model, case.fit_records), misfit(model, case.validate_records))
    return explained_share(base, trials[0]), _left(over, after)


def _quantisation(case: Case, base: BaseFit) -> Trial | None:
    """The coarse grid of a channel's values as a trial, where it is coarser than the noise the user gave."""
    if any(name.partition("@")[0] == "sensor_quantisation" for name in case.experiment.effects):
        return None
    coarse = [
        channel for channel, noise in case.noise.items()
        if noise.quantum is not None and noise.quantum / np.sqrt(12.0) > noise.value
    ]  # fmt: skip
    if not coarse:
        return None
    names = [
        *case.experiment.effects,
        *(["sensor_quantisation"] if len(case.noise) == len(coarse) else [f"sensor_quantisation@{c}" for c in coarse]),
    ]
    other = make_case(case.experiment, case.records, names)
    refit = fit_case(other)
    after_fit = misfit(refit.fitted.model, other.fit_records)
    after = misfit(refit.fitted.model, other.validate_records)
    before = excess(misfit(base.fitted.model, case.fit_records), misfit(base.fitted.model, case.validate_records))
    if before <= ADEQUATE_OVER_NOISE[case.form] or excess(after_fit, after) > 0.9 * before:
        return None
    error = ranking_error(refit.residual)
    candidate = Candidate(find("sensor_quantisation"), 1.0, refit.fitted)
    return Trial(names[-1], candidate, error, 0.0, 99.0, 0.0, refit.residual, after_fit, after)
