"""Forward regression: add the group of columns that lowers the held-out error most, by two per cent at least."""

from __future__ import annotations

import numpy as np

from .features import Problem

WORTHWHILE = 0.02


def _held_out(fit: np.ndarray, y: np.ndarray, held: np.ndarray, target: np.ndarray) -> float:
    scale = np.sqrt(np.mean(fit**2, axis=0))
    scale[scale == 0.0] = 1.0
    c, *_ = np.linalg.lstsq(fit / scale, y, rcond=1e-10)
    return float(np.sqrt(np.mean((target - held / scale @ c) ** 2)))


def name_missing(fit: Problem, held: Problem, most: int = 2) -> list[str]:
    """Effects in the order in which they were added; none when nothing helps."""
    a, b = fit.base, held.base
    error = _held_out(a, fit.target, b, held.target) if a.shape[1] else float(np.sqrt(np.mean(held.target**2)))
    chosen: list[str] = []
    while len(chosen) < most:
        trials = {}
        for name, columns in fit.candidates.items():
            if name not in chosen and name in held.candidates:
                trial = np.hstack([a, columns]), np.hstack([b, held.candidates[name]])
                trials[name] = _held_out(trial[0], fit.target, trial[1], held.target)
        if not trials:
            break
        best = min(trials, key=lambda name: trials[name])
        if trials[best] > (1.0 - WORTHWHILE) * error:
            break
        a, b = np.hstack([a, fit.candidates[best]]), np.hstack([b, held.candidates[best]])
        error = trials[best]
        chosen.append(best)
    return chosen
