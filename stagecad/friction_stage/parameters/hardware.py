"""Tables of what is bought, and of the threads. Lengths in millimetres."""

from dataclasses import dataclass
from typing import Any

from stagecad.parameters.project_tables import NO_ROW
from stagecad.parameters.schema import mm, number, of_material, text


def _row(table: str) -> Any:
    return text(f"of the project's table of {table}, by its name", default=NO_ROW)


@dataclass(frozen=True)
class Piezo:
    """The piezo stacks, three to an actuator."""

    row: str = _row("piezos")
    part_number: str = text("of the catalogue")
    description: str = text("for the bill of materials")
    material: str = of_material()
    diameter: float = mm("of the case")
    length: float = mm("from foot to apex")
    end_radius: float = mm("of the rounded end")
    stroke: float = number("free, at the highest voltage", "m")
    blocking_force: float = number("at the highest voltage", "N")
    highest_voltage: float = number("", "V")
    stiffness: float = number("along the axis: blocking force over free stroke", "N/m", computed=True)
    capacitance: float = number("at small signals", "F")
    full_stroke_capacitance: float = number(
        "capacitance at full stroke over that at small signals", low=1, closed=True, default="1.7"
    )
    hysteresis: float = number("width over stroke, open loop", high=1, closed=True)
    strain_limit: float = number("tensile stress that the ceramic withstands without preload", "Pa", closed=True)
    element_area: float = number("cross-section of the ceramic element in its case", "m^2")
    moving_mass: float = number("share of the stack that moves with the tip", "kg", closed=True)
    loss_factor: float = number("tan(delta) at large signal", high=1, closed=True, computed=True)
    creep: float = number("stretch gained per decade of time", high=1, closed=True)
    damping_ratio: float = number("of a body on the stacks", high=1, closed=True)


@dataclass(frozen=True)
class Screw:
    """A socket cap screw."""

    row: str = _row("screws")
    part_number: str = text("of the catalogue")
    description: str = text("for the bill of materials")
    material: str = of_material()
    thread: str = text("designation")
    diameter: float = mm("major diameter of the thread")
    pitch: float = mm("of the thread")
    length: float = mm("under the head")
    head_diameter: float = mm("of the head")
    head_height: float = mm("of the head")
    socket_width: float = mm("of the hexagon, across flats")
    stress_area: float = number("tensile stress area", "m^2")
    proof_stress: float = number("of the screw", "Pa")
    torque: float = number("for tightening", "N*m")
    nut_factor: float = number("K: torque over preload and diameter", low=0.05, high=0.5, closed=True)


@dataclass(frozen=True)
class Screws:
    """The socket cap screws by what they hold."""

    way: Screw  # bolts a bearing way to the base
    clamp_long: Screw  # closes the clamps of actuator 1
    clamp_short: Screw  # closes the clamps of actuators 2 and 3
    bar: Screw  # holds a tooth bar on the base, and the sensor bracket on a stop bar
    stop: Screw  # holds a stop bar on the base


@dataclass(frozen=True)
class Buffer:
    """The buffers of the end stops."""

    part_number: str = text("of the catalogue")
    description: str = text("for the bill of materials")
    material: str = of_material()
    length: float = mm("along the travel, relaxed")
    width: float = mm("across the travel")
    height: float = mm("upright")


@dataclass(frozen=True)
class LeadClip:
    """The slotted blocks in the lead channels that take the pull on the leads."""

    part_number: str = text("of the catalogue")
    description: str = text("for the bill of materials")
    material: str = of_material()
    length: float = mm("along the channel")
    slot_width: float = mm("of the slot for the leads")
    slot_depth: float = mm("of the slot for the leads")


@dataclass(frozen=True)
class Interferometer:
    """The optics that measure the position of the stage, on a spacer."""

    part_number: str = text("of the catalogue")
    description: str = text("for the bill of materials")
    material: str = of_material("that gives its mean density")
    length: float = mm("along the beam")
    width: float = mm("across the beam")
    height: float = mm("upright, with the spacer")
    beam_height: float = mm("of the beam over the underside of the spacer")
    screw_spacing: float = mm("between the screws that hold it, along the beam")


@dataclass(frozen=True)
class Mirror:
    """The plane mirror on the stage."""

    part_number: str = text("of the catalogue")
    description: str = text("for the bill of materials")
    material: str = of_material()
    width: float = mm("across the travel")
    height: float = mm("upright")
    thickness: float = mm("along the travel")
    screw_hole: float = mm("clearance holes at the target holes of the stage")


@dataclass(frozen=True)
class SetScrew:
    """The screw that pushes height pin 1."""

    row: str = _row("set screws")
    part_number: str = text("of the catalogue")
    description: str = text("for the bill of materials")
    material: str = of_material()
    thread: str = text("designation")
    diameter: float = mm("major diameter of the thread")
    pitch: float = mm("of the thread")
    length: float = mm("overall")
    socket_width: float = mm("of the hexagon, across flats")


@dataclass(frozen=True)
class Spring:
    """The spring that holds height pin 1 against its set screw."""

    row: str = _row("springs")
    part_number: str = text("of the catalogue")
    description: str = text("for the bill of materials")
    material: str = of_material()
    outer_diameter: float = mm("of the coils")
    wire_diameter: float = mm("")
    free_length: float = mm("")
    installed_length: float = mm("at the middle of the height adjustment", computed=True)
    coils: float = number("in all, ground ends included")
    rate: float = number("", "N/m")


@dataclass(frozen=True)
class Shim:
    """The stock with which the gap between tip and stage is set."""

    thinnest: float = mm("of the stock")
    thickest: float = mm("of the stock")


@dataclass(frozen=True)
class Threads:
    """Tap drills and pitches of the threads cut in the parts."""

    m3_tap_drill: float = mm("M3")
    m4_tap_drill: float = mm("M4")
    m5_tap_drill: float = mm("M5")
    m6_tap_drill: float = mm("M6")
    m10_tap_drill: float = mm("M10")
    unc_3_8_tap_drill: float = mm('3/8"-16 UNC')
    unc_1_tap_drill: float = mm('1"-8 UNC')
    m3_pitch: float = mm("M3")
    m4_pitch: float = mm("M4")
    m5_pitch: float = mm("M5")
    m6_pitch: float = mm("M6")
    m10_pitch: float = mm("M10")
    unc_3_8_pitch: float = mm('3/8"-16 UNC')
    unc_1_pitch: float = mm('1"-8 UNC')
