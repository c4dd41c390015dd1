"""The field of teeth and magnet against the flat limit, Carter's map, and finite differences."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.special import jv

from designcalc.drive.magnetic_teeth import MU_0, MagnetSection, _bessel_table, magnet_forces, ratio_map, teeth_field
from tests.reference.tables import reference

REFERENCE = reference("teeth")
SECTION = MagnetSection(5e-3, 2e-3, 1e-3, 2.5e-3, 2, 8e-3, 5e-3, 5e-3, 6e-3)
MAGNET = (40e-3, 1.2, 1.05)


@pytest.mark.parametrize("width, gap", REFERENCE["carter"]["rows"])
def test_deep_lonely_grooves_follow_carter(width, gap):
    half = gap / 2
    u = (1 - width) / (2 * half)
    gamma = 4 / math.pi * (u * math.atan(u) - math.log(math.sqrt(1 + u**2)))
    carter = 1 / (1 - gamma * half)
    assert teeth_field(1.0, width, gap, 5.0).coenergy == pytest.approx(MU_0 / (2 * gap * carter), rel=2e-6)


@pytest.mark.parametrize("width, gap, ratio", REFERENCE["finite_difference"]["rows"])
def test_stiffness_ratio_agrees_with_coarse_finite_differences(width, gap, ratio):
    field = teeth_field(1.0, width, gap, 0.5)
    assert field.lateral_over_normal == pytest.approx(ratio, rel=REFERENCE["finite_difference"]["tolerance"])


def test_limits_and_scale_of_the_field_of_teeth():
    coenergy, normal_stiffness = MU_0 / (2 * 0.2), MU_0 / 0.2**3
    almost = teeth_field(1.0, 0.98, 0.2, 1.0)
    # a groove of small width s in each iron takes s^2/(pi e p) of the flat energy (Carter's factor for small s)
    assert 1 - almost.coenergy / coenergy == pytest.approx(0.02**2 / (np.pi * 0.2), rel=1e-2)
    assert almost.normal_stiffness == pytest.approx(normal_stiffness, rel=2e-3)
    assert abs(almost.lateral_stiffness) < 1e-3 * normal_stiffness
    energies = [teeth_field(1.0, 0.4, 0.05, 0.5, functions=n).coenergy for n in (4, 6, 8, 12, 16)]
    assert all(later <= earlier * (1 + 1e-12) for earlier, later in pairwise(energies))
    rough, fine = teeth_field(1.0, 0.4, 0.05, 0.5, functions=8), teeth_field(1.0, 0.4, 0.05, 0.5, functions=20)
    assert abs(rough.lateral_stiffness / fine.lateral_stiffness - 1) < rough.error
    # Packaged teeth at unit potential: 586.0 N/m^3/A^2 from the attraction, of five digits, at gaps of 0.98 and 1.02
    # mm.
    near, middle, far = (teeth_field(5e-3, 2e-3, gap, 2.5e-3) for gap in (0.98e-3, 1e-3, 1.02e-3))
    assert (near.attraction - far.attraction) / 0.04e-3 == pytest.approx(586.0, abs=0.3)
    assert middle.normal_stiffness == pytest.approx(585.7, abs=0.05)
    small, large = teeth_field(1e-3, 4e-4, 2e-4, 5e-4), teeth_field(1.0, 0.4, 0.2, 0.5)
    assert small.coenergy == pytest.approx(large.coenergy * 1e3)
    assert small.attraction == pytest.approx(large.attraction * 1e6)
    assert small.lateral_stiffness == pytest.approx(large.lateral_stiffness * 1e9)


@pytest.mark.parametrize("offset", [0.0, 0.13])
def test_forces_and_stiffnesses_are_the_slopes_of_the_coenergy(offset):
    step, base = 1e-3, teeth_field(1.0, 0.4, 0.2, 0.5, offset)

    def energy(dx, de):
        return teeth_field(1.0, 0.4, 0.2 + de, 0.5, offset + dx).coenergy

    def slopes(dx, de):
        values = [energy(n * dx, n * de) for n in (-2, -1, 0, 1, 2)]
        first = (values[0] - 8 * values[1] + 8 * values[3] - values[4]) / (12 * step)
        second = (-values[0] + 16 * values[1] - 30 * values[2] + 16 * values[3] - values[4]) / (12 * step**2)
        return first, second

    first, second = slopes(step, 0.0)
    assert base.lateral_force == pytest.approx(first, rel=1e-6, abs=1e-12)
    assert base.lateral_stiffness == pytest.approx(-second, rel=1e-5)
    first, second = slopes(0.0, step)
    assert base.attraction == pytest.approx(-first, rel=1e-6)
    assert base.normal_stiffness == pytest.approx(second, rel=1e-5)


def test_the_map_has_the_shape_the_thesis_missed_and_bessel_functions_recur():
    """K_x/K_z rises steadily as l/p falls, while K_x is flat-topped: 0.4 is a compromise, not an optimum."""
    widths = np.array([0.2, 0.3, 0.4, 0.5, 0.6])
    ratio, lateral, _ = ratio_map(widths, np.array([0.2]))
    assert np.all(np.diff(ratio[0]) < 0)
    assert 0.2 <= widths[np.argmax(lateral[0])] <= 0.4
    x = np.geomspace(0.05, 5e3, 400)
    direct = jv(np.arange(28)[:, None] + 7 / 6, x)
    np.testing.assert_allclose(_bessel_table(28, x), direct, rtol=1e-9, atol=1e-14)


def test_attraction_of_the_packaged_magnets():
    """Two magnets of 40 mm: separate finite-element solutions, at 0.25 and 0.125 mm, gave 79.0 and 79.4 N."""
    assert 2 * magnet_forces(SECTION, *MAGNET).attraction == pytest.approx(79.2, rel=0.01)
    coarse, fine = (magnet_forces(SECTION, *MAGNET, refinement) for refinement in (1, 3))
    assert coarse.attraction == pytest.approx(fine.attraction, rel=1e-3)
    assert coarse.normal_stiffness == pytest.approx(fine.normal_stiffness, rel=3e-3)
    assert coarse.lateral_stiffness == pytest.approx(fine.lateral_stiffness, rel=0.05)
    step = 1e-5
    pull = [magnet_forces(dataclasses.replace(SECTION, gap=1e-3 + s), *MAGNET).attraction for s in (-step, step)]
    slope = (pull[0] - pull[1]) / (2 * step)
    assert magnet_forces(SECTION, *MAGNET).normal_stiffness == pytest.approx(slope, rel=0.01)


def test_flat_irons_have_the_pressure_of_their_flux_and_scale():
    """Without grooves, leakage or fringes to speak of: all flux of the magnet crosses the gap, B^2/(2 mu0) pulls."""
    found = magnet_forces(MagnetSection(20e-3, 19.99e-3, 0.02e-3, 5e-3, 1, 10e-3, 20e-3, 5e-3, 15e-3), *MAGNET)
    assert found.leakage < 0.2
    pull = found.gap_flux_density**2 / (2 * MU_0) * 2 * 20e-3 * 40e-3
    assert found.attraction == pytest.approx(pull, rel=0.03)
    base = magnet_forces(SECTION, *MAGNET)
    lengths = {field.name: 2 * getattr(SECTION, field.name) for field in dataclasses.fields(MagnetSection)}
    large = magnet_forces(MagnetSection(**{**lengths, "teeth": 2}), 80e-3, 0.6, 1.05)
    assert large.gap_flux_density == pytest.approx(base.gap_flux_density / 2)
    assert large.attraction == pytest.approx(base.attraction)
    assert large.lateral_stiffness == pytest.approx(base.lateral_stiffness / 2)
