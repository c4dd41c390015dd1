"""Bodies of the friction stage that move, their masses, and dimensions measured on the built parts."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from stagecad.friction_stage.parameters.derived import Derived
from stagecad.parameters.dimension import Datum
from stagecad.parameters.mass_properties import BodyMasses, combined
from stagecad.solids.artefacts.part import build_parts, part_mass
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.bill_of_materials import Accessory
from stagecad.solids.modelling.frame import UNMOVED, mate, subtract
from stagecad.solids.modelling.mass import MM, placed

if TYPE_CHECKING:
    from stagecad.friction_stage.design import Design
    from stagecad.solids.assembly.built_machine import BuiltMachine


MOVING = ("stage", "tooth_iron", "magnet")
CARRIED = (*MOVING, "mirror")
"""Parts that move with the stage; the mirror is counted in the mass of the payload."""


@dataclass(frozen=True)
class Measures:
    """Dimensions for checks and simulation, measured on the built parts; SI."""

    pad_area: float  # of all pads together, m^2
    piezo_spacing: float  # D, between the seats of piezos 1 and 2 in the tip, m
    tip_height: float  # h, from those seats to the apex, m
    bolt_spacing: float  # between the first two screws of a way, m
    # way_length, way_width, way_height: of the rail's box, m
    way_length: float
    way_width: float
    way_height: float


def measures(machine: BuiltMachine) -> Measures:
    """The dimensions measured on the built parts."""
    tip, way = machine.parts["tip"].datums, machine.parts["bearing_way"]
    one, two = way.datums["way_screw_1"].origin, way.datums["way_screw_2"].origin
    low, high = way.geometry.bounding_box
    return Measures(
        pad_area=math.fsum(machine.parts["stage"].face_areas.values()) * MM**2,
        piezo_spacing=math.dist(tip["piezo_1"].origin, tip["piezo_2"].origin) * MM,
        tip_height=subtract(tip["apex"].origin, tip["piezo_1"].origin)[2] * MM,
        bolt_spacing=math.dist(one, two) * MM,
        way_length=(high[0] - low[0]) * MM,
        way_width=(high[1] - low[1]) * MM,
        way_height=(high[2] - low[2]) * MM,
    )


def documents(machine: BuiltMachine) -> dict[str, Any]:
    """Mass of the moving body, and the measured dimensions, SI."""
    units = {"pad_area": "m^2"}
    found = asdict(measures(machine))
    assert machine.moving_body is not None
    return {
        "moving_body": machine.moving_body.as_json(),
        "measures": {name: {"value": value, "unit": units.get(name, "m")} for name, value in found.items()},
    }


def machine_masses(machine: BuiltMachine) -> BodyMasses:
    """Mass properties of the moving body and of the tip of a built machine."""
    assert machine.moving_body is not None
    return BodyMasses(machine.moving_body, machine.masses["tip"])


def masses(design: Design) -> BodyMasses:
    """Mass properties of the moving body (stage with irons and magnets, at mid-travel) and of the tip, SI.

    Only the solids of these parts are needed; they come from the cache or are made now. The positions of irons and
    magnets follow from the stage's own datums, so that the result equals that of the whole assembly.
    """
    riders = ("tooth_iron", "magnet") if design.teeth.fitted else ()
    store = ArtefactStore()
    parts = build_parts(store, ("stage", "tip", *riders), design, files=False)
    plane = Datum("pads", (0.0, 0.0, design.bearing_way.height), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    stage = parts["stage"]
    frame = mate(stage.datums["pads"], UNMOVED, plane)
    bodies = [placed(part_mass(stage, design), frame)]
    for rider in riders:
        mass = part_mass(parts[rider], design)
        for name, seat in stage.datums.items():
            if name.rpartition("_")[0] == rider:
                bodies.append(placed(mass, mate(parts[rider].datums["seat"], frame, seat)))
    return BodyMasses(combined(bodies), part_mass(parts["tip"], design))


def accessories(design: Design) -> tuple[Accessory, ...]:
    """The accessories of a design, in the order of their use in the procedure."""
    fitted = int(design.actuator.fitted)
    base, shim = design.base, design.shim
    found = [
        Accessory("eye bolt, for lifting", "M10", 4),
        Accessory("foot", "M10, with lock nut", 3),
        Accessory("setting pin", f"dia. {base.setting_pin_hole:g} h6 x {3 * base.setting_pin_depth:g}", 4),
        Accessory("grease for the height pins", "lithium soap, NLGI 2", 1),
        Accessory("set screw, soft-tipped", "M4x0.7 x 8", 3 * fitted),
        Accessory("pair of leads", f"{design.piezo.highest_voltage:g} V, shielded", 3 * fitted),
        Accessory("adhesive for the tip", "cyanoacrylate gel, soluble in acetone", 1),
        Accessory("lifting screw of the holder", "M4x0.7 x 20", 3),
        Accessory("shim set", f"{1e3 * shim.thinnest:.3g} um to {1e3 * shim.thickest:.3g} um", 1),
        Accessory("PTFE film on the pads", f"{1e6 * design.bearing.film_thickness:g} um, by a coater", 1),
        Accessory("adhesive for the lead clips", "silicone", 1),
    ]
    if design.teeth.fitted:
        found += [
            Accessory("adhesive for irons and magnets", "epoxy, low shrinkage", 1),
            Accessory("jack screw for the irons", "M3x0.5 x 16", 2),
        ]
    if Derived(design).end_stops:
        found += [
            Accessory("adhesive for the buffers", "polyurethane", 1),
            Accessory("screw of mirror and interferometer", "ISO 4762 - M4 x 16", 4),
        ]
    return tuple(found)
