"""The columns of a measurement file against time: by which the user recognises each of them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from sysid.experiment.columns.proposal import ExperimentProposal
from workbench.simulation.figures import INK, new_figure, save_figure, styled

POINTS = 2000
"""Pieces of a long column, each drawn by its minimum and maximum."""

MOST = 12
"""Columns that are drawn."""


@styled
def draw_columns(target: Path, columns: Mapping[int, np.ndarray], proposal: ExperimentProposal) -> Path:
    """One panel for each column of numbers, titled with its number, its label and what it is taken for.

    Args:
        target: PNG file.
        columns: (n,) by index.
        proposal: what each is taken for.
    """
    by_channel = {proposal.columns[index].channel: index for index in columns}
    time = columns[by_channel["time"]] if "time" in by_channel else None
    shown = [index for index in columns if index != by_channel.get("time")][:MOST]
    figure, axes = new_figure(max(len(shown), 1), 1, 8.0, 1.1 + 1.35 * max(len(shown), 1), sharex=True)
    for k, index in enumerate(shown):
        column = proposal.columns[index]
        panel = axes[k, 0]
        x = np.arange(columns[index].size) if time is None else time - time[0]
        panel.plot(*_envelope(x, columns[index]), color=INK[k % len(INK)], linewidth=0.8)
        taken = column.channel or "left out"
        mark = " (?)" if column.question else ""
        panel.set_title(f"{column.number}: {column.label or 'no name'}  →  {taken}{mark}", loc="left", fontsize=9)
    unit = proposal.columns[by_channel["time"]].label if "time" in by_channel else "row"
    axes[-1, 0].set_xlabel(unit if time is None else f"{unit}, from the first row")
    return save_figure(figure, target)


def _envelope(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Minimum and maximum of each piece of a long line, in the order of x."""
    if y.size <= 2 * POINTS:
        return x, y
    length = y.size // POINTS
    blocks = y[: length * POINTS].reshape(POINTS, length)
    filled = np.where(np.isfinite(blocks), blocks, np.nanmedian(y))
    ends = np.column_stack([filled.min(axis=1), filled.max(axis=1)]).ravel()
    return np.repeat(x[: length * POINTS : length], 2), ends
