"""Numeric limits and lists of effects of the decision rules in `sysid/diagnosis/verdict.py`.

The limits were chosen on generated records; docs/theory.md lists them with their values.
"""

from __future__ import annotations

NEARLY_NOISE = 1.5
"""Error over noise with an effect up to which no second effect is searched."""

CLEARLY_ABOVE = 2.7
"""Error over noise of a force balance from which `NOISE_ALONE` applies; below it, evaluating a law at a smoothed
velocity may cause an error of that size."""

MUCH_OF_IT = 0.2
"""Share of the loss that errors of event times do not explain: at most 0.05 where no effect is missing."""

MOST_OF_IT = 0.5
"""The same where the effect leaves more than noise, with twice the significance."""

NOISE_ALONE = 1.1
"""Ranking error, in deviations, up to which the residual with an effect is only noise."""

SPELLS = 1.5
"""Ranking error, in deviations, from which an autocorrelated residual is above the noise in stretches, though its
robust error is within the noise: at most 1.35, outliers included, where no effect is missing."""

NOTHING_ABOVE = 1.1
"""Error over noise of a force balance up to which, with a ranking error within the noise, a gain is due to noise."""

ADEQUATE_OVER_NOISE = {"output": 1.15, "force_balance": 1.35}
"""Robust error over noise up to which a model is adequate, by form: the uncertainty of the noise and, for a force
balance, the errors of the times of reversals."""

AT_REVERSALS = (
    "frictional_lag",
    "bristle_damping",
    "presliding",
    "backlash",
    "drive_lag",
    "drive_delay",
)
"""Effects that resemble a small error in the time of a reversal: not accepted while the error is near the noise."""

LATE = {"drive_lag", "drive_delay", "sensor_lag", "sensor_delay"}
"""Effects that delay the logged motion against the logged drive."""

AT_STARTS = ("dwell_strengthening", "flexible_mode")
"""Effects that resemble an error in the time of a break-away, while the error is at the noise."""

AT_REST = 0.5
"""Part of a gain from displacements in stick phases from which errors in the times of reversals do not explain it."""

UNDERRATED = 5.0
"""Error over noise up to which a residual without dependence on a coordinate is underestimated noise."""

LEAST_PERSISTENCE = 0.25
"""Least autocorrelation of the residual at four scored samples, less that of the noise, of a systematic residual."""

LEAST_TEXTURE = 0.08
"""Least cross-validated share explained by the position of a systematic residual; noise has 0.03."""

LEAST_PATTERN = 0.15
"""Least share of the residual's variance explained by a coordinate of a systematic residual."""

MORE_IS_MISSING = 1.5
"""Ranking error, in deviations, from which two effects with gains equal to 1 % are indistinguishable."""

SHARE_ENOUGH = 0.80
"""Share of the ranking loss above the noise from which one effect is sufficient: a true effect with another law reaches
0.85 and more, a partially confounded false one at most 0.65 (generated records)."""

VARIANCE_ENOUGH = 0.93
"""The same for the robust variance, which leaves out outliers: 0.95 and more, against 0.86."""

SHARE_AWAY = 0.85
LEAST_AWAY = 0.15
CLEARLY_AWAY = 2.0
"""Share of the loss away from the reversals of a driven mass from which one effect is sufficient: true ones 0.95 and
more, false ones at most 0.65 (generated records). It applies where the part of the samples away from reversals is at
least `LEAST_AWAY`, and their mean loss at least `CLEARLY_AWAY`, in noise deviations squared."""

BENT = {"position": 0.2, "time": 0.4}
"""Share of the residual with an effect of position or time, explained by that coordinate, from which the true law is a
different one. Over the position the true law leaves at most 0.1, a nonlinear spring 0.45 and more, a texture of several
pitches nearly always 0.2 and more (generated records)."""

BENT_TOGETHER = 0.4
"""The same for the residual with two effects, over a coordinate of one of them."""

SHARE_OF_A_PART = 0.55
LEAST_PATTERN_LEFT = 0.3
"""An effect that removes the first share, and leaves a residual of which no coordinate explains the second, is missing
beside others. If a coordinate explains more, the effect is partially confounded with one that the library lacks."""

SHARE_WITH_THE_PATTERN = 0.25
"""The same for an effect whose residual depends on no coordinate, where it did before: the rest is underestimated noise
(quantisation, for example)."""

SHARE_OF_NOISE = 0.3
"""Share below which all effects must stay for a residual without dependence on a coordinate to be noise."""

SHARE_OF_TWO = 0.92
VARIANCE_OF_TWO = 0.97
"""Least shares removed by two effects together, of the loss and of the robust variance."""

NEARLY_ALL_OF_TWO = 0.95
"""Share from which two effects are accepted though their residual depends on the position: two effects in place of one
nonlinear spring removed at most 0.75, true ones with inexact laws 0.96 and more (generated records)."""

LEAST_SIGNIFICANCE = 4.0
LEAST_STEADINESS = 1.5
LEAST_GAIN = 0.03
"""Least z of the gain, or least t over blocks of time; and least share of the loss, on the records of the fit and on
the held-out ones."""

ALIKE = 0.2
"""Least relative gain on the records of the fit over that on the held-out records, for a gain that is only steady: an
effect with almost no gain where it was fitted corrects the other parameters, not the model."""

SURE_STEADINESS = 2.5
SURE_PART = 0.15
SURE_SIGNIFICANCE = 12.0
"""Steadiness, with `LEAST_SIGNIFICANCE`, and share of the loss, or a higher significance, from which a gain at
reversals is not due to errors of their times: without a missing effect, no candidate came near two of these limits."""

LEAST_OF_MOST = 2.0
"""Sufficient significance, in standard errors, of an effect that removes `MOST_OF_IT` of the loss of all records."""

LEANS = 0.5
"""Loss above the noise of a pair without the best effect, over that with it, below which the former is taken."""

HARDLY_MORE = 1.1
"""Ranking error over that of the best effect up to which another effect is tried as the first of a pair."""

RESTORING = {"cable_spring", "gravity_torque"}
"""Restoring forces that are smooth functions of the position. Two of them together fit any nonlinear spring, so they
are no evidence for either."""
