"""Tables of drive, bearing, friction, sensors, requirements, materials and drawing. All numbers in SI.

The actuator's two lengths are geometry, and in millimetres.
"""

import math
from dataclasses import dataclass

from stagecad.parameters.schema import choice, count, mm, number, switch, text


@dataclass(frozen=True)
class Actuator:
    """Kinematics and drive of one actuator."""

    piezo_spacing: float = mm("D: between the axes of the piezos")
    tip_height: float = mm("h: of the tip's apex over the piezos' ends")
    stroke_amplitude: float = number("of each piezo in the thesis's simulation, zero to peak", "m")
    phase: float = number("between the two piezos", "rad", low=-math.pi, high=math.pi)
    frequency: float = number("of the drive", "Hz")
    bias_voltage: float = number("at which the piezos are at mid-stroke", "V", closed=True)
    fitted: int = count("actuators: one drives one axis, three drive two", low=1, high=3)
    heat_limit: float = number("that tip and holder bear", "W")
    key_angle: float = number("to which a hand sets the key of the height adjustment", "rad")


@dataclass(frozen=True)
class Amplifier:
    """The amplifier of one piezo."""

    current: float = number("highest", "A")
    slew_rate: float = number("highest, without a load", "V/s")
    bandwidth: float = number("", "Hz")
    bits: int = count("of the converter over the whole voltage", high=32)
    noise: float = number("of the voltage across a stack, rms", "V", closed=True)


@dataclass(frozen=True)
class Drive:
    """Friction contact between tip and drive surface."""

    friction: float = number("coefficient between the tip's coating and the drive surface", high=5)
    sea_coating_thickness: float = number("of the friction coating on the drive surface", "m")
    roughness: float = number("Ra of the drive surface", "m")
    tip_wear_rate: float = number("specific wear of the tip's coating", "m^2/N", closed=True)
    impact_loss: float = number("alpha of a coefficient of restitution 1 - alpha v", "s/m", closed=True)


@dataclass(frozen=True)
class Bearing:
    """The sliding bearing: PTFE film on silicon carbide."""

    static_friction: float = number("coefficient of the run-in film", high=1)
    dynamic_friction: float = number("coefficient of the run-in film", high=1)
    static_friction_low: float = number("least after running in", high=1)
    static_friction_high: float = number("most after running in", high=1)
    dynamic_friction_low: float = number("least after running in", high=1)
    dynamic_friction_high: float = number("most after running in", high=1)
    film_thickness: float = number("of the PTFE on the pads", "m")
    way_roughness: float = number("Ra of the lapped way as drawn", "m")
    proposed_way_roughness: float = number("Ra needed for the required smoothness", "m")
    way_straightness: float = number("of the lapped way over its length", "m")
    roughness_correlation: float = number("length over which the way's roughness is correlated", "m")
    way_waviness: float = number("amplitude of the lapped way's waves", "m", closed=True)
    waviness_length: float = number("of the lapped way's waves", "m")
    allowable_pressure: float = number("on the PTFE film", "Pa")
    allowable_pv: float = number("pressure times speed of the film", "W/m^2")
    thickest_film: float = number("that sheds its heat into the stage", "m")
    film_conductivity: float = number("thermal, of the PTFE", "W/m/K")
    film_warming: float = number("that the film bears by its own heat at full speed", "K")
    wear_rate: float = number("specific wear of the run-in film", "m^2/N")
    run_in_wear_rate: float = number("specific wear of the fresh film, mean over running in", "m^2/N")
    run_in_cycles: int = count("strokes there and back until the film is run in", high=1000000)
    life: float = number("distance the film must last", "m")
    heat_limit: float = number("that the stage sheds", "W")
    stribeck_velocity: float = number("at which static has mostly fallen to dynamic friction", "m/s")
    presliding_distance: float = number("from rest to full slip", "m")
    damping_ratio: float = number("of the stage on its pads' film, up and along", closed=True, high=1)


@dataclass(frozen=True)
class Friction:
    """Values of the thesis's friction simulations."""

    mass: float = number("of the body simulated", "kg")
    bristle_stiffness: float = number("a0", "N/m")
    bristle_damping: float = number("a1", "N*s/m", closed=True)
    viscous: float = number("a2", "N*s/m", closed=True)
    coulomb: float = number("Fc: kinetic friction", "N")
    breakaway: float = number("Fs: static friction", "N")
    stribeck_velocity: float = number("vs", "m/s")
    dwell_rate: float = number("gamma of Kato's rising static friction, time in seconds")
    dwell_exponent: float = number("m of Kato's rising static friction")
    lag_low: float = number("least frictional memory", "s")
    lag_high: float = number("greatest frictional memory", "s")


@dataclass(frozen=True)
class Preload:
    """Force that holds the stage on its ways in addition to its weight."""

    force: float = number("", "N", closed=True)
    ratio: float = number("required, of the preload to the applied load", closed=True)


