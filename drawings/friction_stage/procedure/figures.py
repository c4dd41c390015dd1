"""The numbers of the assembly procedure as printed, each with its origin."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from drawings.sheets.procedure import CALCULATED, Figure
from stagecad.friction_stage.construction import part_definition
from stagecad.parameters.threads import thread as thread_of
from stagecad.solids.assembly.bill_of_materials import Row


@dataclass(frozen=True)
class ProcedureValues:
    """Calculated values of the procedure; SI."""

    # way_preload, bar_preload, clamp_force: axial force of one screw at its torque, N
    way_preload: float
    bar_preload: float
    clamp_force: float
    magnet_pull: float | None  # force of all magnets on the stage, N; None without teeth
    # lift_per_turn, lift_per_degree: height of the tip per turn and per degree of the set screw, m
    lift_per_turn: float
    lift_per_degree: float
    adjustment: float  # range of the height on either side of the middle, m
    ellipse_height: float  # height of the path of the tip, m
    clamp_squeeze: float  # rise of the tip by elastic compression of the holder, m
    # clamp_drop, clamp_sideways: greatest shift of the tip downwards and sideways by tilt of the holder, m
    clamp_drop: float
    clamp_sideways: float
    run_in_distance: float  # sliding distance of a pad, m
    run_in_time: float  # at full speed, s
    run_in_wear: float  # wear depth of the film, m
    film_strokes: float  # number of strokes there and back that wear half of the film


_FROM_PARAMETERS = {
    "setting_pin": "base.setting_pin_hole",
    "way_gap": "base.way_gap",
    "way_thread": "screws.way.thread",
    "way_key": "screws.way.socket_width",
    "way_torque": "screws.way.torque",
    "bar_thread": "screws.bar.thread",
    "bar_key": "screws.bar.socket_width",
    "bar_torque": "screws.bar.torque",
    "bar_spacing": "teeth.bar_spacing",
    "teeth_gap": "teeth.gap",
    "stop_thread": "screws.stop.thread",
    "stop_key": "screws.stop.socket_width",
    "stop_torque": "screws.stop.torque",
    "stop_gap": "end_stop.gap",
    "dead_path": "sensors.interferometer.dead_path",
    "preload": "preload.force",
    "set_thread": "set_screw.thread",
    "set_key": "set_screw.socket_width",
    "spring_length": "spring.installed_length",
    "stroke": "height_pin_1.stroke",
    "piezo_spacing": "actuator.piezo_spacing",
    "tip_height": "actuator.tip_height",
    "index_gauge": "holder.index_width",
    "pads": "pads.count",
    "film": "bearing.film_thickness",
    "travel": "stage.travel",
    "bias_voltage": "actuator.bias_voltage",
    "shim": "shim.thinnest",
    "key_angle": "actuator.key_angle",
    "clamp_thread": "screws.clamp_long.thread",
    "clamp_key": "screws.clamp_long.socket_width",
    "clamp_torque": "screws.clamp_long.torque",
    "run_in_cycles": "bearing.run_in_cycles",
    "run_in_speed": "requirements.speed",
    "static_low": "bearing.static_friction_low",
    "static_high": "bearing.static_friction_high",
    "dynamic_low": "bearing.dynamic_friction_low",
    "dynamic_high": "bearing.dynamic_friction_high",
}
"""Figures that are parameters, by key."""

_FROM_VALUES = {
    "way_preload": ("N", 2),
    "bar_preload": ("N", 2),
    "clamp_force": ("N", 2),
    "magnet_pull": ("N", 3),
    "adjustment": ("m", 3),
    "lift_per_turn": ("m", 3),
    "lift_per_degree": ("m", 2),
    "ellipse_height": ("m", 2),
    "clamp_squeeze": ("m", 2),
    "clamp_drop": ("m", 2),
    "clamp_sideways": ("m", 2),
    "run_in_distance": ("m", 3),
    "run_in_wear": ("m", 2),
}
"""Figures that are fields of `ProcedureValues`: unit and number of significant digits."""

_COUNTS = {
    "eye_bolts": ("base", "lifting hole tap drill"),
    "feet": ("base", "foot hole drill depth"),
    "setting_pins": ("base", "setting-pin hole"),
    "piezo_screws": ("holder", "clamp hole tap drill"),
}
"""Figures that are numbers of equal features: part and dimension."""

_THREADS = {"eye_bolt": "m10", "piezo_screw": "m4", "jack_screw": "m3"}


def figures_of(design: Any, rows: Sequence[Row], values: ProcedureValues) -> dict[str, Figure]:
    """All figures by name; those of the magnets only in a design with teeth."""
    figures = {name: _of_parameter(design, key) for name, key in _FROM_PARAMETERS.items()}
    for name, (unit, digits) in _FROM_VALUES.items():
        value = getattr(values, name)
        if value is not None:
            figures[name] = Figure(_quantity(value, unit, digits), CALCULATED)
    for name, (part, dimension) in _COUNTS.items():
        declared = {d.name: d for d in part_definition(part).dimensions(design)}
        figures[name] = Figure(str(declared[dimension].count), f"{part}: {dimension}")
    figures |= {name: Figure(thread_of(thread).designation, "threads") for name, thread in _THREADS.items()}
    base = next(row for row in rows if row.part == "base")
    play = design.base.pocket_diameter - design.holder.diameter
    proud = design.holder.floor + design.piezo.length - design.holder.height
    engaged = design.screws.way.length - design.bearing_way.flange_thickness
    half_ellipse = values.ellipse_height / 2
    shim_angle, ellipse_angle = (
        height / values.lift_per_degree for height in (design.si("shim.thinnest"), half_ellipse)
    )
    return figures | {
        "base_mass": Figure(f"{base.mass:.0f} kg", "list of parts"),
        "way_engagement": Figure(f"{engaged:.1f} mm", "screws.way.length, bearing_way.flange_thickness"),
        "piezo_proud": Figure(f"{proud:.2f} mm", "holder.floor, piezo.length, holder.height"),
        "play": Figure(f"{play:.2f} mm", "base.pocket_diameter, holder.diameter"),
        "half_range_turns": Figure(f"{values.adjustment / values.lift_per_turn:.1f}", CALCULATED),
        "shim_angle": Figure(f"{shim_angle:.0f}°", CALCULATED),
        "half_ellipse": Figure(_quantity(half_ellipse, "m", 2), CALCULATED),
        "half_ellipse_angle": Figure(f"{ellipse_angle:.0f}°", CALCULATED),
        "run_in_time": Figure(f"{values.run_in_time / 3600:.1f} h", CALCULATED),
        "film_strokes": Figure(f"{values.film_strokes:.0f}", CALCULATED),
    }


def _of_parameter(design: Any, key: str) -> Figure:
    entry = design.entry(key)
    match entry.value, entry.unit:
        case str(text), _:
            return Figure(text, key)
        case value, "mm":
            return Figure(_inches(entry.text) or f"{value:g} mm", key)
        case value, "rad":
            return Figure(f"{math.degrees(value):g}°", key)
    return Figure(_quantity(design.si(key), entry.unit, 4), key)


def _quantity(value: float, unit: str, digits: int) -> str:
    """A quantity for the workshop: lengths below a millimetre in µm, no powers of ten."""
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
    """A size in inches by which the tool is named, `5/16 in`; empty for any other unit."""
    number, _, unit = text.partition(" ")
    if unit != "in":
        return ""
    size = Fraction(number)
    return f"{size} in" if size.denominator <= 64 else f"{number} in ({float(size) * 25.4:.4f} mm)"
