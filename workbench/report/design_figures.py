"""Figures of many designs: failed checks over a grid of two parameters, Pareto fronts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stagecad.parameters.atomic import atomic_path
from stagecad.parameters.units import to_si

if TYPE_CHECKING:
    from designcalc.checks.analysis.grid import GridPoint
    from designcalc.checks.analysis.sweep import Range
    from designcalc.optimisation.evaluation import Evaluator
    from designcalc.optimisation.reached_levels import Levels

Array = NDArray[np.float64]


def new_figure(width: float, height: float) -> tuple[Any, Any]:
    """A figure with one pair of axes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def save(figure: Any, path: Path) -> None:
    """Write a figure as PNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=150, format="png")


def grid_figure(ranges: Sequence[Range], points: Sequence[GridPoint], path: Path) -> None:
    """The number of failed checks over two parameters; refused combinations are left empty."""
    rows, columns = (len(one.values) for one in ranges)
    counts = [np.nan if point.refused else len(point.failing) for point in points]
    x, y = ([to_si(value, one.unit) / to_si(1.0, one.unit) for value in one.values] for one in reversed(ranges))
    figure, axes = new_figure(6.4, 4.6)
    shown = axes.pcolormesh(x, y, np.array(counts, float).reshape(rows, columns), shading="nearest", cmap="viridis_r")
    figure.colorbar(shown, ax=axes, label="failed checks")
    names = [f"{one.key}, {one.unit}" if one.unit else one.key for one in ranges]
    axes.set_xlabel(names[1])
    axes.set_ylabel(names[0])
    save(figure, path)


def pareto_figure(evaluator: Evaluator, names: Sequence[str], path: Path) -> None:
    """Margins of the first two requirements of a conflict over all evaluated designs that violate no rule.

    The front joins the designs of which no other one is better in both margins.
    """
    figure, axes = new_figure(6.4, 4.6)
    draw_pareto(axes, evaluator, names)
    save(figure, path)


def draw_pareto(axes: Any, evaluator: Evaluator, names: Sequence[str]) -> None:
    """Draw the margins of the first two requirements of a conflict, and their front, into axes."""
    first, second = names[:2]
    margins = 100 * margins_of(evaluator, (first, second))
    axes.scatter(*margins.T, s=8, color="0.6", label="designs")
    front = pareto_front(margins)
    axes.plot(*front.T, marker="o", ms=4, color="tab:red", drawstyle="steps-post", label="front")
    axes.axhline(0, color="0.3", lw=0.8)
    axes.axvline(0, color="0.3", lw=0.8)
    axes.set_xscale("symlog", linthresh=10)
    axes.set_yscale("symlog", linthresh=10)
    axes.set_xlabel(f"margin of '{first}', %", fontsize=8)
    axes.set_ylabel(f"margin of '{second}', %", fontsize=8)
    axes.legend(frameon=False, fontsize=8)


def fronts_figure(levels: Levels, path: Path) -> None:
    """Pareto fronts of the levels of two requirements each, with the values of Table 1."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullFormatter

    figure = Figure(figsize=(4.2 * max(len(levels.fronts), 1), 3.8), layout="constrained")
    axes = figure.subplots(1, max(len(levels.fronts), 1), squeeze=False)[0]
    for one, ((first, second), points) in zip(axes, levels.fronts.items(), strict=False):
        scales, labels = zip(
            *(_LEVEL_UNITS.get(levels.units[name], (1.0, "")) for name in (first, second)), strict=True
        )
        front, required = np.array(points) * scales, np.array([levels.required[name] for name in (first, second)])
        one.plot(*front.T, marker="o", ms=4, color="tab:red", label="can be met together")
        one.plot(*(required * scales)[:, None], marker="*", ms=10, ls="", color="tab:blue", label="Table 1")
        both = np.vstack([front, required * scales])
        wide = both.max(axis=0) > 5 * both.min(axis=0)
        for axis, set_scale, is_wide in zip(
            (one.xaxis, one.yaxis), (one.set_xscale, one.set_yscale), wide, strict=True
        ):
            set_scale("log" if is_wide else "linear")
            axis.set_major_formatter("{x:g}")
            if is_wide:
                axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
                axis.set_minor_formatter(NullFormatter())
        one.set_xlabel(f"{first}, {labels[0]}")
        one.set_ylabel(f"{second}, {labels[1]}")
        one.grid(which="both", color="0.9")
        one.legend(frameon=False, fontsize=8)
    save(figure, path)


_LEVEL_UNITS = {"m": (1e9, "nm"), "m/s": (1e3, "mm/s"), "m/s^2": (1.0, "m/s²")}
"""Scale and unit of an axis by the unit of a level."""


def margins_of(evaluator: Evaluator, names: Sequence[str]) -> Array:
    """Margins (n, 2) of two requirements in the evaluated designs that violate no rule."""
    first, second = names
    kept = [one for one in evaluator.archive if not one.refused and not one.violated]
    pairs = [(one.margins.get(first), one.margins.get(second)) for one in kept]
    return np.array([pair for pair in pairs if None not in pair], float).reshape(-1, 2)


def pareto_front(points: Array) -> Array:
    """The points, shape (n, 2), of which no other one is larger in one coordinate and not smaller in the other."""
    order = np.lexsort((-points[:, 1], -points[:, 0]))
    front: list[Any] = []
    for point in points[order]:
        if not front or point[1] > front[-1][1]:
            front.append(point)
    return np.array(front[::-1]).reshape(-1, 2)
