"""Bands of simulations over drawn machines: a curve's middle half and 95 %, and what each feature spreads by."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from sim.experiments.friction_models import TITLES
from workbench.simulation.figures import INK, new_figure, save_figure, styled
from workbench.simulation.monte_carlo import Spread, Study, Way, followed

AXES = {
    "presliding": ("time (s)", "position (µm)", 1e6),
    "stick-slip": ("time (s)", "position (m)", 1.0),
    "hysteresis": ("part of the period", "friction force (N)", 1.0),
}
"""Experiment with curves -> its abscissa, ordinate, and the ordinate's factor."""
MOST_BARS = 40


@styled
def draw_study(folder: Path, study: Study) -> list[Path]:
    """For each experiment with curves their bands; for each experiment the spread of its features."""
    written = []
    for name in dict.fromkeys(way[0] for way in study.spreads):
        ways = [way for way in study.nominal.curves if way[0] == name]
        if ways:
            written.append(save_figure(_bands(study, name, ways), folder / f"draws_{name}.png"))
        spreads = {way[1:]: spread for way, spread in study.spreads.items() if way[0] == name}
        figure = _features(study, name, spreads)
        if figure is not None:
            written.append(save_figure(figure, folder / f"draws_{name}_features.png"))
    return written


def _bands(study: Study, name: str, ways: list[Way]) -> Any:
    """A panel for each model; where an experiment has cases, a row for each mean velocity."""
    x_label, y_label, factor = AXES[name]
    models = list(dict.fromkeys(way[1] for way in ways))
    rows = list(dict.fromkeys(_row(way) for way in ways))
    figure, axes = new_figure(len(rows), len(models), max(3.4 * len(models), 5.0), 2.9 * len(rows) + 0.7, sharey="row")
    for column, model in enumerate(models):
        for row, mean in enumerate(rows):
            panel = axes[row, column]
            for ink, way in zip(INK, [way for way in ways if way[1] == model and _row(way) == mean]):
                label = "the design" if len(way) == 2 else way[2].partition("_")[0].replace("w", "") + " rad/s"
                _band(panel, study, way, factor, ink, label)
        axes[0, column].set_title(TITLES[model])
        axes[-1, column].set_xlabel(x_label)
    for row, mean in enumerate(rows):
        axes[row, 0].set_ylabel(y_label if not mean else f"{y_label}, mean {mean}")
        own = factor * max(float(np.abs(study.nominal.curves[way]).max()) for way in ways if _row(way) == mean)
        if own > 0.0 and np.abs(axes[row, 0].get_ylim()).max() > 20.0 * own:
            # Some machines slip and the design does not: both are to be seen.
            axes[row, 0].set_yscale("symlog", linthresh=own)
    axes[0, 0].legend(loc="best", fontsize=8)
    stand = sum(not draw.refused for draw in study.draws)
    figure.suptitle(f"{name}: {stand} drawn machines; the middle half, and 95 %, at each instant")
    return figure


def _row(way: Way) -> str:
    """The mean velocity of a case of the hysteresis; nothing where there are no cases."""
    return "" if len(way) == 2 else way[2].partition("v0_")[2].replace("_s", "/s")


def _band(panel: Any, study: Study, way: Way, factor: float, ink: str, label: str) -> None:
    curves = factor * np.array([draw.curves[way] for draw in study.draws if not draw.refused])
    x = study.abscissae[way]
    outer_low, low, high, outer_high = np.quantile(curves, [0.025, 0.25, 0.75, 0.975], axis=0)
    panel.fill_between(x, outer_low, outer_high, color=ink, alpha=0.18, linewidth=0)
    panel.fill_between(x, low, high, color=ink, alpha=0.35, linewidth=0)
    panel.plot(x, factor * study.nominal.curves[way], color=ink, linewidth=1.0, label=label)


def _features(study: Study, name: str, spreads: dict[Way, Spread]) -> Any:
    """Each feature's 95 % and middle half in percent of its value at the design, with what it follows most."""
    moving = {way: spread for way, spread in spreads.items() if spread.nominal and spread.moves}
    if not moving:
        return None
    shown = dict(sorted(moving.items(), key=lambda item: -_width(item[1]))[:MOST_BARS])
    shown = {way: spread for way, spread in moving.items() if way in shown}
    figure, axes = new_figure(1, 1, 8.4, 0.24 * len(shown) + 1.4)
    panel = axes[0, 0]
    ends = []
    for place, (_, spread) in enumerate(shown.items()):
        relative = 100.0 * (spread.found / spread.nominal - 1.0)
        low, first, middle, third, high = np.quantile(relative, [0.025, 0.25, 0.5, 0.75, 0.975])
        panel.barh(place, high - low, left=low, height=0.5, color=INK[0], alpha=0.25)
        panel.barh(place, third - first, left=first, height=0.5, color=INK[0], alpha=0.55)
        panel.plot([middle, middle], [place - 0.25, place + 0.25], color=INK[0])
        panel.annotate(
            followed(spread), (high, place), (4, 0), textcoords="offset points",
            va="center", fontsize=7, color="#666666", annotation_clip=False,
        )  # fmt: skip
        ends += [low, high]
    panel.axvline(0.0, color="black", linewidth=0.8)
    least, most = min(ends), max(ends)
    panel.set_xlim(least - 0.05 * (most - least), most + 0.45 * (most - least))
    panel.set_yticks(range(len(shown)), [", ".join(word.replace("_", " ") for word in way) for way in shown])
    panel.tick_params(axis="y", labelsize=7)
    panel.set_ylim(len(shown) - 0.4, -0.6)
    panel.grid(visible=False, axis="y")
    panel.set_xlabel("off the design, % (dark: the middle half; pale: 95 %; beside it what the feature follows most)")
    panel.set_title(f"{name}: spread of the features")
    return figure


def _width(spread: Spread) -> float:
    low, high = np.quantile(spread.found, [0.025, 0.975])
    return abs((high - low) / (spread.nominal or 1.0))
