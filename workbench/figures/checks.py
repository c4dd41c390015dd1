"""Figures of the checks: curves behind single checks, budgets, sweeps and tolerances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from designcalc.checks.check import DesignInputs
from designcalc.checks.run import subjects_of
from designcalc.checks.sweep import Point, Range
from designcalc.checks.tolerance import ToleranceStudy
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.units import to_si


def check_figure(width: float, height: float) -> Callable[[Callable[..., str]], Callable[..., Figure]]:
    """Decorator: draw the numbers of a design on the axes of a new figure; the drawing returns its title."""

    def decorate(draw: Callable[..., str]) -> Callable[..., Figure]:
        def drawn(design: Design, masses: Masses | None) -> Figure:
            figure, axes = _figure(width, height)
            axes.set_title(draw(axes, DesignInputs(design, masses)), fontsize=10)
            return figure

        return drawn

    return decorate


def _figure(width: float, height: float) -> tuple[Figure, Any]:
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def _left_title(axes: Any, text: str) -> None:
    axes.set_title(text, fontsize=9, loc="left")


SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _decades(axis: Any) -> None:
    """Lines and labels at the decades of a logarithmic axis alone. They are read more easily than ticks between them,
    of which there would be dozens. A power of ten is written in plain characters: a formula takes longer to lay out."""
    from matplotlib.ticker import FuncFormatter, NullLocator

    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: power_of_ten(value)))
    axis.grid(color="0.92", lw=0.6)
    axis.axes.set_axisbelow(True)


def power_of_ten(value: float) -> str:
    """A power of ten as the label of a tick: 0.01, 1, 1000, 10⁴."""
    exponent = round(np.log10(value))
    return f"{value:g}" if -3 <= exponent <= 3 else f"10{str(exponent).translate(SUPERSCRIPTS)}"


@check_figure(6.4, 4.0)
def rail_figure(axes: Any, r: DesignInputs) -> str:
    """Stiffness of the way over bolt spacing, with the design's place, the optimum, and the thesis's steel curve."""
    from dataclasses import replace

    from designcalc.bearing.bolted_rail import best_spacing_ratio, total_stiffness
    from designcalc.friction_stage.physics.pads import rail

    way, diameter = rail(r), r("screws.way.diameter")
    here, tau = r("bearing_way.bolt_spacing") / diameter, r("bearing_way.flange_thickness") / diameter
    steel = replace(way, rail_modulus=207e9, bed_modulus=207e9, bolt_modulus=207e9, poisson=0.3)
    M = np.linspace(1.3, 10, 200)
    axes.plot(M, total_stiffness(way, M, tau) / 1e6, color="tab:blue", label="materials of the design")
    axes.plot(M, total_stiffness(steel, M, tau) / 1e6, color="0.6", ls="--", label="steel throughout, as the thesis")
    best = best_spacing_ratio(way, tau)
    axes.plot(best, total_stiffness(way, best, tau) / 1e6, "^", color="tab:green", label=f"optimum, M = {best:.2f}")
    axes.plot(here, total_stiffness(way, here, tau) / 1e6, "o", color="tab:red", label=f"design, M = {here:.2f}")
    axes.set(xlabel="bolt spacing over bolt diameter, M", ylabel="stiffness of the way, N/µm", ylim=0)
    axes.legend(frameon=False)
    return f"Bearing way on its bolts, flange {tau:.2f} diameters thick"


@check_figure(6.4, 4.4)
def teeth_figure(axes: Any, r: DesignInputs) -> str:
    """Map of K_x/K_z over l/p and e/p with the thesis's 0.4 and the design on it."""
    from designcalc.drive.magnetic_teeth import ratio_map

    teeth = r.design.teeth
    widths, gaps = np.linspace(0.08, 0.9, 22), np.geomspace(0.04, 1.0, 20)
    ratio, _, _ = ratio_map(widths, gaps, teeth.groove_depth / teeth.pitch)
    axes.figure.colorbar(axes.contourf(widths, gaps, ratio, levels=16, cmap="viridis"), label="$K_x / K_z$")
    axes.axvline(0.4, color="white", ls="--", lw=1.2)
    axes.text(0.41, 0.045, "thesis: 0.4", color="white", va="bottom")
    here = teeth.width / teeth.pitch, teeth.gap / teeth.pitch
    axes.plot(*here, "o", color="tab:red", mec="white")
    axes.annotate("design", here, xytext=(8, 6), textcoords="offset points", color="white")
    axes.set(yscale="log", xlabel="tooth width over pitch, l/p", ylabel="gap over pitch, e/p")
    return "Lateral over normal stiffness of the teeth at fixed magnetic potential"


