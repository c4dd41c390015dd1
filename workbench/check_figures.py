"""Figures beside the checks: the rail curve, the map of the teeth, a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stagecad.parameters.atomic import atomic_path

if TYPE_CHECKING:
    from designcalc.checks.sweep import Point, Range
    from stagecad.parameters.design import Design


def rail_figure(design: Design, path: Path) -> bool:
    """Stiffness of the way over bolt spacing, with the design's place, the optimum, and the thesis's steel curve."""
    from dataclasses import replace

    from matplotlib.figure import Figure

    from designcalc.bolted_rail import best_spacing_ratio, total_stiffness
    from designcalc.checks.machine import rail
    from designcalc.checks.reading import Reading

    r = Reading(design, None, "bearing ways")
    way, diameter = rail(r), r("screws.way.diameter")
    here, tau = r("bearing_way.bolt_spacing") / diameter, r("bearing_way.flange_thickness") / diameter
    steel = replace(way, rail_modulus=207e9, bed_modulus=207e9, bolt_modulus=207e9, poisson=0.3)
    M = np.linspace(1.3, 10, 200)
    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    axes = figure.subplots()
    axes.plot(M, total_stiffness(way, M, tau) / 1e6, color="tab:blue", label="materials of the design")
    axes.plot(M, total_stiffness(steel, M, tau) / 1e6, color="0.6", ls="--", label="steel throughout, as the thesis")
    best = best_spacing_ratio(way, tau)
    axes.plot(best, total_stiffness(way, best, tau) / 1e6, "^", color="tab:green", label=f"optimum, M = {best:.2f}")
    axes.plot(here, total_stiffness(way, here, tau) / 1e6, "o", color="tab:red", label=f"design, M = {here:.2f}")
    axes.set_xlabel("bolt spacing over bolt diameter, M")
    axes.set_ylabel("stiffness of the way, N/µm")
    axes.set_ylim(0)
    axes.legend(frameon=False)
    axes.set_title(f"Bearing way on its bolts, flange {tau:.2f} diameters thick", fontsize=10)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=150)
    return True


def teeth_figure(design: Design, path: Path) -> bool:
    """Map of K_x/K_z over l/p and e/p with the thesis's 0.4 and the design on it; False without teeth."""
    if not design.teeth.fitted:
        return False
    from matplotlib.figure import Figure

    from designcalc.magnetic_teeth import ratio_map

    teeth = design.teeth
    widths, gaps = np.linspace(0.08, 0.9, 22), np.geomspace(0.04, 1.0, 20)
    ratio, _, _ = ratio_map(widths, gaps, teeth.groove_depth / teeth.pitch)
    figure = Figure(figsize=(6.4, 4.4), layout="constrained")
    axes = figure.subplots()
    shades = axes.contourf(widths, gaps, ratio, levels=16, cmap="viridis")
    figure.colorbar(shades, label="$K_x / K_z$")
    axes.axvline(0.4, color="white", ls="--", lw=1.2)
    axes.text(0.41, 0.045, "thesis: 0.4", color="white", va="bottom")
    axes.plot(teeth.width / teeth.pitch, teeth.gap / teeth.pitch, "o", color="tab:red", mec="white")
    axes.annotate(
        "design",
        (teeth.width / teeth.pitch, teeth.gap / teeth.pitch),
        xytext=(8, 6),
        textcoords="offset points",
        color="white",
    )
    axes.set_yscale("log")
    axes.set_xlabel("tooth width over pitch, l/p")
    axes.set_ylabel("gap over pitch, e/p")
    axes.set_title("Lateral over normal stiffness of the teeth at fixed magnetic potential", fontsize=10)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=150)
    return True


def sweep_figure(swept: Range, points: Sequence[Point], names: Sequence[str], path: Path) -> None:
    """Margins of some checks over a swept parameter; below the zero line a check fails."""
    from matplotlib.figure import Figure

    from stagecad.parameters.quantities import to_si

    kept = [point for point in points if point.checks]
    scale = 1 / to_si(1.0, swept.unit)
    x = [point.value * scale for point in kept]
    figure = Figure(figsize=(7.2, 4.4), layout="constrained")
    axes = figure.subplots()
    for name in names:
        margins = [next((c.margin for c in p.checks if c.name == name), None) for p in kept]
        axes.plot(x, [np.nan if m is None else 100 * m for m in margins], marker=".", label=name)
    axes.axhline(0, color="0.3", lw=0.8)
    axes.set_yscale("symlog", linthresh=10)
    axes.set_xlabel(f"{swept.key}, {swept.unit}" if swept.unit else swept.key)
    axes.set_ylabel("margin, % of the limit")
    axes.legend(frameon=False, fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path, dpi=150)
