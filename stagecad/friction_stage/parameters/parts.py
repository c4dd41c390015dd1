"""Tables of the parts that are made from a drawing and of purchased ones. Lengths in millimetres, angles in degrees."""

from dataclasses import dataclass
from typing import Any

from stagecad.parameters.project_tables import NO_ROW
from stagecad.parameters.schema import choice, count, mm, number, of_material, switch, text


@dataclass(frozen=True)
class Stage:
    """The plate that slides, is driven from below, and carries the payload."""

    material: str = of_material()
    length: float = mm("along the travel")
    width: float = mm("across the travel")
    thickness: float = mm("from the drive surface to the payload face")
    travel: float = mm("from end to end")
    damping_ratio: float = number("of its bending", closed=True, high=1)
    corner_radius: float = mm("of the upright corners")
    edge_chamfer: float = mm("of the rim")
    hole_chamfer: float = mm("at the mouth of every hole")
    payload_columns: int = count("of payload holes along the travel", low=2)
    payload_rows: int = count("of payload holes across the travel", low=2)
    payload_pitch: float = mm("between payload holes")
    payload_floor: float = mm("left under the full diameter of a payload hole")
    payload_drill_depth: float = mm("of the payload holes' full diameter", computed=True)
    payload_thread_depth: float = mm("of the payload holes' full thread", computed=True)
    dowel_diameter: float = mm("of the reamed holes that place a payload")
    dowel_spacing: float = mm("between the dowel holes, along the travel")
    dowel_offset: float = mm("of the dowel holes from the middle, across", zero=True)
    target_spacing: float = mm("between the sensor target's holes in each end face")
    target_drill_depth: float = mm("of the target holes' full diameter")
    target_thread_depth: float = mm("of the target holes' full thread")
    iron_pocket_length: float = mm("of the pocket for the tooth irons, along the travel")
    iron_pocket_width: float = mm("of the pocket for irons and magnet, across", computed=True)
    iron_pocket_clearance: float = mm("of irons and magnet in their pocket")
    iron_pocket_depth: float = mm("from the drive surface to the seat of the irons")
    iron_pocket_corner: float = mm("radius the cutter leaves in the pocket's corners")


@dataclass(frozen=True)
class Pads:
    """The crowned pads under the stage that slide on the ways."""

    count: int = count("of pads: three do not over-constrain, four suit a gravity preload", low=3, high=4)
    length: float = mm("of a pad along the travel")
    width: float = mm("of a pad across the travel")
    height: float = mm("of a pad's crown below the drive surface")
    crown_radius: float = mm("of the pads' convex faces")
    corner_radius: float = mm("of the pads' upright corners")
    root_fillet: float = mm("at the transition from pad to stage")
    spacing_along: float = mm("between the pads on one way")
    spacing_across: float = mm("between the pads of the two ways")
    sag_tolerance: float = mm("of the crown's height over its chord, either way", default="0.005 mm")
    roughness: float = number("Ra of the crowns under their film", "m", default="0.4 um")
    ratio: float = number("of a pad's length to its width")
    ratio_deviation: float = number("of that ratio that is still accepted", high=1)


@dataclass(frozen=True)
class DriveSurface:
    """The strip of the stage's underside on which the tip drives."""

    width: float = mm("across the travel")
    groove_width: float = mm("of the grooves that bound it")
    groove_depth: float = mm("of the grooves that bound it")
    whole_underside: bool = switch("two axes: the whole underside is drive surface")
    contact_margin: float = mm("of drive surface that must remain beyond the tip at the ends of the travel")


@dataclass(frozen=True)
class BearingWay:
    """The silicon carbide rails on which the pads slide; two of one kind."""

    material: str = of_material()
    length: float = mm("along the travel")
    width: float = mm("across the travel")
    height: float = mm("from bed to lapped face")
    ledge_width: float = mm("of the outer ledge that takes the screw heads")
    ledge_fillet: float = mm("at the root of the ledge")
    flange_thickness: float = mm("of the ledge under the screw heads")
    bolt_spacing: float = mm("between screws")
    bolt_edge: float = mm("of the screws' row from the outer edge")
    bolt_end: float = mm("least distance of the last screw from the way's end")
    bolt_count: int = count("of screws in a way: as many as fit at the spacing", low=2, computed=True)
    bolt_hole: float = mm("clearance hole of the screws")
    edge_chamfer: float = mm("of outer edges")
    hole_chamfer: float = mm("at the mouth of the holes")
    pair_tolerance: float = mm("of the heights of a pair to each other", default="0.002 mm")
    joint_ratio: float = number("stiffness of the bedded joint over that of the bolt joint")
    wanted_stiffness: float = number("of one way at its loaded edge", "N/m")