@check_figure(6.4, 4.0)
def speed_figure(axes: Any, r: DesignInputs) -> str:
    """Speed over drive frequency by the three laws, and where the tip's resonance ends them."""
    from designcalc.drive.tip_ellipse import speed_of
    from designcalc.friction_stage.physics.tip_dynamics import tip_resonance, usable_ellipse

    travel, first, wanted = usable_ellipse(r)[0], tip_resonance(r), r("requirements.speed")
    frequency = np.linspace(0, 1.9 * first, 50)
    for (law, speed), colour in zip(speed_of(travel, frequency).items(), ("tab:blue", "tab:orange", "tab:green")):
        axes.plot(frequency / 1e3, 1e3 * speed, color=colour, label=f"{law}")
    axes.axhline(1e3 * wanted, color="0.3", lw=0.8)
    axes.text(0.1, 1e3 * wanted, " required", va="bottom", fontsize=8, color="0.3")
    axes.axvspan(0, first / 3e3, color="tab:green", alpha=0.12, lw=0)
    axes.axvline(first / 1e3, color="tab:red", ls="--", lw=1)
    axes.text(first / 1e3, 8, " first resonance of the tip", color="tab:red", fontsize=8)
    axes.axvline(r("actuator.frequency") / 1e3, color="0.6", ls=":", lw=1.2)
    axes.text(r("actuator.frequency") / 1e3, 8, " drive", color="0.4", fontsize=8)
    axes.set(xlabel="drive frequency, kHz (shaded: below a third of the resonance)", ylabel="speed of the stage, mm/s")
    axes.set(xlim=(0, frequency[-1] / 1e3), ylim=0)
    axes.legend(frameon=False, title="contact", loc="upper left")
    return f"Speed from an ellipse {1e6 * travel:.2f} µm long"


@check_figure(6.4, 4.0)
def travel_figure(axes: Any, r: DesignInputs) -> str:
    """Acceleration the tip can give over the travel without tipping the stage off its pads."""
    from designcalc.drive.friction_drive import acceleration_limit, tip_force_limit
    from designcalc.friction_stage.physics.loads import gravity, load_centre, preload_ratio
    from designcalc.friction_stage.physics.pads import pad_positions

    half, places, centre = r("stage.travel") / 2, pad_positions(r), load_centre(r)
    x = np.linspace(-half, half, 161)
    # With the stage at x the tip acts at -x on it.
    share = np.array([tip_force_limit(places, centre, (-place, 0.0)) for place in x])
    mu, mu_pad, p = r("drive.friction"), r("bearing.dynamic_friction"), preload_ratio(r)
    g = gravity(r)
    axes.plot(1e3 * x, acceleration_limit(mu, p, share, mu_pad, g) / g, color="tab:blue", label="before a pad lifts")
    lift_off = float(acceleration_limit(mu, p, gravity=g)) / g
    axes.axhline(lift_off, color="tab:orange", ls="--", label="before lift-off, mu (1 + p)")
    for key, label in (("acceleration_low", "required, least"), ("acceleration", "required, most")):
        axes.axhline(r(f"requirements.{key}") / g, color="0.4", lw=0.8)
        axes.text(-1e3 * half, r(f"requirements.{key}") / g, label, va="bottom", fontsize=8, color="0.4")
    axes.axhline(0, color="0.8", lw=0.8)
    axes.set(xlabel="stage from the middle of its travel, mm", ylabel="acceleration, g")
    axes.legend(frameon=False, loc="center right", fontsize=8)
    return "Force of the tip over the travel"


