"""Figures of an identification: overlay and residual, loops, maps, ranking, ladder, motions, records, refits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from textwrap import fill
from typing import Any

import numpy as np

from stagecad.parameters.errors import require, require_known
from stagecad.parameters.units import format_quantity
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.documents import LEAST_P
from sysid.estimation.bootstrap import Bootstrap
from sysid.estimation.covariance import public_key
from sysid.estimation.residual_correlation import ResidualCorrelation
from sysid.experiment.column_proposal import ExperimentProposal
from sysid.experiment.record import Record
from sysid.prediction.problem import Problem
from workbench.figures import plot
from workbench.figures.curves import Curve, axis_scale, coordinate_unit, decimate, drawn_maps, quantile, worst_stretch
from workbench.figures.plot import WIDTH, Plot, new_plot, styled

LOOP_POINTS = 4000
"""Samples of a record drawn against its velocity and position."""
MOST_MAPS = 6
"""Maps of a figure, strongest first."""
MOST_BARS = 10
"""Effects of a ranking that are drawn."""
MOST_COLUMNS = 12
"""Columns of a file that are drawn."""
LABEL_WIDTH, LINE = 18, 0.13
"""Letters for which there is room below a bar of the ladder, and inches that another line of them takes."""
BY_RANK = ("velocity", "acceleration", "distance_since_reversal", "contact_age")
"""Coordinates whose maps have bins of equal count."""


def _inks(curve: Curve) -> tuple[str, ...]:
    return (plot.MODEL,) if len(curve.predicted) == 1 else (plot.BEFORE, plot.AFTER)


def _residual_scale(curve: Curve) -> tuple[float, str]:
    return axis_scale(np.array([2.0 * quantile(next(iter(curve.residuals.values())), 0.985)]), curve.unit)


def _legend(figure: Plot, panel: Any, **options: Any) -> None:
    figure.legend(*panel.get_legend_handles_labels(), loc="outside upper right", ncols=3, **options)


@styled
def overlay_figure(curve: Curve, width: float = WIDTH) -> Plot:
    """Measurement and predictions above their residual: the whole record, and the stretch of the largest residual."""
    factor, unit = axis_scale(curve.measured, curve.unit)
    small, small_unit = _residual_scale(curve)
    zoom = worst_stretch(next(iter(curve.residuals.values())))
    inks = _inks(curve)
    ratios: dict[str, Any] = {"width_ratios": (1.7, 1.0), "height_ratios": (1.3, 1.0)}
    figure, axes = new_plot(2, 2, width, 0.46 * width, sharex="col", **ratios)
    for column, span in enumerate((slice(0, curve.time.size), zoom)):
        top, bottom = axes[:, column]
        time = curve.time[span]
        top.plot(*decimate(time, curve.measured[span] * factor), color=plot.MEASURED, linewidth=2.0, label="measured")
        for (label, predicted), ink in zip(curve.predicted.items(), inks):
            top.plot(*decimate(time, predicted[span] * factor), color=ink, linewidth=0.8, label=label)
        _residual_panel(bottom, curve, span, small)
        bottom.set(xlabel="time (s)", xlim=(time[0], time[-1]))
    for panel in axes[:, 0]:
        panel.axvspan(curve.time[zoom][0], curve.time[zoom][-1], color="#f5e6c8", zorder=0, linewidth=0)
    axes[0, 0].set(ylabel=f"{curve.words} ({unit})", title=f"{curve.words}, record {curve.record}")
    axes[0, 1].set_title("largest residual")
    axes[1, 0].set(ylabel=f"residual ({small_unit})")
    axes[1, 0].set_title("measured less predicted; band: two standard deviations of noise")
    _legend(figure, axes[0, 0])
    figure.align_ylabels(axes[:, 0])
    return figure


@styled
def residual_figure(curve: Curve) -> Plot:
    """The residual of each prediction over the record; the band is two standard deviations of the noise."""
    small, unit = _residual_scale(curve)
    figure, axes = new_plot(height=2.0)
    _residual_panel(axes[0, 0], curve, slice(0, curve.time.size), small)
    axes[0, 0].set(xlabel="time (s)", ylabel=f"residual ({unit})", title=f"{curve.words}, record {curve.record}")
    axes[0, 0].set_xlim(curve.time[0], curve.time[-1])
    if len(curve.predicted) > 1:
        axes[0, 0].legend(loc="upper right", ncols=2)
    return figure


def _residual_panel(panel: Any, curve: Curve, span: slice, factor: float) -> None:
    """The residual of each prediction over a part of the record, in the unit of `factor`, with the noise as a band."""
    panel.axhspan(-2 * curve.noise * factor, 2 * curve.noise * factor, color=plot.FAINT, alpha=0.8, linewidth=0)
    for (label, residual), ink in zip(curve.residuals.items(), _inks(curve)):
        panel.plot(*decimate(curve.time[span], residual[span] * factor), color=ink, linewidth=0.7, label=label)
    first = next(iter(curve.residuals.values()))[span]
    if np.isfinite(first).any():
        # A few large samples near reversals would set the scale and hide all others.
        part = 0.985 if first.size == curve.time.size else 0.93
        reach = max(1.5 * quantile(first, part), 4.0 * curve.noise) * factor
        panel.set_ylim(-reach, reach)


@styled
def loops_figure(curve: Curve, width: float = WIDTH) -> Plot:
    """Measured and predicted force against velocity and against position."""
    require(curve.motion, "plot: 'loops' are drawn of a force over its motion, which this record does not have")
    factor, unit = axis_scale(curve.measured, curve.unit)
    every = max(1, curve.time.size // LOOP_POINTS)
    figure, axes = new_plot(1, 2, width, 0.37 * width, sharey=True)
    figure.set_dpi(200)
    # As an image: thousands of dots as elements of SVG are slow to write and to show.
    dots: dict[str, Any] = {"linestyle": "none", "marker": ".", "markeredgewidth": 0.0, "rasterized": True}
    for panel, (name, (values, of_motion)) in zip(axes[0], curve.motion.items()):
        scale, shown = axis_scale(values, of_motion)
        x = values[::every] * scale
        panel.plot(x, curve.measured[::every] * factor, color=plot.MEASURED, markersize=3.0, label="measured", **dots)
        for (label, predicted), ink in zip(curve.predicted.items(), _inks(curve)):
            panel.plot(x, predicted[::every] * factor, color=ink, markersize=1.8, label=label, **dots)
        panel.set_xlabel(f"{name} ({shown})")
    axes[0, 0].set(ylabel=f"{curve.words} ({unit})")
    axes[0, 0].set_title(f"{curve.words} against the motion, record {curve.record}")
    _legend(figure, axes[0, 0], markerscale=3)
    return figure


@styled
def maps_figure(maps: Sequence[ResidualMap], problem: Problem, width: float = WIDTH) -> Plot:
    """Mean residual, in noise deviations, over the coordinates it depends on, apart for the two directions of motion.

    Bars are two standard errors of the mean.
    """
    drawn = drawn_maps(maps, MOST_MAPS)
    require(drawn, "plot: the residual depends on no recorded coordinate, so there is no map to draw")
    columns = min(3, len(drawn))
    rows = -(-len(drawn) // columns)
    figure, axes = new_plot(rows, columns, width * max(columns, 2) / 3.0, 0.2 + 0.27 * width * rows)
    for panel, m in zip(axes.flat, drawn):
        _map_panel(panel, m, coordinate_unit(problem, m.coordinate))
        p_text = f"p < {LEAST_P:g}" if m.p_value <= 1.5 * LEAST_P else f"p = {m.p_value:.2g}"
        # In two lines: the longest name and its numbers are wider than a panel.
        panel.set_title(f"{m.coordinate.replace('_', ' ')}\n{100 * m.share:.0f} % of the variance, {p_text}")
    for panel in axes.flat[len(drawn) :]:
        panel.set_axis_off()
    for row in axes:
        row[0].set_ylabel("residual / noise")
    named = [p for p, m in zip(axes.flat, drawn) if m.coordinate not in ("frequency", "direction")]
    if named and problem.kind != "actuator-tip":
        figure.legend(*named[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _map_panel(panel: Any, m: ResidualMap, unit: str) -> None:
    """One residual map; `unit` is the SI unit of its coordinate."""
    factor, shown = axis_scale(m.centres, unit)
    x = m.centres * factor
    if m.coordinate == "frequency":
        panel.fill_between(x, m.forward, color=plot.MODEL, alpha=0.25, linewidth=0)
        panel.plot(x, m.forward, color=plot.MODEL, linewidth=0.9)
        strong = np.flatnonzero(m.forward > 0.02 * float(np.max(m.forward, initial=0.0)))
        last = x[min(strong[-1] + 2, x.size - 1)] if strong.size else 1.0
        panel.set(xlabel=f"frequency ({shown})", xlim=(0, last), ylim=(0, None))
        return
    panel.axhspan(-1, 1, color=plot.FAINT, alpha=0.8, linewidth=0)
    if m.coordinate == "direction":
        # Each direction of motion fills its own cell only.
        panel.bar([0.0], [m.backward[0]], color=plot.BACKWARD, width=0.5, label="backward")
        panel.bar([1.0], [m.forward[-1]], color=plot.FORWARD, width=0.5, label="forward")
        panel.set_xticks([0, 1], ["backward", "forward"])
        return
    sides = (
        (m.forward, m.forward_error, plot.FORWARD, "o-", "forward"),
        (m.backward, m.backward_error, plot.BACKWARD, "s--", "backward"),
    )
    for values, errors, ink, line, label in sides:
        # A cell that no sample fell into holds an exact zero.
        filled = values != 0.0
        bars = 2.0 * errors[filled] if errors.size else None
        marks: dict[str, Any] = {"markersize": 2.4, "linewidth": 1.0, "elinewidth": 0.7}
        panel.errorbar(x[filled], values[filled], bars, fmt=line, color=ink, label=label, **marks)
    middle = float(np.median(np.abs(x))) if x.size else 0.0
    if m.coordinate in BY_RANK and middle > 0.0 and float(np.max(np.abs(x))) > 8.0 * middle:
        # Bins of equal count crowd where the axis spends its time.
        panel.set_xscale("symlog", linthresh=middle)
        panel.minorticks_off()
        largest = float(np.max(np.abs(x)))
        decades = np.unique([np.ceil(np.log10(middle)), np.floor(np.log10(largest))])
        ticks = np.concatenate([-(10.0 ** decades[::-1]), [0.0], 10.0**decades])
        panel.set_xticks(ticks[(ticks >= x.min()) & (ticks <= x.max()) | (ticks == 0.0)])
        panel.xaxis.set_major_formatter("{x:g}")
    panel.set_xlabel(f"{m.coordinate.replace('_', ' ')}" + (f" ({shown})" if shown else ""))


@styled
def correlation_figure(correlation: ResidualCorrelation) -> Plot:
    """Autocorrelation and cross-correlations of a residual over their lags; bands: 99 % of independent series."""
    panels = correlation.series
    figure, axes = new_plot(1, len(panels), min(WIDTH, 2.4 * max(len(panels), 2)), 2.2, sharey=True)
    for panel, (name, (lags, r, bound)) in zip(axes[0], panels.items()):
        factor, unit = axis_scale(lags, "s")
        panel.axhspan(-bound, bound, color=plot.FAINT, alpha=0.8, linewidth=0)
        panel.axhline(0.0, color=plot.GREY, linewidth=0.6)
        panel.vlines(lags * factor, 0.0, r, color=plot.MODEL, linewidth=1.0)
        panel.plot(lags * factor, r, "o", color=plot.MODEL, markersize=2.0)
        words = name.replace("_", " ")
        title = "autocorrelation" if name == "residual" else f"with {words}"
        panel.set(title=title, xlabel=f"lag ({unit})")
    axes[0, 0].set_ylabel(f"residual of {correlation.channel.replace('_', ' ')}")
    return figure


@styled
def ranking_figure(over_noise: Mapping[str, float], named: str | None, before: float) -> Plot:
    """Error over noise on held-out records with each effect tried, and without any."""
    names, over = list(over_noise)[:MOST_BARS], np.array(list(over_noise.values())[:MOST_BARS], dtype=float)
    figure, axes = new_plot(width=plot.COLUMN * 1.5, height=0.7 + 0.2 * len(names))
    panel, at = axes[0, 0], np.arange(over.size)
    panel.barh(at, over, color=[plot.AFTER if name == named else plot.MODEL for name in names], height=0.66)
    panel.axvline(before, color=plot.BEFORE, linewidth=1.0)
    panel.axvline(1.0, color=plot.GREY, linewidth=0.8, linestyle=(0, (4, 2)))
    least, most = float(np.min(over, initial=1.0)), float(np.max(over, initial=before))
    panel.set_xscale("log")
    panel.set_xlim(0.8 * least, 1.6 * most)
    panel.xaxis.set_major_formatter("{x:g}")
    panel.set_yticks(at, [name.replace("_", " ") for name in names])
    panel.invert_yaxis()
    panel.grid(axis="y", visible=False)
    for x, text, ink in ((before, "without", plot.BEFORE), (1.0, "noise", plot.GREY)):
        place = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "ha": "center"}
        panel.annotate(text, (x, 1.0), (0, 3), color=ink, **place)
    panel.set_xlabel("error over noise on held-out records, with the effect")
    return figure


@styled
def ladder_figure(changes: Sequence[str], fit: Sequence[float], held: Sequence[float]) -> Plot:
    """Error over noise after each effect added, log axis; bars: held-out records, circles: records of the fit."""
    words = [text.replace("_", " ").replace(":", ": ").split(", ") for text in changes]
    labels = ["\n".join(fill(part, LABEL_WIDTH) for part in parts) for parts in words]
    more = LINE * max(label.count("\n") for label in labels)
    figure, axes = new_plot(width=min(2 * WIDTH, max(1.6 * plot.COLUMN, 1.6 + 1.5 * len(labels))), height=2.5 + more)
    panel, x = axes[0, 0], np.arange(len(labels))
    panel.set_yscale("log")
    panel.axhspan(0.5, 1.0, color=plot.FAINT, alpha=0.8, linewidth=0)
    panel.axhline(1.0, color=plot.GREY, linewidth=1.0)
    for k, value in enumerate(held if np.isfinite(held).any() else fit):
        ink = plot.MODEL if k < len(x) - 1 else plot.AFTER
        panel.bar(k, value - 0.5, bottom=0.5, width=0.56, color=ink, alpha=0.85)
        panel.annotate(f"{value:.3g} ×", (k, value), (0, 3), textcoords="offset points", ha="center", weight="bold")
    panel.plot(x, fit, "o", color="#1c2833", markersize=3.5, markerfacecolor="white", label="records of the fit")
    panel.text(len(x) - 0.45, 0.97, "noise", va="top", ha="right", color=plot.GREY)
    panel.set_xticks(x, labels)
    top = max(v for v in (*fit, *held, 1.5) if np.isfinite(v))
    panel.set(ylim=(0.5, 2.2 * top), xlim=(-0.6, len(x) - 0.4), ylabel="error over noise")
    panel.set_title("Error over noise after each effect; bars: held-out records")
    panel.grid(axis="x", visible=False)
    panel.yaxis.set_major_formatter("{x:g}")
    panel.legend(loc="upper right")
    return figure


@styled
def motion_figure(motions: Mapping[str, Mapping[str, np.ndarray]], name: str | None) -> Plot:
    """The channels of a motion over its first column, the time; the first motion when `name` is left out."""
    name = next(iter(motions)) if name is None else name
    require_known(name, motions, f"no motion '{name}'")
    (_, time), *series = ((label, np.asarray(values)) for label, values in motions[name].items())
    return channels_figure({name: (time, dict(series))})


@styled
def channels_figure(drawn: Mapping[str, tuple[np.ndarray, Mapping[str, np.ndarray]]]) -> Plot:
    """Channels `name [unit]` in rows, records (time, channels) by name in columns."""
    labels = list(dict.fromkeys(label for _, series in drawn.values() for label in series))
    figure, axes = new_plot(len(labels), len(drawn), height=0.4 + 1.0 * len(labels), sharex="col", sharey="row")
    for column, (name, (time, series)) in enumerate(drawn.items()):
        axes[0, column].set_title(name)
        axes[-1, column].set_xlabel("time (s)")
        for row, label in enumerate(labels):
            channel, _, unit = label.rstrip("]").partition(" [")
            everything = np.concatenate([s[label] for _, s in drawn.values() if label in s])
            factor, shown = axis_scale(everything, unit)
            if label in series:
                axes[row, column].plot(*decimate(time, series[label] * factor), color=plot.MODEL, linewidth=0.7)
            if column == 0:
                axes[row, 0].set_ylabel(f"{channel.replace('_', ' ')}\n({shown})" if shown else channel)
    figure.align_ylabels(axes[:, 0])
    return figure


@styled
def columns_figure(columns: Mapping[int, np.ndarray], proposal: ExperimentProposal) -> Plot:
    """One panel for each column (n,) of numbers of a file, titled with its number, its label and what it is taken
    for."""
    taken_for = {column.number - 1: column for column in proposal.columns}
    by_channel = {taken_for[index].channel: index for index in columns}
    time = columns[by_channel["time"]] if "time" in by_channel else None
    shown = [index for index in columns if index != by_channel.get("time")][:MOST_COLUMNS]
    count = max(len(shown), 1)
    figure, axes = new_plot(count, 1, 8.0, 1.1 + 1.35 * count, sharex=True)
    for k, index in enumerate(shown):
        column, values = taken_for[index], columns[index]
        x = np.arange(values.size) if time is None else time - time[0]
        axes[k, 0].plot(*decimate(x, values), color=plot.INK[k % len(plot.INK)], linewidth=0.8)
        taken = column.channel or "left out"
        axes[k, 0].set_title(
            f"{column.number}: {column.label or 'no name'}  →  {taken}{' (?)' if column.question else ''}"
        )
    unit = taken_for[by_channel["time"]].label if "time" in by_channel else "row"
    axes[-1, 0].set_xlabel(unit if time is None else f"{unit}, from the first row")
    return figure


@styled
def bootstrap_figure(drawn: Bootstrap, document: Mapping[str, Any]) -> Plot:
    """A histogram of each value over the refits, with the two intervals under it."""
    count = len(drawn.keys)
    columns = min(count, 3)
    rows = -(-count // columns)
    figure, axes = new_plot(rows, columns, 3.4 * columns, 2.4 * rows + 0.5)
    for panel in axes.flat[count:]:
        panel.set_axis_off()
    for k, panel in enumerate(axes.flat[:count]):
        key = public_key(drawn.keys[k])
        q, linear = document["bootstrap"]["parameters"][key], document["parameters"][key]
        values = drawn.values[:, k]
        bins = min(40, max(10, int(np.sqrt(values.size) * 1.5)))
        counts, _, _ = panel.hist(values, bins=bins, color=plot.INK[0], alpha=0.35)
        unit = counts.max() / 12.0
        panel.plot([q["low"], q["high"]], [-unit, -unit], color=plot.INK[0], linewidth=4, solid_capstyle="butt")
        if linear.get("low") is not None and linear.get("high") is not None:
            ends = [linear["low"], linear["high"]]
            panel.plot(ends, [-2.2 * unit, -2.2 * unit], color=plot.INK[1], linewidth=4, solid_capstyle="butt")
        panel.axvline(q["value"], color="black", linewidth=0.8)
        panel.set_yticks([])
        panel.set_xlabel(f"{key} ({q['unit']})" if q["unit"] != "1" else key)
        panel.locator_params(axis="x", nbins=5)
    figure.suptitle("Refitted values (bars: 95 %; blue by refitting, red linear)", fontsize=10)
    return figure


COLOURS = {"clipped": "C3", "frozen": "C4", "dropped": "C1", "held": "C5", "unloaded": "C7"}


def records_figure(records: Sequence[Record], faults: bool = False) -> Plot:
    """Every channel of records over time, with its range; the rows of the faults of a sensor are marked."""
    drawn = {f"{r.name} ({r.role})": (r.time, _labelled(r)) for r in records}
    figure = channels_figure(drawn)
    labels = list(dict.fromkeys(label for _, series in drawn.values() for label in series))
    axes = np.array(figure.axes).reshape(len(labels), len(records))
    for (row, label), (column, record) in product(enumerate(labels), enumerate(records)):
        panel, series = axes[row, column], _labelled(record)
        if label not in series:
            panel.text(0.5, 0.5, "not recorded", ha="center", transform=panel.transAxes, color=plot.GREY)
            continue
        channel, unit = label.rstrip("]").split(" [")
        if np.isfinite(series[label]).any():
            ends = [format_quantity(float(end(series[label])), unit, 3) for end in (np.nanmin, np.nanmax)]
            panel.set_title(" .. ".join(ends), fontsize=7, loc="right", color=plot.GREY, pad=2)
        factor, _ = axis_scale(np.concatenate([s[label] for _, s in drawn.values() if label in s]), unit)
        for fault in record.faults if faults else ():
            if fault.channel == channel and (count := int(fault.rows.sum())):
                rows = np.flatnonzero(fault.rows)[:: max(1, count // LOOP_POINTS)]
                marks: dict[str, Any] = {"color": COLOURS[fault.kind], "label": f"{fault.kind}: {count} rows"}
                panel.plot(record.time[rows], factor * fault.logged[rows], ".", markersize=3, **marks)
                panel.legend(loc="upper right")
    return figure


def _labelled(record: Record) -> dict[str, np.ndarray]:
    return {f"{channel} [{record.units[channel]}]": values for channel, values in record.channels.items()}
