"""Effects added earlier that are not needed, or that another effect replaces with a clearly lower held-out loss."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sysid.diagnosis.candidate import Candidate
from sysid.diagnosis.constants import CERTAIN_Z, CURVE_MARGIN, LEAST_GAIN
from sysid.diagnosis.model_search import ModelSearch
from sysid.estimation.misfit import misfit, worst_over_noise
from sysid.prediction.model import public_name


@dataclass(frozen=True)
class Replacement:
    """An effect of the model that should be removed or replaced.

    Args:
        old: its name.
        new: its replacement; none where it is not needed.
        before, after: error over noise on the held-out records, without and with the replacement.
    """

    old: str
    new: str | None
    before: float
    after: float


def find_replacements(search: ModelSearch, added: Sequence[str], others_too: bool = True) -> list[Replacement]:
    """Effects added earlier that should be removed or replaced."""
    found = []
    for name in added:
        family = public_name(name)
        below = search.without(search.stated, family) if _removable(search, family) else None
        if below is None:
            continue
        if not _needed(search, below):
            found.append(_replacement(search, name, below))
            continue
        options = [search.converged(option) for option in search.step(below)] if others_too else []
        best = min(options, key=lambda c: c.held_out.loss, default=None)
        if best is not None and _clearly_better(search, best):
            found.append(_replacement(search, name, best))
    return found


def _removable(search: ModelSearch, family: str) -> bool:
    """Whether an effect acts in the fitted model, is not a friction state, and was estimated from these residuals."""
    model = search.base.fitted.model
    present = any(public_name(e.name) == family and e.friction_state is None for e in model.effects)
    own = [u for u in model.unknowns if public_name(u.key.rpartition(".")[0]) == family]
    # An effect detected outside these residuals, such as a mode above the filter band, has priors on all its values.
    return present and not (own and all(u.prior is not None for u in own))


def _needed(search: ModelSearch, below: Candidate) -> bool:
    gain = below.held_out.gain_of(search.reference.held_out)
    return gain.loss >= LEAST_GAIN * below.held_out.loss or gain.z >= CERTAIN_Z


def _clearly_better(search: ModelSearch, other: Candidate) -> bool:
    excess = max(search.reference.held_out.loss - 1.0, 0.0)
    gain = other.gain
    return gain.z >= CERTAIN_Z and gain.loss > max(CURVE_MARGIN * excess, LEAST_GAIN * search.reference.held_out.loss)


def _replacement(search: ModelSearch, old: str, candidate: Candidate) -> Replacement:
    before = misfit(search.base.fitted.model, search.problem.validate_records)
    new = candidate.public_name if candidate.added else None
    return Replacement(old, new, worst_over_noise({}, before), worst_over_noise({}, candidate.after_validate))
