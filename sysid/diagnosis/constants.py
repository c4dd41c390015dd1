"""Constants of the decision of a diagnosis. docs/theory.md lists them (docs/make_thresholds.py).

Losses are mean Huber squares of the held-out residual in standard deviations of the noise: 1 for noise alone. The
excess is the loss above that of a complete model; the share of a model is the part of the excess that it removes.
"""

from __future__ import annotations

LEAST_SIGNIFICANCE = 4.0
"""Least gain over its standard error, if the residual of the better model is noise; blocks of time count once."""

LEAST_STEADINESS = 1.0
"""Least gain over its standard error from the scatter of the blocks: it does not come from one short stretch."""

LEAST_GAIN = 0.03
"""Least gain, over the loss of the model without the effect."""

SUFFICIENT_SHARE = 0.5
"""Share of the excess from which a model is a sufficient explanation: it explains more than it leaves."""

CLEAR_MARGIN = 0.07
"""Share of the excess by which a free curve, or a second effect, must exceed a single named effect."""

CURVE_STEADINESS = 2.0
"""Steadiness of that margin for a free curve, since it is the best of several."""

NOTABLE_SHARE = 0.2
"""Part of the loss; a model is not adequate if a free curve explains more."""

FORM_ERROR = 0.04
"""Relative error of the form of a law: each further effect must gain more than its square, and where a model is judged
adequate, it is part of the variance of the residual. Published laws of one effect, fitted to each other, have errors of
about this size (median and quartiles: benchmarks/form_errors.py)."""

NOISE_FACTOR = 2.0
"""Factor by which the level of the noise may be too low or too high, where no model gains."""

EQUIVALENT_GAIN = 0.03
EQUIVALENT_SIGNIFICANCE = 2.5
"""Largest difference of the gains of indistinguishable effects, over the gain, and over its standard error."""

NEAR_NOISE_LOSS = 1.1
"""Loss of the stated model up to which a gain has to be twice as significant and twice as steady."""
