"""Put the values of the constants that decide into theory.md: python docs/make_thresholds.py."""

from __future__ import annotations

import re
from pathlib import Path

from stagecad.parameters.atomic import atomic_write_text
from sysid.diagnosis import verdict_limits
from sysid.estimation import covariance, misfit, variant_selection

PAGE = Path(__file__).parent / "theory.md"
TABLE = re.compile(r"(<!-- thresholds: .*? -->\n).*?(<!-- end of thresholds -->)", re.DOTALL)
# In the order in which a verdict meets them.
CONSTANTS = (
    (misfit, "KEPT", "part of the samples in the robust error"),
    (misfit, "LOSS_CORNER", "deviations from which the ranking's loss is linear"),
    (verdict_limits, "LEAST_SIGNIFICANCE", "standard errors of the held-out gain from which it is more than chance"),
    (verdict_limits, "LEAST_STEADINESS", "or: mean gain of a block of time over its standard error"),
    (verdict_limits, "ALIKE", "there, part of its held-out gain that an effect must take of the fit's loss too"),
    (verdict_limits, "LEAST_GAIN", "part of the loss that must go, on the records of the fit and on the held-out ones"),
    (verdict_limits, "ADEQUATE_OVER_NOISE", "error over noise up to which a model is adequate"),
    (verdict_limits, "NOTHING_ABOVE", "error over noise of a force balance up to which a gain is of noise"),
    (verdict_limits, "NOISE_ALONE", "ranking error, in deviations, from which an effect leaves nothing but noise"),
    (verdict_limits, "SPELLS", "ranking error of a residual that persists from which a model is not adequate"),
    (verdict_limits, "CLEARLY_ABOVE", "error over noise of a force balance from which that is believed"),
    (verdict_limits, "MUCH_OF_IT", "or: part of the loss that the effect takes"),
    (verdict_limits, "MOST_OF_IT", "the same where more than noise is left"),
    (verdict_limits, "SURE_PART", "or: part of the loss that it takes steadily"),
    (verdict_limits, "SURE_SIGNIFICANCE", "or: standard errors of its gain, where it is steady"),
    (verdict_limits, "SURE_STEADINESS", "that is, with such a mean gain of a block over its standard error"),
    (verdict_limits, "LEAST_PATTERN", "share that some coordinate must explain before a misfit is `unexplained`"),
    (verdict_limits, "LEAST_TEXTURE", "or: share that the position must foretell"),
    (verdict_limits, "SHARE_ENOUGH", "share of the loss above the noise from which one effect is the explanation"),
    (verdict_limits, "VARIANCE_ENOUGH", "or: share of the robust variance above the noise"),
    (verdict_limits, "SHARE_AWAY", "or: share of the loss away from the turns of a driven mass"),
    (verdict_limits, "LEAST_AWAY", "part of the samples that must be away from turns for that"),
    (verdict_limits, "CLEARLY_AWAY", "mean squared loss there, in deviations squared, that it takes"),
    (verdict_limits, "BENT", "share of what is left, over the effect's own coordinate, that tells of another law"),
    (verdict_limits, "BENT_TOGETHER", "the same of what two effects leave"),
    (verdict_limits, "LEANS", "part of the loss left beside the best effect below which a pair without it is taken"),
    (
        verdict_limits,
        "SHARE_OF_A_PART",
        "share from which an effect is missing beside others, if it leaves little pattern",
    ),
    (verdict_limits, "LEAST_PATTERN_LEFT", "that little: share of what is left that some coordinate explains"),
    (verdict_limits, "SHARE_WITH_THE_PATTERN", "the same for an effect that leaves no pattern at all"),
    (verdict_limits, "UNDERRATED", "error over noise up to which what follows nothing is noise thought too small"),
    (verdict_limits, "SHARE_OF_NOISE", "share that no effect may take then"),
    (verdict_limits, "HARDLY_MORE", "ranking error over the best's up to which another may be the first of two"),
    (
        verdict_limits,
        "LEAST_OF_MOST",
        "standard errors that are enough for an effect that takes `MOST_OF_IT` of all",
    ),
    (verdict_limits, "MORE_IS_MISSING", "ranking error beside which effects that gain the same to 1 % are a tie"),
    (variant_selection, "BETTER_HELD_OUT", "part of the held-out loss below which another law of an effect is added"),
    (verdict_limits, "SHARE_OF_TWO", "the first of these, for two effects together"),
    (verdict_limits, "VARIANCE_OF_TWO", "the second, for two together"),
    (verdict_limits, "NEARLY_ALL_OF_TWO", "share of two from which what they leave may follow the position"),
    (verdict_limits, "AT_STARTS", "effects that an error in the time of a start looks like"),
    (verdict_limits, "AT_REVERSALS", "effects that an error in the time of a reversal looks like"),
    (covariance, "BLOCKS_PER_RECORD", "blocks of time per record behind an interval"),
)


def with_thresholds(text: str) -> str:
    """The page with the constants' values as they are now."""
    head = "| constant | value | what it is |\n| --- | --- | --- |\n"
    rows = [f"| `{name}` | {_shown(getattr(module, name))} | {meaning} |\n" for module, name, meaning in CONSTANTS]
    return TABLE.sub(lambda found: found[1] + head + "".join(rows) + found[2], text)


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{item:g} (`{key}`)" for key, item in value.items())
    if isinstance(value, tuple):
        return ", ".join(f"`{item}`" for item in value)
    return f"{value:g}"


if __name__ == "__main__":
    atomic_write_text(PAGE, with_thresholds(PAGE.read_text(encoding="utf-8")))
