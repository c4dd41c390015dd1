"""Figures 34 to 42 of the thesis, drawn from the simulations' own data, and the bands of many sampled machines."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from designcalc.errors.monte_carlo import Distribution
from sim.experiments.friction_models import TITLES
from sim.experiments.hysteresis import CASES, Hysteresis
from sim.experiments.limit_cycles import SHOWN as SHOWN_SPEEDS
from sim.experiments.limit_cycles import SPEEDS, LimitCycles
from sim.experiments.passivity import MOTIONS, Audit
from sim.experiments.presliding import Presliding
from sim.experiments.stick_slip import PULL, SHOWN, StickSlip
from sim.experiments.tip import TipEllipse
from workbench.figures.plot import INK, Plot, new_plot, styled

if TYPE_CHECKING:
    from workbench.operations.simulation.study import FeaturePath, Study


@styled
def tip_figure(results: Mapping[str, Mapping[str, TipEllipse]]) -> Plot:
    """Ellipses of the tip, one panel per stroke (Figure 34)."""
    figure, axes = new_plot(1, len(results), 4.6 * len(results), 4.4)
    for panel, (stroke, phases) in zip(axes[0], results.items()):
        for ink, (phase, path) in zip(INK, phases.items()):
            x, y = np.append(path.x, path.x[0]) * 1e6, np.append(path.y, path.y[0]) * 1e6
            panel.plot(x, y, color=ink, label=phase.replace("pi", "π"))
        panel.set_aspect("equal", "datalim")
        panel.set(
            xlabel="x, along the travel (µm)", ylabel="y, up (µm)", title=f"stroke ±{stroke.replace('um', ' µm')}"
        )
        panel.legend(title="phase", loc="upper right")
    figure.suptitle("Path of the actuator tip (Figure 34)")
    return figure


@styled
def presliding_figure(results: Mapping[str, Presliding]) -> Plot:
    """Position in time, and force against position, for each model (Figures 35 to 37)."""
    figure, axes = new_plot(2, len(results), 3.4 * len(results), 5.6, sharey="row")
    for column, (model, result) in enumerate(results.items()):
        run, ink = result.simulation, INK[column % len(INK)]
        axes[0, column].plot(run.time, run.position * 1e6, color=ink)
        axes[0, column].set(xlabel="time (s)", title=TITLES[model])
        axes[1, column].plot(run.position * 1e6, run.friction, color=ink)
        axes[1, column].set(xlabel="position (µm)")
    axes[0, 0].set_ylabel("position (µm)")
    axes[1, 0].set_ylabel("friction force (N)")
    figure.suptitle("Presliding displacement (Figures 35 to 37)")
    return figure


@styled
def hysteresis_figure(results: Mapping[str, Mapping[str, Hysteresis]]) -> Plot:
    """Friction force against velocity in the last period, for each model (Figure 38)."""
    figure, axes = new_plot(2, len(results), 3.4 * len(results), 5.6, sharey="row")
    for column, (model, cases) in enumerate(results.items()):
        for row, mean in enumerate(("1.5mm_s", "0")):
            panel = axes[row, column]
            for ink, (case, result) in zip(INK, ((c, r) for c, r in cases.items() if c.endswith(f"v0_{mean}"))):
                run = result.simulation
                last = run.time >= 0.5 * run.time[-1]
                label = f"{CASES[case][0]:g} rad/s"
                panel.plot(run.velocity[last] * 1e3, run.friction[last], color=ink, label=label)
            panel.set_xlabel("velocity (mm/s)")
        axes[0, column].set_title(TITLES[model])
    axes[0, 0].set_ylabel("friction force (N)")
    axes[1, 0].set_ylabel("friction force (N)")
    axes[0, 0].legend(loc="upper right")
    figure.suptitle("Hysteresis: force against an imposed velocity (Figure 38)")
    return figure


@styled
def stick_slip_figure(model: str, result: StickSlip, ink: str) -> Plot:
    """Position, velocity and forces of a model in time (Figures 40 to 42)."""
    run = result.simulation
    shown = run.time <= SHOWN
    t = run.time[shown]
    figure, axes = new_plot(4, 1, 7.2, 8.0)
    position, velocity, force, landing = axes[:, 0]
    position.plot(t, run.position[shown], color=ink, label="mass")
    position.plot(t, PULL * t, color="#888888", linewidth=0.8, label="pulled end")
    position.set_ylabel("position (m)")
    position.legend(loc="upper left")
    velocity.plot(t, run.velocity[shown], color=ink)
    velocity.set_ylabel("velocity (m/s)")
    force.plot(t, run.drive[shown], color="#888888", linewidth=0.8, label="spring")
    force.plot(t, run.friction[shown], color=ink, label="friction")
    force.set_ylabel("force (N)")
    force.legend(loc="lower right")
    if result.slips.size:
        near = (run.time > result.slips[0] + 2.5) & (run.time < result.slips[0] + 4.0)
        landing.plot(run.time[near], run.friction[near], color=ink, linewidth=0.8)
    landing.set(ylabel="friction (N)", xlabel="time (s)", title="about the first landing")
    figure.suptitle(f"Stick-slip: {TITLES[model]} (Figures 40 to 42)")
    return figure


@styled
def passivity_figure(results: Mapping[str, Mapping[str, Audit]]) -> Plot:
    """Heat and force of each model in a fast start, and force at a tip's motion."""
    figure, axes = new_plot(3, 1, 7.2, 7.2)
    for ink, (model, motions) in zip(INK, results.items()):
        start, tip = (motions[motion] for motion in MOTIONS)
        run = start.simulation
        style = "--" if model == "lugre_causal_as_run" else "-"
        axes[0, 0].plot(run.time * 1e3, start.heat * 1e6, style, color=ink, label=TITLES[model])
        axes[1, 0].plot(run.time * 1e3, run.friction, style, color=ink)
        axes[2, 0].plot(tip.simulation.time * 1e3, tip.simulation.friction, style, color=ink)
    axes[0, 0].axhline(0.0, color="black", linewidth=0.8)
    axes[0, 0].set(ylabel="heat (µJ)", xlabel="time (ms)", title="A fast start from near break-away, to 0.2 m/s")
    axes[0, 0].legend(loc="upper left")
    axes[1, 0].set(ylabel="friction force (N)", xlabel="time (ms)")
    axes[2, 0].set(ylabel="friction force (N)", xlabel="time (ms)", title="A tip's motion, 0.2 m/s at 5 kHz")
    return figure


