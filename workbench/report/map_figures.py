"""Figures of residual maps: mean residual against each coordinate, with standard errors; as SVG text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sysid.diagnosis.residual_maps import ResidualMap
from sysid.report import LEAST_P
from workbench.report.figures import BEFORE, FAINT, MODEL, add_legend, as_svg, axis_scale, new_panels, report_style

BY_RANK = ("velocity", "acceleration", "distance_since_reversal", "contact_age")
"""Coordinates whose maps have bins of equal count."""


def coordinate_unit(coordinate: str, rotary: bool, tip: bool) -> str:
    """SI unit of a coordinate of the residual maps."""
    length = "rad" if rotary else "m"
    if tip:
        length = {"velocity": "V", "acceleration": "V"}.get(coordinate, length)
    units = {
        "time": "s",
        "frequency": "Hz",
        "contact_age": "s",
        "normal_load": "N",
        "temperature": "degC",
        "input": "V",
    }
    units |= dict.fromkeys(("position", "distance_since_reversal", "distance_travelled"), length)
    units |= {"velocity": f"{length}/s", "acceleration": f"{length}/s^2"}
    return units.get(coordinate, "1")


def draw_maps(maps: Sequence[ResidualMap], rotary: bool, tip: bool) -> str:
    """Residual, in noise deviations, against each coordinate, apart for the two directions of motion; SVG text.

    Bars are two standard errors of the mean.
    """
    columns = min(3, len(maps))
    rows = -(-len(maps) // columns)
    with report_style():
        figure, axes = new_panels(rows, columns, 9.6, 0.4 + 2.5 * rows)
        flat = axes.ravel()
        for panel, m in zip(flat, maps):
            map_panel(panel, m, coordinate_unit(m.coordinate, rotary, tip))
            p_text = "p < 0.001" if m.p_value <= 1.5 * LEAST_P else f"p = {m.p_value:.2g}"
            panel.set_title(f"{m.coordinate.replace('_', ' ')}: {100 * m.share:.0f} %, {p_text}")
        for panel in flat[len(maps) :]:
            panel.set_visible(False)
        for row in axes:
            row[0].set_ylabel("residual / noise")
        if not tip:
            drawn = next((p for p, m in zip(flat, maps) if m.coordinate != "frequency"), None)
            if drawn is not None:
                add_legend(figure, drawn)
        return as_svg(figure, "maps " + " ".join(m.coordinate for m in maps))


def map_panel(panel: Any, m: ResidualMap, unit: str) -> None:
    """One residual map; `unit` is the SI unit of its coordinate."""
    factor, shown = axis_scale(m.centres, unit)
    x = m.centres * factor
    if m.coordinate == "frequency":
        panel.fill_between(x, m.forward, color=MODEL, alpha=0.25, linewidth=0)
        panel.plot(x, m.forward, color=MODEL, linewidth=0.9)
        strong = np.flatnonzero(m.forward > 0.02 * float(np.max(m.forward, initial=0.0)))
        last = x[min(strong[-1] + 2, x.size - 1)] if strong.size else 1.0
        panel.set(xlabel=f"frequency ({shown})", xlim=(0, last), ylim=(0, None))
        return
    panel.axhspan(-1, 1, color=FAINT, alpha=0.8, linewidth=0)
    if m.coordinate == "direction":
        # Each direction of motion fills its own cell only.
        panel.bar([0.0], [m.backward[0]], color=BEFORE, width=0.5, label="backward")
        panel.bar([1.0], [m.forward[-1]], color=MODEL, width=0.5, label="forward")
        panel.set_xticks([0, 1], ["backward", "forward"])
        return
    sides = (
        (m.forward, m.forward_error, MODEL, "o-", "forward"),
        (m.backward, m.backward_error, BEFORE, "s--", "backward"),
    )
    for values, errors, ink, line, label in sides:
        # A cell that no sample fell into holds an exact zero.
        filled = values != 0.0
        bars = 2.0 * errors[filled] if errors.size else None
        panel.errorbar(
            x[filled],
            values[filled],
            bars,
            fmt=line,
            color=ink,
            markersize=2.4,
            linewidth=1.0,
            elinewidth=0.7,
            label=label,
        )
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
