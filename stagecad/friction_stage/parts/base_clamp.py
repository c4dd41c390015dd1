"""The clamps of the base: a finger cut out next to each actuator pocket, which one long screw pulls round the holder.

Seen from above, with u along the screw towards its head and v at right angles, both from the pocket's axis:

- a gap slot crosses the screw's line at u = slot place, from the pocket outwards;
- a relief slot continues from its outer end, past the lug that holds the screw's thread, and back to
- a relief hole, which leaves a neck between itself and the pocket: the flexure on which the finger turns;
- below the pocket's floor an arc slot along the pocket's wall parts the finger from the floor.

All go through the whole depth of the base (one set-up of wire or saw), so that the finger bends at its neck alone: a
finger still joined to the floor would be over-stiff. Its free end is drawn along the pocket's tangent, and the finger
lays itself round the holder like a band brake. Arc slots and pocket also let air out as the holder goes in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import Derived, Place
from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.holes import OVERRUN, stepped_hole
from stagecad.solids.modelling.kernel import cq


@dataclass(frozen=True)
class Clamp:
    """Place of one clamp. All lengths in mm, angles in degrees."""

    pocket: int  # number of its pocket, 1 to 3
    centre: Place  # the pocket's axis (x, y)
    head: float  # side of the base the screw's head is on: +1 for +x, -1 for -x
    side: float  # side of the pocket the finger is on: +1 for +y, -1 for -y
    slot: float  # u of the gap slot
    neck: float  # angle of the neck about the pocket, from u, in degrees

    def place(self, u: float, v: float) -> Place:
        """The point (u, v) of the clamp in part coordinates."""
        return (self.centre[0] + self.head * u, self.centre[1] + self.side * v)

    def start_angle(self, radius: float) -> float:
        """Angle from u to the gap slot's crossing with a circle about the pocket, radians."""
        return math.acos(self.slot / radius)

    def relief_hole(self, design: Design) -> Place:
        """Centre of the relief hole, part coordinates."""
        base = design.base
        reach, angle = (base.pocket_diameter + base.clamp_relief_hole) / 2 + base.clamp_neck, math.radians(self.neck)
        return self.place(reach * math.cos(angle), reach * math.sin(angle))


def clamps(design: Design) -> list[Clamp]:
    """The clamps: two at pocket 1 (the 6 inch screws, from +x), one each at 2 and 3 (the 4.5 inch screws, from -x).

    Pocket 1 lies on the plane of symmetry and has a finger on either side, so that clamping does not shift it.
    """
    base, (one, two, three) = design.base, Derived(design).actuator_places
    return [
        Clamp(1, one, 1.0, 1.0, base.clamp_slot_1, base.clamp_neck_angle_1),
        Clamp(1, one, 1.0, -1.0, base.clamp_slot_1, base.clamp_neck_angle_1),
        Clamp(2, two, -1.0, 1.0, -base.clamp_slot_2, base.clamp_neck_angle_2),
        Clamp(3, three, -1.0, -1.0, -base.clamp_slot_2, base.clamp_neck_angle_2),
    ]


def clamp_cutters(design: Design) -> list[cq.Shape]:
    """Cutters of all clamps: slots, relief holes and screw holes."""
    cutters: list[cq.Shape] = []
    for clamp in clamps(design):
        cutters += _slots(design, clamp)
        cutters.append(_screw_hole(design, clamp))
    return cutters


def _slots(design: Design, clamp: Clamp) -> list[cq.Shape]:
    base = design.base
    radius = base.pocket_diameter / 2
    low, depth = -base.height - OVERRUN, base.height + 2 * OVERRUN

    inside = math.sqrt(radius**2 - clamp.slot**2) - 2 * base.clamp_floor_slot
    spine = [
        clamp.place(clamp.slot, inside),
        clamp.place(clamp.slot, base.clamp_reach),
        clamp.place(clamp.slot - base.clamp_lug, base.clamp_reach),
        clamp.relief_hole(design),
    ]
    path = cq.Wire.makePolygon([(x, y, low) for x, y in spine])
    arc_radius = radius - base.clamp_floor_slot / 2
    first, last = clamp.start_angle(arc_radius), math.radians(clamp.neck)
    arc = cq.Edge.makeThreePointArc(
        *(
            cq.Vector(*clamp.place(arc_radius * math.cos(a), arc_radius * math.sin(a)), low)
            for a in (first, (first + last) / 2, last)
        )
    )
    x, y = clamp.relief_hole(design)
    return [
        _slot(path, base.clamp_slot_width, depth),
        _slot(cq.Wire.assembleEdges([arc]), base.clamp_floor_slot, depth),
        cq.Solid.makeCylinder(base.clamp_relief_hole / 2, depth, cq.Vector(x, y, low), cq.Vector(0, 0, 1)),
    ]


def _slot(spine: cq.Wire, width: float, depth: float) -> cq.Solid:
    """A slot of constant width along a flat spine, extruded upwards, its ends and corners round as the tool is."""
    return cq.Solid.extrudeLinear(spine.offset2D(width / 2, "arc")[0], [], cq.Vector(0, 0, depth))


def _screw_hole(design: Design, clamp: Clamp) -> cq.Solid:
    """Counterbore and clearance hole from the side face to the gap slot, then the tapped hole in the lug."""
    base = design.base
    face = clamp.head * base.length / 2
    _, y = clamp.place(0.0, base.clamp_screw_offset)
    to_slot = abs(face - clamp.place(clamp.slot, 0.0)[0])
    steps = (
        (base.clamp_counterbore, base.clamp_counterbore_depth),
        (base.clamp_hole, to_slot),
        (design.threads.unc_3_8_tap_drill, to_slot + base.clamp_slot_width / 2 + base.clamp_thread_depth),
    )
    at, into = (face, y, -base.clamp_screw_depth), (-clamp.head, 0, 0)
    return stepped_hole(at, into, *steps, chamfer=base.hole_chamfer, point=True)


def clamp_datums(design: Design) -> list[Datum]:
    """Seats of the clamp screws' heads: long ones at pocket 1, short ones at 2 and 3.

    A pocket without an actuator keeps its screw too: a free finger would vibrate.
    """
    base, found = design.base, []
    counts = {"clamp_screw_long": 0, "clamp_screw_short": 0}
    for clamp in clamps(design):
        name = "clamp_screw_long" if clamp.pocket == 1 else "clamp_screw_short"
        counts[name] += 1
        seat = clamp.head * (base.length / 2 - base.clamp_counterbore_depth)
        at = (seat, clamp.place(0.0, base.clamp_screw_offset)[1], -base.clamp_screw_depth)
        found.append(Datum(f"{name}_{counts[name]}", at, (clamp.head, 0.0, 0.0), (0.0, 0.0, 1.0)))
    return found