@dataclass(frozen=True)
class Base:
    """The block that houses the actuators and carries the ways."""

    material: str = of_material()
    length: float = mm("along the travel")
    width: float = mm("across the travel: flush with the ways' outer edges", computed=True)
    height: float = mm("from underside to the seats of the ways")
    seat_height: float = mm("of the seats of the ways over the rest of the top", default="1 mm")
    seat_gap: float = mm("between the seats of the ways", computed=True)
    seat_overhang: float = mm("of the ways beyond their seats, at their inner edges", default="1 mm")
    edge_chamfer: float = mm("of outer edges")
    hole_chamfer: float = mm("at the mouth of the holes")
    way_gap: float = mm("between the inner edges of the ways")
    way_drill_depth: float = mm("of the way screws' holes, full diameter")
    way_thread_depth: float = mm("of the way screws' full thread")
    setting_pin_hole: float = mm("reamed holes for the pins against which a way is set")
    setting_pin_depth: float = mm("of the setting-pin holes")
    setting_pin_spacing: float = mm("between the setting-pin holes of a way")
    actuator_spacing: float = mm("between the axes of the actuators, an equilateral triangle")
    pocket_diameter: float = mm("of the pockets for the holders")
    pocket_clearance: float = mm("between holder and pocket floor, for the height adjustment")
    pocket_depth: float = mm("of the pockets' floors below the seats", computed=True)
    pocket_bore: float = mm("depth of the pockets from the face they start in", computed=True)
    pocket_chamfer: float = mm("at the mouth of the pockets")
    pin_2_bore: float = mm("vertical guide of height pin 2")
    pin_1_bore: float = mm("horizontal guide of height pin 1")
    pin_1_axis_depth: float = mm("of the axis of height pin 1 below the seats", computed=True)
    pin_1_bore_end: float = mm("of the bore beyond the actuator's axis, where the spring rests")
    set_screw_thread_start: float = mm("outer end of the set screw's thread, from the actuator's axis")
    set_screw_thread_end: float = mm("inner end of the set screw's thread, from the actuator's axis")
    set_screw_access: float = mm("bore from the side face for the wrench")
    vent_hole: float = mm("from the underside into the blind end of the bore")
    clamp_screw_depth: float = mm("of the clamp screws' axes below the seats")
    clamp_screw_offset: float = mm("of a clamp screw's axis from its pocket's, across")
    clamp_counterbore: float = mm("diameter for the clamp screw's head")
    clamp_counterbore_depth: float = mm("for the clamp screw's head")
    clamp_hole: float = mm("clearance hole of the clamp screws")
    clamp_thread_depth: float = mm("of the drilled hole in the lug, from the slot")
    clamp_slot_width: float = mm("of the slots that free a clamp's finger")
    clamp_slot_1: float = mm("of the gap slot of pocket 1 from its axis")
    clamp_slot_2: float = mm("of the gap slots of pockets 2 and 3 from their axes")
    clamp_reach: float = mm("of the slots from the pocket's axis, across")
    clamp_lug: float = mm("width of the lug that holds the clamp screw's thread")
    clamp_neck: float = mm("thickness of the flexure on which the finger turns")
    clamp_relief_hole: float = mm("at the end of the relief slot, next to the neck")
    clamp_neck_angle_1: float = number("of the neck about pocket 1, from the way to the screw's head", "deg", high=180)
    clamp_neck_angle_2: float = number("of the necks about pockets 2 and 3, likewise", "deg", high=180)
    clamp_floor_slot: float = mm("of the arc slot that parts finger and floor")
    clamp_friction: float = number("coefficient between holder and pocket", high=1)
    lead_channel_width: float = mm("of the channels for the piezos' leads")
    lead_channel_depth: float = mm("of the channels for the piezos' leads")
    bar_drill_depth: float = mm("of the tooth bars' screw holes, full diameter")
    bar_thread_depth: float = mm("of the tooth bars' screw holes, full thread")
    foot_spacing_along: float = mm("between the feet, along the travel")
    foot_spacing_across: float = mm("between the feet, across")
    foot_drill_depth: float = mm("of the foot holes' full diameter")
    foot_thread_depth: float = mm("of the foot holes' full thread")
    lift_spacing_along: float = mm("between the lifting holes, along the travel")
    lift_spacing_across: float = mm("between the lifting holes, across")
    lift_drill_depth: float = mm("of the lifting holes' full diameter")
    lift_thread_depth: float = mm("of the lifting holes' full thread")
    bracket_spacing_along: float = mm("between the stop bars' holes, along the travel")
    bracket_spacing_across: float = mm("between the stop bars' holes, across")
    bracket_drill_depth: float = mm("of the bracket holes' full diameter")
    bracket_thread_depth: float = mm("of the bracket holes' full thread")


