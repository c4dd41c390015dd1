"""The magnet with its irons and bar against five-point differences on a square grid, and against virtual work."""

import dataclasses

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

from designcalc.drive.magnetic_circuit import MagnetSection, magnet_forces
from designcalc.drive.magnetic_teeth import MU_0
from stagecad.parameters.errors import InputError

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


def test_attraction_of_the_packaged_magnets_is_that_of_five_point_differences():
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


def test_a_finer_grid_changes_the_forces_by_what_is_stated():
    coarse, fine = (magnet_forces(SECTION, *MAGNET, refinement) for refinement in (1, 3))
    assert coarse.attraction == pytest.approx(fine.attraction, rel=1e-3)
    assert coarse.normal_stiffness == pytest.approx(fine.normal_stiffness, rel=3e-3)
    assert coarse.lateral_stiffness == pytest.approx(fine.lateral_stiffness, rel=0.05)


def test_normal_stiffness_is_the_slope_of_the_attraction():
    step = 1e-5
    pull = [magnet_forces(dataclasses.replace(SECTION, gap=1e-3 + s), *MAGNET).attraction for s in (-step, step)]
    slope = (pull[0] - pull[1]) / (2 * step)
    assert magnet_forces(SECTION, *MAGNET).normal_stiffness == pytest.approx(slope, rel=0.01)


def test_flat_wide_irons_close_to_the_bar_have_the_pressure_of_their_flux():
    """Without grooves, leakage or fringes to speak of: all flux of the magnet crosses the gap, B^2/(2 mu0) pulls."""
    flat = MagnetSection(20e-3, 19.99e-3, 0.02e-3, 5e-3, 1, 10e-3, 20e-3, 5e-3, 15e-3)
    found = magnet_forces(flat, *MAGNET)
    assert found.leakage < 0.2
    pull = found.gap_flux_density**2 / (2 * MU_0) * 2 * 20e-3 * 40e-3
    assert found.attraction == pytest.approx(pull, rel=0.03)


def test_it_scales_with_size_remanence_and_length():
    base = magnet_forces(SECTION, *MAGNET)
    lengths = {field.name: 2 * getattr(SECTION, field.name) for field in dataclasses.fields(MagnetSection)}
    large = magnet_forces(MagnetSection(**{**lengths, "teeth": 2}), 80e-3, 0.6, 1.05)
    assert large.gap_flux_density == pytest.approx(base.gap_flux_density / 2)
    assert large.attraction == pytest.approx(base.attraction)
    assert large.lateral_stiffness == pytest.approx(base.lateral_stiffness / 2)


@pytest.mark.parametrize("magnet", [(0.0, 1.2, 1.05), (40e-3, -1.0, 1.05), (40e-3, 1.2, 0.0)])
def test_outside_the_range_is_said(magnet):
    with pytest.raises(InputError, match="must be above 0"):
        magnet_forces(SECTION, *magnet)
