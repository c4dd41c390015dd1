"""Figures of results: overlay and residual, maps, loops, ranking, ladder, motions, records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from stagecad.parameters.errors import InputError, nearest
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.estimation.residual_correlation import ResidualCorrelation
from sysid.prediction.actuator_tip import TipRecord
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem
from sysid.report import channel_unit
from workbench.api.figures.plot import COLUMN, WIDTH, Plot, new_plot, style
from workbench.api.measurement.series import channel_named, record_named
from workbench.report.figures import (
    AFTER,
    BEFORE,
    FAINT,
    LOOP_POINTS,
    MEASURED,
    MODEL,
    Curve,
    axis_scale,
    curve_of,
    decimate,
    residual_panel,
    worst_stretch,
)
from workbench.report.map_figures import coordinate_unit, map_panel

if TYPE_CHECKING:
    import pandas as pd

    from workbench.api.measurement.diagnosis import Diagnosis
    from workbench.api.measurement.experiment import Experiment

LEAST_SHARE = 0.005
"""Share of the residual's variance from which a map is drawn."""

MOST_MAPS = 6
"""Maps of a figure, strongest first."""

MOST_BARS = 10
"""Effects of a ranking that are drawn."""


def model_figure(
    problem: Problem,
    models: Mapping[str, Model],
    maps: Sequence[ResidualMap],
    kind: str,
    record: str | None,
    channel: str | None,
) -> Plot:
    """A figure of one or two models on the records of a problem.

    Raises:
        InputError: no such kind of figure, record or channel.
    """
    kinds = ("overlay", "residual", "maps", "loops")
    if kind not in kinds:
        raise InputError(f"plot: no figure '{kind}'{nearest(kind, kinds)}")
    if kind == "maps":
        return maps_figure(maps, problem)
    name = channel_named(problem, channel)
    chosen = record_named(problem, record, name, next(iter(models.values())))
    curve = curve_of(chosen, name, channel_unit(problem, name), models)
    if kind == "loops" and not curve.motion:
        raise InputError("plot: 'loops' are drawn of a force over its motion, which this record does not have")
    inks = (MODEL,) if len(models) == 1 else (BEFORE, AFTER)
    return {"overlay": overlay_figure, "residual": residual_figure, "loops": loops_figure}[kind](curve, inks)


def overlay_figure(curve: Curve, inks: Sequence[str]) -> Plot:
    """Measurement and predictions above their residual: the whole record, and the stretch of the largest residual."""
    factor, unit = axis_scale(curve.measured, curve.unit)
    residual = curve.measured - next(iter(curve.predicted.values()))
    small, small_unit = _residual_scale(curve)
    zoom = worst_stretch(residual)
    words = curve.channel.replace("_", " ")
    figure, axes = new_plot(
        2, 2, height=3.4, width_ratios=(1.7, 1.0), height_ratios=(1.3, 1.0), sharex="col", gridspec_kw={}
    )
    with style():
        for column, span in enumerate((slice(0, curve.time.size), zoom)):
            top, bottom = axes[:, column]
            time = curve.time[span]
            top.plot(*decimate(time, curve.measured[span] * factor), color=MEASURED, linewidth=2.0, label="measured")
            for (label, predicted), ink in zip(curve.predicted.items(), inks):
                top.plot(*decimate(time, predicted[span] * factor), color=ink, linewidth=0.8, label=label)
            residual_panel(bottom, curve, inks, span, small)
            bottom.set(xlabel="time (s)", xlim=(time[0], time[-1]))
        for panel in axes[:, 0]:
            panel.axvspan(curve.time[zoom][0], curve.time[zoom][-1], color="#f5e6c8", zorder=0, linewidth=0)
        axes[0, 0].set(ylabel=f"{words} ({unit})", title=f"record {curve.record}")
        axes[0, 1].set_title("largest residual")
        axes[1, 0].set(ylabel=f"residual ({small_unit})")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=3)
        figure.align_ylabels(axes[:, 0])
    return figure


def residual_figure(curve: Curve, inks: Sequence[str]) -> Plot:
    """The residual of each prediction over the record; the band is two standard deviations of the noise."""
    small, unit = _residual_scale(curve)
    figure, axes = new_plot(height=2.0)
    with style():
        residual_panel(axes[0, 0], curve, inks, slice(0, curve.time.size), small)
        words = curve.channel.replace("_", " ")
        axes[0, 0].set(xlabel="time (s)", ylabel=f"residual ({unit})", title=f"{words}, record {curve.record}")
        axes[0, 0].set_xlim(curve.time[0], curve.time[-1])
        if len(inks) > 1:
            axes[0, 0].legend(loc="upper right", ncols=2)
    return figure


