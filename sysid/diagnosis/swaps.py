"""Early mistakes: effects added before that another explains better, or that nothing needs any more."""

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
"""Effects refitted in the place of an old one: those that looked best."""

CLEARLY = 0.8
"""Part of the loss above the noise that another effect must stay below to take an old one's place."""

NEEDLESS = 1.01
"""Held-out error without an effect, over that with it, up to which the effect is not needed."""


@dataclass(frozen=True)
class Swap:
    """An effect of the model that should go.

    Args:
        old: its name.
        new: the effect to put in its place; none where the model does as well without.
        before, after: error over noise on the held-out records, as it is and with the swap.
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
        others_too: look for replacements, not only for effects that are not needed.
    """
    problem, base = reduced.problem, reduced.base
    now = root_mean_huber(base.residual)
    found = []
    for name in added:
        family = public_name(name)
        # Steps are read off the values themselves, not off a misfit that a model without them could be spared.
        if family == "sensor_quantisation" or not any(
            public_name(e.name) == family and e.friction_state is None for e in base.fitted.model.effects
        ):
            continue
        own = [u for u in base.fitted.model.unknowns if public_name(u.key.rpartition(".")[0]) == family]
        if own and all(u.prior is not None for u in own):
            # Something else than these residuals told of it, as a mode's ringing does above what they show.
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
        for look in [look for look in first.fits if public_name(look.effect.name) != family][:TRIED]:
            candidate = refit_candidate(below.fitted, look, problem.fit_records, problem.scales)
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
