"""Figures of an identification: measurement and prediction, residual, residual maps, ladder; as SVG text.

A record of any length is drawn by the minimum and maximum of each pixel column, so a figure stays small and no spike is
lost.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np

from stagecad.parameters.atomic import atomic_path
from sysid.estimation.bootstrap import Bootstrap
from sysid.estimation.identifiability import public_key
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model, predict
from sysid.prediction.prepared_record import PreparedRecord
from workbench.identification.tables import revision_text
from workbench.simulation.figures import INK, STYLE, new_figure

MEASURED, MODEL, BEFORE, AFTER, FAINT = "#8a939c", "#0072b2", "#d55e00", "#009e73", "#c9d6df"
"""Colours that readers with deficient colour vision distinguish (Okabe and Ito, 2008)."""

LOOP_POINTS = 4000
"""Samples of a record drawn against its velocity and position."""

COLUMNS = 900
"""Pixel columns a line is drawn in."""

LABEL_WIDTH, LINE = 18, 0.15
"""Letters for which there is room below a bar of the ladder, and inches that another line of them takes."""

_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_WITH_PREFIX = ("m", "N", "s", "V", "rad", "Hz")


@dataclass(frozen=True)
class Curve:
    """One channel of one record with the predictions to draw over it. Arrays (n,), SI; NaN where nothing is scored.

    Args:
        record, channel: names.
        unit: SI unit of the channel.
        time: s.
        measured: as compared (filtered where the balance is).
        predicted: by label, in drawing order.
        noise: standard deviation that sensor noise leaves in the residual.
        motion: velocity and position, with their SI units; empty where the record has none.
    """

    record: str
    channel: str
    unit: str
    time: np.ndarray
    measured: np.ndarray
    predicted: Mapping[str, np.ndarray]
    noise: float
    motion: Mapping[str, tuple[np.ndarray, str]] = field(default_factory=dict)


def curve_of(record: PreparedRecord, channel: str, unit: str, models: Mapping[str, Model]) -> Curve:
    """A record's channel with what each of `models` predicts for it."""
    valid = record.valid[channel]

    def scored(values: np.ndarray) -> np.ndarray:
        return np.where(valid, values, np.nan)

    predicted = {label: scored(predict(record, m.effects, m.values)[channel]) for label, m in models.items()}
    time, motion = record.time, {}
    if isinstance(record, ForceBalanceRecord) and channel == record.force_channel:
        length = "rad" if unit.startswith("N*m") else "m"
        motion = {"velocity": (record.axis.velocity, f"{length}/s"), "position": (record.axis.position, length)}
    measured = scored(record.measured[channel])
    return Curve(record.name, channel, unit, time - time[0], measured, predicted, record.noise[channel], motion)


def worst_record(records: Sequence[PreparedRecord], channel: str, model: Model) -> PreparedRecord:
    """The record whose residual in `channel` is largest over its noise, by its rms."""

    def error(record: PreparedRecord) -> float:
        predicted = predict(record, model.effects, model.values)[channel]
        valid = record.valid[channel]
        return float(np.sqrt(np.mean((record.measured[channel] - predicted)[valid] ** 2))) / record.noise[channel]

    return max(records, key=error)


def axis_scale(values: np.ndarray, unit: str) -> tuple[float, str]:
    """Factor that brings SI values into a readable range, and the unit they then have, for a label."""
    finite = np.abs(values[np.isfinite(values)])
    largest = float(finite.max()) if finite.size else 0.0
    shown = unit.replace("*", "·").replace("degC", "°C").replace("^2", "²").replace("^3", "³")
    head = shown.replace("/", "·").split("·")[0]
    if head not in _WITH_PREFIX or largest == 0.0:
        return 1.0, "" if unit == "1" else shown
    size, prefix = next(((s, p) for s, p in _PREFIXES if largest >= s), _PREFIXES[-1])
    return 1.0 / size, prefix + shown


