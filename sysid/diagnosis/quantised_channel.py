"""Quantisation of a channel, found from its values: a least significant bit larger than the stated noise."""

from dataclasses import dataclass

from sim.effects.catalogue import find_where, rounding_effects
from sysid.diagnosis.candidate import Candidate, Reference
from sysid.diagnosis.constants import CURVE_MARGIN, NOISE_FACTOR
from sysid.diagnosis.held_out import LARGEST, Transfer
from sysid.diagnosis.ledger import Entry
from sysid.estimation.misfit import misfit, worst_over_noise
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model
from sysid.prediction.problem import build_problem
from sysid.signals import KEPT, TRIM_FACTOR

EVEN = (KEPT / TRIM_FACTOR) ** 2
"""Trimmed variance of a uniform distribution, that of the rounding error, over its variance."""

MOST_RISE = 1.02
"""Largest ratio of the held-out errors with quantisation and without."""

CLEAR_FALL = 0.5
"""Ratio of the held-out errors, in their unit, up to which they fall clearly."""


@dataclass(frozen=True)
class QuantisedChannel:
    """The stated model with the quantisation noise of a channel, its fit, and the part of the excess it explains."""

    candidate: Candidate
    base: ReferenceFit
    share: float

    @property
    def entry(self) -> Entry:
        """Its entry in the ledger."""
        words = "the measured values lie on a grid coarser than the noise"
        return Entry(self.candidate.effect, "established", words, self.candidate, words=words)


def quantised_channel(reference: Reference) -> QuantisedChannel | None:
    """The stated model with the quantisation of a channel, if the stated noise is less than its quantisation noise.

    None if there is no such channel (an estimated noise includes the quantisation), or if the held-out error rises. A
    larger standard deviation alone explains nothing, since it is the unit of the error: the quantisation noise has to
    account for a part of the excess over the stated noise, or the error in the unit of the channel has to fall clearly,
    to the noise. If the error does not exceed the stated noise, but the quantisation noise does, the signal occupies
    few levels, which mask the noise.
    """
    problem, base = reference.problem, reference.base
    coarse = [c for c, n in problem.noise.items() if n.quantisation_step is not None and n.without_quantisation is None]
    if not coarse or rounding_effects(problem.experiment.effects, problem.custom):
        return None
    every = len(problem.noise) == len(coarse)
    rounding = find_where(lambda effect: effect.rounds)
    added = [rounding.name] if every else [f"{rounding.name}@{c}" for c in coarse]
    model = base.fitted.model
    validated = misfit(model, problem.validate_records)
    before = worst_over_noise(misfit(model, problem.fit_records), validated)
    other = build_problem(problem.experiment, problem.records, [*problem.experiment.effects, *added])
    refit = fit_stated_model(other)
    with_steps = Reference.of(other, refit)
    candidate = Candidate(
        problem=other,
        added=(rounding,),
        fitted=refit.fitted,
        held_out=with_steps.held_out,
        gain=Transfer(1.0, LARGEST),
        fit_gain=0.0,
        law=added[-1],
    )
    # By quantisation over that of the noise, of the channel where it is largest.
    pairs = zip(problem.validate_records, other.validate_records, strict=True)
    added_variance = max((new.noise[c] / old.noise[c]) ** 2 - 1.0 for old, new in pairs for c in old.measured)
    hidden = before <= NOISE_FACTOR and added_variance >= NOISE_FACTOR**2
    share = min(1.0, EVEN * added_variance / max(before**2 - 1.0, 1e-9))
    # With another noise the filter of a force balance has another width: the values are compared at the same one.
    compared = misfit(
        model.at({k: v for k, v in refit.fitted.model.values.items() if k in model.values}), problem.validate_records
    )
    risen = any(compared[c].rms > MOST_RISE * m.rms for c, m in validated.items())
    # If the stated noise is too small, the filter of a force balance is too narrow, and the times of events are wrong.
    fallen = all(candidate.after_validate[c].rms <= CLEAR_FALL * m.rms for c, m in validated.items())
    resolved = fallen and worst_over_noise(candidate.after_fit, candidate.after_validate) <= NOISE_FACTOR
    explained = before > NOISE_FACTOR and (resolved or share >= CURVE_MARGIN)
    if risen or not (hidden or explained):
        return None
    return QuantisedChannel(candidate, refit, share)
