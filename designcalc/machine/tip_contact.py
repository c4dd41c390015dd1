"""Contact of the tip's nose with the stage: Hertz normal to the surface, Mindlin along it.

Three callers need it under different loads. The checks take the load at lift-off, payload included
(`tip_contact`, `tip_shear_stiffness`). Experiments take the load without payload (`contact_without_payload`). The
simulation computes the load itself and takes the contact at 1 N, with the tangential ratio of one material that has
the mean of both Poisson's ratios (`unit_load_contact`).

Source: Johnson, Contact Mechanics (1985), eq. 4.24 and 7.43; Mindlin, J. Appl. Mech. 16 (1949) 259.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from designcalc.contact.hertz import PointContact, contact_modulus, point_contact, tangential_stiffness
from designcalc.drive.friction_drive import GRAVITY
from designcalc.machine.inputs import DesignInputs


def elastic_constants(r: DesignInputs, first: str, second: str) -> tuple[float, float, float, float]:
    """Young's modulus (Pa) and Poisson's ratio of the materials of two parts."""
    return (
        r.material(first, "youngs_modulus"),
        r.material(first, "poisson_ratio"),
        r.material(second, "youngs_modulus"),
        r.material(second, "poisson_ratio"),
    )


def tip_contact(r: DesignInputs, load: float) -> PointContact:
    """Nose of the tip on the stage's underside under `load`, N."""
    modulus = contact_modulus(*elastic_constants(r, "tip", "stage"))
    return point_contact(load, r("tip.nose_radius"), np.inf, modulus)


def tip_shear_stiffness(r: DesignInputs, contact: PointContact) -> float:
    """``k_t = 8 a G*`` of two bodies with their own Poisson's ratios, before any of the contact slips, N/m."""
    return float(tangential_stiffness(contact, *elastic_constants(r, "tip", "stage")))


@dataclass(frozen=True)
class ContactStiffness:
    """The tip on the stage at one load, SI.

    Args:
        load: N.
        normal: tangent stiffness normal to the surface, N/m.
        tangential: stiffness along the surface before any of it slips, N/m.
    """

    load: float
    normal: float
    tangential: float


def contact_without_payload(r: DesignInputs, mass: float) -> ContactStiffness:
    """The contact under preload and the weight of a moving `mass`, kg, which carries no payload.

    ``k_n = 2 a E*`` and ``k_t = 8 a G*``; both grow with the cube root of the load, so a tip that carries half of it
    is a fifth softer; a surface that slips at its edge, or is rough, is softer too.
    """
    load = mass * GRAVITY + r("preload.force")
    contact = tip_contact(r, load)
    return ContactStiffness(load, float(contact.stiffness), tip_shear_stiffness(r, contact))


def unit_load_contact(r: DesignInputs) -> tuple[float, float]:
    """K of ``F = K delta^1.5``, N/m^1.5, and the ratio of tangential to normal stiffness, ``2 (1 - nu)/(2 - nu)``.

    nu is the mean of the Poisson's ratios of tip and stage.
    """
    contact = tip_contact(r, 1.0)
    nu = 0.5 * sum(r.material(part, "poisson_ratio") for part in ("tip", "stage"))
    return float(contact.load / contact.approach**1.5), 2.0 * (1.0 - nu) / (2.0 - nu)
