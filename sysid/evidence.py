"""What a verdict is made from: a base model's misfit, the effects tried on it, and what can be read off both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sim.effect import Effect
from sysid.balance import Balance
from sysid.base_fit import ranking_error
from sysid.case import Case
from sysid.case_fit import BaseFit
from sysid.misfit import ChannelMisfit, away_from_turns, excess, huber_square, misfit
from sysid.model import Model
from sysid.own_patterns import apart_from, own_coordinates
from sysid.residual_maps import residual_maps
from sysid.trials import Search, Trial
from sysid.verdict_limits import (
    ADEQUATE_OVER_NOISE,
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
)


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
        added: effects of the model that earlier rounds added.
    """

    case: Case
    base: BaseFit
    search: Search
    ranked: Sequence[Trial]
    over: float
    pattern: float
    all_effects: bool
    added: Sequence[Effect] = ()

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
        return self.left_at(excess(*misfits_of(self.case, trial)))

    def left_at(self, over: float) -> float:
        """Share of the variance above the noise that is left where a model's error over noise is `over`."""
        return float(min(1.0, max(0.0, over**2 - 1.0) / max(self.over**2 - 1.0, 1e-9)))

    @property
    def patterned(self) -> bool:
        """Whether the base model's residual follows some coordinate, known or not."""
        return self.pattern >= LEAST_PATTERN or persistence(self.case, self.base) >= LEAST_PERSISTENCE

    def pattern_left(self, model: Model, coordinates: Sequence[str] = ()) -> float:
        """Largest share of a model's residual that one coordinate explains, of all or of some."""
        case, base = self.case, self.base
        maps = residual_maps(model, case.fit_records, base.fitted.weights, case.validate_records, base.weights)
        return max((m.share for m in maps if not coordinates or m.coordinate in coordinates), default=0.0)

    def bent(self, trial: Trial) -> bool:
        """Whether an effect of the position, or of time, leaves a residual that still follows it: another law."""
        own = trial.candidate.effect.coordinates
        if own not in (("position",), ("time",)):
            return False
        return self.pattern_left(trial.candidate.fitted.model, own) >= BENT

    def share_away(self, trial: Trial) -> float | None:
        """Share of the held-out loss above the noise, away from the turns of a driven mass, that an effect takes."""
        away = away_from_turns(self.case.validate_records, self.base.weights)
        if np.mean(away) < LEAST_AWAY:
            return None
        before, after = (float(np.mean(huber_square(r[away]))) for r in (self.base.residual, trial.residual))
        # Where there is little above the noise a share of it says nothing.
        return (before - after) / (before - min(1.0, after)) if before > CLEARLY_AWAY else 0.0

    def share_apart(self, trial: Trial) -> float:
        """Share of the held-out loss above the noise that an effect takes, apart from the patterns of added effects."""
        own = own_coordinates(self.added)
        if not own:
            return 0.0
        records, weights = self.case.validate_records, self.base.weights
        before, after = (
            float(np.mean(huber_square(apart_from(r, records, weights, own))))
            for r in (self.base.residual, trial.residual)
        )
        return (before - after) / max(before - min(1.0, after), 1e-9)

    def like_turns(self, trial: Trial) -> bool:
        """Whether a small error in the time of the turns would look like this effect."""
        # On a driven mass a late sensor of its motion is a late drive.
        late = self.case.kind == "force-drive" and trial.family in LATE
        return (late or trial.family in AT_REVERSALS) and trial.share_at_rest < AT_REST


def misfits_of(case: Case, trial: Trial) -> tuple[dict[str, ChannelMisfit], dict[str, ChannelMisfit]]:
    """Misfits with an effect in, kept with its trial."""
    if not trial.after_fit:
        trial.after_fit = misfit(trial.candidate.fitted.model, case.fit_records)
        trial.after_validate = misfit(trial.candidate.fitted.model, case.validate_records)
    return trial.after_fit, trial.after_validate


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
    # What shows at a few break-aways alone is never steady: there it must take most, on all records.
    most = trial.gain >= MOST_OF_IT * before and trial.fit_gain >= MOST_OF_IT * before_fit
    certain |= most and trial.significance >= LEAST_OF_MOST
    return certain and trial.gain >= LEAST_GAIN * before and trial.fit_gain >= LEAST_GAIN * before_fit
