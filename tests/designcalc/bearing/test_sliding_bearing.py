"""Pads and their ways: thin films, statics, roughness, profiles; porous air bearings."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import solve_banded

from designcalc.bearing import porous_air as air
from designcalc.bearing import sliding as bearing
from designcalc.bearing.sliding import averaged_roughness
from designcalc.bearing.way_profile import Surface, carried_height, carried_waves, synthetic_profiles
from designcalc.contact.film import confined_modulus, film_contact
from designcalc.contact.hertz import point_contact

ROUGH = Surface(roughness=20e-9, correlation_length=20e-6, waviness=0.0, wavelength=10e-3)
SIDE = 0.8e-3
D, SUPPLY, LOAD, GAP = 25.4e-3, 413e3, 90.0, 5e-6


def test_films_carry_their_load_and_soften_hertz():
    R, t, M = 2.0, 2e-6, 1.2e9
    film = film_contact(5.0, R, t, M, np.inf)
    depth = float(film.radius) ** 2 / (2 * R)
    assert float(film.indentation) == pytest.approx(depth)
    load, _ = quad(lambda r: 2 * np.pi * r * M / t * (depth - r**2 / (2 * R)), 0, float(film.radius))
    assert load == pytest.approx(5.0, rel=1e-9)
    more, less = (film_contact(5.0 * s, R, t, M, np.inf) for s in (1 + 1e-5, 1 - 1e-5))
    slope = 5.0 * 2e-5 / float(more.indentation - less.indentation)
    assert float(film.stiffness) == pytest.approx(slope, rel=1e-6)
    loads = np.array([0.01, 5.0, 300.0])
    film = film_contact(loads, 2.0, 2e-6, 1e16, 60e9)
    plain = point_contact(loads, 2.0, np.inf, 60e9)
    np.testing.assert_allclose(film.radius, plain.semi_axis_major, rtol=1e-3)
    np.testing.assert_allclose(film.peak_pressure, plain.peak_pressure, rtol=2e-3)
    np.testing.assert_allclose(film.stiffness, plain.stiffness, rtol=1e-3)
    plain = point_contact(5.0, 2.0, np.inf, 60e9)
    film = film_contact(5.0, 2.0, 2e-6, 2e9, 60e9)
    assert film.radius > plain.semi_axis_major and film.peak_pressure < plain.peak_pressure
    assert film.stiffness < plain.stiffness


def test_wear_and_heat_are_their_closed_forms():
    R, h = 2.0, 1e-6
    volume, _ = quad(lambda z: np.pi * (2 * R * z - z**2), 0, h)
    assert float(bearing.crown_wear_distance(h, R, 1e-15, 16.0)) == pytest.approx(volume / (1e-15 * 16.0), rel=1e-6)
    depth = bearing.crown_wear_depth(1200.0, 2.0, 1e-15, 16.0)
    assert float(bearing.crown_wear_distance(depth, 2.0, 1e-15, 16.0)) == pytest.approx(1200.0)
    assert float(bearing.friction_heat(0.1, 20.0, 0.2)) == pytest.approx(0.4)
    E, nu = 0.5e9, 0.46
    compliance = np.array([[1, -nu, -nu], [-nu, 1, -nu], [-nu, -nu, 1]]) / E
    assert confined_modulus(E, nu) == pytest.approx(np.linalg.inv(compliance)[0, 0])


def test_loads_and_stiffness_of_pads_balance_and_respond():
    for pads in ([(-0.025, 0.115), (0.025, 0.115), (0, -0.115)], [(-1, -1), (1, -1), (1, 1), (-1, 1)]):
        centre = (0.003, 0.01)
        loads = bearing.pad_loads(pads, 20.0, centre)
        assert loads.sum() == pytest.approx(20.0)
        np.testing.assert_allclose(loads @ np.array(pads, float), 20.0 * np.array(centre))
    np.testing.assert_allclose(bearing.pad_loads([(-1, -1), (1, -1), (1, 1), (-1, 1)], 8.0, (0, 0)), 2.0)
    pads, k = np.array([(-0.025, 0.115), (0.025, 0.115), (0.0, -0.115)]), np.array([3e6, 4e6, 5e6])
    found = bearing.pad_stiffness(pads, k)
    rows = np.column_stack([np.ones(3), pads])
    full = rows.T @ (k[:, None] * rows)
    reduced = full[1:, 1:] - np.outer(full[1:, 0], full[0, 1:]) / full[0, 0]  # free to heave
    assert found.normal == pytest.approx(full[0, 0])
    assert (found.pitch, found.roll) == pytest.approx((reduced[0, 0], reduced[1, 1]))


def test_averaged_roughness_and_profile_over_a_contact():
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
    expected = bearing.averaged_roughness(float(np.mean(np.abs(surface))), correlation, radius)
    assert float(np.sqrt(np.mean(heights**2))) == pytest.approx(float(expected), rel=0.2)  # 64 patches: +-9 %
    # Integrated over the circle of Hertz's pressure: 20.3 nm for one pad of Ra 1 um and 0.407 nm for Ra 20 nm, by a
    # separate quadrature; the square about it has 17.0 and 0.340 nm.
    assert float(bearing.averaged_roughness(1e-6, 20e-6, 0.7560e-3, 3)) == pytest.approx(20.3e-9, rel=5e-3)
    assert float(bearing.averaged_roughness(20e-9, 20e-6, 0.7560e-3, 3)) == pytest.approx(0.407e-9, rel=5e-3)
    x = np.arange(0, 0.1, 1e-4)
    for wavelength in (0.05, 0.001):
        ridden = bearing.averaged_profile(np.sin(2 * np.pi * x / wavelength), 1e-4, 0.02)
        half = np.pi * 0.02 / wavelength
        transfer = 3 * (np.sin(half) - half * np.cos(half)) / half**3  # Fourier transform of a parabola
        assert np.ptp(ridden) / 2 == pytest.approx(abs(transfer), abs=0.01)


def test_the_made_up_profile_has_its_roughness_and_its_correlation():
    profiles, step = synthetic_profiles(ROUGH, 0.5, SIDE, 3)
    across = np.sqrt(np.sqrt(np.pi) * ROUGH.correlation_length / (4 * np.pi / 15 * SIDE))
    assert np.std(profiles) == pytest.approx(ROUGH.roughness * np.sqrt(np.pi / 2) * across, rel=0.02)
    lag = round(ROUGH.correlation_length / step)
    assert np.mean(profiles[:, lag:] * profiles[:, :-lag]) / np.var(profiles) == pytest.approx(np.exp(-1), abs=0.02)
    again, _ = synthetic_profiles(ROUGH, 0.5, SIDE, 3)
    np.testing.assert_array_equal(profiles, again)


@pytest.mark.parametrize("count", [1, 3])
def test_the_profile_is_periodic_white_noise_behind_a_filter_of_its_whole_length(count):
    profiles, _ = synthetic_profiles(ROUGH, 0.05, SIDE, count)
    n = profiles.shape[1]
    white = np.random.default_rng(1).standard_normal(1 << (count * n - 1).bit_length())[: count * n].reshape(count, n)
    wave_number = 2 * np.pi * np.fft.fftfreq(n, 0.25)
    gain = np.exp(-(wave_number**2) / 8)
    filtered = np.fft.ifft(np.fft.fft(white) * gain).real / np.sqrt(np.mean(gain**2))
    scale = np.std(profiles) / np.std(filtered)
    np.testing.assert_allclose(profiles / scale, filtered, atol=1e-8)


def test_pads_average_roughness_and_waves_as_the_closed_forms_say():
    profiles, step = synthetic_profiles(ROUGH, 1.0, SIDE, 3)
    left = np.std(carried_height(profiles, step, SIDE))
    circle = float(averaged_roughness(ROUGH.roughness, ROUGH.correlation_length, SIDE / 2, 3))
    assert left == pytest.approx(circle, rel=0.05)
    waves = Surface(roughness=0.0, correlation_length=20e-6, waviness=5e-9, wavelength=10e-3)
    in_step, step = synthetic_profiles(waves, 0.3, SIDE, 2)
    half = np.pi * SIDE / waves.wavelength
    transfer = 3 * (np.sin(half) - half * np.cos(half)) / half**3  # Fourier transform of a parabola
    # the contact is rounded down to whole steps of the profile, and its weights to points
    assert np.std(carried_height(in_step, step, SIDE)) == pytest.approx(5e-9 / np.sqrt(2) * transfer, rel=2e-3)
    opposed, _ = synthetic_profiles(waves, 0.3, SIDE, 2, phase=np.pi)
    assert np.std(carried_height(opposed, step, SIDE)) < 1e-12
    waves = Surface(roughness=0.0, correlation_length=20e-6, waviness=5e-9, wavelength=7e-3)
    profiles, step = synthetic_profiles(waves, 0.3, SIDE, 2, phase=0.7)
    starts, size = np.array([0, 811, 405]), 50_000
    rows = [profiles[track, start : start + size] for track, start in zip((0, 1, 1), starts)]
    found = carried_waves(waves, starts, np.array([0.0, 0.7, 0.7]), step, size, SIDE)
    assert found == pytest.approx(np.std(carried_height(rows, step, SIDE)), rel=1e-9)


def solved_load(feed, nodes=2000):
    """Load with the film's equation in p^2 solved on rings of equal width, by the flow through each ring's edges."""
    x = (np.arange(nodes) + 0.5) / nodes
    inner, outer = x - 0.5 / nodes, x + 0.5 / nodes
    source, outside = (air.ATMOSPHERE + SUPPLY) ** 2, air.ATMOSPHERE**2
    bands, right = np.zeros((3, nodes)), np.zeros(nodes)
    bands[1] = -(inner + outer) * nodes - feed**2 * x / nodes
    bands[0, 1:] = outer[:-1] * nodes
    bands[2, :-1] = inner[1:] * nodes
    bands[1, -1] -= outer[-1] * nodes  # the rim stands half a ring away
    right[:] = -(feed**2) * x / nodes * source
    right[-1] -= 2 * outer[-1] * nodes * outside
    squares = solve_banded((1, 1), bands, right)
    return float(np.sum((np.sqrt(squares) - air.ATMOSPHERE) * 2 * np.pi * x / nodes) * (D / 2) ** 2)


def test_an_air_bearing_has_the_catalogues_stiffness_and_the_slope_of_its_load():
    """90 N at 5 um and 413 kPa; stated stiffness 24.5 N/um. The load alone fixes the one unknown."""
    assert float(air.stiffness_of_gap(GAP, GAP, LOAD, D, SUPPLY)) == pytest.approx(24.5e6, rel=0.1)
    assert 0.2 < LOAD / (SUPPLY * np.pi / 4 * D**2) < 0.5
    area = np.pi / 4 * D**2
    assert float(air.load_of_feed(800.0, D, SUPPLY)) == pytest.approx(SUPPLY * area, rel=5e-3)
    # little feed: P - Pa = (Ps - Pa)(lambda^2/4)(1 - x^2), so the load is lambda^2 (Ps - Pa)/(16 pa) of the area
    poor = 1e-4**2 * ((air.ATMOSPHERE + SUPPLY) ** 2 - air.ATMOSPHERE**2) / (16 * air.ATMOSPHERE) * area
    assert float(air.load_of_feed(1e-4, D, SUPPLY)) == pytest.approx(poor, rel=1e-4)
    gaps = np.array([3e-6, 5e-6, 9e-6])
    up, down = (air.load_of_gap(gaps * s, GAP, LOAD, D, SUPPLY) for s in (1 + 1e-5, 1 - 1e-5))
    slope = -(up - down) / (2e-5 * gaps)
    np.testing.assert_allclose(air.stiffness_of_gap(gaps, GAP, LOAD, D, SUPPLY), slope, rtol=1e-5)
    assert float(air.load_of_gap(GAP, GAP, LOAD, D, SUPPLY)) == pytest.approx(LOAD)


@pytest.mark.parametrize("feed", [0.3, 1.92, 8.0])
def test_load_agrees_with_finite_differences(feed):
    assert float(air.load_of_feed(feed, D, SUPPLY)) == pytest.approx(solved_load(feed), rel=2e-3)
