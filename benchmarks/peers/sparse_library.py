"""pysindy's thresholded least squares over the same library; threshold and verdict from the held-out record.

The columns of the model as it stands are taken out of target and library first, since they are known to be there. The
sparsest model that comes within two per cent of the best held-out error is kept, and its effects are ordered by how
much the error rises when each is left out.
"""

import importlib.util
import warnings

import numpy as np

from .features import Problem
from .forward_regression import WORTHWHILE
from .regression import coefficients, held_out_error

THRESHOLDS = (0.003, 0.01, 0.03, 0.1, 0.2, 0.4)
RIDGE = 1e-4


def available() -> bool:
    """Whether pysindy can be imported."""
    return importlib.util.find_spec("pysindy") is not None


def name_missing(fit: Problem, held: Problem) -> list[str]:
    """Effects that the sparse model keeps, the weightiest first; none when the model as it stands is best."""
    names = [name for name in fit.candidates if name in held.candidates]
    rest = fit.target - fit.base @ coefficients(fit.base, fit.target)
    library, owner = [], []
    for name in names:
        columns = fit.candidates[name]
        for k in range(columns.shape[1]):
            free = columns[:, k] - fit.base @ coefficients(fit.base, columns[:, k])
            size = float(np.sqrt(np.mean(free**2)))
            if size > 1e-9 * float(np.sqrt(np.mean(columns[:, k] ** 2))):
                library.append(free / size)
                owner.append((name, k))
    kept = _sparse_models(np.column_stack(library), rest / float(np.sqrt(np.mean(rest**2))))
    scored = [(_error(fit, held, [owner[i] for i in model]), model) for model in kept]
    least = min(error for error, _ in scored)
    error, model = min(((e, m) for e, m in scored if e <= (1.0 + WORTHWHILE) * least), key=lambda row: len(row[1]))
    terms = [owner[i] for i in model]
    without = {
        name: _error(fit, held, [term for term in terms if term[0] != name])
        for name in dict.fromkeys(n for n, _ in terms)
    }
    return [name for name in sorted(without, key=lambda name: -without[name]) if without[name] > error]


def _sparse_models(library: np.ndarray, rest: np.ndarray) -> list[list[int]]:
    """Columns that pysindy keeps at each threshold, and none of them."""
    import pysindy

    kept: list[list[int]] = [[]]
    for threshold in THRESHOLDS:
        optimizer = pysindy.STLSQ(threshold=threshold, alpha=RIDGE * rest.size, max_iter=20)
        with warnings.catch_warnings():
            # It warns where a threshold leaves nothing: the empty model is among those compared.
            warnings.simplefilter("ignore")
            optimizer.fit(library, rest[:, None])
        kept.append([int(i) for i in np.flatnonzero(optimizer.coef_.ravel())])
    return kept


def _error(fit: Problem, held: Problem, terms: list[tuple[str, int]]) -> float:
    a = np.column_stack([fit.base, *(fit.candidates[name][:, k] for name, k in terms)])
    b = np.column_stack([held.base, *(held.candidates[name][:, k] for name, k in terms)])
    return held_out_error(a, fit.target, b, held.target)
