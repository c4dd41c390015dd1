"""Purchased parts of one simple solid each. Lengths in millimetres; threads are cosmetic.

Part coordinates of each: origin in the middle of the face at its lower end, z out of the material beyond its other end.
"""

from __future__ import annotations

import itertools
import math

from stagecad.friction_stage.design import Design
from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DOWN, X, Z, named
from stagecad.solids.modelling.holes import OVERRUN, cut_all, drilled, plate, revolved
from stagecad.solids.modelling.kernel import cq

ORIGIN = (0.0, 0.0, 0.0)


def ends(lower: str, upper: str, length: float) -> dict[str, Datum]:
    """Datums of both ends on the z axis, normals out of the material."""
    return named(Datum(lower, ORIGIN, DOWN, X), Datum(upper, (0.0, 0.0, length), Z, X))


class Buffer:
    """Buffer of an end stop: a block of polyurethane, cut from strip and bonded to the nose of a stop bar.

    x along its width, y along its height; the origin is in the bonded face.
    """

    @staticmethod
    def build(design: Design) -> cq.Solid:
        buffer = design.buffer
        return plate(ORIGIN, buffer.width, buffer.height, buffer.length)

    @staticmethod
    def datums(design: Design) -> dict[str, Datum]:
        return ends("seat", "face", design.buffer.length)


class Interferometer:
    """The optics that measure the position of the mirror on the stage; a spacer below sets the height of the beam.

    Origin on the underside at the front, in the middle of the width; x along the beam, away from the mirror, y across,
    z up.
    """

    @staticmethod
    def build(design: Design) -> cq.Solid:
        optics = design.interferometer
        return plate((optics.length / 2, 0.0, 0.0), optics.length, optics.width, optics.height)

    @staticmethod
    def datums(design: Design) -> dict[str, Datum]:
        beam = (0.0, 0.0, design.interferometer.beam_height)
        return named(Datum("seat", ORIGIN, DOWN, X), Datum("beam", beam, (-1.0, 0.0, 0.0), Z))


class LeadClip:
    """A slotted block of silicone rubber, bonded into the end of a lead channel, that holds the leads.

    x along the channel, which the block fills, z up; the slot is open at the top.
    """

    @staticmethod
    def build(design: Design) -> cq.Solid:
        clip, deep = design.lead_clip, design.base.lead_channel_depth
        block = plate(ORIGIN, clip.length, design.base.lead_channel_width, deep)
        floor = (0.0, 0.0, deep - clip.slot_depth)
        return cut_all(block, [plate(floor, clip.length + 2 * OVERRUN, clip.slot_width, clip.slot_depth + OVERRUN)])

    @staticmethod
    def datums(design: Design) -> dict[str, Datum]:
        return named(Datum("seat", ORIGIN, DOWN, X))


class Mirror:
    """Plane mirror of the interferometer, on the target holes in an end face of the stage.

    Origin in the face against the stage, x along its width, y upright. Its mass is a part of the payload's
    (`payload.mass`).
    """

    @staticmethod
    def build(design: Design) -> cq.Solid:
        """A block with a clearance hole at either target hole."""
        mirror = design.mirror
        half, through = design.stage.target_spacing / 2, (mirror.screw_hole, mirror.thickness + OVERRUN)
        block = plate(ORIGIN, mirror.width, mirror.height, mirror.thickness)
        return cut_all(block, drilled([(-half, 0.0), (half, 0.0)], mirror.thickness, through))

    @staticmethod
    def datums(design: Design) -> dict[str, Datum]:
        return ends("seat", "face", design.mirror.thickness)


class Piezo:
    """Piezo stack in the holder, which lifts one arm of the tip.

    Origin in its flat foot, apex of its rounded end at z = length. The end is a piece of a sphere, so that the tip's
    seat meets it in one place and does not bend the stack.
    """

    @staticmethod
    def build(design: Design) -> cq.Solid:
        """A cylinder with a chamfered foot and a spherical end, turned from one outline."""
        piezo = design.piezo
        radius, length, crown = piezo.diameter / 2, piezo.length, piezo.end_radius
        shoulder = length - crown + math.sqrt(crown**2 - radius**2)
        middle = math.asin(radius / crown) / 2
        foot = 0.04 * piezo.diameter
        outline = cq.Workplane("XZ").polyline([(0.0, 0.0), (radius - foot, 0.0), (radius, foot), (radius, shoulder)])
        arc = (crown * math.sin(middle), length - crown * (1.0 - math.cos(middle)))
        return revolved(outline.threePointArc(arc, (0.0, length)).close())

    @staticmethod
    def datums(design: Design) -> dict[str, Datum]:
        return ends("foot", "end", design.piezo.length)


class Spring:
    """Compression spring that holds height pin 1 against its set screw, at installed length.

    Axis along z, one end at z = 0, the other at the installed length.
    """

    @staticmethod
    def build(design: Design, compression: float = 0.0) -> cq.Solid:
        """Half turns of a torus that join without a kink; the first and last lie flat, as closed ends do.

        Each half turn is a semicircle in a plane through the y direction, so that at its ends, which lie over the x
        axis, the wire of one and of the next run parallel to y. Torus faces keep the solid small, and its volume has a
        closed form: wire section times the length of the semicircles. `compression`, mm, is counted from the middle of
        the height adjustment.
        """
        spring = design.spring
        length = spring.installed_length - compression
        wire = spring.wire_diameter / 2
        halves = 2 * round(spring.coils)
        rise = (length - 2 * wire) / halves
        reach = spring.outer_diameter / 2 - wire
        side = math.sqrt(reach**2 - (rise / 2) ** 2)
        heights = [wire + rise * index for index in range(halves + 1)]
        edges = []
        for index, (low, high) in enumerate(itertools.pairwise([heights[0], *heights, heights[-1]])):
            sign = 1 if index % 2 == 0 else -1
            edges.append(
                cq.Edge.makeThreePointArc(
                    cq.Vector(sign * side, 0.0, low),
                    cq.Vector(0.0, sign * (reach if high > low else side), (low + high) / 2),
                    cq.Vector(-sign * side, 0.0, high),
                )
            )
        circle = cq.Wire.makeCircle(wire, cq.Vector(side, 0.0, heights[0]), cq.Vector(0.0, 1.0, 0.0))
        return cq.Solid.sweep(circle, [], cq.Wire.assembleEdges(edges), True, True).Solids()[0]

    @staticmethod
    def datums(design: Design) -> dict[str, Datum]:
        return ends("end_1", "end_2", design.spring.installed_length)


PARTS = {
    "buffer": Buffer,
    "interferometer": Interferometer,
    "lead_clip": LeadClip,
    "mirror": Mirror,
    "piezo": Piezo,
    "spring": Spring,
}
