"""Figures of a design: margins of its checks, and sheets."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from designcalc.checks.check import Check
from stagecad.parameters.errors import InputError
from workbench.figures.plot import AFTER, BEFORE, WIDTH, Plot, new_plot, style

if TYPE_CHECKING:
    import pandas as pd

    from designcalc.optimisation.evaluation import Evaluator

MOST_BARS = 40
"""Checks of a figure, worst first."""


def margins_figure(checks: Sequence[Check]) -> Plot:
    """Margin of each check, in percent of its limit, worst first; linear within +-100 %, logarithmic beyond.

    Raises:
        InputError: no check with a margin.
    """
    drawn = sorted((c for c in checks if c.margin is not None), key=lambda c: c.margin or 0.0)[:MOST_BARS]
    if not drawn:
        raise InputError("plot: no check has a margin to draw")
    margins = 100.0 * np.array([check.margin for check in drawn])
    figure, axes = new_plot(width=WIDTH, height=0.6 + 0.16 * len(drawn))
    panel = axes[0, 0]
    with style():
        panel.barh(range(len(drawn)), margins, color=[AFTER if m >= 0 else BEFORE for m in margins], height=0.66)
        panel.set_yticks(range(len(drawn)), [check.name for check in drawn])
        panel.invert_yaxis()
        panel.axvline(0.0, color="#5d6d7e", linewidth=0.8)
        if np.max(np.abs(margins)) > 100.0:
            panel.set_xscale("symlog", linthresh=100.0)
            panel.xaxis.set_major_formatter("{x:g}")
        panel.grid(axis="y", visible=False)
        panel.set_xlabel("margin (% of the limit)")
    return figure


def changed_margins_figure(margins: pd.DataFrame) -> Plot:
    """Margins before and after, in percent of the limit; linear within +-100 %, logarithmic beyond.

    Args:
        margins: columns `margin_before` and `margin_after`, index of checks; the first ones are drawn.

    Raises:
        InputError: no margin differs.
    """
    drawn = margins.dropna(subset=["margin_before", "margin_after"])[:MOST_BARS]
    if drawn.empty:
        raise InputError("plot: no margin differs")
    before, after = (100.0 * np.asarray(drawn[name], float) for name in ("margin_before", "margin_after"))
    figure, axes = new_plot(width=WIDTH, height=0.8 + 0.16 * len(drawn))
    panel, places = axes[0, 0], np.arange(len(drawn))
    with style():
        panel.hlines(places, before, after, color="#5d6d7e", linewidth=0.8)
        panel.plot(before, places, "o", color=BEFORE, markersize=3.5, label="before")
        panel.plot(after, places, "o", color=AFTER, markersize=3.5, label="after")
        panel.set_yticks(places, list(drawn.index))
        panel.invert_yaxis()
        panel.axvline(0.0, color="#5d6d7e", linewidth=0.8)
        if max(np.max(np.abs(before)), np.max(np.abs(after))) > 100.0:
            panel.set_xscale("symlog", linthresh=100.0)
            panel.xaxis.set_major_formatter("{x:g}")
        panel.grid(axis="y", visible=False)
        panel.set_xlabel("margin (% of the limit)")
        panel.legend()
    return figure


def pareto_plot(evaluator: Evaluator, names: Sequence[str]) -> Plot:
    """Margins of two requirements in all evaluated designs that violate no rule, and their Pareto front."""
    from workbench.report.design_figures import draw_pareto

    figure, axes = new_plot(width=WIDTH, height=0.7 * WIDTH)
    with style():
        draw_pareto(axes[0, 0], evaluator, names)
    return figure


def sheet_figure(file: Path) -> Plot:
    """A picture file on a page."""
    from matplotlib.image import imread

    picture = imread(file)
    height, width = picture.shape[:2]
    figure, axes = new_plot(width=WIDTH, height=WIDTH * height / width)
    with style():
        axes[0, 0].imshow(picture)
        axes[0, 0].set_axis_off()
    return figure
