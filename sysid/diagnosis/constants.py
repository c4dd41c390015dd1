"""Constants of the ledger of a diagnosis. docs/theory.md lists them (docs/make_thresholds.py).

Losses are mean Huber squares of the held-out residual in standard deviations of the noise: 1 for noise alone. The
excess is the loss above that of a complete model; the share of a model is the part of the excess that it removes.
"""

MOST_EFFECTS = 8
"""Largest number of effects of a set."""

STEP_Z = 2.5
"""Least significance of a step of the selection of effects, or of a free curve."""

STEP_GAIN = 0.01
"""Least gain of a step, over the loss before it."""

CERTAIN_Z = 4.06
"""Least significance of an effect on all records: probability 1e-3 that one of 40 candidates has it by chance."""

EACH_Z = 2.33
"""Least significance on the records of the fit and on the held-out ones, each: probability 1 %."""

LEAST_OWN_SHARE = 0.25
"""Least part of what is left without an effect that it removes: otherwise more than three times its gain is left, and
what is left may be mimicked by it."""

MOST_AMPLITUDE = 2.0
"""Largest factor between the amplitude of an effect on the held-out records and the fitted one."""

MOST_FORM_ERROR = 0.1
"""Largest gain of a free curve of an effect's own coordinates on top of it, over its own gain: less than a straight
line leaves of a cubic law in sinusoidal motion (1 - (3/8)^2/(1/2 5/16) = 0.1, over 0.9)."""

FORM_ERROR = 0.08
"""Relative error of the form of a law: twice the median error of published laws of one effect, fitted to each other
(benchmarks/form_errors.py). An effect must gain more than this error of the other effects can leave."""

NEAR_NOISE_LOSS = 1.25
"""Loss without an effect, over that of the noise, up to which it is not established, and the search ends: the error
beside the noise is at most half of it (1 + 0.5^2), as small as that of the level of an estimated noise."""
KNOWN_NOISE_LOSS = 1.1
"""The same where the level of the noise is known."""

WELL_EXPLAINED = 0.75
"""Part of the excess that a set removes up to which half of its effects has to be significant, too: more than a quarter
is unknown, and may be mimicked."""

PLACES = 8
"""Parts of the travel in which the power of a periodic effect with its copies is compared."""

LOCAL_POWER = 0.25
"""Median of these powers over their mean below which the waves describe a force at one place: the power of two waves
that beat varies as cos^2, whose median is half of its mean."""

CURVE_MARGIN = 0.07
"""Part of the excess by which a free curve must exceed a set of effects to refute it."""

MOST_DAMPING = 0.3
"""Damping ratio from which a fitted mode is a filter of the signal."""

LEAST_GAIN = 0.03
"""Least gain of a mode detected above the filter band, and of an effect that counts as detectable, over the loss."""

NOTABLE_SHARE = 0.2
"""Part of the loss; a model is not adequate if a free curve of a recurring coordinate explains more."""

NOISE_FACTOR = 2.0
"""Factor by which the level of the noise may be too low or too high, where no model gains."""

EVEN_SHARE = 0.5
"""Least evenness of an error above that factor that may be noise of a wrong level."""
