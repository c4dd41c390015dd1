"""The field of teeth and magnet against the flat limit, Carter's map, and finite differences."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse import coo_array, csr_matrix, lil_matrix
from scipy.sparse.linalg import spsolve
from scipy.special import jv

from designcalc.drive.magnetic_teeth import MU_0, MagnetSection, _bessel_table, magnet_forces, ratio_map, teeth_field
from tests.reference.tables import reference

REFERENCE = reference("teeth")


@pytest.mark.parametrize("width, gap", REFERENCE["carter"]["rows"])
def test_deep_lonely_grooves_follow_carter(width, gap):
    half = gap / 2
    u = (1 - width) / (2 * half)
    gamma = 4 / math.pi * (u * math.atan(u) - math.log(math.sqrt(1 + u**2)))
    carter = 1 / (1 - gamma * half)
    field = teeth_field(1.0, width, gap, 5.0)
    assert field.coenergy == pytest.approx(MU_0 / (2 * gap * carter), rel=2e-6)


@pytest.mark.parametrize("width, gap, ratio", REFERENCE["finite_difference"]["rows"])
def test_stiffness_ratio_agrees_with_coarse_finite_differences(width, gap, ratio):
    field = teeth_field(1.0, width, gap, 0.5)
    assert field.lateral_over_normal == pytest.approx(ratio, rel=REFERENCE["finite_difference"]["tolerance"])


def _finite_difference_energy(cells: int, width: int, gap: int, depth: int, shift: int) -> float:
    """W/mu0 of one cell by five-point differences on a square grid; lengths in grid steps, pitch = `cells`."""
    rows = depth + gap + depth
    number = np.full((rows + 1, cells), -1)
    fixed = np.full((rows + 1, cells), np.nan)
    column = np.arange(cells)
    lower_iron = (column <= width) if width < cells else np.ones(cells, bool)
    upper_iron = np.roll(lower_iron, shift)
    fixed[: depth + 1, lower_iron] = 0.0
    fixed[depth + gap :, upper_iron] = 1.0
    fixed[0, :], fixed[rows, :] = 0.0, 1.0
    free = np.isnan(fixed)
    number[free] = np.arange(free.sum())
    matrix, right = lil_matrix((free.sum(), free.sum())), np.zeros(free.sum())
    for i, j in zip(*np.nonzero(free)):
        here = number[i, j]
        matrix[here, here] = 4.0
        for a, b in ((i + 1, j), (i - 1, j), (i, (j + 1) % cells), (i, (j - 1) % cells)):
            if free[a, b]:
                matrix[here, number[a, b]] = -1.0
            else:
                right[here] += fixed[a, b]
    potential = fixed.copy()
    potential[free] = spsolve(csr_matrix(matrix), right)
    across = np.diff(potential, axis=0)
    along = np.roll(potential, -1, axis=1) - potential
    return 0.5 * float(np.sum(across**2) + np.sum(along**2)) / cells


@pytest.mark.parametrize("shift", [0, 1])
def test_coenergy_agrees_with_extrapolated_finite_differences(shift):
    """l/p = 0.4, e/p = 0.2, grooves 0.3 p, shifted by 0 or 0.2 p; five-point errors at the corners fall as h^(4/3)."""
    energies = [_finite_difference_energy(10 * n, 4 * n, 2 * n, 3 * n, 2 * n * shift) * 10 * n for n in (4, 8)]
    extrapolated = energies[1] + (energies[1] - energies[0]) / (2 ** (4 / 3) - 1)
    cell = teeth_field(1.0, 0.4, 0.2, 0.3, 0.2 * shift)
    assert cell.coenergy / MU_0 == pytest.approx(extrapolated, rel=4e-3)


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


SECTION = MagnetSection(5e-3, 2e-3, 1e-3, 2.5e-3, 2, 8e-3, 5e-3, 5e-3, 6e-3)
MAGNET = (40e-3, 1.2, 1.05)


def permeance_by_differences(gap: int, step: float) -> float:
    """Flux out of one iron at unit potential per length, over mu0; half of the section, its middle plane at zero.

    Conductances between the nodes of a square grid; `gap` and all lengths in steps of `step`, mm.
    """

    def cells(length: float) -> int:
        return round(length / step)

    half, width, up, down = cells(2.5), cells(40.0), cells(23.0), cells(15.0)
    tooth = [(cells(4.0), cells(6.0)), (cells(9.0), cells(11.0))]
    end, groove, iron = cells(12.5), cells(2.5), cells(8.0)
    x, z = np.meshgrid(np.arange(width + 1), np.arange(-down, up + 1))
    in_tooth = np.any([(x >= low) & (x <= high) for low, high in tooth], axis=0)
    inside = (x >= half) & (x <= end)
    upper = inside & (z >= gap) & (z <= gap + iron) & (in_tooth | (z >= gap + groove))
    bar = (x <= end) & (z <= 0) & ((inside & (in_tooth | (z <= -groove))) | (z <= -cells(6.0)))
    fixed = upper | bar | (x == 0)
    potential = upper.astype(float)
    top = gap + iron

    def weight(mid_x, mid_z, along_x):
        """Conductance of a link: its share of the magnet and of air on either side."""
        total = np.zeros(mid_x.shape)
        for side in (-0.25, 0.25):
            a, b = (mid_x, mid_z + side) if along_x else (mid_x + side, mid_z)
            magnet = (a < half) & (b > top - cells(5.0)) & (b < top)
            outside = (a < 0) | (a > width) | (b < -down) | (b > up)
            total += np.where(outside, 0.0, 0.5 * np.where(magnet, 1.05, 1.0))
        return total

    number = np.arange(x.size).reshape(x.shape)
    links = [
        (number[:, :-1], number[:, 1:], weight(x[:, :-1] + 0.5, z[:, :-1], True)),
        (number[:-1], number[1:], weight(x[:-1], z[:-1] + 0.5, False)),
    ]
    first, second, k = (np.concatenate([link[i].ravel() for link in links]) for i in range(3))
    rows = np.concatenate([first, second, first, second])
    columns = np.concatenate([first, second, second, first])
    matrix = coo_array((np.concatenate([k, k, -k, -k]), (rows, columns)), shape=(x.size, x.size)).tocsr()
    free, u = ~fixed.ravel(), potential.ravel()
    u[free] = spsolve(matrix[free][:, free].tocsc(), -(matrix[free] @ u))
    return float(u @ (matrix @ u))


def test_attraction_of_the_packaged_magnets():
    """Two halves of two magnets of 40 mm, driven by Br h into the permeance; both solutions are refined grids' 79 N."""
    step = 0.125
    near, middle, far = (permeance_by_differences(gap, step) * MU_0 for gap in (7, 8, 9))
    potential = 1.2 * 5e-3 / middle
    pull = -0.5 * potential**2 * (far - near) / (2e-3 * step) * 40e-3 * 4
    forces = magnet_forces(SECTION, *MAGNET)
    # The chord over an eighth of the gap on either side is some 2 % steeper than the slope.
    assert 2 * forces.attraction == pytest.approx(pull, rel=0.03)
    # Separate finite-element solutions, at 0.25 and 0.125 mm, gave 79.0 and 79.4 N.
    assert 2 * forces.attraction == pytest.approx(79.2, rel=0.01)
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
    flat = MagnetSection(20e-3, 19.99e-3, 0.02e-3, 5e-3, 1, 10e-3, 20e-3, 5e-3, 15e-3)
    found = magnet_forces(flat, *MAGNET)
    assert found.leakage < 0.2
    pull = found.gap_flux_density**2 / (2 * MU_0) * 2 * 20e-3 * 40e-3
    assert found.attraction == pytest.approx(pull, rel=0.03)
    base = magnet_forces(SECTION, *MAGNET)
    lengths = {field.name: 2 * getattr(SECTION, field.name) for field in dataclasses.fields(MagnetSection)}
    large = magnet_forces(MagnetSection(**{**lengths, "teeth": 2}), 80e-3, 0.6, 1.05)
    assert large.gap_flux_density == pytest.approx(base.gap_flux_density / 2)
    assert large.attraction == pytest.approx(base.attraction)
    assert large.lateral_stiffness == pytest.approx(base.lateral_stiffness / 2)
