"""Items of the assembly besides its parts: small screws, consumables, leads, tools that stay with it, sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stagecad.friction_stage.parameters.derived import Derived
from stagecad.solids.assembly.bill_of_materials import Accessory

if TYPE_CHECKING:
    from stagecad.friction_stage.design import Design


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