@check_figure(6.4, 4.0)
def profile_figure(axes: Any, r: DesignInputs) -> str:
    """The lapped way with its waves under one pad, and the height of the pad that slides on it."""
    from designcalc.bearing.sliding import averaged_profile
    from designcalc.bearing.way_profile import synthetic_profiles
    from designcalc.friction_stage.calculated.pads import lapped_surface, spot

    surface, side = lapped_surface(r), spot(r)
    profiles, step = synthetic_profiles(surface, 4 * surface.wavelength, side, 1)
    height = averaged_profile(profiles[0], step, side)
    x = step * np.arange(profiles.shape[1])
    first = (x.size - height.size) // 2
    axes.plot(1e3 * x, 1e9 * profiles[0], color="0.75", lw=0.5, label="way, averaged across the contact")
    axes.plot(1e3 * x[first : first + height.size], 1e9 * height, color="tab:blue", lw=1.4, label="pad on it")
    limit = 1e9 * r("requirements.smoothness")
    axes.axhspan(-limit, limit, color="tab:green", alpha=0.15, lw=0, label="required smoothness")
    axes.set(xlabel="along the travel, mm", ylabel="height, nm")
    axes.legend(frameon=False, fontsize=8, loc="upper right")
    return f"A pad touches over {1e3 * side:.2g} mm: roughness is averaged, waves are not"


def budget_figure(design: Design, masses: Masses | None) -> Figure:
    """Contributions to the error budgets at the payload."""
    from designcalc.friction_stage.calculated.budget import budgets

    r = DesignInputs(design, masses)
    found = budgets(r)
    heights = [len(one.rows) + 1 for one in found]
    figure = Figure(figsize=(6.8, 0.28 * sum(heights) + 1.8), layout="constrained")
    panels = figure.subplots(len(found), 1, height_ratios=heights, squeeze=False)[:, 0]
    for axes, one in zip(panels, found, strict=True):
        names = [cause.name for cause, _ in one.rows] + ["total"]
        sizes = [1e9 * abs(float(e[one.axis])) for _, e in one.rows] + [1e9 * float(one.total[one.axis])]
        colours = ["tab:blue" if cause.random else "tab:orange" for cause, _ in one.rows] + ["0.3"]
        axes.barh(names, sizes, color=colours, height=0.65)
        axes.axvline(1e9 * r(f"requirements.{one.key}"), color="tab:red", ls="--", lw=1)
        axes.invert_yaxis()
        axes.set_xscale("log")
        _decades(axes.xaxis)
        axes.set_xlim(max(min(sizes) / 3, 1e-3))
        axes.tick_params(labelsize=8)
        _left_title(axes, f"{one.name}, {one.direction}")
    panels[-1].set_xlabel("at the payload, nm (blue: by squares; orange: in full; dashed: limit)", fontsize=9)
    return figure


def dynamic_figure(design: Design, masses: Masses | None) -> Figure:
    """Densities and cumulative rms of the dynamic error budgets at the payload."""
    from designcalc.friction_stage.calculated.position_loop import limit_key
    from designcalc.friction_stage.physics.position_loop import dynamic_budgets

    r = DesignInputs(design, masses)
    found, lowest = dynamic_budgets(r), 1 / r("loop.observation")
    figure = Figure(figsize=(10.0, 3.1 * len(found)), layout="constrained")
    panels = figure.subplots(len(found), 2, sharex=True, squeeze=False)
    names = list(dict.fromkeys(row.name for one in found for row in one.rows))
    colours = {name: f"C{k}" for k, name in enumerate(names)}
    for (left, right), one in zip(panels, found, strict=True):
        shown = one.frequency >= 1e-2
        f = one.frequency[shown]
        above = one.frequency >= lowest
        for row in (*one.rows, one.total):
            style = {"color": "0.2", "lw": 1.6} if row.name == "total" else {"color": colours[row.name], "lw": 1.0}
            left.loglog(f, 1e9 * row.density[shown], label=row.name, **style)
            below = one.rms(row, 0.0) ** 2 - one.rms(row, lowest) ** 2
            run = np.sqrt(np.maximum(one.cumulative(row)[above] ** 2 - below, 0.0))
            right.loglog(one.frequency[above], 1e9 * run, **style)
        right.axhline(1e9 * r(limit_key(one)), color="tab:red", ls="--", lw=1)
        top = 1e9 * max(one.rms(one.total, lowest), r(limit_key(one)))
        right.set_ylim(1e-5 * top, 3 * top)
        peak = 1e9 * float(one.total.density[shown].max())
        left.set_ylim(1e-7 * peak, 3 * peak)
        left.set_ylabel("density, nm/√Hz", fontsize=9)
        right.set_ylabel("cumulative rms, nm", fontsize=9)
        _left_title(left, one.name)
        left.legend(frameon=False, fontsize=7, loc="upper right")
        for axes in (left, right):
            axes.tick_params(labelsize=8)
            axes.set_xlim(1e-2, 1e5)
            _decades(axes.xaxis)
            _decades(axes.yaxis)
    for axes in panels[-1]:
        axes.set_xlabel("frequency, Hz", fontsize=9)
    _left_title(panels[0, 1], f"from {lowest:.3g} Hz upwards; dashed: limit")
    return figure


