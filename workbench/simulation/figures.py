"""Figures 34 to 42 of the thesis, drawn from the simulations' own data."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from sim.experiments.friction_models import TITLES
from sim.experiments.hysteresis import CASES, Hysteresis
from sim.experiments.passivity import MOTIONS, Audit
from sim.experiments.presliding import Presliding
from sim.experiments.stick_slip import PULL, SHOWN, StickSlip
from sim.experiments.tip import TipEllipse
from stagecad.parameters.atomic import atomic_path

INK = ("#1b4f72", "#b03a2e", "#1e8449", "#7d6608")
STYLE: Any = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
}


Drawn = TypeVar("Drawn")


def styled(draw: Callable[..., Drawn]) -> Callable[..., Drawn]:
    """Decorator: draw in this module's style, and leave matplotlib's own settings alone."""

    @functools.wraps(draw)
    def drawn(*arguments: Any) -> Drawn:
        from matplotlib import rc_context

        with rc_context(STYLE):
            return draw(*arguments)

    return drawn


def new_figure(rows: int, columns: int, width: float, height: float, **options: Any) -> tuple[Any, Any]:
    # Figure and not pyplot: no window system, and nothing global that outlives the figure.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def save_figure(figure: Any, path: Path) -> Path:
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=150, format="png")
    return path


@styled
def draw_tip(folder: Path, results: Mapping[str, Mapping[str, TipEllipse]]) -> list[Path]:
    """Ellipses of the tip, one panel per stroke (Figure 34)."""
    figure, axes = new_figure(1, len(results), 4.6 * len(results), 4.4)
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
    return [save_figure(figure, folder / "tip.png")]


@styled
def draw_presliding(folder: Path, results: Mapping[str, Presliding]) -> list[Path]:
    """Position in time, and force against position, for each model (Figures 35 to 37)."""
    figure, axes = new_figure(2, len(results), 3.4 * len(results), 5.6, sharey="row")
    for column, (model, result) in enumerate(results.items()):
        run, ink = result.simulation, INK[column % len(INK)]
        axes[0, column].plot(run.time, run.position * 1e6, color=ink)
        axes[0, column].set(xlabel="time (s)", title=TITLES[model])
        axes[1, column].plot(run.position * 1e6, run.friction, color=ink)
        axes[1, column].set(xlabel="position (µm)")
    axes[0, 0].set_ylabel("position (µm)")
    axes[1, 0].set_ylabel("friction force (N)")
    figure.suptitle("Presliding displacement (Figures 35 to 37)")
    return [save_figure(figure, folder / "presliding.png")]


@styled
def draw_hysteresis(folder: Path, results: Mapping[str, Mapping[str, Hysteresis]]) -> list[Path]:
    """Friction force against velocity in the last period, for each model (Figure 38)."""
    figure, axes = new_figure(2, len(results), 3.4 * len(results), 5.6, sharey="row")
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
    return [save_figure(figure, folder / "hysteresis.png")]


@styled
def draw_stick_slip(folder: Path, results: Mapping[str, StickSlip]) -> list[Path]:
    """Position, velocity and forces in time, a figure for each model (Figures 40 to 42)."""
    written = []
    for number, (model, result) in enumerate(results.items()):
        run, ink = result.simulation, INK[number % len(INK)]
        shown = run.time <= SHOWN
        t = run.time[shown]
        figure, axes = new_figure(4, 1, 7.2, 8.0)
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
        written.append(save_figure(figure, folder / f"stick-slip_{model}.png"))
    return written


@styled
def draw_passivity(folder: Path, results: Mapping[str, Mapping[str, Audit]]) -> list[Path]:
    """Heat and force of each model in a fast start, and force at a tip's motion."""
    figure, axes = new_figure(3, 1, 7.2, 7.2)
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
    return [save_figure(figure, folder / "passivity.png")]


FIGURES: dict[str, Callable[..., list[Path]]] = {
    "tip": draw_tip,
    "presliding": draw_presliding,
    "hysteresis": draw_hysteresis,
    "stick-slip": draw_stick_slip,
    "passivity": draw_passivity,
}
"""Functions that draw the figures, by experiment."""