def decimate(time: np.ndarray, values: np.ndarray, columns: int = COLUMNS) -> tuple[np.ndarray, np.ndarray]:
    """The least and the largest of `values` (n,) in each of `columns` equal stretches, in the order they occur.

    A stretch without any number stays a gap. With two samples a column or fewer, the line itself.
    """
    n = values.size
    if n <= 2 * columns:
        return time, values
    edges = np.linspace(0, n, columns + 1).astype(int)[:-1]
    number = np.isfinite(values)
    column = np.searchsorted(edges, np.arange(n), side="right") - 1
    low = np.minimum.reduceat(np.where(number, values, np.inf), edges)
    high = np.maximum.reduceat(np.where(number, values, -np.inf), edges)

    def first_at(extreme: np.ndarray) -> np.ndarray:
        hits = np.flatnonzero(number & (values == extreme[column]))
        where = edges.copy()
        # Written backwards, so the first hit of a column is the one that stays.
        where[column[hits[::-1]]] = hits[::-1]
        return where

    pair = np.sort(np.stack([first_at(low), first_at(high)], axis=1), axis=1).ravel()
    return time[pair], values[pair]


def worst_stretch(residual: np.ndarray, least: int = 150) -> slice:
    """The stretch of about a twenty-fifth of the record where the residual (n,) is worst, single spikes aside."""
    n = residual.size
    length = min(n, max(least, n // 25))
    size = np.abs(np.nan_to_num(residual))
    ceiling = 6.0 * (float(np.median(size)) or 1.0)
    total = np.concatenate([[0.0], np.cumsum(np.minimum(size, ceiling) ** 2)])
    start = int(np.argmax(total[length:] - total[:-length])) if n > length else 0
    return slice(start, start + length)


def new_panels(rows: int, columns: int, width: float, height: float, **options: Any) -> tuple[Any, Any]:
    """A figure of `width` by `height` inches, with room for labels in inches: a constrained layout doubles the time."""
    # Figure and not pyplot: no window system, and nothing global that outlives the figure.
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height))
    inside = (width - 0.8) / columns - 0.45
    tall = (height - 0.95) / rows - 0.65 if rows > 1 else height - 0.95
    grid = {"wspace": 0.45 / inside, "hspace": 0.65 / tall, **options}
    frame = {"left": 0.7 / width, "right": 1 - 0.1 / width, "bottom": 0.45 / height, "top": 1 - 0.5 / height}
    return figure, figure.subplots(rows, columns, squeeze=False, gridspec_kw={**frame, **grid})


def add_legend(figure: Any, panel: Any, markerscale: float = 1.0) -> None:
    handles, labels = panel.get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", ncols=4, borderaxespad=0.1, markerscale=markerscale)


