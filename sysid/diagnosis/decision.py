"""Verdict of a diagnosis: an effect is missing, the model is adequate, or the misfit is unexplained.

1. An effect that is established in the ledger (`sysid/diagnosis/ledger.py`) is missing: the one of largest gain first.
2. Without one, the model is adequate if its error is at most that of noise whose level was estimated too low, and no
   free curve of a recurring coordinate explains a notable part of it.
3. Otherwise the misfit is unexplained.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sim.effects.effect import Coordinate
from sysid.diagnosis.candidate import Candidate
from sysid.diagnosis.constants import CERTAIN_Z, EVEN_SHARE, FORM_ERROR, NOISE_FACTOR, NOTABLE_SHARE
from sysid.diagnosis.held_out import evenness
from sysid.diagnosis.ledger import Entry, Ledger
from sysid.diagnosis.model_search import ModelSearch, without_added
from sysid.estimation.misfit import ResidualWeights, blocks, huber_square, weighted_residual
from sysid.prediction.prepared_record import PreparedRecord


@dataclass(frozen=True)
class NoiseLevel:
    """Noise level as far as it is known."""

    loss: float = 1.0  # of a complete model: 1, or less where the estimated level was too high
    # largest loss of the stated model on any records, with the form error of the laws added to it before in the
    # variance
    adequate_loss: float = 1.0
    evenness: float = 1.0  # median over mean of the variances of that residual in the blocks of time (`evenness`)

    @property
    def plausible(self) -> bool:
        """Whether the loss of the stated model may be that of noise whose level was estimated too low.

        A wrong level is the same at all times: an error that occurs mostly in less than half of the blocks has another
        cause, such as an effect that acts for some of the time.
        """
        even = self.adequate_loss <= NOISE_FACTOR or self.evenness >= EVEN_SHARE
        return self.adequate_loss <= NOISE_FACTOR**2 and even


@dataclass(frozen=True)
class FreeCurve:
    """The best free curve: its coordinate, its share of the excess, the quantity that is a function of the coordinate,
    as text, and whether the coordinate recurs, so that the curve is a rival of the effects."""

    coordinate: Coordinate
    share: float
    quantity: str = "force"
    recurs: bool = True


@dataclass(frozen=True)
class Decision:
    """Decision of a diagnosis."""

    verdict: str  # `missing-effect`, `adequate` or `unexplained`
    best: Candidate | None  # the stated model with the effect named, for `missing-effect`
    ledger: Ledger  # every effect with its state
    reason: str  # as text
    free_curve: FreeCurve | None = None  # best free curve on top of the stated model; none where there is no excess
    best_named: tuple[str, float] | None = None  # best named candidate, and its share of the excess
    detected_by: str = ""  # method of detection as text, if not a reduction of the error

    @property
    def indistinguishable(self) -> tuple[str, ...]:
        """Effects that these records cannot distinguish from the one named."""
        return self.ledger.established[0].ties if self.ledger.established else ()

    @property
    def unexplained_share(self) -> float:
        """Part of the excess that the established effects leave."""
        return 0.0 if self.verdict == "adequate" else 1.0 - self.ledger.explained


def decide(
    search: ModelSearch, ledger: Ledger, noise: NoiseLevel, recurring: frozenset[Coordinate], driven: bool = False
) -> Decision:
    """The decision on a stated model; `driven`: the balance has the inertia force of a measured motion."""
    reference = search.reference.held_out
    curve = next(iter(search.curves), None)
    # Mass times acceleration has the errors of the measured motion: a curve of it takes them up, missing force or not.
    deciding = recurring - {"acceleration"} if driven else recurring
    fair = [c for c in search.curves if c.effect.coordinates[0] in deciding]
    named = next((c for c in search.ranked if c.implausible is None), None)

    def share(candidate: Candidate) -> float:
        loss = candidate.held_out.loss
        return max(0.0, (reference.loss - loss) / max(reference.loss - min(noise.loss, loss), 1e-9))

    best_curve = best_named = None
    if reference.loss > noise.loss:
        if curve is not None:
            quantity = {"friction": "friction level", "piezo": "voltage"}.get(curve.effect.acts_on, "force")
            place = curve.effect.coordinates[0]
            best_curve = FreeCurve(place, share(curve), quantity, place in recurring)
        if named is not None:
            best_named = named.public_name, share(named)
    if ledger.established:
        first, *rest = ledger.established
        others = ", ".join({entry.name: "" for entry in rest if entry.name != first.name})
        words = f"explains the residual together with {others}" if others else "explains the residual"
        if first.words:
            words = first.reason
        best = _alone(search, first, ledger)
        return Decision("missing-effect", best, ledger, words, best_curve, best_named, first.words)
    # Below the noise as far as it is known, a dependence is one of the estimate of its level.
    notable = next((c for c in fair if _is_notable(c, reference.loss)), None) if reference.loss > 1.0 else None
    if noise.plausible and notable is None:
        words = "no effect and no coordinate explains the residual"
        if noise.adequate_loss > NOISE_FACTOR:
            words += (
                ", but the error exceeds the noise: the level of the noise is too low, or an effect acts that no "
                "coordinate shows"
            )
        return Decision("adequate", None, ledger, words, best_curve, best_named)
    words = "no effect lowers the error significantly on the held-out records"
    if ledger.entries:
        entry = ledger.entries[0]
        words = f"{entry.name} is {'possible' if entry.state == 'possible' else 'not established'}: {entry.reason}"
    elif noise.adequate_loss <= NOISE_FACTOR**2 and not noise.plausible:
        words += "; most of the error occurs in less than half of the time"
    if notable is not None:
        words += f"; a free curve of {notable.effect.coordinates[0]} explains {100.0 * share(notable):.0f} %"
    return Decision("unexplained", None, ledger, words, best_curve, best_named)


def _is_notable(curve: Candidate, loss: float) -> bool:
    """Whether a free curve explains a notable part of the loss on the records of the fit and on the held-out ones: what
    acts on one of them only is a property of the record, such as its noise or its sampling."""
    shares = curve.gain.loss / loss, curve.fit_gain / (curve.fit_gain + curve.fit_loss)
    return min(shares) >= NOTABLE_SHARE and curve.gain.z >= CERTAIN_Z


def _alone(search: ModelSearch, entry: Entry, ledger: Ledger) -> Candidate:
    """The stated model with one effect of the ledger alone."""
    if len(ledger.model.added) == 1:
        return ledger.model
    alone = ledger.model
    for effect in ledger.model.added:
        if effect.name != entry.effect.name:
            alone = search.without(alone, effect.name) or alone
    return alone


def noise_level(search: ModelSearch, added: Sequence[str]) -> NoiseLevel:
    """What is known of the noise level; `added` has the names of the effects that were added to the stated model."""
    problem, base = search.problem, search.base
    known = problem.noise_is_known
    richest = min((c.held_out.loss for c in (*search.ranked, *search.curves)), default=1.0)
    held = _contributions(search, added, problem.validate_records, base.weights)
    fit = _contributions(search, added, problem.fit_records, base.fitted.weights)
    fit_block = blocks(problem.fit_records, base.fitted.weights)
    reference = search.reference.held_out
    parts = [(reference.residual, held, reference.block), (base.fitted.fit.residual, fit, fit_block)]
    scaled = [(r / np.sqrt(1.0 + (0.5 * FORM_ERROR) ** 2 * c), block) for r, c, block in parts if r.size]
    losses = [(float(np.mean(huber_square(r))), evenness(r, block)) for r, block in scaled]
    adequate_loss, even = max(losses, default=(1.0, 1.0))
    return NoiseLevel(1.0 if known else min(1.0, max(richest, NOISE_FACTOR**-2)), adequate_loss, even)


def _contributions(
    search: ModelSearch, added: Sequence[str], records: Sequence[PreparedRecord], weights: ResidualWeights
) -> np.ndarray:
    """Sum over the effects added of the squared change (n,) of the residual without the effect, in deviations."""
    model = search.base.fitted.model
    residual = weighted_residual(model, records, weights)
    total = np.zeros(residual.size)
    for effect in model.effects:
        if effect.name in added:
            rest = without_added(model, effect.name, model, search.problem.scales)
            total += (weighted_residual(rest, records, weights) - residual) ** 2
    return total
