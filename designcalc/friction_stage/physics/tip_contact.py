"""Contact of the tip's nose with the stage: Hertz normal to the surface, Mindlin along it.

Source: Johnson, Contact Mechanics (1985), eq. 4.24 and 7.43; Mindlin, J. Appl. Mech. 16 (1949) 259.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from designcalc.checks.inputs import DesignInputs, remembered
from designcalc.contact.hertz import PointContact, contact_modulus, point_contact, tangential_stiffness


def elastic_constants(r: DesignInputs, first: str, second: str) -> tuple[float, float, float, float]:
    """Young's modulus (Pa) and Poisson's ratio of the materials of two parts."""
    return (
        r.material(first, "youngs_modulus"),
        r.material(first, "poisson_ratio"),
        r.material(second, "youngs_modulus"),
        r.material(second, "poisson_ratio"),
    )


@remembered
def tip_contact(r: DesignInputs, load: float) -> PointContact:
    """Nose of the tip on the stage's underside under `load`, N."""
    modulus = contact_modulus(*elastic_constants(r, "tip", "stage"))
    return point_contact(load, r("tip.nose_radius"), np.inf, modulus)


@dataclass(frozen=True)
class ContactStiffness:
    """The tip on the stage at one load, SI.

    Args:
        load: N.
        normal: tangent stiffness normal to the surface, N/m.
        tangential: stiffness along the surface before any of it slips, N/m.
        rate: K of ``F = K delta^1.5``, N/m^1.5; the same at every load.
    """

    load: float
    normal: float
    tangential: float
    rate: float

    @property
    def tangential_ratio(self) -> float:
        """Tangential over normal stiffness, the same at every load: ``2 (1 - nu)/(2 - nu)`` for equal materials."""
        return self.tangential / self.normal


@remembered
def contact_stiffness(r: DesignInputs, load: float) -> ContactStiffness:
    """The contact under a load, N: ``k_n = 2 a E*``, ``k_t = 8 a G*``, each body with its own Poisson's ratio.

    Both grow with the cube root of the load, so that a tip with half of the load is a fifth softer; a surface that
    slips at its edge, or is rough, is softer too.
    """
    contact = tip_contact(r, load)
    tangential = float(tangential_stiffness(contact, *elastic_constants(r, "tip", "stage")))
    return ContactStiffness(load, float(contact.stiffness), tangential, load / float(contact.approach) ** 1.5)
