"""The numbers of the assembly procedure as a workshop reads them, each with where it comes from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from stagecad.solids.assembly.bill_of_materials import Row
from stagecad.solids.modelling.dimensioning import THREAD_DESIGNATION
from stagecad.solids.modelling.registry import module_of

CALCULATED = "calculated"


@dataclass(frozen=True)
class ProcedureValues:
    """What of the procedure has to be calculated; SI.

    Args:
        way_preload, bar_preload, clamp_force: of one screw at its torque, N.
        magnet_pull: of all magnets on the stage, N; none without teeth.
        lift_per_turn: of the tip by a turn of the set screw, m.
        lift_per_degree: likewise by a degree.
        adjustment: from the middle to either end, m.
        ellipse_height: Y of the tip's path, m.
        clamp_squeeze: the tip rises by it as the holder is squeezed, m.
        clamp_drop: the most it sinks by as the holder tilts in its play, m.
        clamp_sideways: the most it goes sideways, m.
        run_in_distance: that a pad slides, m.
        run_in_time: at full speed, s.
        run_in_wear: of the film, m.
        film_strokes: there and back, until half of the film is worn as it is run in.
    """

    way_preload: float
    bar_preload: float
    clamp_force: float
    magnet_pull: float | None
    lift_per_turn: float
    lift_per_degree: float
    adjustment: float
    ellipse_height: float
    clamp_squeeze: float
    clamp_drop: float
    clamp_sideways: float
    run_in_distance: float
    run_in_time: float
    run_in_wear: float
    film_strokes: float


@dataclass(frozen=True)
class Figure:
    """A number of the procedure as it is printed, and where it comes from: keys of parameters, or calculated."""

    text: str
    origin: str


def figures_of(design: Any, rows: Sequence[Row], values: ProcedureValues) -> dict[str, Figure]:
    """Every figure that a step may name, by its name."""

    def given(key: str) -> Figure:
        entry = design.entry(key)
        match entry.value, entry.unit:
            case str(text), _:
                return Figure(text, key)
            case value, "mm":
                return Figure(_inches(entry.text) or f"{value:g} mm", key)
            case value, "rad":
                return Figure(f"{math.degrees(value):g}°", key)
        return Figure(_quantity(design.si(key), entry.unit, 4), key)

    def worked(value: float, unit: str, digits: int = 2) -> Figure:
        return Figure(_quantity(value, unit, digits), CALCULATED)

    def angle(value: float) -> Figure:
        return Figure(f"{value:.0f}°", CALCULATED)

    def counted(part: str, dimension: str) -> Figure:
        declared = {d.name: d for d in module_of(part).dimensions(design)}
        return Figure(str(declared[dimension].count), f"{part}: {dimension}")

    base = next(row for row in rows if row.part == "base")
    play = design.base.pocket_diameter - design.holder.diameter
    proud = design.holder.floor + design.piezo.length - design.holder.height
    engaged = design.screws.way.length - design.bearing_way.flange_thickness
    figures = {
        "base_mass": Figure(f"{base.mass:.0f} kg", "list of parts"),
        "eye_bolts": counted("base", "lifting hole tap drill"),
        "feet": counted("base", "foot hole drill depth"),
        "setting_pins": counted("base", "setting-pin hole"),
        "piezo_screws": counted("holder", "clamp hole tap drill"),
        "eye_bolt": Figure(THREAD_DESIGNATION["m10"], "threads"),
        "setting_pin": given("base.setting_pin_hole"),
        "way_gap": given("base.way_gap"),
        "way_thread": given("screws.way.thread"),
        "way_key": given("screws.way.socket_width"),
        "way_torque": given("screws.way.torque"),
        "way_preload": worked(values.way_preload, "N"),
        "way_engagement": Figure(f"{engaged:.1f} mm", "screws.way.length, bearing_way.flange_thickness"),
        "bar_thread": given("screws.bar.thread"),
        "bar_key": given("screws.bar.socket_width"),
        "bar_torque": given("screws.bar.torque"),
        "bar_preload": worked(values.bar_preload, "N"),
        "bar_spacing": given("teeth.bar_spacing"),
        "teeth_gap": given("teeth.gap"),
        "set_thread": given("set_screw.thread"),
        "set_key": given("set_screw.socket_width"),
        "spring_length": given("spring.installed_length"),
        "stroke": given("height_pin_1.stroke"),
        "adjustment": worked(values.adjustment, "m", 3),
        "lift_per_turn": worked(values.lift_per_turn, "m", 3),
        "lift_per_degree": worked(values.lift_per_degree, "m"),
        "half_range_turns": Figure(f"{values.adjustment / values.lift_per_turn:.1f}", CALCULATED),
        "piezo_screw": Figure(THREAD_DESIGNATION["m4"], "threads"),
        "piezo_proud": Figure(f"{proud:.2f} mm", "holder.floor, piezo.length, holder.height"),
        "piezo_spacing": given("actuator.piezo_spacing"),
        "tip_height": given("actuator.tip_height"),
        "index_gauge": given("holder.index_width"),
        "play": Figure(f"{play:.2f} mm", "base.pocket_diameter, holder.diameter"),
        "pads": given("pads.count"),
        "film": given("bearing.film_thickness"),
        "jack_screw": Figure(THREAD_DESIGNATION["m3"], "threads"),
        "travel": given("stage.travel"),
        "bias_voltage": given("actuator.bias_voltage"),
        "shim": given("shim.thinnest"),
        "shim_angle": angle(design.si("shim.thinnest") / values.lift_per_degree),
        "ellipse_height": worked(values.ellipse_height, "m"),
        "half_ellipse": worked(values.ellipse_height / 2, "m"),
        "half_ellipse_angle": angle(values.ellipse_height / 2 / values.lift_per_degree),
        "key_angle": given("actuator.key_angle"),
        "clamp_thread": given("screws.clamp_long.thread"),
        "clamp_key": given("screws.clamp_long.socket_width"),
        "clamp_torque": given("screws.clamp_long.torque"),
        "clamp_force": worked(values.clamp_force, "N"),
        "clamp_squeeze": worked(values.clamp_squeeze, "m"),
        "clamp_drop": worked(values.clamp_drop, "m"),
        "clamp_sideways": worked(values.clamp_sideways, "m"),
        "run_in_cycles": given("bearing.run_in_cycles"),
        "run_in_speed": given("requirements.speed"),
        "run_in_distance": worked(values.run_in_distance, "m", 3),
        "run_in_time": Figure(f"{values.run_in_time / 3600:.1f} h", CALCULATED),
        "run_in_wear": worked(values.run_in_wear, "m"),
        "film_strokes": Figure(f"{values.film_strokes:.0f}", CALCULATED),
        "static_low": given("bearing.static_friction_low"),
        "static_high": given("bearing.static_friction_high"),
        "dynamic_low": given("bearing.dynamic_friction_low"),
        "dynamic_high": given("bearing.dynamic_friction_high"),
    }
    if values.magnet_pull is not None:
        figures["magnet_pull"] = worked(values.magnet_pull, "N", 3)
        figures["preload"] = given("preload.force")
    return figures


def _quantity(value: float, unit: str, digits: int) -> str:
    """A quantity as a workshop reads it: lengths below a millimetre in µm, no powers of ten."""
    if unit == "m":
        value, unit = (
            (value * 1e6, "µm") if abs(value) < 1e-3 else (value, "m") if abs(value) >= 1 else (value * 1e3, "mm")
        )
    elif unit == "N" and abs(value) >= 1e3:
        value, unit = value / 1e3, "kN"
    elif unit == "m/s":
        value, unit = value * 1e3, "mm/s"
    rounded = float(f"{value:.{digits}g}")
    shown = f"{rounded:.0f}" if abs(rounded) >= 10 ** (digits - 1) else f"{rounded:g}"
    return f"{shown} {unit.replace('*', '·')}".strip()


def _inches(text: str) -> str:
    """A size in inches as the tool is named, `5/16 in`; empty for any other unit."""
    number, _, unit = text.partition(" ")
    if unit != "in":
        return ""
    size = Fraction(number)
    return f"{size} in" if size.denominator <= 64 else f"{number} in ({float(size) * 25.4:.4f} mm)"
