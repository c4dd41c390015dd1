"""Numeric limits and lists of effects of the decision rules in `sysid/diagnosis/verdict.py`.

The limits were chosen on generated records; docs/theory.md lists them with their values.
"""

from __future__ import annotations

NEARLY_NOISE = 1.5
"""Error over noise that an effect may leave without anything else being looked for beside it."""

CLEARLY_ABOVE = 2.7
"""Error over noise of a force balance above which that is believed: below, a law that sees a smoothed velocity may be
off by as much."""

MUCH_OF_IT = 0.2
"""Part of the mean squared loss that no accident of timing takes: with nothing hidden 0.05 at the most."""

MOST_OF_IT = 0.5
"""The same where the effect leaves more than noise, with twice the significance."""

NOISE_ALONE = 1.1
"""Ranking error, in deviations, from which an effect has left nothing but noise: no accident of timing does that."""

SPELLS = 1.5
"""Ranking error, in deviations, from which a residual that persists lies above the noise in stretches, though its
robust error is within the noise: with nothing hidden 1.35 at the most, outliers included."""

NOTHING_ABOVE = 1.1
"""Error over noise of a force balance up to which, with a ranking error within the noise too, a gain is of noise."""

ADEQUATE_OVER_NOISE = {"output": 1.15, "force_balance": 1.35}
"""Robust error over noise up to which a model is adequate, by form: the noise itself is known to no better, and a force
balance has besides the errors of when exactly the axis turned."""

AT_REVERSALS = (
    "frictional_lag",
    "bristle_damping",
    "presliding",
    "backlash",
    "drive_lag",
    "drive_delay",
)
"""Effects that a small error in the time of a reversal looks like: not believed while the error is near the noise."""

LATE = {"drive_lag", "drive_delay", "sensor_lag", "sensor_delay"}
"""Effects that make a logged motion late against the logged drive."""

AT_STARTS = ("dwell_strengthening", "flexible_mode")
"""The same of the time at which motion starts, while the error is at the noise."""

AT_REST = 0.5
"""Part of a gain that comes from displacements at rest from which no error in the time of a turn looks like it."""

UNDERRATED = 5.0
"""Error over noise up to which a residual without any pattern is noise that was thought smaller than it is."""

LEAST_PERSISTENCE = 0.25
"""Correlation of the residual with itself four scored samples on, above the noise's own, that counts as a pattern."""

LEAST_TEXTURE = 0.08
"""Share that the position must foretell of blocks of time it has not seen, to count as a pattern: noise has 0.03."""

LEAST_PATTERN = 0.15
"""Share of the residual's variance that some coordinate must explain before it counts as a pattern."""

MORE_IS_MISSING = 1.5
"""Ranking error, in deviations, beside which two effects that gain the same to a hundredth are not told apart."""

SHARE_ENOUGH = 0.80
"""Share of the ranking loss above the noise from which one effect is the explanation: with another law for the same
effect a true one reaches 0.85 and more, a false one that leans on it 0.65 at the most (generated records)."""

VARIANCE_ENOUGH = 0.93
"""The same in the robust variance, which a few rough samples do not weigh down: 0.95 and more, against 0.86."""

SHARE_AWAY = 0.85
LEAST_AWAY = 0.15
CLEARLY_AWAY = 2.0
"""Share of the loss away from a driven mass's turns from which one effect is the explanation, whatever is left at the
turns: true ones 0.95 and more, false ones 0.65 at the most (generated records). It counts where so large a part of the
samples is away from turns, and their mean squared loss is at least so large, in noise deviations squared."""

BENT = {"position": 0.2, "time": 0.4}
"""Share of what an effect of the position or of time leaves from which that coordinate tells that the law is another.
Over the position the true law leaves 0.1 at the most, a spring that is not straight 0.45 and more, a texture of several
pitches 0.2 and more, nearly always (generated records)."""

BENT_TOGETHER = 0.4
"""The same of what two effects leave, over a coordinate of one of them."""

SHARE_OF_A_PART = 0.55
LEAST_PATTERN_LEFT = 0.3
"""An effect that takes this share, and leaves a residual of which no coordinate explains so much, is missing beside
others; where a coordinate still explains much of what is left, the effect only leans on one that no library has."""

SHARE_WITH_THE_PATTERN = 0.25
"""The same for an effect that leaves no pattern at all, where there was one: the rest is noise, though more of it than
was thought (the steps of a coarse sensor, say)."""

SHARE_OF_NOISE = 0.3
"""Share that an effect must stay below where what is left, without any pattern, is to be noise."""

SHARE_OF_TWO = 0.92
VARIANCE_OF_TWO = 0.97
"""Shares that two effects must take together, where one alone leaves much."""

NEARLY_ALL_OF_TWO = 0.95
"""Share from which two effects are two, though what little they leave follows the position: two that stand for one
curved pull took 0.75 at the most, true ones whose laws are not quite nature's 0.96 and more (generated records)."""

LEAST_SIGNIFICANCE = 4.0
LEAST_STEADINESS = 1.5
LEAST_GAIN = 0.03
"""Of the mean squared loss, on the records of the fit and on the held-out ones."""

ALIKE = 0.2
"""Part of what an effect takes of the held-out records' loss that it must take of that of the fit's, where it is steady
and no more: what takes next to nothing where it was fitted corrects the other parameters, not the model."""

SURE_STEADINESS = 2.5
SURE_PART = 0.15
SURE_SIGNIFICANCE = 12.0
"""Steadiness, with `LEAST_SIGNIFICANCE`, and part of the loss, or a higher significance, from which a gain at turns is
none of their timing: where nothing was hidden no effect came near two of them."""

LEAST_OF_MOST = 2.0
"""Significance, in standard errors, that is enough for an effect that takes `MOST_OF_IT` of all records' losses."""

LEANS = 0.5
"""Part of the loss above the noise, left beside the best effect, that another pair must fall below to unseat it."""

HARDLY_MORE = 1.1
"""Ranking error over the best effect's up to which another effect too is tried with a second one on top."""

RESTORING = {"cable_spring", "gravity_torque"}
"""Forces that pull the axis back along one smooth curve of its position. Two of them together bend as a spring that is
not straight does: they explain no more than that there is such a curve."""
