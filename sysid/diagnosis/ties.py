"""Practically equivalent candidate effects: those whose held-out losses differ insignificantly from the best one's.

The simplest of them is named, the others are reported as indistinguishable.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sysid.diagnosis.pairs import Pair
from sysid.diagnosis.trials import CandidateFit, parameter_count, significance_of
from sysid.diagnosis.verdict_limits import LATE, MORE_IS_MISSING
from sysid.estimation.fit import root_mean_huber
from sysid.estimation.misfit import blocks, worst_over_noise
from sysid.estimation.reference_fit import ReferenceFit
from sysid.prediction.problem import Problem

OF_FORM = 1e-3
"""Part of the gain by which two effects may differ because no law is exact."""

CONTAINED = {"coulomb": ("presliding",)}
"""Effects that contain another as a limit: bristles of zero stretch are rigid friction. With equal gains they are no
rivals; the simpler one is named."""

COMPARED = 6
"""Effects, in the order of held-out error, among which a simpler one with an equal error is preferred."""


def tied_beside(
    problem: Problem, base: ReferenceFit, pair: Pair, pairs: Sequence[Pair], partner: str
) -> tuple[str, ...]:
    """Effects that, beside the same partner, are equivalent to the other one of a pair."""
    numbers = blocks(problem.validate_records, base.weights)
    gained = root_mean_huber(base.residual) ** 2 - pair.error**2
    others = [other for other in pairs if other is not pair and partner in other.names]
    return tuple(other.partner(partner) for other in others if _by_chance(pair, other, gained, numbers))[:2]


def _by_chance(
    first: CandidateFit | Pair, other: CandidateFit | Pair, gained: float, numbers: np.ndarray, alike: bool = False
) -> bool:
    """Whether the losses of two effects differ insignificantly, with samples in the blocks of time `numbers` (n,)."""
    behind = other.error**2 - first.error**2
    # Where another effect is missing too, it determines the last hundredth of the gain.
    alike |= first.error > MORE_IS_MISSING and behind <= 0.01 * gained
    alike |= behind <= OF_FORM * gained
    return behind <= 0.03 * gained and (alike or significance_of(other.residual, first.residual, numbers) < 2.5)


def tied(problem: Problem, base: ReferenceFit, ranked: Sequence[CandidateFit]) -> tuple[tuple[str, ...], CandidateFit]:
    """The indistinguishable effects, and the effect to name.

    Tied are effects whose held-out loss differs insignificantly from the best one's. Named is the simplest of them, or
    a simpler effect with an equal robust error, which differs in a few samples beside reversals only.
    """
    numbers = blocks(problem.validate_records, base.weights)
    first = ranked[0]
    before = root_mean_huber(base.residual) ** 2
    gained = before - first.error**2
    group = [first]
    for other in ranked[1:]:
        # Along a filtered motion a lag and a delay differ by less than the error of the filter.
        alike = problem.kind == "force-drive" and {first.public_name, other.public_name} <= LATE and other.error <= 1.0
        if _by_chance(first, other, gained, numbers, alike):
            group.append(other)
    best = min(group, key=lambda t: (parameter_count(t), t.error))
    least = worst_over_noise(best.after_fit, best.after_validate)
    for other in ranked[1:COMPARED]:
        simpler = parameter_count(other) < parameter_count(best)
        as_good = simpler and worst_over_noise(other.after_fit, other.after_validate) <= 1.03 * least
        if as_good and before - other.error**2 >= 0.97 * gained:
            best = other
    rivals = [t for t in group if t is not best and t.public_name not in CONTAINED.get(best.public_name, ())]
    names = [t.public_name for t in rivals if t is first or parameter_count(t) <= parameter_count(best)]
    return tuple(names[:2]), best
