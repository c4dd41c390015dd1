"""The channels of records as they are logged, with the rows that hold no value of their own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stagecad.parameters.units import format_quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sysid.experiment.record import Record

COLOURS = {"clipped": "#d62728", "frozen": "#9467bd", "dropped": "#ff7f0e"}
POINTS = 4000
"""Rows of a channel that are drawn; a longer one is drawn by the extremes of its pieces."""


def raw_channels_figure(records: Sequence[Record]) -> Figure:
    """One column of panels for each record, one row for each channel, over time."""
    from matplotlib.figure import Figure

    channels = list(dict.fromkeys(channel for record in records for channel in record.channels))
    figure = Figure(figsize=(1.2 + 5.0 * len(records), 0.8 + 1.5 * len(channels)), layout="constrained")
    axes = figure.subplots(len(channels), len(records), squeeze=False, sharex="col")
    for column, record in enumerate(records):
        axes[0, column].set_title(f"{record.name} ({record.role})", fontsize=10)
        axes[-1, column].set_xlabel("time (s)")
        for row, channel in enumerate(channels):
            panel = axes[row, column]
            if channel not in record.channels:
                panel.text(0.5, 0.5, "not recorded", ha="center", transform=panel.transAxes, color="0.5")
                continue
            _draw(panel, record, channel)
            panel.set_ylabel(f"{channel.replace('_', ' ')} ({record.units[channel]})", fontsize=8)
    return figure


def _draw(panel, record: Record, channel: str) -> None:
    x, y = _extremes(record.time, record.channels[channel])
    panel.plot(x, y, color="#1f77b4", linewidth=0.7)
    panel.tick_params(labelsize=8)
    panel.margins(x=0.01)
    for fault in record.faults:
        if fault.channel == channel and fault.rows.any():
            rows = np.flatnonzero(fault.rows)[:: max(1, int(fault.rows.sum()) // POINTS)]
            label = f"{fault.kind}: {int(fault.rows.sum())} rows"
            panel.plot(record.time[rows], fault.logged[rows], ".", color=COLOURS[fault.kind], markersize=3, label=label)
    if panel.get_legend_handles_labels()[0]:
        panel.legend(fontsize=7, loc="upper right", framealpha=0.8)
    values = record.channels[channel]
    if np.isfinite(values).any():
        low, high = (
            format_quantity(float(end), record.units[channel], 3) for end in (np.nanmin(values), np.nanmax(values))
        )
        panel.set_title(f"{low} .. {high}", fontsize=7, loc="right", color="0.4", pad=2)


def _extremes(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Minimum and maximum of each piece of a long line (m,), in the order of time."""
    size = values.size // POINTS
    if size < 2:
        return time, values
    blocks = values[: size * POINTS].reshape(POINTS, size).copy()
    empty = np.asarray(np.isnan(blocks).all(axis=1))
    blocks[empty] = 0.0
    low = np.where(empty, np.nan, np.nanmin(blocks, axis=1))
    high = np.where(empty, np.nan, np.nanmax(blocks, axis=1))
    return np.repeat(time[: size * POINTS : size], 2), np.column_stack([low, high]).ravel()