def _residual_scale(curve: Curve) -> tuple[float, str]:
    residual = curve.measured - next(iter(curve.predicted.values()))
    usual = np.nanquantile(np.abs(residual), 0.985) if np.isfinite(residual).any() else 0.0
    return axis_scale(np.array([2.0 * usual]), curve.unit)


def loops_figure(curve: Curve, inks: Sequence[str]) -> Plot:
    """Measured and predicted force against velocity and against position."""
    factor, unit = axis_scale(curve.measured, curve.unit)
    every = max(1, curve.time.size // LOOP_POINTS)
    figure, axes = new_plot(1, 2, height=2.6, sharey=True)
    dots: dict[str, Any] = {"linestyle": "none", "marker": ".", "markeredgewidth": 0.0, "rasterized": True}
    with style():
        for panel, (name, (values, of_motion)) in zip(axes[0], curve.motion.items()):
            scale, shown = axis_scale(values, of_motion)
            x = values[::every] * scale
            panel.plot(x, curve.measured[::every] * factor, color=MEASURED, markersize=3.0, label="measured", **dots)
            for (label, predicted), ink in zip(curve.predicted.items(), inks):
                panel.plot(x, predicted[::every] * factor, color=ink, markersize=1.8, label=label, **dots)
            panel.set_xlabel(f"{name} ({shown})")
        axes[0, 0].set(ylabel=f"{curve.channel.replace('_', ' ')} ({unit})", title=f"record {curve.record}")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=3, markerscale=3)
    return figure


