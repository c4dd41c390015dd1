"""Forward regression: add the group of columns that lowers the held-out error most, by two per cent at least."""

import numpy as np

from .features import Problem
from .regression import held_out_error

WORTHWHILE = 0.02


def name_missing(fit: Problem, held: Problem, most: int = 2) -> list[str]:
    """Effects in the order in which they were added; none when nothing helps."""
    a, b = fit.base, held.base
    error = held_out_error(a, fit.target, b, held.target)
    chosen: list[str] = []
    while len(chosen) < most:
        trials = {
            name: held_out_error(
                np.hstack([a, columns]), fit.target, np.hstack([b, held.candidates[name]]), held.target
            )
            for name, columns in fit.candidates.items()
            if name not in chosen and name in held.candidates
        }
        if not trials:
            break
        best = min(trials, key=lambda name: trials[name])
        if trials[best] > (1.0 - WORTHWHILE) * error:
            break
        a, b = np.hstack([a, fit.candidates[best]]), np.hstack([b, held.candidates[best]])
        error = trials[best]
        chosen.append(best)
    return chosen