@dataclass(frozen=True)
class Tip:
    """The spider on three piezos whose nose drives the stage."""

    material: str = of_material()
    coating_material: str = of_material("of the friction coating on the nose")
    coating_thickness: float = mm("of the friction coating on the nose")
    arm_width: float = mm("of the three arms")
    arm_thickness: float = mm("of the three arms")
    foot_diameter: float = mm("of the bosses over the piezos")
    seat_diameter: float = mm("of the recess for a piezo's end")
    seat_depth: float = mm("of the recess for a piezo's end")
    hub_diameter: float = mm("of the hub in which the arms meet")
    cone_diameter: float = mm("of the cone at its root")
    cone_fillet: float = mm("at the root of the cone")
    nose_radius: float = mm("of the spherical nose")
    nose_diameter: float = mm("of the cone where the nose begins")
    relief_diameter: float = mm("of the bore that lightens the hub")
    relief_cover: float = mm("of the apex above the bore that lightens the hub, from its full diameter's end")
    relief_depth: float = mm("of the bore that lightens the hub", computed=True)
    root_fillet: float = mm("where arms meet hub and feet")
    edge_chamfer: float = mm("of edges")
    mass_limit: float = number("the most the tip may weigh", "kg")


@dataclass(frozen=True)
class Holder:
    """The cylinder that holds three piezos upright and takes their side load."""

    material: str = of_material()
    diameter: float = mm("outside")
    height: float = mm("overall")
    bore_diameter: float = mm("of the piezos' bores")
    floor: float = mm("under the piezos")
    ejector_hole: float = mm("through the floor under each piezo")
    well_diameter: float = mm("of the well in the middle for the leads")
    lead_slot_width: float = mm("from each bore into the well")
    clamp_height: float = mm("of the piezos' set screws above the bottom")
    lift_radius: float = mm("of the circle of lifting holes")
    lift_drill_depth: float = mm("of the lifting holes' full diameter")
    lift_thread_depth: float = mm("of the lifting holes' full thread")
    index_width: float = mm("of the notch that lines the piezos up")
    index_depth: float = mm("of the notch that lines the piezos up")
    edge_chamfer: float = mm("of both ends")
    bore_chamfer: float = mm("at the mouth of the bores")


@dataclass(frozen=True)
class HeightPin1:
    """The horizontal wedge pin, pushed by the set screw against the spring."""

    material: str = of_material()
    diameter: float = mm("of the pin")
    length: float = mm("of the pin")
    slope: float = number("of the wedge's flat: rise over run", high=1)
    stroke: float = mm("along its axis that the height adjustment uses")
    friction: float = number("coefficient of its sliding faces, greased, low end", high=2)
    friction_dry: float = number("the same run dry, high end", high=2)
    flat_height: float = mm("of the wedge's flat above the axis, at mid-length")
    spigot_diameter: float = mm("of the spigot that guides the spring")
    spigot_length: float = mm("of the spigot that guides the spring")
    withdrawal_drill_depth: float = mm("of the tapped hole by which the pin is pulled out, full diameter")
    withdrawal_thread_depth: float = mm("of the tapped hole by which the pin is pulled out, full thread")
    end_chamfer: float = mm("of both ends")
    coating_thickness: float = mm("of the hard anodic layer of both height pins", default="0.02 mm")


@dataclass(frozen=True)
class HeightPin2:
    """The vertical pin that carries the holder on the wedge."""

    material: str = of_material()
    diameter: float = mm("of the pin")
    length: float = mm("along its axis, from the wedge's face to the top")
    crown_radius: float = mm("of the domed top under the holder")
    sag_tolerance: float = mm("of the crown's height over its chord, either way", default="0.02 mm")
    end_chamfer: float = mm("of both ends")


