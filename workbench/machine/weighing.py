"""What checks want to know of the solids, weighed on those parts alone: the rest of the machine need not be made."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from designcalc.checks import Weighed
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import MassProperties


def weigh(design: Design) -> Weighed:
    """Moving body and tip as the checks take them, SI."""
    from designcalc.checks import Weighed

    return Weighed(*moving_and_tip(design))


def moving_and_tip(design: Design) -> tuple[MassProperties, MassProperties]:
    """Moving body (stage with irons and magnets, at mid-travel) and tip, SI.

    The solids come from the cache or are made now; with the pads on the ways the riders' places follow from the
    stage's own datums. Equal to what `Machine` has of the whole assembly.
    """
    from stagecad.parameters.dimension import Datum
    from stagecad.parameters.mass_properties import combined
    from stagecad.solids.artefacts.part import make_part
    from stagecad.solids.artefacts.store import Store
    from stagecad.solids.assembly.machine import part_mass
    from stagecad.solids.assembly.mass import placed
    from stagecad.solids.modelling.frame import UNMOVED, mate

    riders = ("tooth_iron", "magnet") if design.teeth.fitted else ()
    store = Store()
    # One after another: other processes for so few parts cost more than they save, and a cluster's may start none.
    parts = {name: make_part(store, name, design) for name in ("stage", "tip", *riders)}
    plane = Datum("pads", (0.0, 0.0, design.bearing_way.height), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    stage = parts["stage"]
    frame = mate(stage.datums["pads"], UNMOVED, plane)
    bodies = [placed(part_mass(stage, design), frame)]
    for rider in riders:
        mass = part_mass(parts[rider], design)
        for name, seat in stage.datums.items():
            if name.rpartition("_")[0] == rider:
                bodies.append(placed(mass, mate(parts[rider].datums["seat"], frame, seat)))
    return combined(bodies), part_mass(parts["tip"], design)
