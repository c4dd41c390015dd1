"""Masses of a changed design without its solids: those of the present solids, changed by plain bodies.

The moving body changes by the mass of its plain plate, irons and magnets; the tip by the ratio of the volumes of its
hub, arms, feet and cone. Pockets, holes and fillets are taken as unchanged: within a few percent of the change. A
result is verified with the masses of its own solids.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stagecad.parameters.mass_properties import BodyMasses, MassProperties

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

MM3 = 1e-9


MASS_KEYS = ("stage.", "tip.", "teeth.", "tooth_iron.", "magnet.", "actuator.", "pads.", "bearing_way.")
"""Beginnings of the keys that `changed_masses` reads."""


def changed_masses(design: Design, base: Design, masses: BodyMasses) -> BodyMasses:
    """Masses of a design from those of the solids of another one.

    Args:
        design: the changed design.
        base: the design of the solids.
        masses: of its solids.
    """
    moving, tip = masses.moving, masses.tip
    mass = moving.mass + _moving(design) - _moving(base)
    scale = mass / moving.mass
    lift = (design.derived.drive_surface_height - base.derived.drive_surface_height) * 1e-3
    lift += 0.5e-3 * (design.stage.thickness - base.stage.thickness)
    x, y, z = moving.centre_of_mass
    inertia = np.asarray(moving.inertia) * scale * _gyration(design, base)
    new = MassProperties(moving.volume * scale, mass, (x, y, z + lift), inertia, moving.bounding_box)
    ratio = _tip_volume(design) / _tip_volume(base) * _density(design, "tip") / _density(base, "tip")
    reach = (design.actuator.piezo_spacing / base.actuator.piezo_spacing) ** 2
    centre = (*tip.centre_of_mass[:2], tip.centre_of_mass[2] * design.actuator.tip_height / base.actuator.tip_height)
    other = MassProperties(
        tip.volume * ratio, tip.mass * ratio, centre, np.asarray(tip.inertia) * ratio * reach, tip.bounding_box
    )
    return BodyMasses(new, other)


def _gyration(design: Design, base: Design) -> float:
    """Ratio of the mean squared radius of gyration of the plain plates."""
    one, other = (d.stage.length**2 + d.stage.width**2 for d in (design, base))
    return one / other


def _density(design: Design, part: str) -> float:
    return design.si(f"materials.{design.value(f'{part}.material')}.density")


def _moving(design: Design) -> float:
    """Mass of plain plate, irons and magnets, kg."""
    stage = design.stage
    found = stage.length * stage.width * stage.thickness * _density(design, "stage")
    if design.teeth.fitted:
        iron, magnet, teeth = design.tooth_iron, design.magnet, design.teeth
        grooves = teeth.per_iron * (teeth.pitch - teeth.width) * teeth.groove_depth
        section = design.derived.iron_width * iron.height - grooves
        found += 2 * design.derived.magnets * iron.length * section * _density(design, "tooth_iron")
        found += design.derived.magnets * magnet.length * magnet.thickness * magnet.height * _density(design, "magnet")
    return found * MM3


def _tip_volume(design: Design) -> float:
    """Volume of hub, arms, feet and cone of the tip less seats and relief, mm^3."""
    tip, height = design.tip, design.actuator.tip_height
    circle = design.derived.piezo_circle

    def disc(diameter: float) -> float:
        return math.pi / 4 * diameter**2

    arms = 3 * tip.arm_width * max(circle - (tip.hub_diameter + tip.foot_diameter) / 2, 0.0) * tip.arm_thickness
    plates = (disc(tip.hub_diameter) + 3 * disc(tip.foot_diameter)) * tip.arm_thickness
    tall = max(height - tip.arm_thickness + tip.seat_depth, 0.0)
    cone = math.pi / 12 * tall * (tip.cone_diameter**2 + tip.cone_diameter * tip.nose_diameter + tip.nose_diameter**2)
    return (
        arms
        + plates
        + cone
        - 3 * disc(tip.seat_diameter) * tip.seat_depth
        - disc(tip.relief_diameter) * tip.relief_depth
    )
