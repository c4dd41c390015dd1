"""Write the table of decision thresholds in theory.md from the constants: python docs/make_thresholds.py."""

from __future__ import annotations

import re
from pathlib import Path

from stagecad.parameters.atomic import atomic_write_text
from sysid.diagnosis import verdict_limits
from sysid.estimation import covariance, misfit, variant_selection

PAGE = Path(__file__).parent / "theory.md"
TABLE = re.compile(r"(<!-- thresholds: .*? -->\n).*?(<!-- end of thresholds -->)", re.DOTALL)
# In the order in which a verdict uses them.
CONSTANTS = (
    (misfit, "KEPT", "share of the samples in the robust error"),
    (misfit, "LOSS_CORNER", "corner of the Huber loss of the ranking, in deviations"),
    (verdict_limits, "LEAST_SIGNIFICANCE", "standard errors of the held-out gain from which it is significant"),
    (verdict_limits, "LEAST_STEADINESS", "or: mean gain per block of time over its standard error"),
    (verdict_limits, "ALIKE", "then: least relative gain on the records of the fit, over that on the held-out records"),
    (
        verdict_limits,
        "LEAST_GAIN",
        "least share of the loss removed, on the records of the fit and on the held-out ones",
    ),
    (verdict_limits, "ADEQUATE_OVER_NOISE", "error over noise up to which a model is adequate"),
    (verdict_limits, "NOTHING_ABOVE", "error over noise of a force balance up to which a gain is attributed to noise"),
    (
        verdict_limits,
        "NOISE_ALONE",
        "ranking error, in deviations, up to which the residual with an effect is only noise",
    ),
    (verdict_limits, "SPELLS", "ranking error from which a model with an autocorrelated residual is not adequate"),
    (verdict_limits, "CLEARLY_ABOVE", "error over noise of a force balance from which `NOISE_ALONE` applies"),
    (verdict_limits, "MUCH_OF_IT", "or: share of the loss that the effect removes"),
    (verdict_limits, "MOST_OF_IT", "the same where more than noise is left"),
    (verdict_limits, "SURE_PART", "or: share of the loss that it removes steadily"),
    (verdict_limits, "SURE_SIGNIFICANCE", "or: standard errors of its gain, where the gain is steady"),
    (verdict_limits, "SURE_STEADINESS", "least mean gain per block over its standard error of a steady gain"),
    (verdict_limits, "LEAST_PATTERN", "share that some coordinate must explain before a misfit is `unexplained`"),
    (verdict_limits, "LEAST_TEXTURE", "or: least share predicted from the position by cross-validation"),
    (verdict_limits, "SHARE_ENOUGH", "share of the loss above the noise from which one effect is sufficient"),
    (verdict_limits, "VARIANCE_ENOUGH", "or: share of the robust variance above the noise"),
    (verdict_limits, "SHARE_AWAY", "or: share of the loss away from the reversals of a driven mass"),
    (verdict_limits, "LEAST_AWAY", "least share of the samples away from reversals for that"),
    (verdict_limits, "CLEARLY_AWAY", "least mean squared loss there, in deviations squared"),
    (
        verdict_limits,
        "BENT",
        "share of the residual explained by the effect's own coordinate from which the true law is a different one",
    ),
    (verdict_limits, "BENT_TOGETHER", "the same for the residual with two effects"),
    (
        verdict_limits,
        "LEANS",
        "loss of a pair without the best effect, over that with it, below which the former is taken",
    ),
    (
        verdict_limits,
        "SHARE_OF_A_PART",
        "share from which an effect is missing beside others, if its residual depends little on coordinates",
    ),
    (verdict_limits, "LEAST_PATTERN_LEFT", "then: largest share of the residual explained by a coordinate"),
    (
        verdict_limits,
        "SHARE_WITH_THE_PATTERN",
        "the same as `SHARE_OF_A_PART` if the residual depends on no coordinate",
    ),
    (
        verdict_limits,
        "UNDERRATED",
        "error over noise up to which a residual without dependence on a coordinate is underestimated noise",
    ),
    (verdict_limits, "SHARE_OF_NOISE", "share that no effect may remove then"),
    (
        verdict_limits,
        "HARDLY_MORE",
        "ranking error over that of the best effect up to which another may be the first of a pair",
    ),
    (
        verdict_limits,
        "LEAST_OF_MOST",
        "standard errors sufficient for an effect that removes `MOST_OF_IT` of the loss of all records",
    ),
    (verdict_limits, "MORE_IS_MISSING", "ranking error from which effects with equal gains within 1 % are a tie"),
    (
        variant_selection,
        "BETTER_HELD_OUT",
        "ratio of held-out losses below which another variant of an effect is selected",
    ),
    (verdict_limits, "SHARE_OF_TWO", "the same as `SHARE_ENOUGH` for two effects together"),
    (verdict_limits, "VARIANCE_OF_TWO", "the same as `VARIANCE_ENOUGH` for two effects together"),
    (verdict_limits, "NEARLY_ALL_OF_TWO", "share of two effects from which their residual may depend on the position"),
    (verdict_limits, "AT_STARTS", "effects that resemble an error in the time of a break-away"),
    (verdict_limits, "AT_REVERSALS", "effects that resemble an error in the time of a reversal"),
    (covariance, "BLOCKS_PER_RECORD", "blocks of time per record for the covariance"),
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
