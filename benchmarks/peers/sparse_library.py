"""pysindy's thresholded least squares over the same library; the threshold chosen on the held-out record."""

from __future__ import annotations

import warnings

import numpy as np

from .features import Problem


def available() -> bool:
    """Whether pysindy can be imported."""
    try:
        import pysindy  # noqa: F401  # pyright: ignore[reportMissingImports]
    except ImportError:
        return False
    return True


def name_missing(fit: Problem, held: Problem) -> list[str]:
    """Effects kept by the regression, largest contribution first; the base columns are in the library too."""
    import pysindy as ps  # pyright: ignore[reportMissingImports]

    names = [name for name in fit.candidates if name in held.candidates]
    groups = [fit.base] + [fit.candidates[name] for name in names]
    a = np.hstack(groups)
    b = np.hstack([held.base] + [held.candidates[name] for name in names])
    owner = np.repeat(np.arange(len(groups)), [group.shape[1] for group in groups])
    scale = np.sqrt(np.mean(a**2, axis=0))
    scale[scale == 0.0] = 1.0
    level = float(np.sqrt(np.mean(fit.target**2)))
    best: tuple[float, np.ndarray] | None = None
    for threshold in (0.003, 0.01, 0.03, 0.1):
        optimizer = ps.STLSQ(threshold=threshold, alpha=1e-6, max_iter=20)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            optimizer.fit(a / scale, (fit.target / level)[:, None])
        c = optimizer.coef_.ravel()
        error = float(np.sqrt(np.mean((held.target / level - b / scale @ c) ** 2)))
        if best is None or error < 0.98 * best[0]:
            best = error, c
    assert best is not None
    size = {
        name: float(np.sqrt(np.mean((a[:, owner == i + 1] / scale[owner == i + 1] @ best[1][owner == i + 1]) ** 2)))
        for i, name in enumerate(names)
    }
    return [name for name in sorted(size, key=lambda name: -size[name]) if size[name] > 0.0]
