"""Figures of many designs: failed checks over a grid of two parameters."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stagecad.parameters.atomic import atomic_path
from stagecad.parameters.units import to_si

if TYPE_CHECKING:
    from designcalc.checks.analysis.grid import GridPoint
    from designcalc.checks.analysis.sweep import Range


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