def as_svg(figure: Any, name: str) -> str:
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    out = io.StringIO()
    figure.patch.set_visible(False)
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        # `savefig` would draw everything once more to learn its size.
        FigureCanvasSVG(figure).print_svg(out, metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    # Verdana has the widths of DejaVu Sans, for readers without it.
    return text[text.index("<svg") :].replace("'DejaVu Sans'", "'DejaVu Sans', Verdana")


def report_style() -> Any:
    from matplotlib import rc_context

    return rc_context(
        {
            **STYLE,
            "font.size": 8.5,
            "axes.titlesize": 9,
            "axes.titlelocation": "left",
            "figure.constrained_layout.use": False,
        }
    )


def residual_panel(panel: Any, curve: Curve, inks: Sequence[str], span: slice, factor: float) -> None:
    """The residual of each prediction over a part of the record, in the unit of `factor`, with the noise as a band."""
    time = curve.time[span]
    panel.axhspan(-2 * curve.noise * factor, 2 * curve.noise * factor, color=FAINT, alpha=0.8, linewidth=0)
    for (label, predicted), ink in zip(curve.predicted.items(), inks):
        t, r = decimate(time, (curve.measured[span] - predicted[span]) * factor)
        panel.plot(t, r, color=ink, linewidth=0.7, label=label)
    first = np.abs(curve.measured - next(iter(curve.predicted.values())))[span]
    if np.isfinite(first).any():
        # A few large samples near reversals would set the scale and hide all others.
        part = 0.985 if first.size == curve.time.size else 0.93
        reach = max(1.5 * float(np.nanquantile(first, part)), 4.0 * curve.noise) * factor
        panel.set_ylim(-reach, reach)


def draw_overlay(curve: Curve, inks: Sequence[str] = (MODEL,)) -> str:
    """Measured and predicted signal, of the full record and of its worst section, and residual with noise; SVG text."""
    factor, unit = axis_scale(curve.measured, curve.unit)
    residual = curve.measured - next(iter(curve.predicted.values()))
    usual = np.nanquantile(np.abs(residual), 0.985) if np.isfinite(residual).any() else 0.0
    small, small_unit = axis_scale(np.array([2.0 * usual]), curve.unit)
    zoom = worst_stretch(residual)
    everything = slice(0, curve.time.size)
    words = curve.channel.replace("_", " ")
    with report_style():
        figure, axes = new_panels(2, 2, 9.6, 4.3, width_ratios=(1.7, 1.0), height_ratios=(1.25, 1.0))
        for column, span in enumerate((everything, zoom)):
            top, bottom = axes[0, column], axes[1, column]
            time = curve.time[span]
            top.plot(*decimate(time, curve.measured[span] * factor), color=MEASURED, linewidth=2.4, label="measured")
            for (label, predicted), ink in zip(curve.predicted.items(), inks):
                top.plot(*decimate(time, predicted[span] * factor), color=ink, linewidth=0.9, label=label)
            residual_panel(bottom, curve, inks, span, small)
            bottom.set_xlabel("time (s)")
            for panel in (top, bottom):
                panel.set_xlim(time[0], time[-1])
        for panel in axes[:, 0]:
            panel.axvspan(curve.time[zoom][0], curve.time[zoom][-1], color="#f5e6c8", zorder=0, linewidth=0)
        axes[0, 0].set(ylabel=f"{words} ({unit})", title=f"{words}, record {curve.record}")
        axes[0, 1].set_title("largest residual")
        axes[1, 0].set(
            ylabel=f"residual ({small_unit})", title="measured less predicted; band: two standard deviations of noise"
        )
        add_legend(figure, axes[0, 0])
        return as_svg(figure, f"overlay {curve.record} {curve.channel}")


def draw_loops(curve: Curve, inks: Sequence[str] = (MODEL,)) -> str:
    """Measured and predicted force against velocity and against position; SVG text, empty without a motion."""
    if not curve.motion:
        return ""
    factor, unit = axis_scale(curve.measured, curve.unit)
    every = max(1, curve.time.size // LOOP_POINTS)
    words = curve.channel.replace("_", " ")
    with report_style():
        figure, axes = new_panels(1, 2, 9.6, 3.4, wspace=0.22)
        figure.set_dpi(200)
        for panel, (name, (values, of_motion)) in zip(axes[0], curve.motion.items()):
            scale, shown = axis_scale(values, of_motion)
            x = values[::every] * scale
            # As an image: thousands of dots as elements of SVG are slow to write and to show.
            dots = {"linestyle": "none", "marker": ".", "markeredgewidth": 0.0, "rasterized": True}
            panel.plot(x, curve.measured[::every] * factor, color=MEASURED, markersize=3.5, label="measured", **dots)
            for (label, predicted), ink in zip(curve.predicted.items(), inks):
                panel.plot(x, predicted[::every] * factor, color=ink, markersize=2.0, label=label, **dots)
            panel.set(xlabel=f"{name} ({shown})", ylabel=f"{words} ({unit})")
        axes[0, 0].set_title(f"{words} against the motion, record {curve.record}")
        add_legend(figure, axes[0, 0], markerscale=3.0)
        return as_svg(figure, f"loops {curve.record} {curve.channel}")


def draw_ladder(rungs: Sequence[Mapping[str, Any]], png: Path | None = None) -> str:
    """Error over noise after each effect added, log axis, the noise as a line at one; SVG text, and a PNG file."""
    labels, fit, held = [], [], []
    for rung in rungs:
        words = revision_text(rung, "initial model").replace("_", " ").replace(":", ": ").split(", ")
        came = len(rung.get("added") or ())
        signed = [f"+ {word}" if k < came else word for k, word in enumerate(words)]
        labels.append("\n".join(fill(word, LABEL_WIDTH) for word in signed))
        fit.append(_worst(rung["before"].get("fit", {})))
        held.append(_worst(rung["before"].get("validate", {})))
    x = np.arange(len(rungs))
    with report_style():
        more = LINE * max(label.count("\n") for label in labels)
        height = 3.6 + more
        figure, axes = new_panels(1, 1, max(5.6, 1.6 + 1.5 * len(rungs)), height, bottom=(0.45 + more) / height)
        panel = axes[0, 0]
        panel.set_yscale("log")
        panel.axhspan(0.5, 1.0, color=FAINT, alpha=0.8, linewidth=0)
        panel.axhline(1.0, color="#5d6d7e", linewidth=1.0)
        top = max(1.0, *(v for v in [*fit, *held] if np.isfinite(v)), 1.5)
        for k, value in enumerate(held if np.isfinite(held).any() else fit):
            panel.bar(k, value - 0.5, bottom=0.5, width=0.56, color=MODEL if k < len(x) - 1 else AFTER, alpha=0.85)
            panel.annotate(f"{value:.3g} ×", (k, value), (0, 4), textcoords="offset points", ha="center", weight="bold")
        panel.plot(x, fit, "o", color="#1c2833", markersize=4, markerfacecolor="white", label="records of the fit")
        panel.text(len(x) - 0.45, 1.0, "noise", va="bottom", ha="right", color="#5d6d7e")
        panel.set_xticks(x, labels)
        panel.set(ylim=(0.5, 2.2 * top), xlim=(-0.6, len(x) - 0.4), ylabel="error over noise")
        panel.set_title("Error over noise after each effect; bars: held-out records")
        panel.grid(axis="x", visible=False)
        panel.yaxis.set_major_formatter("{x:g}")
        panel.legend(loc="upper right")
        if png is not None:
            with atomic_path(png) as temporary:
                figure.savefig(temporary, dpi=150, format="png", metadata={"Software": None})
        return as_svg(figure, "ladder")


def _worst(by_channel: Mapping[str, Mapping[str, Any]]) -> float:
    return max((m["over_noise"] for m in by_channel.values() if m.get("over_noise") is not None), default=float("nan"))


def bootstrap_figure(drawn: Bootstrap, document: Mapping[str, Any]) -> Any:
    """A histogram of each value over the refits, with the two intervals under it."""
    from matplotlib import rc_context

    count = len(drawn.keys)
    columns = min(count, 3)
    rows = -(-count // columns)
    with rc_context(STYLE):
        figure, axes = new_figure(rows, columns, 3.4 * columns, 2.4 * rows + 0.5)
        for k, panel in enumerate(axes.flat):
            if k >= count:
                panel.set_axis_off()
                continue
            key = public_key(drawn.keys[k])
            q, linear = document["bootstrap"]["parameters"][key], document["parameters"][key]
            values = drawn.values[:, k]
            bins = min(40, max(10, int(np.sqrt(values.size) * 1.5)))
            counts, _, _ = panel.hist(values, bins=bins, color=INK[0], alpha=0.35)
            unit = counts.max() / 12.0
            panel.plot([q["low"], q["high"]], [-unit, -unit], color=INK[0], linewidth=4, solid_capstyle="butt")
            if linear.get("low") is not None and linear.get("high") is not None:
                ends = [linear["low"], linear["high"]]
                panel.plot(ends, [-2.2 * unit, -2.2 * unit], color=INK[1], linewidth=4, solid_capstyle="butt")
            panel.axvline(q["value"], color="black", linewidth=0.8)
            panel.set_yticks([])
            panel.set_xlabel(f"{key} ({q['unit']})" if q["unit"] != "1" else key)
            panel.locator_params(axis="x", nbins=5)
        figure.suptitle("Refitted values (bars: 95 %; blue by refitting, red linear)", fontsize=10)
    return figure
