"""Replacement of effects added earlier: by another effect that explains more, or by none if the effect is not needed.

Each added effect is removed and the model refitted; then the candidates are evaluated in its place on the held-out
records.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sysid.diagnosis.pairs import ReducedModels
from sysid.diagnosis.trials import evaluate_candidate
from sysid.estimation.fit import root_mean_huber
from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import ReferenceFit
from sysid.estimation.screening import refit_candidate
from sysid.prediction.model import public_name
from sysid.prediction.problem import Problem

TRIED = 4
"""Candidates refitted in the place of an old effect, in the order of the screening."""

CLEARLY = 0.8
"""Largest loss above the noise with a replacement, over that with the old effect."""

NEEDLESS = 1.01
"""Held-out error without an effect, over that with it, up to which the effect is not needed."""


@dataclass(frozen=True)
class Swap:
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


def find_swaps(reduced: ReducedModels, added: Sequence[str], others_too: bool = True) -> list[Swap]:
    """Effects added earlier that should be removed or replaced.

    Args:
        reduced: the model without one of its effects.
        added: names of the effects that were added to it.
        others_too: search replacements too, not only effects that are not needed.
    """
    problem, base = reduced.problem, reduced.base
    now = root_mean_huber(base.residual)
    found = []
    for name in added:
        family = public_name(name)
        # Quantisation is found from the measured values, not from the misfit.
        if family == "sensor_quantisation" or not any(
            public_name(e.name) == family and e.friction_state is None for e in base.fitted.model.effects
        ):
            continue
        own = [u for u in base.fitted.model.unknowns if public_name(u.key.rpartition(".")[0]) == family]
        if own and all(u.prior is not None for u in own):
            # The effect was detected outside these residuals, as a mode above the filter band is.
            continue
        below = reduced.fit(family)
        without = root_mean_huber(below.residual)
        if without <= NEEDLESS * now:
            found.append(Swap(name, None, _worst(problem, base), _worst(problem, below)))
            continue
        if not others_too:
            continue
        first = reduced.screening(family)
        best, least = None, CLEARLY * max(now**2 - 1.0, 0.0)
        others = [fit for fit in first.fits if public_name(fit.effect.name) != family]
        for screening_fit in others[:TRIED]:
            candidate = refit_candidate(below.fitted, screening_fit, problem.fit_records, problem.scales)
            trial = evaluate_candidate(problem, below, candidate)
            if trial is not None and trial.error**2 - 1.0 < least:
                best, least = trial, trial.error**2 - 1.0
        if best is not None:
            after = misfit(best.fitted.model, problem.validate_records)
            found.append(Swap(name, best.public_name, _worst(problem, base), max(m.over_noise for m in after.values())))
    return found


def _worst(problem: Problem, base: ReferenceFit) -> float:
    over = [m.over_noise for m in misfit(base.fitted.model, problem.validate_records).values()]
    return max(over, default=float(np.nan))