@dataclass(frozen=True)
class Payload:
    """The payload of the stage."""

    mass: float = number("", "kg", closed=True)
    height: float = mm("of its centre of mass above the payload face", zero=True)
    cable_force: float = number("change over the travel of the force of its cables", "N", closed=True)


@dataclass(frozen=True)
class EndStop:
    """Buffers at either end of the travel, on stop bars, which the tooth irons run against."""

    count: int = count("buffers at either end; none without end stops", low=0, high=4)
    stiffness: float = number("of one buffer", "N/m")
    compression: float = mm("largest of a buffer")
    gap: float = mm("from the end of the travel to the buffer", zero=True)
    height: float = number("of the buffers over the drive surface", "m", low=-0.1)


@dataclass(frozen=True)
class Leads:
    """Leads of the piezos, and the clips that hold them at the base."""

    pull: float = number("on a lead from outside", "N", closed=True)
    allowed: float = number("that a piezo's soldered lead bears", "N")
    clip: float = number("pull that a clip holds; 0 without clips", "N", closed=True)


@dataclass(frozen=True)
class Lvdt:
    """Coarse position sensor."""

    range: float = number("from end to end", "m")
    output_span: float = number("of its voltage over the range", "V")
    bits: int = count("of the converter", high=32)
    linearity: float = number("over the range", high=1)
    bandwidth: float = number("", "Hz")
    contactless: bool = switch("whether it lets the stage move across its axis")


@dataclass(frozen=True)
class CapacitiveProbe:
    """Fine position sensor."""

    range: float = number("", "m")
    linearity: float = number("over the range", high=1)
    bandwidth: float = number("", "Hz")
    resolution: float = number("at that bandwidth", "m")


@dataclass(frozen=True)
class FilteredProbe:
    """The fine sensor behind filter, gain and converter."""

    filter_frequency: float = number("corner of the RC filter", "Hz")
    gain: float = number("")
    bits: int = count("of the converter", high=32)
    claimed_resolution: float = number("", "m")


@dataclass(frozen=True)
class Interferometer:
    """Long-range position sensor."""

    resolution: float = number("of position", "m")
    angular_resolution: float = number("", "rad")
    contactless: bool = switch("whether it lets the stage move across its axis")
    highest_speed: float = number("", "m/s")
    misalignment: float = number("of its beam to the travel", "rad", closed=True)
    range: float = number("to either side", "m")
    dead_path: float = number("of the beam before the travel begins", "m", closed=True)


@dataclass(frozen=True)
class Sensors:
    """Position sensors considered."""

    lvdt: Lvdt
    probe: CapacitiveProbe
    filtered_probe: FilteredProbe
    interferometer: Interferometer


@dataclass(frozen=True)
class Requirements:
    """Requirements on the machine: Tables 1 and 2."""

    resolution: float = number("finest required", "m")
    resolution_coarse: float = number("coarsest required", "m")
    travel: float = number("", "m")
    speed: float = number("", "m/s")
    acceleration_low: float = number("smallest required", "m/s^2")
    acceleration: float = number("largest required", "m/s^2")
    smoothness: float = number("normal to the motion", "m")
    straightness: float = number("of the motion over the travel", "m")
    repeatability: float = number("of the position along the travel", "m")
    sensor_range: float = number("", "m")
    sensor_contactless: bool = switch("for two axes")


@dataclass(frozen=True)
class Environment:
    """Surroundings of the machine."""

    temperature: float = number("", "degC", low=-273.15)
    temperature_change: float = number("that the machine must bear", "K", closed=True)
    pressure_change: float = number("of the air, between two uses of a position", "Pa", closed=True)
    storage_change: float = number("that its joints must bear in store and transport", "K", closed=True)
    floor_velocity: float = number(
        "of the floor's vibration, rms in each third octave of 8 to 80 Hz", "m/s", closed=True
    )
    air_time: float = number("constant of the changes of the air's temperature and pressure", "s")
    part_time: float = number("constant with which base and stage follow the air", "s")
    gravity: float = number("", "m/s^2")


@dataclass(frozen=True)
class Loop:
    """The loop that holds a position with the tip at rest on the drive surface."""

    crossover: float = number("of the integral controller", "Hz")
    sample_rate: float = number("of the controller", "Hz")
    observation: float = number("over which the position is held; slower changes count as drift", "s")
    settling: float = number("permitted from the end of a move until the position is held", "s")


@dataclass(frozen=True)
class Heat:
    """Flow of the stacks' heat, and the duty that causes it."""

    conductivity: float = number("thermal, of the stacks' ceramic", "W/m/K", default="1.1 W/m/K")
    joint_conductance: float = number("of the bond at either end of a stack", "W/m^2/K", default="2000 W/m^2/K")
    air_conductivity: float = number("thermal, of the air in bores and pocket", "W/m/K", default="0.026 W/m/K")
    convection: float = number("to the surroundings, from tip and base", "W/m^2/K", default="10 W/m^2/K")
    capacity: float = number("of a volume of metal or ceramic", "J/m^3/K", default="3.5e6 J/m^3/K")
    moving: float = number("at full speed in each period of the duty", "s", default="1 s")
    period: float = number("of the duty", "s", default="10 s")
    highest_rise: float = number("of the stacks' temperature that they bear", "K", default="60 K")