@styled
def elements_figure(results: Mapping[str, Mapping[str, Audit]]) -> Plot:
    """Energy received by each element of the bond graphs (Figures 27 to 32), in both motions of the audit."""
    figure, axes = new_plot(len(MOTIONS), len(results), 3.6 * len(results), 5.6, sharex="row")
    for column, (model, motions) in zip(axes.T, results.items()):
        column[0].set_title(TITLES[model], fontsize=9)
        for panel, motion in zip(column, MOTIONS):
            audit = motions[motion]
            for ink, (element, energy) in zip(INK, audit.elements.items()):
                panel.plot(audit.simulation.time * 1e3, energy * 1e6, color=ink, label=element)
            panel.axhline(0.0, color="black", linewidth=0.6)
            panel.set_xlabel(f"time (ms), {motion}")
    axes[0, 0].set_ylabel("energy received (µJ)")
    axes[1, 0].set_ylabel("energy received (µJ)")
    axes[0, 0].legend(loc="upper left")
    figure.suptitle("Bond graphs of the friction models: energy of spring, damper and slip element")
    return figure


@styled
def limit_cycles_figure(model: str, springs: Mapping[str, LimitCycles]) -> Plot:
    """Spring force in time at two speeds, and size and break-away force of the limit cycles (Figures 20 to 22)."""
    figure, axes = new_plot(3, 1, 7.2, 8.0)
    force, size, rise = axes[:, 0]
    soft = next(iter(springs.values()))
    for ink, speed in zip(INK, SHOWN_SPEEDS):
        run = soft.cycles[SPEEDS.index(speed)].simulation
        force.plot(run.time * speed, run.drive, color=ink, label=f"{speed * 1e3:.3g} mm/s")
    force.set(xlabel="way of the pulled end (m)", ylabel="spring force (N)", xlim=(0.0, 4.0))
    force.legend(title=f"{soft.stiffness:g} N/m", loc="lower right")
    for ink, result in zip(INK, springs.values()):
        label = f"{result.stiffness:g} N/m"
        size.plot(np.array(SPEEDS) * 1e3, result.sizes, "o-", color=ink, markersize=3, label=label)
        if result.critical is not None:
            size.axvline(result.critical * 1e3, color=ink, linestyle="--", linewidth=0.8)
        stuck = [one for one in result.cycles if result.critical is None or one.size > 0.1]
        rise.plot([one.dwell for one in stuck], [one.top for one in stuck], "o", color=ink, markersize=3)
    size.set(xscale="log", xlabel="speed (mm/s); dashed: critical", ylabel="limit cycle, peak to peak (N)")
    size.legend(loc="upper left")
    rise.set(xscale="log", xlabel="dwell time (s)", ylabel="break-away (N)")
    figure.suptitle(f"Limit cycles of stick-slip: {TITLES[model]} (Figures 20 to 22)")
    return figure


