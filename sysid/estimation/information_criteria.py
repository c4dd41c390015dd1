"""Information criteria of a fitted model: what a further parameter must gain.

    AIC = n ln(S/n) + 2 k,    BIC = n ln(S/n) + k ln n,    S = sum of squared residuals in deviations of the noise

with n scored samples and k fitted parameters, the residual variance being one of them: least squares with normal errors
of unknown variance (Burnham and Anderson, Model Selection and Multimodel Inference (2002), eq. 2.2 and 6.5; additive
constants left out). Values compare models on the same samples with the same weights. All samples count as independent,
and a few large residuals at reversals count in full: where the residual is not white noise, use the held-out error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sysid.estimation.fit import FittedModel


@dataclass(frozen=True)
class InformationCriteria:
    """Criteria of a fitted model; the smaller, the better.

    Args:
        aic: of Akaike.
        bic: of Schwarz.
        samples: n, scored samples of the records of the fit.
        parameters: k, with the residual variance.
    """

    aic: float
    bic: float
    samples: int
    parameters: int

    def to_json(self) -> dict[str, Any]:
        """The criteria as JSON data."""
        return {"aic": self.aic, "bic": self.bic, "samples": self.samples, "parameters": self.parameters}


def information_criteria(fitted: FittedModel) -> InformationCriteria:
    """Criteria of a model on the records of its fit."""
    residual, k = fitted.fit.residual, len(fitted.fit.keys) + 1
    return criteria_of(residual, k)


def criteria_of(residual: np.ndarray, parameters: int) -> InformationCriteria:
    """Criteria of a weighted residual (n,) with a number of parameters, the variance included."""
    n = residual.size
    squares = float(residual @ residual)
    deviance = n * float(np.log(max(squares, np.finfo(float).tiny) / n)) if n else float("nan")
    penalty = float(np.log(n)) if n else float("nan")
    return InformationCriteria(deviance + 2.0 * parameters, deviance + penalty * parameters, n, parameters)