@dataclass(frozen=True)
class Material:
    """Properties at room temperature."""

    description: str = text("in the order")
    density: float = number("", "kg/m^3")
    youngs_modulus: float = number("", "Pa")
    poisson_ratio: float = number("", low=-1.0, high=0.5)
    expansion: float = number("coefficient of thermal expansion", "1/K", low=-math.inf)
    strength: float = number("yield or fracture stress, by its kind", "Pa")
    strength_kind: str = choice("meaning of the strength", "yield", "fracture")
    magnetic: bool = switch("whether a magnet attracts it")
    treatment: str = text("heat treatment of a part made of it, for the title block", default="none")
    coating: str = text("that grows from it, as `anodised` of aluminium; of others no sheet says so", default="none")


@dataclass(frozen=True)
class Drawing:
    """Title block entries of every sheet."""

    title: str = text("of the machine")
    tolerance_x: float = mm("of a dimension without decimals")
    tolerance_x_x: float = mm("of a dimension with one decimal")
    tolerance_x_xx: float = mm("of a dimension with two decimals")
    tolerance_angle: float = number("of an angle", "deg", high=10.0)
    file_tip: str = text("file name in the title block")
    file_holder: str = text("file name in the title block")
    file_stage: str = text("file name in the title block")
    file_bearing_way: str = text("file name in the title block")
    file_base: str = text("file name in the title block")
    file_height_pin_1: str = text("file name in the title block")
    file_height_pin_2: str = text("file name in the title block")
    file_magnet: str = text("file name in the title block")
    file_tooth_iron: str = text("file name in the title block")
    file_tooth_bar: str = text("file name in the title block")
    file_stop_bar: str = text("file name in the title block", default="THS_STG_STOP")
    file_sensor_bracket: str = text("file name in the title block", default="THS_STG_BRACKET")
    file_assembly: str = text("file name in the title block")
    file_procedure: str = text("file name in the title block")
    roughness: float = number("Ra of faces without a mark of their own", "m")
    hole_position: float = mm("diameter of the position tolerance of screw holes", default="0.2 mm")
    function_position: float = mm("diameter of the position tolerance of bores and pins", default="0.05 mm")
    fit_roughness: float = number("Ra of bores and shanks with a class of ISO 286", "m", default="0.8 um")
    wedge_angularity: float = mm("width of the angularity tolerance of the height wedges", default="0.005 mm")
    company: str = text("in the title block", default="-")
    revision: str = text("letter or number in the title block", default="A")
    date: str = text("of issue in the title block", default="-")
    drawn: str = text("name in the title block", default="stagecad")
    checked: str = text("name in the title block", default="-")
    approved: str = text("name in the title block", default="-")
    edges: str = text("state of edges without indication, by ISO 13715", default="outside -0.3, inside +0.3")


@dataclass(frozen=True)
class AirBearing:
    """Porous air bearing, by one point of its catalogue."""

    diameter: float = mm("of the porous face")
    height: float = mm("of the pad")
    gap: float = number("flying height of the catalogue point", "m")
    load: float = number("at that gap", "N")
    stiffness: float = number("at that gap", "N/m")
    supply: float = number("pressure above the atmosphere", "Pa")
    averaging: float = number("error of motion over flying height")
    repeatability: float = number("normal to the motion", "m")
    cost_rank: int = count("place by cost, 1 the cheapest", high=10)


@dataclass(frozen=True)
class BallSpring:
    """Balls on springs."""

    small_diameter: float = mm("the smaller ball")
    large_diameter: float = mm("the larger ball")
    stated_stiffness: float = number("of one large ball, as stated", "N/m")
    stated_pressure: float = number("under one small ball, as stated", "Pa")
    roundness: float = number("deviation from a sphere", "m")
    repeatability: float = number("normal to the motion", "m")
    rolling_friction: float = number("coefficient")
    cost_rank: int = count("place by cost, 1 the cheapest", high=10)


@dataclass(frozen=True)
class MagneticLevitation:
    """Passive levitation by repelling magnets."""

    pitch: float = mm("of the magnets on the base")
    moment: float = number("of a magnet", "A*m^2")
    flying_height: float = mm("of the stage's magnet over those of the base")
    cost_rank: int = count("place by cost, 1 the cheapest", high=10)


@dataclass(frozen=True)
class SlidingPads:
    """The sliding pads themselves, where the ranking needs more than their own tables say."""

    repeatability: float = number("normal to the motion", "m")
    cost_rank: int = count("place by cost, 1 the cheapest", high=10)


@dataclass(frozen=True)
class Candidates:
    """The suspensions that were compared."""

    sliding_pads: SlidingPads
    air_bearing: AirBearing
    ball_spring: BallSpring
    magnetic_levitation: MagneticLevitation