FIGURES: dict[str, tuple[str, Callable[..., Figure]]] = {
    "stiffness of the bearing way over bolt spacing": ("rail", rail_figure),
    "map of the magnetic teeth": ("teeth", teeth_figure),
    "speed over drive frequency": ("speed", speed_figure),
    "acceleration over the travel": ("travel", travel_figure),
    "profile of the way": ("profile", profile_figure),
    "error budgets": ("budget", budget_figure),
    "dynamic error budgets": ("dynamic_budget", dynamic_figure),
}
"""Figure by title: name of its file, and what draws it."""


def figures_of(design: Design) -> dict[str, tuple[str, Callable[..., Figure]]]:
    """The figures of the checks that a design has, by title."""
    names = subjects_of(design).figures(design)
    return {title: figure for title, figure in FIGURES.items() if figure[0] in names}


def tolerance_figure(study: ToleranceStudy) -> Figure:
    """The dimensions whose tolerance uses up most of a margin."""
    shown = [item for item in study.influences if item.share > 0][:12]
    figure, axes = _figure(7.2, 0.34 * len(shown) + 1.2)
    labels = [f"{item.key} ({item.tolerance})" for item in shown]
    bars = axes.barh(labels, [100 * item.share for item in shown], color="tab:blue", height=0.6)
    axes.bar_label(bars, [f" {item.check}" for item in shown], fontsize=7, color="0.35")
    axes.invert_yaxis()
    axes.set_xlim(0, 210 * shown[0].share if shown else 1)
    axes.set_xlabel("part of a margin used up by the tolerance alone, %")
    axes.tick_params(labelsize=8)
    return figure


def sweep_figure(swept: Range, points: Sequence[Point], names: Sequence[str]) -> Figure:
    """Margins of some checks over a swept parameter; below the zero line a check fails."""
    kept = [point for point in points if point.checks]
    scale = 1 / to_si(1.0, swept.unit)
    x = [point.values[0] * scale for point in kept]
    figure, axes = _figure(7.2, 4.4)
    for name in names:
        margins = [next((c.margin for c in p.checks if c.name == name), None) for p in kept]
        axes.plot(x, [np.nan if m is None else 100 * m for m in margins], marker=".", label=name)
    axes.axhline(0, color="0.3", lw=0.8)
    axes.set_yscale("symlog", linthresh=10)
    axes.set(xlabel=_label(swept), ylabel="margin, % of the limit")
    axes.legend(frameon=False, fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def grid_figure(ranges: Sequence[Range], points: Sequence[Point]) -> Figure:
    """The number of failed checks over two parameters; refused combinations are left empty."""
    rows, columns = (len(swept.values) for swept in ranges)
    counts = [np.nan if point.refused else len(point.failing) for point in points]
    x, y = ([to_si(value, swept.unit) / to_si(1.0, swept.unit) for value in swept.values] for swept in reversed(ranges))
    figure, axes = _figure(6.4, 4.6)
    shown = axes.pcolormesh(x, y, np.array(counts, float).reshape(rows, columns), shading="nearest", cmap="viridis_r")
    figure.colorbar(shown, ax=axes, label="failed checks")
    axes.set(xlabel=_label(ranges[1]), ylabel=_label(ranges[0]))
    return figure


def _label(swept: Range) -> str:
    return f"{swept.key}, {swept.unit}" if swept.unit else swept.key
