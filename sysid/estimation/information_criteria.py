"""Information criteria of a fitted model: what a further parameter must gain.

    AIC = m ln(S/n) + 2 k,    BIC = m ln(S/n) + k ln m,    S = sum of squared residuals in deviations of the noise

with n scored samples, of which m = n (1 - r)/(1 + r) are effective at the autocorrelation r of neighbouring residuals
(Bayley and Hammersley, J. R. Stat. Soc. Suppl. 8 (1946) 184), and k fitted parameters, the residual variance being one
of them: least squares with normal errors of unknown variance (Burnham and Anderson, Model Selection and Multimodel
Inference (2002), eq. 2.2 and 6.5; additive constants left out). Values compare models on the same samples with the same
weights. A few large residuals at reversals count in full: there, use the held-out error.
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
    products, squares, start = 0.0, 0.0, 0
    for samples in fitted.weights.samples:
        for pick in samples.values():
            part = residual[start : start + pick.size]
            start += pick.size
            products, squares = products + float(part[1:] @ part[:-1]), squares + float(part @ part)
    return criteria_of(residual, k, products / squares if squares > 0.0 else 0.0)


def criteria_of(residual: np.ndarray, parameters: int, correlation: float = 0.0) -> InformationCriteria:
    """Criteria of a weighted residual (n,) with a number of parameters, the variance included, and the autocorrelation
    of neighbouring samples."""
    n = residual.size
    if n == 0:
        return InformationCriteria(float("nan"), float("nan"), 0, parameters)
    r = min(max(correlation, 0.0), 1.0 - 2.0 / (n + 1.0))
    effective = n * (1.0 - r) / (1.0 + r)
    deviance = effective * float(np.log(max(float(residual @ residual), np.finfo(float).tiny) / n))
    penalty = float(np.log(max(effective, 1.0)))
    return InformationCriteria(deviance + 2.0 * parameters, deviance + penalty * parameters, n, parameters)
