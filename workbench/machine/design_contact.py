"""What the design says of the contact between tip and stage: Hertz across it, Mindlin along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from designcalc.contact.hertz import contact_modulus, point_contact, tangential_stiffness
from designcalc.drive.friction_drive import GRAVITY
from stagecad.parameters.design import Design


@dataclass(frozen=True)
class TipContact:
    """The nose of the tip on the stage, SI.

    Args:
        load: N.
        normal: stiffness across the surface at that load, N/m.
        tangential: stiffness along it before any of it slips, N/m.
    """

    load: float
    normal: float
    tangential: float


def tip_contact(design: Design, mass: float) -> TipContact:
    """The contact under the whole weight of a moving `mass`, kg, and the preload.

    ``k_n = 2 a E*`` and ``k_t = 8 a G*``: for two bodies of one Poisson's ratio ``k_t = k_n 2 (1 - nu)/(2 - nu)``. Both
    go with the cube root of the load, so a tip that carries half of it is a fifth softer; a surface that slips at its
    edge, or is rough, is softer too.

    Source: Johnson, Contact Mechanics (1985), eq. 4.24 and 7.43; Mindlin, J. Appl. Mech. 16 (1949) 259.
    """
    tip, stage = (design.materials[design.value(f"{part}.material")] for part in ("tip", "stage"))
    load = mass * GRAVITY + design.si("preload.force")
    modulus = contact_modulus(tip.youngs_modulus, tip.poisson_ratio, stage.youngs_modulus, stage.poisson_ratio)
    touch = point_contact(load, design.si("tip.nose_radius"), np.inf, modulus)
    along = tangential_stiffness(
        touch, tip.youngs_modulus, tip.poisson_ratio, stage.youngs_modulus, stage.poisson_ratio
    )  # fmt: skip
    return TipContact(load, float(touch.stiffness), float(along))
