"""Mass properties of the moving body from its solids alone: the rest of the machine need not be made for them."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import MassProperties


def moving_body_of(design: Design) -> MassProperties:
    """Stage with irons and magnets, in the assembly's coordinates at mid-travel, SI.

    The solids come from the cache or are made now; with the pads on the ways their places follow from the stage's own
    datums. Equal to `Machine.moving_body` of the whole machine.
    """
    from stagecad.parameters.dimension import Datum
    from stagecad.parameters.mass_properties import combined
    from stagecad.solids.cache import Store
    from stagecad.solids.frame import UNMOVED, mate
    from stagecad.solids.machine import part_mass
    from stagecad.solids.made_part import make_parts
    from stagecad.solids.mass import placed

    riders = ("tooth_iron", "magnet") if design.teeth.fitted else ()
    parts = make_parts(Store(), ("stage", *riders), design)
    plane = Datum("pads", (0.0, 0.0, design.bearing_way.height), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    stage = parts["stage"]
    frame = mate(stage.datums["pads"], UNMOVED, plane)
    bodies = [placed(part_mass(stage, design), frame)]
    for rider in riders:
        mass = part_mass(parts[rider], design)
        for name, seat in stage.datums.items():
            if name.rpartition("_")[0] == rider:
                bodies.append(placed(mass, mate(parts[rider].datums["seat"], frame, seat)))
    return combined(bodies)
