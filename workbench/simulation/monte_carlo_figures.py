"""Figures of a Monte Carlo study: bands of the curves (50 % and 95 %), and the distribution of each feature."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from designcalc.errors.monte_carlo import Distribution
from sim.experiments.friction_models import TITLES
from workbench.simulation.experiments import FeaturePath
from workbench.simulation.figures import INK, new_figure, save_figure, styled
from workbench.simulation.monte_carlo import Study

AXES = {
    "presliding": ("time (s)", "position (µm)", 1e6),
    "stick-slip": ("time (s)", "position (m)", 1.0),
    "hysteresis": ("part of the period", "friction force (N)", 1.0),
}
"""Experiment with curves -> its abscissa, ordinate, and the ordinate's factor."""
MOST_BARS = 40


@styled
def draw_study(folder: Path, study: Study) -> list[Path]:
    """Draw the bands of the curves of each experiment, and the distribution of its features."""
    written = []
    for name in dict.fromkeys(path[0] for path in study.distributions):
        paths = [path for path in study.nominal.curves if path[0] == name]
        if paths:
            written.append(save_figure(_bands(study, name, paths), folder / f"draws_{name}.png"))
        distributions = {
            path[1:]: distribution for path, distribution in study.distributions.items() if path[0] == name
        }
        figure = _features(study, name, distributions)
        if figure is not None:
            written.append(save_figure(figure, folder / f"draws_{name}_features.png"))
    return written


def _bands(study: Study, name: str, paths: list[FeaturePath]) -> Any:
    """A panel for each model; where an experiment has cases, a row for each mean velocity."""
    x_label, y_label, factor = AXES[name]
    models = list(dict.fromkeys(path[1] for path in paths))
    rows = list(dict.fromkeys(_row(path) for path in paths))
    figure, axes = new_figure(len(rows), len(models), max(3.4 * len(models), 5.0), 2.9 * len(rows) + 0.7, sharey="row")
    for column, model in enumerate(models):
        for row, mean in enumerate(rows):
            panel = axes[row, column]
            for ink, path in zip(INK, [path for path in paths if path[1] == model and _row(path) == mean]):
                label = "the design" if len(path) == 2 else path[2].partition("_")[0].replace("w", "") + " rad/s"
                _band(panel, study, path, factor, ink, label)
        axes[0, column].set_title(TITLES[model])
        axes[-1, column].set_xlabel(x_label)
    for row, mean in enumerate(rows):
        axes[row, 0].set_ylabel(y_label if not mean else f"{y_label}, mean {mean}")
        own = factor * max(float(np.abs(study.nominal.curves[path][1]).max()) for path in paths if _row(path) == mean)
        if own > 0.0 and np.abs(axes[row, 0].get_ylim()).max() > 20.0 * own:
            # Some machines slip where the design does not: both remain visible.
            axes[row, 0].set_yscale("symlog", linthresh=own)
    axes[0, 0].legend(loc="best", fontsize=8)
    completed = sum(not sample.refused for sample in study.samples)
    figure.suptitle(f"{name}: {completed} sampled machines; 50 % and 95 % bands at each instant")
    return figure


def _row(path: FeaturePath) -> str:
    """The mean velocity of a case of the hysteresis; nothing where there are no cases."""
    return "" if len(path) == 2 else path[2].partition("v0_")[2].replace("_s", "/s")


def _band(panel: Any, study: Study, path: FeaturePath, factor: float, ink: str, label: str) -> None:
    curves = factor * np.array([sample.curves[path][1] for sample in study.samples if not sample.refused])
    x = study.nominal.curves[path][0]
    outer_low, low, high, outer_high = np.quantile(curves, [0.025, 0.25, 0.75, 0.975], axis=0)
    panel.fill_between(x, outer_low, outer_high, color=ink, alpha=0.18, linewidth=0)
    panel.fill_between(x, low, high, color=ink, alpha=0.35, linewidth=0)
    panel.plot(x, factor * study.nominal.curves[path][1], color=ink, linewidth=1.0, label=label)


def _features(study: Study, name: str, distributions: dict[FeaturePath, Distribution]) -> Any:
    """Each feature's 95 % and middle half in percent of the design's value, and its strongest rank correlation."""
    moving = {
        path: distribution
        for path, distribution in distributions.items()
        if distribution.nominal and distribution.varies
    }
    if not moving:
        return None
    shown = dict(sorted(moving.items(), key=lambda item: -_width(item[1]))[:MOST_BARS])
    shown = {path: distribution for path, distribution in moving.items() if path in shown}
    figure, axes = new_figure(1, 1, 8.4, 0.24 * len(shown) + 1.4)
    panel = axes[0, 0]
    ends = []
    for place, (_, distribution) in enumerate(shown.items()):
        relative = 100.0 * (distribution.finite / distribution.nominal - 1.0)
        low, first, middle, third, high = np.quantile(relative, [0.025, 0.25, 0.5, 0.75, 0.975])
        panel.barh(place, high - low, left=low, height=0.5, color=INK[0], alpha=0.25)
        panel.barh(place, third - first, left=first, height=0.5, color=INK[0], alpha=0.55)
        panel.plot([middle, middle], [place - 0.25, place + 0.25], color=INK[0])
        offset = {"xytext": (4, 0), "textcoords": "offset points", "va": "center", "annotation_clip": False}
        panel.annotate(distribution.strongest_text, (high, place), fontsize=7, color="#666666", **offset)
        ends += [low, high]
    panel.axvline(0.0, color="black", linewidth=0.8)
    least, most = min(ends), max(ends)
    panel.set_xlim(least - 0.05 * (most - least), most + 0.45 * (most - least))
    panel.set_yticks(range(len(shown)), [", ".join(word.replace("_", " ") for word in path) for path in shown])
    panel.tick_params(axis="y", labelsize=7)
    panel.set_ylim(len(shown) - 0.4, -0.6)
    panel.grid(visible=False, axis="y")
    panel.set_xlabel("deviation from the design, % (dark: 50 %; light: 95 %; text: strongest rank correlation)")
    panel.set_title(f"{name}: distribution of the features")
    return figure


def _width(distribution: Distribution) -> float:
    low, high = np.quantile(distribution.finite, [0.025, 0.975])
    return abs((high - low) / (distribution.nominal or 1.0))