@dataclass(frozen=True)
class ToothBar:
    """The stationary toothed iron on the base; two of one kind."""

    material: str = of_material()
    length: float = mm("along the travel")
    height: float = mm("from the base to the tooth crests", computed=True)
    end_length: float = mm("of the low ends that take the screws")
    end_height: float = mm("of the low ends that take the screws")
    foot_width: float = mm("of the low ends, across")
    relief: float = mm("of the bar's underside between its feet")
    root_fillet: float = mm("where the low ends meet the bar")
    screw_hole: float = mm("clearance hole of the bar's screws")
    screw_span: float = mm("between the screws of both ends, along")
    screw_spacing: float = mm("between the two screws of an end, across")
    channel_depth: float = mm("of the channel under the magnet, from the crests; as wide as the magnet")
    edge_chamfer: float = mm("of edges")


@dataclass(frozen=True)
class StopBar:
    """The angle at either end of the base that carries the buffers of the end stops."""

    material: str = of_material()
    length: float = mm("across the travel", computed=True)
    height: float = mm("from the base to the upper edge of the buffers", computed=True)
    grip: float = mm("from the base to the heads of its screws")
    reach: float = mm("from the axes of its screws to the buffers, towards the stage", computed=True)
    foot: float = mm("from the axes of its screws to the end of the foot, towards the stage")
    overhang: float = mm("from the axes of its screws to its back")
    relief: float = mm("of the underside of the nose over the base")
    screw_hole: float = mm("clearance hole of its screws")
    counterbore: float = mm("diameter for the heads of its screws")
    sensor_spacing: float = mm("between the tapped holes for the sensor bracket")
    sensor_depth: float = mm("of these holes below the top")
    sensor_drill_depth: float = mm("of these holes, full diameter")
    sensor_thread_depth: float = mm("of these holes, full thread")


@dataclass(frozen=True)
class SensorBracket:
    """The angle on a stop bar that carries the interferometer."""

    material: str = of_material()
    length: float = mm("from the stop bar to the end of the arm")
    width: float = mm("across the travel")
    thickness: float = mm("of the arm")
    flange: float = mm("thickness of the flange")
    rise: float = mm("of the flange over the axes of its screws")
    optics: float = mm("from the stop bar to the first screw of the interferometer", computed=True)
    drop: float = mm("of the arm's top below the axes of the flange's screws", computed=True)
    screw_hole: float = mm("clearance hole of the flange's screws")
    optics_hole: float = mm("clearance hole of the interferometer's screws")


@dataclass(frozen=True)
class ToothIron:
    """The toothed iron under the stage; two to a pocket, a magnet between them."""

    material: str = of_material()
    length: float = mm("along the travel")
    height: float = mm("from its seat to the tooth crests")
    corner_radius: float = mm("of the upright corners, larger than the pocket's")
    edge_chamfer: float = mm("of edges")


@dataclass(frozen=True)
class Magnet:
    """The permanent magnet between two tooth irons, magnetised across the travel."""

    material: str = of_material()
    length: float = mm("along the travel")
    thickness: float = mm("across the travel, the way it is magnetised")
    height: float = mm("upright")
    edge_chamfer: float = mm("of edges")
    remanence: float = number("of the magnet's material", "T")
    recoil_permeability: float = number("relative", low=1.0, closed=True)


@dataclass(frozen=True)
class Teeth:
    """The magnetic teeth that preload and align the stage."""

    fitted: bool = switch("whether the machine has magnets and teeth (two axes: none)")
    pitch: float = mm("of the teeth, across the travel")
    width: float = mm("of a tooth")
    gap: float = mm("between the crests of stage and base")
    gap_tolerance: float = mm("of the gap, either way, that the preload admits", default="0.1 mm")
    groove_depth: float = mm("between teeth")
    per_iron: int = count("teeth on one iron of the stage")
    bar_spacing: float = mm("between the two bars")
    saturation: float = number("flux density at which the iron saturates", "T")
    profile: str = choice("of the teeth", "square")


@dataclass(frozen=True)
class Making:
    """Manufacturing data common to all parts."""

    least_wall: float = mm("of material around a hole, pocket or edge")
    least_floor: float = mm("left under the drill's point of a blind hole")
    engagement: float = number("least length of engaged thread over the screw's diameter")
    largest_fit: float = mm("clearance that still guides a pin or holder")
    slot_depth_ratio: float = number("greatest depth of a milled slot over its width", default="6")
    bore_depth_ratio: float = number("greatest depth of a bore over its diameter", default="15")


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
