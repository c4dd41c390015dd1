"""Figures of a design: margins of its checks, and sheets."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from designcalc.checks.check import Check
from designcalc.optimisation.requirement_levels import Levels
from stagecad.deferred import pd
from stagecad.parameters.errors import require
from workbench.figures.plot import AFTER, BEFORE, GREY, MODEL, WIDTH, Plot, new_plot, styled

MOST_BARS = 40
"""Checks of a figure, worst first."""


def _margin_axis(panel: Any, margins: np.ndarray) -> None:
    """Margins in percent to the right, linear within +-100 %, logarithmic beyond; checks from the top down."""
    panel.invert_yaxis()
    panel.axvline(0.0, color=GREY, linewidth=0.8)
    if np.max(np.abs(margins)) > 100.0:
        panel.set_xscale("symlog", linthresh=100.0)
        panel.xaxis.set_major_formatter("{x:g}")
    panel.grid(axis="y", visible=False)
    panel.set_xlabel("margin (% of the limit)")


@styled
def margins_figure(checks: Sequence[Check]) -> Plot:
    """Margin of each check, in percent of its limit, worst first; linear within +-100 %, logarithmic beyond."""
    drawn = sorted((c for c in checks if c.margin is not None), key=lambda c: c.margin or 0.0)[:MOST_BARS]
    require(drawn, "plot: no check has a margin to draw")
    margins = 100.0 * np.array([check.margin for check in drawn])
    figure, axes = new_plot(width=WIDTH, height=0.6 + 0.16 * len(drawn))
    panel = axes[0, 0]
    panel.barh(range(len(drawn)), margins, color=[AFTER if m >= 0 else BEFORE for m in margins], height=0.66)
    panel.set_yticks(range(len(drawn)), [check.name for check in drawn])
    _margin_axis(panel, margins)
    return figure


@styled
def changed_margins_figure(margins: pd.DataFrame) -> Plot:
    """Margins before and after, in percent of the limit; linear within +-100 %, logarithmic beyond."""
    drawn = margins.dropna(subset=["margin_before", "margin_after"])[:MOST_BARS]
    require(not drawn.empty, "plot: no margin differs")
    before, after = (100.0 * np.asarray(drawn[name], float) for name in ("margin_before", "margin_after"))
    figure, axes = new_plot(width=WIDTH, height=0.8 + 0.16 * len(drawn))
    panel, places = axes[0, 0], np.arange(len(drawn))
    panel.hlines(places, before, after, color=GREY, linewidth=0.8)
    panel.plot(before, places, "o", color=BEFORE, markersize=3.5, label="before")
    panel.plot(after, places, "o", color=AFTER, markersize=3.5, label="after")
    panel.set_yticks(places, list(drawn.index))
    _margin_axis(panel, np.stack([before, after]))
    panel.legend()
    return figure


@styled
def pareto_figure(names: Sequence[str], points: np.ndarray, front: np.ndarray) -> Plot:
    """Margins (n, 2) of two requirements, in parts of the limit, over all evaluated designs that violate no rule, and
    those of the Pareto front (m, 2)."""
    figure, axes = new_plot(width=WIDTH, height=0.7 * WIDTH)
    panel = axes[0, 0]
    panel.scatter(*(100 * points).T, s=8, color="0.6", label="designs")
    panel.plot(*(100 * front).T, marker="o", ms=4, color=BEFORE, drawstyle="steps-post", label="front")
    panel.axhline(0, color="0.3", lw=0.8)
    panel.axvline(0, color="0.3", lw=0.8)
    panel.set_xscale("symlog", linthresh=10)
    panel.set_yscale("symlog", linthresh=10)
    panel.set(xlabel=f"margin of '{names[0]}', %", ylabel=f"margin of '{names[1]}', %")
    panel.legend()
    return figure


_LEVEL_UNITS = {"m": (1e9, "nm"), "m/s": (1e3, "mm/s"), "m/s^2": (1.0, "m/s²")}
"""Scale and unit of an axis by the unit of a level."""


@styled
def levels_figure(levels: Levels) -> Plot:
    """Pareto fronts of the levels of two requirements each, with the values of Table 1."""
    from matplotlib.ticker import LogLocator, NullFormatter

    count = max(len(levels.fronts), 1)
    figure, axes = new_plot(1, count, width=3.6 * count, height=3.3)
    for panel, ((first, second), points) in zip(axes[0], levels.fronts.items(), strict=False):
        units = [_LEVEL_UNITS.get(levels.units[name], (1.0, "")) for name in (first, second)]
        scales, labels = zip(*units, strict=True)
        front = np.array(points) * scales
        required = np.array([levels.required[name] for name in (first, second)]) * scales
        panel.plot(*front.T, marker="o", ms=4, color=BEFORE, label="can be met together")
        panel.plot(*required[:, None], marker="*", ms=10, ls="", color=MODEL, label="Table 1")
        both = np.vstack([front, required])
        wide = both.max(axis=0) > 5 * both.min(axis=0)
        for axis, name, is_wide in zip((panel.xaxis, panel.yaxis), "xy", wide, strict=True):
            panel.set(**{f"{name}scale": "log" if is_wide else "linear"})
            axis.set_major_formatter("{x:g}")
            if is_wide:
                axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
                axis.set_minor_formatter(NullFormatter())
        panel.set(xlabel=f"{first}, {labels[0]}", ylabel=f"{second}, {labels[1]}")
        panel.legend()
    return figure


@styled
def sheet_figure(file: Path) -> Plot:
    """A picture file on a page."""
    from matplotlib.image import imread

    picture = imread(file)
    height, width = picture.shape[:2]
    figure, axes = new_plot(width=WIDTH, height=WIDTH * height / width)
    axes[0, 0].imshow(picture)
    axes[0, 0].set_axis_off()
    return figure
