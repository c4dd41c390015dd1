"""Contact stiffness of tip and stage against Hertz and Mindlin written out for one material."""

from __future__ import annotations

import pytest

from designcalc.machine.inputs import DesignInputs
from designcalc.machine.tip_contact import contact_without_payload
from stagecad.parameters.load import load_design

MASS = 1.8


def test_for_two_bodies_of_one_material_the_stiffness_ratio_is_mindlins():
    material = load_design(None, ()).value("tip.material")
    design = load_design(None, (f"stage.material={material}",))
    steel = design.materials[material]
    found = contact_without_payload(DesignInputs(design), MASS)
    load = MASS * 9.80665 + design.si("preload.force")
    assert found.load == pytest.approx(load)
    # A sphere on a flat: F = (4/3) E* sqrt(R) d^1.5, and the slope of that at the load.
    modulus = steel.youngs_modulus / (2.0 * (1.0 - steel.poisson_ratio**2))
    normal = (6.0 * modulus**2 * design.si("tip.nose_radius") * load) ** (1.0 / 3.0)
    assert found.normal == pytest.approx(normal, rel=1e-6)
    nu = steel.poisson_ratio
    assert found.tangential == pytest.approx(normal * 2.0 * (1.0 - nu) / (2.0 - nu), rel=1e-6)
