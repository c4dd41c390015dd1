"""Contact stiffness of tip and stage against Hertz and Mindlin written out for one material, and for two."""

import pytest

from designcalc.checks.check import DesignInputs
from designcalc.friction_stage.physics.loads import load
from designcalc.friction_stage.physics.tip_dynamics import contact_stiffness
from stagecad.parameters.load import load_design


def test_for_two_bodies_of_one_material_the_stiffness_ratio_is_mindlins():
    design = load_design(None, ())
    r = DesignInputs(design)
    found = contact_stiffness(r, load(r))
    aluminium = design.materials[design.value("tip.material")]
    # A sphere on a flat: F = (4/3) E* sqrt(R) d^1.5, and the slope of that at the load.
    modulus = aluminium.youngs_modulus / (2.0 * (1.0 - aluminium.poisson_ratio**2))
    assert found.rate == pytest.approx(4 / 3 * modulus * design.si("tip.nose_radius") ** 0.5, rel=1e-6)
    normal = (6.0 * modulus**2 * design.si("tip.nose_radius") * found.load) ** (1.0 / 3.0)
    assert found.normal == pytest.approx(normal, rel=1e-6)
    nu = aluminium.poisson_ratio
    assert found.tangential_ratio == pytest.approx(2.0 * (1.0 - nu) / (2.0 - nu), rel=1e-6)


def test_of_two_materials_each_has_its_own_poisson_ratio():
    """8 a G*: 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, with E and nu of silicon carbide and aluminium."""
    design = load_design(None, ("tip.material=sic",))
    found = contact_stiffness(DesignInputs(design), 10.0)
    (e1, n1), (e2, n2) = ((m.youngs_modulus, m.poisson_ratio) for m in map(design.materials.get, ("sic", "al_6061_t6")))
    shear = 1 / (2 * (1 + n1) * (2 - n1) / e1 + 2 * (1 + n2) * (2 - n2) / e2)
    normal = 1 / ((1 - n1**2) / e1 + (1 - n2**2) / e2)
    assert found.tangential_ratio == pytest.approx(4 * shear / normal, rel=1e-9)
    assert contact_stiffness(DesignInputs(design), 80.0).tangential_ratio == pytest.approx(found.tangential_ratio)
