"""Decision of a diagnosis: an effect is missing, the model is adequate, or the misfit is unexplained.

All models are compared by their held-out losses (`sysid/diagnosis/held_out.py`). With L0 the loss of the stated model,
L that of another one and n that of a complete model (`NoiseLevel.loss`), the excess is L0 - n and the share of the
other model (L0 - L) / (L0 - min(n, L)).

1. The best named model is the effect of lowest loss with plausible values, or a pair of effects that is clearly better.
2. If its gain is certain (over its standard error, over the scatter of the blocks, and large enough), and its share is
   sufficient, and no free curve of a coordinate is clearly better, the effect is missing.
3. If no named model is sufficient and no free curve explains a notable part, the model is adequate, as far as the level
   of the noise is known.
4. Otherwise the misfit is unexplained.

The constants are in `sysid/diagnosis/constants.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from sim.effects.effect import Coordinate
from sysid.diagnosis.candidate import Candidate
from sysid.diagnosis.constants import (
    CLEAR_MARGIN,
    CURVE_STEADINESS,
    EQUIVALENT_GAIN,
    EQUIVALENT_SIGNIFICANCE,
    FORM_ERROR,
    LEAST_GAIN,
    LEAST_SIGNIFICANCE,
    LEAST_STEADINESS,
    NEAR_NOISE_LOSS,
    NOISE_FACTOR,
    NOTABLE_SHARE,
    SUFFICIENT_SHARE,
)
from sysid.diagnosis.held_out import HeldOut
from sysid.diagnosis.model_search import ModelSearch


@dataclass(frozen=True)
class NoiseLevel:
    """Noise level as far as it is known, and form error of the laws that were added.

    Args:
        loss: of a complete model: 1, or less where the estimated level was too high, and the form error.
        form_error: mean square of the form error, in standard deviations.
        adequate_loss: largest loss of the stated model on any records, with the form error in the variance.
        evenness: median over mean of the variances of that residual in the blocks of time (`evenness`).
    """

    loss: float = 1.0
    form_error: float = 0.0
    adequate_loss: float = 1.0
    evenness: float = 1.0

    @property
    def plausible(self) -> bool:
        """Whether the loss of the stated model may be that of noise whose level was estimated too low.

        A wrong level is the same at all times: an error that occurs mostly in less than half of the blocks has another
        cause, such as an effect that acts for some of the time.
        """
        even = self.adequate_loss <= NOISE_FACTOR or self.evenness >= SUFFICIENT_SHARE
        return self.adequate_loss <= NOISE_FACTOR**2 and even


@dataclass(frozen=True)
class FreeCurve:
    """The best free curve: its coordinate, its share of the excess, and the quantity that is a function of the
    coordinate, as text."""

    coordinate: Coordinate
    share: float
    quantity: str = "force"


@dataclass(frozen=True)
class Decision:
    """Decision of a diagnosis.

    Args:
        verdict: `missing-effect`, `adequate` or `unexplained`.
        best: the candidate named, for `missing-effect`.
        ties: effects that these records cannot distinguish from it.
        unexplained_share: of the excess, that remains with the effect.
        reason: as text.
        free_curve: best free curve; none where there is no excess.
        best_named: best named candidate, and its share of the excess.
        detected_by: method of detection as text, if not a reduction of the error.
    """

    verdict: str
    best: Candidate | None
    ties: tuple[str, ...]
    unexplained_share: float
    reason: str
    free_curve: FreeCurve | None = None
    best_named: tuple[str, float] | None = None
    detected_by: str = ""


class _BestShares(NamedTuple):
    """Fields of a decision that do not depend on its verdict."""

    free_curve: FreeCurve | None = None
    best_named: tuple[str, float] | None = None


@dataclass(frozen=True)
class _Comparison:
    """Comparison of candidates with the stated model."""

    reference: HeldOut
    noise: NoiseLevel

    @property
    def excess(self) -> float:
        """Loss of the stated model above the noise."""
        return max(self.reference.loss - self.noise.loss, 0.0)

    def share(self, candidate: Candidate) -> float:
        """Part of the excess that a candidate removes."""
        loss = candidate.held_out.loss
        return (self.reference.loss - loss) / max(self.reference.loss - min(self.noise.loss, loss), 1e-9)

    def certain(self, candidate: Candidate) -> bool:
        """Whether the gain of a candidate is significant, steady and large enough."""
        gain = candidate.gain
        if self.excess == 0.0:
            return False
        strict = 2.0 if self.reference.loss <= NEAR_NOISE_LOSS * self.noise.loss else 1.0
        return (
            gain.significance >= strict * LEAST_SIGNIFICANCE
            and gain.steadiness >= strict * LEAST_STEADINESS
            and gain.loss >= max(LEAST_GAIN * self.reference.loss, len(candidate.added) * self.noise.form_error)
            and candidate.fit_gain > 0.0
        )

    def clearly_better(self, other: Candidate, candidate: Candidate, steadiness: float) -> bool:
        """Whether another candidate removes a clearly larger part of the excess, by more than the form error of the
        laws added before."""
        gain = candidate.held_out.gain_of(other.held_out)
        return gain.loss > max(CLEAR_MARGIN * self.excess, self.noise.form_error) and gain.steadiness >= steadiness

    def notable(self, curve: Candidate) -> bool:
        """Whether a free curve explains a notable part of the residual."""
        gain = curve.gain
        return (
            self.excess > 0.0
            and gain.loss >= max(NOTABLE_SHARE * self.reference.loss, self.noise.form_error)
            and gain.significance >= LEAST_SIGNIFICANCE
            and gain.steadiness >= CURVE_STEADINESS
        )


def decide(models: ModelSearch, reference: HeldOut, noise: NoiseLevel) -> Decision:
    """The decision on a stated model and its candidates."""
    compared = _Comparison(reference, noise)
    best, curve = _plausible(models.ranked), next(iter(models.curves), None)
    shares = _best_shares(compared, best, curve)
    named = best if best is not None and compared.certain(best) else None
    model = named
    if compared.excess > 0.0 and (named is None or compared.share(named) < 1.0 - CLEAR_MARGIN):
        pair = _plausible(models.pairs)
        if pair is not None and compared.certain(pair) and _needs_both(compared, pair, models.ranked, named):
            model = pair
    if model is None:
        return _insufficient(compared, None, curve, shares)
    beaten = curve is not None and compared.clearly_better(curve, model, CURVE_STEADINESS)
    if compared.share(model) >= SUFFICIENT_SHARE and not beaten:
        if len(model.added) == 2:
            pair = _of_pair(reference, models, model)
            if pair is not None:
                first, partner, ties = pair
                ties = _with_form_error(compared, models.ranked, first, ties, partner)
                return _missing(compared, first, ties, f"explains a part; {partner} explains the rest", shares)
        elif named is not None:
            chosen, ties = equivalent(reference, models.ranked, named)
            ties = _with_form_error(compared, models.ranked, chosen, ties)
            return _missing(compared, chosen, ties, "explains the residual", shares)
    return _insufficient(compared, model, curve, shares)


def _plausible(candidates: Sequence[Candidate]) -> Candidate | None:
    """The best candidate whose fitted values are plausible."""
    return next((c for c in candidates if c.implausible is None), None)


def _needs_both(compared: _Comparison, pair: Candidate, ranked: Sequence[Candidate], named: Candidate | None) -> bool:
    """Whether a pair is clearly better than the effect that would be named, and than each of its own effects alone."""
    alone = [c for c in ranked if c.public_name in pair.families and c.implausible is None]
    return all(_clear_pair(compared, pair, one) for one in [*alone, *([] if named is None else [named])])


def _clear_pair(compared: _Comparison, pair: Candidate, single: Candidate) -> bool:
    gain = single.held_out.gain_of(pair.held_out)
    return gain.significance >= LEAST_SIGNIFICANCE and compared.clearly_better(pair, single, LEAST_STEADINESS)


def _of_pair(reference: HeldOut, models: ModelSearch, best: Candidate) -> tuple[Candidate, str, tuple[str, ...]] | None:
    """The effect of a pair that is named, its partner, and the effects that may replace it beside the partner.

    Of the pairs whose gains do not differ significantly from the best one's the simplest is taken; of its members the
    one that is in most of these pairs, then the one that gains more alone.
    """
    gained = reference.loss - best.held_out.loss
    group = [pair for pair in models.pairs if pair.implausible is None and _equivalent(pair, best, gained)]
    chosen = min(group, key=lambda c: (c.parameter_count, c.held_out.loss))
    alone = [c for c in models.ranked if c.public_name in chosen.families and c.implausible is None]
    if not alone:
        return None
    first = max(alone, key=lambda c: (sum(c.public_name in pair.families for pair in group), c.gain.loss))
    partner = next((name for name in chosen.families if name != first.public_name), "")
    ties = [name for pair in group if partner in pair.families for name in pair.families]
    others = dict.fromkeys(name for name in ties if name not in (partner, first.public_name))
    return first, partner, tuple(others)[:2]


def _equivalent(other: Candidate, best: Candidate, gained: float) -> bool:
    """Whether the gain of another candidate differs insignificantly from the best one's, `gained`."""
    if other is best:
        return True
    behind = other.held_out.loss - best.held_out.loss
    if behind <= FORM_ERROR**2 * gained:
        # A relative form error e of a law leaves e^2 of the gain.
        return True
    return (
        behind <= EQUIVALENT_GAIN * gained
        and other.held_out.gain_of(best.held_out).significance < EQUIVALENT_SIGNIFICANCE
    )


