"""Physical range of each number of the parameter file, with its reason: beyond it a value is a slip.

The first pattern that a key matches counts; the bounds of its declaration hold besides. Ranges of single keys stand
before those of tables and units. What fits together within the ranges is a matter of the rules.
"""

import math
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cache

from stagecad.friction_stage.parameters import parts, physics
from stagecad.parameters.project_tables import ROW, Kind
from stagecad.parameters.schema import Declaration, declarations, mm, text
from stagecad.parameters.threads import threads

THREAD = "a tap drill lies between the thread's minor and major diameter"
PITCH = "no standard pitch of this thread is outside"
EDGE = "edges are broken, not cut away"
FILLET = "a cutter's radius at the root of a step"
TIP = "the tip is a light body on piezos some 46 mm apart"
PLATE = "the machine stands on a table, and its plates are lapped"

_LENGTHS: tuple[tuple[str, float, float, str], ...] = (
    ("threads.m3_tap_drill", 2.3, 3.0, THREAD),
    ("threads.m4_tap_drill", 3.1, 4.0, THREAD),
    ("threads.m5_tap_drill", 4.0, 5.0, THREAD),
    ("threads.m6_tap_drill", 4.8, 6.0, THREAD),
    ("threads.m10_tap_drill", 8.1, 10.0, THREAD),
    ("threads.unc_3_8_tap_drill", 7.4, 9.525, THREAD),
    ("threads.unc_1_tap_drill", 21.2, 25.4, THREAD),
    ("threads.m3_pitch", 0.3, 0.6, PITCH),
    ("threads.m4_pitch", 0.3, 0.75, PITCH),
    ("threads.m5_pitch", 0.4, 0.9, PITCH),
    ("threads.m6_pitch", 0.4, 1.1, PITCH),
    ("threads.m10_pitch", 0.4, 1.75, PITCH),
    ("threads.unc_3_8_pitch", 0.5, 1.7, PITCH),
    ("threads.unc_1_pitch", 0.7, 3.4, PITCH),
    ("pads.crown_radius", 5.0, 50_000.0, "a pad's crown is a few micrometres high"),
    ("height_pin_2.crown_radius", 1.0, 5_000.0, "the pin touches the holder in one point"),
    ("*chamfer", 0.01, 5.0, EDGE),
    ("*fillet", 0.05, 20.0, FILLET),
    ("tip.coating_thickness", 1e-4, 0.5, "a coating is thin against the tip's radius"),
    ("height_pin_1.coating_thickness", 1e-4, 0.5, "an anodic layer is thin"),
    ("*_tolerance", 1e-4, 5.0, "a tolerance is small against the part"),
    ("tip.nose_radius", 0.5, 200.0, "a flatter nose touches with its rim, a sharper one indents the surface"),
    ("stage.thickness", 1.0, 100.0, "the piezos carry the plate, and the pads touch its underside"),
    ("stage.corner_radius", 0.1, 100.0, "the corners are a part of the plate"),
    ("base.height", 20.0, 500.0, PLATE),
    ("*.head_height", 0.5, 50.0, "heads of screws up to 1 in"),
    ("teeth.gap", 0.02, 20.0, "magnetic teeth hold over a fraction of their pitch"),
    ("teeth.pitch", 0.2, 50.0, "the pitch of teeth that are milled"),
    ("stage.*", 0.05, 1_000.0, PLATE),
    ("pads.*", 0.05, 1_000.0, "pads are a part of the stage"),
    ("sea.*", 0.01, 1_000.0, "the drive surface is a part of the stage"),
    ("bearing_way.*", 0.05, 1_500.0, PLATE),
    ("base.*", 0.05, 1_500.0, PLATE),
    ("tip.*", 0.05, 150.0, TIP),
    ("actuator.*", 0.5, 300.0, TIP),
    ("holder.*", 0.05, 300.0, "the holder goes into the base"),
    ("height_pin_?.*", 0.05, 300.0, "the pins go into the base"),
    ("teeth.*", 0.05, 1_000.0, "the bars lie between the ways"),
    ("tooth_*", 0.05, 1_000.0, "the bars lie between the ways"),
    ("magnet.*", 0.1, 300.0, "magnets are glued into a pocket of the stage"),
    ("stop_bar.*", 0.2, 500.0, "the bars stand between the ways"),
    ("sensor_bracket.*", 0.2, 1_000.0, PLATE),
    ("buffer.*", 0.5, 100.0, "the buffers are smaller than the irons that they stop"),
    ("lead_clip.*", 0.2, 200.0, "the clips go into the lead channels"),
    ("interferometer.*", 1.0, 500.0, PLATE),
    ("mirror.*", 0.5, 300.0, "the mirror is as high as the stage"),
    ("piezo.*", 0.5, 300.0, "stacks up to 300 mm are sold"),
    ("screws.*", 0.2, 400.0, "screws up to 400 mm are sold"),
    ("set_screw.*", 0.2, 200.0, "set screws up to 200 mm are sold"),
    ("spring.*", 0.05, 500.0, "the spring goes into the base"),
    ("shim.*", 0.001, 10.0, "shim stock is foil"),
    ("making.largest_fit", 0.001, 1.0, "a fit with more clearance guides nothing"),
    ("making.*", 0.05, 50.0, "it is a share of a wall"),
    ("drawing.*", 0.001, 5.0, "a general tolerance is small against the part"),
    ("payload.*", 0.0, 2_000.0, "the payload stands on the stage"),
    ("candidates.*", 0.001, 1_000.0, PLATE),
)