def maps_figure(maps: Sequence[ResidualMap], problem: Problem) -> Plot:
    """Mean residual, in noise deviations, over the coordinates it depends on; bars are two standard errors.

    Raises:
        InputError: the residual depends on no coordinate.
    """
    drawn = [m for m in maps if m.share > LEAST_SHARE][:MOST_MAPS]
    if not drawn:
        raise InputError("plot: the residual depends on no recorded coordinate, so there is no map to draw")
    tip = isinstance(problem.fit_records[0], TipRecord)
    columns = min(3, len(drawn))
    rows = -(-len(drawn) // columns)
    figure, axes = new_plot(rows, columns, WIDTH * max(columns, 2) / 3.0, 0.2 + 1.9 * rows)
    with style():
        for panel, m in zip(axes.flat, drawn):
            map_panel(panel, m, coordinate_unit(m.coordinate, problem.experiment.rig.rotary, tip))
            panel.set_title(f"{m.coordinate.replace('_', ' ')}: {100 * m.share:.0f} % of the variance")
        for panel in axes.flat[len(drawn) :]:
            panel.set_axis_off()
        for row in axes:
            row[0].set_ylabel("residual / noise")
        named = [p for p, m in zip(axes.flat, drawn) if m.coordinate not in ("frequency", "direction")]
        if named and not tip:
            figure.legend(*named[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def correlation_figure(found: ResidualCorrelation) -> Plot:
    """Autocorrelation and cross-correlations of a residual over their lags; bands: 99 % of independent series."""
    panels = {"residual": (found.lags, found.autocorrelation, found.bound)}
    panels |= {name: (found.cross_lags, r, found.cross_bound[name]) for name, r in found.cross.items()}
    figure, axes = new_plot(1, len(panels), min(WIDTH, 2.4 * max(len(panels), 2)), 2.2, sharey=True)
    with style():
        for panel, (name, (lags, r, bound)) in zip(axes[0], panels.items()):
            factor, unit = axis_scale(lags, "s")
            panel.axhspan(-bound, bound, color=FAINT, alpha=0.8, linewidth=0)
            panel.axhline(0.0, color="#5d6d7e", linewidth=0.6)
            panel.vlines(lags * factor, 0.0, r, color=MODEL, linewidth=1.0)
            panel.plot(lags * factor, r, "o", color=MODEL, markersize=2.0)
            words = name.replace("_", " ")
            title = "autocorrelation" if name == "residual" else f"with {words}"
            panel.set(title=title, xlabel=f"lag ({unit})")
        axes[0, 0].set_ylabel(f"residual of {found.channel.replace('_', ' ')}")
    return figure


def ranking_figure(found: Diagnosis) -> Plot:
    """Error over noise on held-out records with each effect tried, and without any."""
    table = found.ranking.dropna(subset=["over_noise"])[:MOST_BARS]
    names, over = [str(name) for name in table.index], np.asarray(table["over_noise"], dtype=float)
    before = max((m.over_noise for m in found.found.before_validate.values()), default=float("nan"))
    figure, axes = new_plot(width=COLUMN * 1.5, height=0.7 + 0.2 * len(table))
    panel = axes[0, 0]
    with style():
        inks = [AFTER if name == found.effect else MODEL for name in names]
        at = np.arange(over.size)
        panel.barh(at, over, color=inks, height=0.66)
        panel.axvline(before, color=BEFORE, linewidth=1.0)
        panel.axvline(1.0, color="#5d6d7e", linewidth=0.8, linestyle=(0, (4, 2)))
        least, most = float(np.min(over, initial=1.0)), float(np.max(over, initial=before))
        panel.set_xscale("log")
        panel.set_xlim(0.8 * least, 1.6 * most)
        panel.xaxis.set_major_formatter("{x:g}")
        panel.set_yticks(at, [name.replace("_", " ") for name in names])
        panel.invert_yaxis()
        panel.grid(axis="y", visible=False)
        for x, text, ink in ((before, "without", BEFORE), (1.0, "noise", "#5d6d7e")):
            place = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "ha": "center"}
            panel.annotate(text, (x, 1.0), (0, 3), color=ink, **place)
        panel.set_xlabel("error over noise on held-out records, with the effect")
    return figure


def ladder_figure(rungs: Sequence[Mapping[str, Any]]) -> Plot:
    """Error over noise after each effect added; bars: held-out records, circles: records of the fit."""
    from workbench.identification.tables import revision_text

    words = [revision_text(r, "initial model").replace("_", " ").replace(":", ": ").split(", ") for r in rungs]
    labels = ["\n".join(fill(part, 16) for part in parts) for parts in words]
    fit, held = ([_worst(rung["before"].get(part, {})) for rung in rungs] for part in ("fit", "validate"))
    bars = held if np.isfinite(held).any() else fit
    lines = max(label.count("\n") for label in labels)
    figure, axes = new_plot(width=min(WIDTH, max(COLUMN, 1.0 + 0.95 * len(rungs))), height=2.4 + 0.12 * lines)
    panel, x = axes[0, 0], np.arange(len(rungs))
    with style():
        panel.set_yscale("log")
        panel.axhspan(0.5, 1.0, color=FAINT, alpha=0.8, linewidth=0)
        panel.bar(x, np.array(bars) - 0.5, bottom=0.5, width=0.56, color=MODEL)
        for k, value in enumerate(bars):
            panel.annotate(f"{value:.3g}", (k, value), (0, 3), textcoords="offset points", ha="center")
        panel.plot(x, fit, "o", color="#1c2833", markersize=3.5, markerfacecolor="white", label="records of the fit")
        panel.text(len(x) - 0.45, 0.97, "noise", va="top", ha="right", color="#5d6d7e")
        panel.set_xticks(x, labels)
        top = max(v for v in (*fit, *held, 1.5) if np.isfinite(v))
        panel.set(ylim=(0.5, 2.2 * top), xlim=(-0.6, len(x) - 0.4), ylabel="error over noise")
        panel.grid(axis="x", visible=False)
        panel.yaxis.set_major_formatter("{x:g}")
        panel.legend(loc="upper right")
    return figure


def _worst(by_channel: Mapping[str, Mapping[str, Any]]) -> float:
    return max((m["over_noise"] for m in by_channel.values() if m.get("over_noise") is not None), default=float("nan"))


def motion_figure(motions: Mapping[str, pd.DataFrame], name: str | None) -> Plot:
    """The channels of a motion over time.

    Raises:
        InputError: no such motion.
    """
    name = next(iter(motions)) if name is None else name
    if name not in motions:
        raise InputError(f"no motion '{name}'{nearest(name, motions)}")
    table = motions[name]
    series = {label: table[label].to_numpy() for label in table.columns[1:]}
    return _channels_figure({name: (table.iloc[:, 0].to_numpy(), series)})


def records_figure(experiment: Experiment) -> Plot:
    """The channels of every record over time."""
    drawn = {}
    for record in experiment.problem.records:
        series = {f"{c} [{record.units[c]}]": values for c, values in record.channels.items()}
        drawn[record.name] = (record.time, series)
    return _channels_figure(drawn)


def _channels_figure(drawn: Mapping[str, tuple[np.ndarray, Mapping[str, np.ndarray]]]) -> Plot:
    """Channels `name [unit]` in rows, records in columns."""
    labels = list(dict.fromkeys(label for _, series in drawn.values() for label in series))
    figure, axes = new_plot(len(labels), len(drawn), height=0.4 + 1.0 * len(labels), sharex="col", sharey="row")
    with style():
        for column, (name, (time, series)) in enumerate(drawn.items()):
            axes[0, column].set_title(name)
            axes[-1, column].set_xlabel("time (s)")
            for row, label in enumerate(labels):
                channel, _, unit = label.rstrip("]").partition(" [")
                everything = np.concatenate([s[label] for _, s in drawn.values() if label in s])
                factor, shown = axis_scale(everything, unit)
                if label in series:
                    axes[row, column].plot(*decimate(time, series[label] * factor), color=MODEL, linewidth=0.7)
                if column == 0:
                    axes[row, 0].set_ylabel(f"{channel.replace('_', ' ')}\n({shown})" if shown else channel)
        figure.align_ylabels(axes[:, 0])
    return figure