def equivalent(reference: HeldOut, ranked: Sequence[Candidate], best: Candidate) -> tuple[Candidate, tuple[str, ...]]:
    """The simplest of the effects whose gains do not differ significantly from the best one's, and the others."""
    gained = reference.loss - best.held_out.loss
    group = [c for c in ranked if c.implausible is None and _equivalent(c, best, gained)]
    chosen = min(group, key=lambda c: (c.parameter_count, c.held_out.loss))
    rivals = [c for c in group if c is not chosen and (c is best or c.parameter_count <= chosen.parameter_count)]
    return chosen, tuple(c.public_name for c in rivals)[:2]


def _with_form_error(
    compared: _Comparison, ranked: Sequence[Candidate], chosen: Candidate, ties: tuple[str, ...], partner: str = ""
) -> tuple[str, ...]:
    """The ties of an effect, at most two: also the effects with no more parameters whose losses exceed its own by less
    than the form error of the laws added before."""
    behind = [
        c.public_name
        for c in ranked
        if c.implausible is None
        and compared.certain(c)
        and c.parameter_count <= chosen.parameter_count
        and c.held_out.loss - chosen.held_out.loss < compared.noise.form_error
    ]
    names = dict.fromkeys([*ties, *behind])
    return tuple(name for name in names if name not in (chosen.public_name, partner))[:2]