_NUMBERS: tuple[tuple[str, float, float, str], ...] = (
    ("materials.*.density", 1.0, 23_000.0, "osmium has 22 590 kg/m^3"),
    ("materials.*.youngs_modulus", 1e5, 2e12, "diamond has 1.2 TPa"),
    ("materials.*.strength", 1e3, 2e11, "no material bears more than a tenth of its modulus"),
    ("materials.*.expansion", -1e-3, 1e-3, "polymers have some 1e-4/K"),
    ("magnet.remanence", 0.0, 2.0, "no permanent magnet has more than 1.6 T"),
    ("magnet.recoil_permeability", 1.0, 20.0, "permanent magnets have 1 to 5"),
    ("teeth.saturation", 0.0, 3.0, "iron-cobalt saturates at 2.4 T"),
    ("environment.gravity", 0.0, 300.0, "the sun's is 274 m/s^2"),
    ("environment.temperature", -273.15, 500.0, "the machine is in a laboratory"),
)

_BY_UNIT: dict[str, tuple[float, str]] = {
    "m": (1e9, "no length of the machine or its life is longer"),
    "m^2": (1.0, "no section of the machine is larger"),
    "N": (1e6, "no force in the machine is larger"),
    "N*m": (1e4, "no torque in the machine is larger"),
    "N/m": (1e12, "no part of the machine is stiffer"),
    "N*s/m": (1e9, "no damper of the machine is stronger"),
    "Pa": (1e12, "no material bears it"),
    "kg": (1e4, "the machine stands on a table"),
    "s": (1e6, "no process in the machine is slower"),
    "s/m": (1e3, "a coefficient of restitution is not negative at millimetres per second"),
    "m/s": (1e3, "nothing in the machine is faster"),
    "m/s^2": (1e5, "nothing in the machine is accelerated more"),
    "V": (1e4, "no piezo bears it"),
    "V/s": (1e12, "no amplifier is faster"),
    "A": (1e3, "no amplifier gives it"),
    "F": (1.0, "no piezo has it"),
    "Hz": (1e10, "no amplifier or sensor is faster"),
    "W": (1e5, "the machine would not shed it"),
    "W/m^2": (1e12, "no film bears it"),
    "m^2/N": (1e-6, "no film wears faster"),
    "K": (1e3, "the machine is in a laboratory"),
    "": (1e6, "no ratio in the machine is larger"),
}

OTHERWISE = (1e15, "no quantity of the machine is larger")
"""Upper bound of a number of another unit."""


@cache
def with_range(key: str, declaration: Declaration) -> Declaration:
    """`declaration` of `key` with the bounds and the reason of its physical range."""
    if declaration.kind != "number":
        return declaration
    ranges = _LENGTHS if declaration.unit == "mm" else _NUMBERS
    found = next(((low, high, why) for pattern, low, high, why in ranges if fnmatchcase(key, pattern)), None)
    if found is None and math.isinf(declaration.high):
        found = (declaration.low, *_BY_UNIT.get(declaration.unit, OTHERWISE))
    if found is None:
        return declaration
    low, high, why = found
    # Zero stays where the declaration permits it: no coating, no chamfer.
    low = declaration.low if declaration.closed and declaration.low == 0.0 else max(low, declaration.low)
    closed = declaration.closed or low > declaration.low
    return replace(declaration, low=low, high=min(high, declaration.high), closed=closed, why=why)


@dataclass
class _Thread:
    tap_drill: float = mm("of the thread")
    pitch: float = mm("of the thread")
    designation: str = text("of a thread of one's own")
    major: float = mm("diameter of a thread of one's own")


@cache
def kinds() -> dict[str, Kind]:
    """The kinds of table by name."""

    def of(table: type, slots: tuple[str, ...], optional: tuple[str, ...] = ()) -> Kind:
        columns = {name: one for name, one in declarations(table).items() if name != ROW}
        free = (name for name, one in columns.items() if one.computed or one.default is not None)
        return Kind(columns, slots, (*optional, *free))

    screws = tuple(f"screws.{name}" for name in ("way", "clamp_long", "clamp_short", "bar"))
    ceramic = ("hysteresis", "strain_limit", "creep", "damping_ratio")
    return {
        "piezos": of(parts.Piezo, ("piezo",), ceramic),
        "screws": of(parts.Screw, screws, ("torque", "nut_factor")),
        "set_screws": of(parts.SetScrew, ("set_screw",)),
        "springs": of(parts.Spring, ("spring",)),
        "threads": Kind(declarations(_Thread), optional=("designation", "major"), names=tuple(threads())),
        "materials": of(physics.Material, ()),
    }