def experiment_figures(name: str, results: Mapping[str, Any]) -> dict[str, Plot]:
    """Figures of an experiment of the thesis, by the names of their files."""
    if name == "limit-cycles":
        return {f"{name}_{model}": limit_cycles_figure(model, springs) for model, springs in results.items()}
    if name == "passivity":
        return {name: passivity_figure(results), f"{name}_elements": elements_figure(results)}
    if name == "stick-slip":
        inked = zip(results.items(), cycle(INK))
        return {f"{name}_{model}": stick_slip_figure(model, result, ink) for (model, result), ink in inked}
    return {name: {"tip": tip_figure, "presliding": presliding_figure, "hysteresis": hysteresis_figure}[name](results)}


AXES = {
    "presliding": ("time (s)", "position (µm)", 1e6),
    "stick-slip": ("time (s)", "position (m)", 1.0),
    "hysteresis": ("part of the period", "friction force (N)", 1.0),
}
"""Experiment with curves -> its abscissa, ordinate, and the ordinate's factor."""
MOST_BARS = 40


@styled
def study_figures(study: Study) -> dict[str, Plot]:
    """Bands of the curves of each experiment (50 % and 95 %), and the distribution of its features, by file."""
    figures = {}
    for name in dict.fromkeys(path[0] for path in study.distributions):
        paths = [path for path in study.nominal.curves if path[0] == name]
        if paths:
            figures[f"draws_{name}"] = _bands(study, name, paths)
        features = _features(name, {path[1:]: one for path, one in study.distributions.items() if path[0] == name})
        if features is not None:
            figures[f"draws_{name}_features"] = features
    return figures


def _bands(study: Study, name: str, paths: list[FeaturePath]) -> Plot:
    """A panel for each model; where an experiment has cases, a row for each mean velocity."""
    x_label, y_label, factor = AXES[name]
    models = list(dict.fromkeys(path[1] for path in paths))
    rows = list(dict.fromkeys(_row(path) for path in paths))
    figure, axes = new_plot(len(rows), len(models), max(3.4 * len(models), 5.0), 2.9 * len(rows) + 0.7, sharey="row")
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


def _features(name: str, distributions: dict[FeaturePath, Distribution]) -> Plot | None:
    """Each feature's 95 % and middle half in percent of the design's value, and its strongest rank correlation."""
    moving = {path: one for path, one in distributions.items() if one.nominal and one.varies}
    if not moving:
        return None
    widest = sorted(moving, key=lambda path: -_width(moving[path]))[:MOST_BARS]
    shown = {path: one for path, one in moving.items() if path in widest}
    figure, axes = new_plot(1, 1, 8.4, 0.24 * len(shown) + 1.4)
    panel = axes[0, 0]
    ends = []
    for place, distribution in enumerate(shown.values()):
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
