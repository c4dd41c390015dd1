"""The steps of the assembly as templates, whose sentences name their figures in braces, and the figures."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

from drawings.sheets.procedure import CALCULATED, Figure
from stagecad.friction_stage.construction import part_definition
from stagecad.friction_stage.parameters.derived import Derived
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


Condition = Literal["always", "teeth", "no teeth", "film lasts", "film wears out", "end stops"]
"""Designs that have a step: with or without magnetic teeth, with end stops; film thick or thin for the running-in."""


@dataclass(frozen=True)
class StepTemplate:
    """A step without its figures."""

    title: str
    parts: tuple[str, ...]  # names of the parts that are put in
    # tools, sentences: with names of figures in braces
    tools: tuple[str, ...]
    sentences: tuple[str, ...]
    torque: str = ""  # name of the figure that is the torque of the screws; empty where there is none
    condition: Condition = "always"  # designs that have this step


_LOWERED = "Tip at its lowest. Lower the stage square onto the ways, pads on the running faces."
_RELEASE = (
    "Clamps open. Lift the actuator, holder with piezos and tip, out of its pocket by the lifting screws. Acetone into "
    "the gaps around the three domes until the tip comes off by itself: no prying or twisting, the stacks bear no "
    "bending.",
    "Loosen the soft-tipped screw of the piezo, draw the piezo out, put the new one in. Clean domes and seats, bond "
    "the tip again, and repeat all steps of the actuator, from its pocket to the shift by clamping.",
)
_SLIDES = "It slides freely over the whole travel of {travel}."
_STROKES = (
    "{run_in_cycles} strokes there and back over {travel} at up to {run_in_speed}: {run_in_distance}, {run_in_time}."
)
_AFTER_RUN_IN = (
    "Wipe the ways. Friction is then {dynamic_low} to {dynamic_high} moving, {static_low} to {static_high} from rest; "
    "check the height once more."
)

STEPS = (
    StepTemplate(
        "Set up the base",
        ("base",),
        ("{eye_bolts} eye bolts {eye_bolt}", "{feet} feet {eye_bolt}"),
        (
            "Lift the base by its corners ({base_mass}) and set it on its feet.",
            "Wipe the lapped seats of the ways; a hard stone finds burrs at the holes.",
        ),
    ),
    StepTemplate(
        "Bolt the bearing ways",
        ("bearing_way", "way_screw"),
        ("{setting_pins} setting pins {setting_pin}", "key {way_key}", "torque wrench"),
        (
            "Put the setting pins into the reamed holes and lay each way on its bed, ledge outwards, both faces wiped.",
            "Push the way against its pins and put the screws in by hand ({way_thread}, {way_engagement} engaged).",
            "Tighten from the middle outwards, alternating sides, in thirds to {way_torque} ({way_preload} a "
            "screw); no more, or the ceramic warps.",
            "Draw the pins out. Inner edges are {way_gap} apart.",
        ),
        "way_torque",
    ),
    StepTemplate(
        "Screw the tooth bars down",
        ("tooth_bar", "bar_screw"),
        ("key {bar_key}", "torque wrench"),
        (
            "Stand each bar on its feet, teeth up and along the travel, {bar_spacing} from middle to middle.",
            "Set them parallel to the ways' inner edges by a dial on a way, then tighten {bar_thread} to "
            "{bar_torque} ({bar_preload} a screw).",
        ),
        "bar_torque",
        condition="teeth",
    ),
    StepTemplate(
        "Put in spring, height pins and set screw",
        ("spring", "height_pin_1", "set_screw", "height_pin_2"),
        ("key {set_key}", "grease"),
        (
            "From the side face: the spring, then height pin 1, greased, spigot into the spring and wedge face up, "
            "then the set screw ({set_thread}).",
            "From above into the pocket's floor: height pin 2, greased, sloping end down; it lies flat on the wedge.",
            "At the middle of its stroke of {stroke} the spring is {spring_length} long. From there turn the set "
            "screw out by {half_range_turns} turns: the tip will be {adjustment} below its middle.",
        ),
    ),
    StepTemplate(
        "Put the piezos into their holder",
        ("holder", "piezo"),
        ("{piezo_screws} soft-tipped set screws {piezo_screw} a holder", "gauge"),
        (
            "Stand each piezo on the floor of its bore, leads through the slot into the well and out at the top.",
            "Draw the soft-tipped screws finger tight against the piezos' feet: they hold the foot and leave the "
            "stroke free.",
            "All ends are {piezo_proud} above the holder, to equal height.",
        ),
    ),
    StepTemplate(
        "Bond the tip",
        ("tip",),
        ("cyanoacrylate gel", "flat plate"),
        (
            "A drop of adhesive in each seat; set the tip on the piezos' domes ({piezo_spacing} apart), nose up, "
            "and let it cure with the seats touching metal to metal. The adhesive carries tension only; it is soluble, "
            "so that a piezo can be replaced.",
            "The apex is {tip_height} above the piezos' ends.",
        ),
    ),
    StepTemplate(
        "Lower the holder into its pocket",
        ("lead_clip",),
        ("lifting screws {piezo_screw}", "gauge {index_gauge}", "silicone adhesive"),
        (
            "Clamps open. Lower the holder (play {play}) until it rests on height pin 2 alone.",
            "Turn it until the gauge, laid in the base's lead channel, enters the index notch: piezos 1 and 2 then "
            "lie along the travel. Lay the leads in the channel and bond them with their clip into its outer end.",
        ),
    ),
    StepTemplate(
        "Screw the end stops down",
        ("stop_bar", "stop_screw", "buffer"),
        ("key {stop_key}", "torque wrench", "polyurethane adhesive"),
        (
            "Bond the buffers to the noses of the stop bars, level with the upper edge, in line "
            "with the inner teeth of the tooth bars.",
            "Stand a bar at either end of the base, nose towards the middle, and tighten {stop_thread} "
            "to {stop_torque}. At the ends of {travel} the irons stop {stop_gap} before the buffers.",
        ),
        "stop_torque",
        condition="end stops",
    ),
    StepTemplate(
        "Bond irons and magnets into the stage",
        ("tooth_iron", "magnet"),
        ("adhesive", "non-magnetic clamps"),
        (
            "Two irons to a pocket, teeth down and along the travel, seated on the pocket's floor; the magnet "
            "between them pulls them together.",
            "Crests of all irons in one plane. Iron comes out again by a jack screw {jack_screw} from the "
            "payload face.",
        ),
        condition="teeth",
    ),
    StepTemplate(
        "Check the film on the pads",
        (),
        ("film gauge",),
        (
            "The stage comes from the coater with PTFE on the crowns of its {pads} pads; the film is {film} thick, and "
            "none of it is on the drive surface.",
        ),
    ),
    StepTemplate(
        "Lower the stage onto the ways",
        ("stage",),
        ("wooden wedges",),
        (
            _LOWERED,
            "The magnets pull it down with {magnet_pull} at a gap of {teeth_gap} (specified: {preload}); let it down "
            "by the wedges, fingers out.",
            _SLIDES,
        ),
        condition="teeth",
    ),
    StepTemplate("Lower the stage onto the ways", ("stage",), (), (_LOWERED, _SLIDES), condition="no teeth"),
    StepTemplate(
        "Mount mirror and interferometer",
        ("mirror", "sensor_bracket", "interferometer"),
        ("key {bar_key}", "torque wrench"),
        (
            "Screw the mirror to the end face of the stage on the side of the two pockets, the bracket by two screws "
            "{bar_thread} to the stop bar there ({bar_torque}), and the interferometer on its arm: {dead_path} from "
            "the mirror at the near end of the travel.",
            "Align the beam along the travel: the signal keeps its strength from end to end.",
        ),
        condition="end stops",
    ),
    StepTemplate(
        "Set the height of the tip",
        (),
        ("shim {shim}", "key {set_key}"),
        (
            "Piezos at {bias_voltage}, the middle of their stroke. Shim between nose and drive surface; turn the set "
            "screw in until the shim just drags. A turn lifts the tip by {lift_per_turn}, a degree by "
            "{lift_per_degree}; always approach from below.",
            "Draw the shim out and turn on by {shim_angle}: the nose now touches at mid-stroke.",
            "The tip's path is {ellipse_height} high, so the height has to be right to {half_ellipse}: "
            "{half_ellipse_angle} of the key; a hand sets it to {key_angle}.",
        ),
    ),
    StepTemplate(
        "Close the clamps",
        ("clamp_screw_long", "clamp_screw_short"),
        ("key {clamp_key}", "torque wrench"),
        (
            "At each fitted pocket, in thirds to {clamp_torque} ({clamp_thread}, {clamp_force}); at pocket 1 both "
            "fingers in turn, so that the holder stays in the middle.",
            "Screws of empty pockets by hand only: a finger without a holder would be bent.",
        ),
        "clamp_torque",
    ),
    StepTemplate(
        "Check the shift by clamping",
        (),
        ("electronics that show the piezos' contact signal",),
        (
            "As the clamp closes the tip rises by {clamp_squeeze} (the holder is squeezed), sinks by {clamp_drop} "
            "at most and goes sideways by {clamp_sideways} at most (it tilts within its play).",
            "Contact must begin within {half_ellipse} of mid-stroke. If not: open the clamps, turn the set screw "
            "by the difference ({lift_per_degree} a degree), close them again.",
        ),
    ),
    StepTemplate(
        "Run in",
        (),
        ("drive or hand",),
        (f"{_STROKES} The film wears by {{run_in_wear}} of its {{film}}.", _AFTER_RUN_IN),
        condition="film lasts",
    ),
    StepTemplate(
        "Run in",
        (),
        ("drive or hand",),
        (
            f"{_STROKES} They would wear the film by {{run_in_wear}} of its {{film}}: stop after {{film_strokes}}, "
            "when half of it is left, and inspect the crowns.",
            _AFTER_RUN_IN,
        ),
        condition="film wears out",
    ),
    StepTemplate(
        "Replace a piezo (service)",
        (),
        ("wooden wedges", "lifting screws {piezo_screw}", "acetone, syringe"),
        ("Wedge the stage up evenly on all sides against the magnets ({magnet_pull}) and take it off.", *_RELEASE),
        condition="teeth",
    ),
    StepTemplate(
        "Replace a piezo (service)",
        (),
        ("lifting screws {piezo_screw}", "acetone, syringe"),
        ("Take the stage off.", *_RELEASE),
        condition="no teeth",
    ),
)
"""All steps in the order of assembly."""


def step_templates(design: Any, values: ProcedureValues) -> list[StepTemplate]:
    """The steps of a design in the order of assembly."""
    teeth: Condition = "teeth" if design.teeth.fitted else "no teeth"
    film: Condition = "film lasts" if values.film_strokes >= design.bearing.run_in_cycles else "film wears out"
    stops = ("end stops",) if Derived(design).end_stops else ()
    return [step for step in STEPS if step.condition in ("always", teeth, film, *stops)]