def _insufficient(
    compared: _Comparison, model: Candidate | None, curve: Candidate | None, shares: _BestShares
) -> Decision:
    """The decision where no named model is sufficient: adequate as far as the level of the noise is known."""
    notable = curve is not None and compared.notable(curve)
    if compared.noise.plausible and not notable:
        words = "no effect and no coordinate explains the residual"
        if compared.noise.adequate_loss > NOISE_FACTOR:
            words += (
                ", but the error exceeds the noise: the level of the noise is too low, or an effect acts that no "
                "coordinate shows"
            )
        return Decision("adequate", None, (), 0.0, words, *shares)
    better = curve is not None and (
        notable if model is None else compared.clearly_better(curve, model, CURVE_STEADINESS)
    )
    return _unexplained(compared, model, curve, better, shares)


def _unexplained(
    compared: _Comparison, model: Candidate | None, curve: Candidate | None, beaten: bool, shares: _BestShares
) -> Decision:
    left = 1.0 if model is None else 1.0 - max(compared.share(model), 0.0)
    words = "no effect lowers the error significantly on the held-out records"
    if compared.noise.adequate_loss <= NOISE_FACTOR**2 and not compared.noise.plausible:
        words += "; most of the error occurs in less than half of the time"
    if model is not None:
        words = f"{' with '.join(model.families)} explains only {100.0 * (1.0 - left):.0f} % of the misfit"
    if beaten and curve is not None:
        words += f"; a free curve of {curve.effect.coordinates[0]} explains {100.0 * compared.share(curve):.0f} %"
    return Decision("unexplained", None, (), left, words, *shares)


def _missing(
    compared: _Comparison, best: Candidate, ties: tuple[str, ...], reason: str, shares: _BestShares
) -> Decision:
    left = min(1.0, max(0.0, 1.0 - compared.share(best)))
    return Decision("missing-effect", best, ties, left, reason, *shares)


def _free_curve(curve: Candidate, share: float) -> FreeCurve:
    quantity = {"friction": "friction level", "piezo": "voltage"}.get(curve.effect.acts_on, "force")
    return FreeCurve(curve.effect.coordinates[0], share, quantity)


def _best_shares(compared: _Comparison, best: Candidate | None, curve: Candidate | None) -> _BestShares:
    if compared.excess <= 0.0:
        return _BestShares()
    return _BestShares(
        None if curve is None else _free_curve(curve, max(compared.share(curve), 0.0)),
        None if best is None else (best.public_name, max(compared.share(best), 0.0)),
    )
