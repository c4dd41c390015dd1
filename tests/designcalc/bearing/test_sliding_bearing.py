"""Pads: thin-film contact against its integral, statics, and averaging against random surfaces."""

import numpy as np
import pytest
from scipy.integrate import quad

from designcalc.bearing import sliding as bearing
from designcalc.contact.film import confined_modulus, film_contact
from designcalc.contact.hertz import point_contact
from stagecad.parameters.errors import InputError


def test_film_on_rigid_bodies_carries_its_load_and_stiffness_is_the_slope():
    R, t, M = 2.0, 2e-6, 1.2e9
    film = film_contact(5.0, R, t, M, np.inf)
    depth = float(film.radius) ** 2 / (2 * R)
    assert float(film.indentation) == pytest.approx(depth)
    load, _ = quad(lambda r: 2 * np.pi * r * M / t * (depth - r**2 / (2 * R)), 0, float(film.radius))
    assert load == pytest.approx(5.0, rel=1e-9)
    more, less = (film_contact(5.0 * s, R, t, M, np.inf) for s in (1 + 1e-5, 1 - 1e-5))
    slope = 5.0 * 2e-5 / float(more.indentation - less.indentation)
    assert float(film.stiffness) == pytest.approx(slope, rel=1e-6)


def test_a_stiff_film_leaves_hertz():
    loads = np.array([0.01, 5.0, 300.0])
    film = film_contact(loads, 2.0, 2e-6, 1e16, 60e9)
    plain = point_contact(loads, 2.0, np.inf, 60e9)
    np.testing.assert_allclose(film.radius, plain.semi_axis_major, rtol=1e-3)
    np.testing.assert_allclose(film.peak_pressure, plain.peak_pressure, rtol=2e-3)
    np.testing.assert_allclose(film.stiffness, plain.stiffness, rtol=1e-3)


def test_a_film_widens_and_softens_a_contact():
    plain = point_contact(5.0, 2.0, np.inf, 60e9)
    film = film_contact(5.0, 2.0, 2e-6, 2e9, 60e9)
    assert film.radius > plain.semi_axis_major
    assert film.peak_pressure < plain.peak_pressure
    assert film.stiffness < plain.stiffness


def test_crown_wear_takes_the_volume_of_its_cap():
    R, h = 2.0, 1e-6
    volume, _ = quad(lambda z: np.pi * (2 * R * z - z**2), 0, h)
    assert float(bearing.crown_wear_distance(h, R, 1e-15, 16.0)) == pytest.approx(volume / (1e-15 * 16.0), rel=1e-6)


def test_depth_worn_undoes_the_distance():
    depth = bearing.crown_wear_depth(1200.0, 2.0, 1e-15, 16.0)
    assert float(bearing.crown_wear_distance(depth, 2.0, 1e-15, 16.0)) == pytest.approx(1200.0)
    with pytest.raises(InputError, match="wear rate"):
        bearing.crown_wear_depth(1200.0, 2.0, 0.0, 16.0)


def test_confined_modulus_is_hookes_law_without_side_strain():
    E, nu = 0.5e9, 0.46
    compliance = np.array([[1, -nu, -nu], [-nu, 1, -nu], [-nu, -nu, 1]]) / E
    assert confined_modulus(E, nu) == pytest.approx(np.linalg.inv(compliance)[0, 0])
    with pytest.raises(InputError, match="poisson"):
        confined_modulus(E, 0.5)


def test_pad_loads_balance_force_and_moment():
    for pads in ([(-0.025, 0.115), (0.025, 0.115), (0, -0.115)], [(-1, -1), (1, -1), (1, 1), (-1, 1)]):
        centre = (0.003, 0.01)
        loads = bearing.pad_loads(pads, 20.0, centre)
        assert loads.sum() == pytest.approx(20.0)
        np.testing.assert_allclose(loads @ np.array(pads, float), 20.0 * np.array(centre))
    np.testing.assert_allclose(bearing.pad_loads([(-1, -1), (1, -1), (1, 1), (-1, 1)], 8.0, (0, 0)), 2.0)


def test_pad_stiffness_is_the_response_of_a_rigid_plate():
    pads, k = np.array([(-0.025, 0.115), (0.025, 0.115), (0.0, -0.115)]), np.array([3e6, 4e6, 5e6])
    found = bearing.pad_stiffness(pads, k)
    rows = np.column_stack([np.ones(3), pads])
    full = rows.T @ (k[:, None] * rows)
    reduced = full[1:, 1:] - np.outer(full[1:, 0], full[0, 1:]) / full[0, 0]  # free to heave
    assert found.normal == pytest.approx(full[0, 0])
    assert (found.pitch, found.roll) == pytest.approx((reduced[0, 0], reduced[1, 1]))


def test_averaged_roughness_is_that_of_a_random_surface():
    rng = np.random.default_rng(7)
    correlation, step, n = 8.0, 1.0, 1024
    frequency = np.fft.fftfreq(n, step) * 2 * np.pi
    kx, ky = np.meshgrid(frequency, frequency)
    filtered = np.fft.ifft2(
        np.fft.fft2(rng.standard_normal((n, n))) * np.exp(-(kx**2 + ky**2) * correlation**2 / 8)
    ).real
    surface = filtered / filtered.std()
    radius, side = 64, 128
    x, y = np.meshgrid(*(np.arange(side) - (side - 1) / 2,) * 2)
    pressure = np.sqrt(np.maximum(1 - (x**2 + y**2) / radius**2, 0.0))
    patches = surface.reshape(n // side, side, n // side, side).transpose(0, 2, 1, 3)
    heights = np.sum(patches * pressure, axis=(2, 3)) / pressure.sum()
    ra = float(np.mean(np.abs(surface)))
    expected = bearing.averaged_roughness(ra, correlation, radius)
    assert float(np.sqrt(np.mean(heights**2))) == pytest.approx(float(expected), rel=0.2)  # 64 patches: +-9 %
    # Integrated over the circle of Hertz's pressure: 20.3 nm for one pad of Ra 1 um and 0.407 nm for Ra 20 nm, by a
    # separate quadrature; the square about it has 17.0 and 0.340 nm.
    assert float(bearing.averaged_roughness(1e-6, 20e-6, 0.7560e-3, 3)) == pytest.approx(20.3e-9, rel=5e-3)
    assert float(bearing.averaged_roughness(20e-9, 20e-6, 0.7560e-3, 3)) == pytest.approx(0.407e-9, rel=5e-3)


def test_averaged_profile_keeps_slow_and_stops_fast():
    x = np.arange(0, 0.1, 1e-4)
    for wavelength in (0.05, 0.001):
        ridden = bearing.averaged_profile(np.sin(2 * np.pi * x / wavelength), 1e-4, 0.02)
        half = np.pi * 0.02 / wavelength
        transfer = 3 * (np.sin(half) - half * np.cos(half)) / half**3  # Fourier transform of a parabola
        assert np.ptp(ridden) / 2 == pytest.approx(abs(transfer), abs=0.01)
    with pytest.raises(InputError, match="3 or more"):
        bearing.averaged_profile(x, 1e-4, 1.0)


def test_heat_is_force_times_speed():
    assert float(bearing.friction_heat(0.1, 20.0, 0.2)) == pytest.approx(0.4)
