"""Hertz contact against tables, closed forms and a direct integration; a tip that presses in pulses."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import dblquad, quad
from scipy.optimize import brentq
from scipy.special import elliprd

from designcalc.contact import hertz
from designcalc.contact.pulsed import peak_of_mean, pressed_force
from tests.reference.tables import reference

REFERENCE = reference("hertz")
RATE, STACKS = 7.3e9, 1.41e8
"""K of the packaged nose on the stage, and three stacks."""


@pytest.mark.parametrize("row", REFERENCE["ellipse"]["rows"])
def test_ellipses_agree_with_harris(row):
    difference, a_star, b_star, delta_star = row
    large, small = 1 + difference, 1 - difference  # curvature sums with sum of all four = 2
    contact = hertz.point_contact(100.0, 1 / large, np.inf, 1e11, radius_1_minor=1 / small)
    scale = np.cbrt(3 * 100.0 / (2 * 1e11 * 2.0))
    assert contact.semi_axis_major / scale == pytest.approx(a_star, rel=1.5e-3)
    assert contact.semi_axis_minor / scale == pytest.approx(b_star, rel=1.5e-3)
    assert contact.approach / (scale**2 * 2.0 / 2) == pytest.approx(delta_star, rel=1.5e-3)


@pytest.mark.parametrize("row", REFERENCE["shear"]["rows"])
def test_peak_shear_agrees_with_johnson(row):
    ratio, depth, shear = row
    curvatures = elliprd(0.0, ratio**2, 1.0), elliprd(0.0, 1.0, ratio**2)
    contact = hertz.point_contact(1.0, 0.5 / curvatures[1], np.inf, 1e9, radius_1_minor=0.5 / curvatures[0])
    assert contact.semi_axis_minor / contact.semi_axis_major == pytest.approx(ratio, rel=1e-12)
    peak = hertz.point_shear_peak(contact, 0.3)
    assert peak.depth / contact.semi_axis_minor == pytest.approx(depth, abs=0.01)
    assert peak.shear / contact.peak_pressure == pytest.approx(shear, abs=1.2e-3)


def test_sphere_has_its_closed_form_and_yields_first_where_johnson_says():
    radius, modulus = 2.5e-3, 60e9
    load = np.array([0.1, 1.0, 50.0])
    contact = hertz.point_contact(load, radius, np.inf, modulus)
    a = np.cbrt(3 * load * radius / (4 * modulus))
    np.testing.assert_allclose(contact.semi_axis_major, a, rtol=1e-12)
    np.testing.assert_allclose(contact.semi_axis_minor, a, rtol=1e-12)
    np.testing.assert_allclose(contact.approach, a**2 / radius, rtol=1e-12)
    np.testing.assert_allclose(contact.peak_pressure, 1.5 * load / (np.pi * a**2), rtol=1e-12)
    np.testing.assert_allclose(contact.stiffness, 2 * modulus * a, rtol=1e-12)
    assert 1 / hertz.peak_mises(1.0, 0.3) == pytest.approx(REFERENCE["yield"]["pressure_over_yield_strength"], rel=3e-3)


@pytest.mark.parametrize("ratio", [1.0, 0.999999, 0.5, 0.05])
@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
def test_axis_stresses_are_those_of_point_loads_summed(ratio, poisson):
    """Boussinesq's point load integrated over the ellipsoidal pressure, by a rule of its own."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    r, wr = 0.5 * (nodes + 1), 0.5 * weights
    rr, tt = np.meshgrid(r, (np.arange(400) + 0.5) / 400 * 2 * np.pi, indexing="ij")
    x, y = rr * np.cos(tt), ratio * rr * np.sin(tt)
    force = np.sqrt(1 - rr**2) * rr * ratio * wr[:, None] * (2 * np.pi / 400)
    z = 0.6 * ratio
    plane, distance = x**2 + y**2, np.sqrt(x**2 + y**2 + z**2)

    def in_plane(u, v):
        stretch = 3 * u**2 * z / distance**5
        free = (u**2 - v**2) / (distance * plane * (distance + z)) + z * v**2 / (distance**3 * plane)
        return float(np.sum(force * ((1 - 2 * poisson) * free - stretch)) / (2 * np.pi))

    expected = (in_plane(x, y), in_plane(y, x), -float(np.sum(force * 3 * z**3 / (2 * np.pi * distance**5))))
    np.testing.assert_allclose(hertz.axis_stresses(0.6, ratio, poisson), expected, atol=1.5e-3 if ratio < 0.1 else 2e-5)


def test_edge_tension_is_that_of_the_free_surface_outside_the_contact():
    """Outside a round load the surface moves as under a point load, and the skin is in plane stress."""
    E, nu, R, F = 70e9, 0.3, 0.01, 20.0
    contact = hertz.point_contact(F, R, np.inf, hertz.contact_modulus(np.inf, 0.3, E, nu))
    a, h = float(contact.semi_axis_major), 1e-9

    def move(r):
        return -(1 - 2 * nu) * (1 + nu) * F / (2 * np.pi * E * r)

    radial, hoop = (move(a + h) - move(a - h)) / (2 * h), move(a) / a
    stress = E / (1 - nu**2) * (radial + nu * hoop)
    assert float(hertz.edge_tension(contact.peak_pressure, nu)) == pytest.approx(stress, rel=1e-6)


def test_traction_adds_the_tension_of_cerruti_point_forces():
    """Surface stress behind a circle under the traction mu p, by summing point forces along the surface.

    Outside the circle the surface is in plane stress. The sum is taken a little behind the edge; towards the edge the
    stress goes as the root of the distance.
    """
    nu, mu, peak = 0.33, 0.3, 1.0

    def behind(distance):
        x0 = 1 + distance

        def strain(y, x):
            # Cerruti: u_x = Q/(2 pi G) [(1 - nu)/r + nu x^2/r^3], u_y = Q nu x y/(2 pi G r^3); E = 2 G (1 + nu), G = 1
            dx, r = x0 - x, np.hypot(x0 - x, y)
            traction = mu * peak * np.sqrt(max(1 - x**2 - y**2, 0.0))
            along = (-(1 - nu) * dx / r**3 + nu * (2 * dx / r**3 - 3 * dx**3 / r**5)) / (2 * np.pi)
            across = nu * dx * (1 / r**3 - 3 * y**2 / r**5) / (2 * np.pi)
            return traction * 2 * (1 + nu) / (1 - nu**2) * (along + nu * across)

        total = dblquad(strain, -1, 1, lambda x: -np.sqrt(1 - x**2), lambda x: np.sqrt(1 - x**2), epsabs=1e-6)[0]
        return total

    # The traction on the body points to -x, away from the edge at x = 1.
    distances = np.array([0.04, 0.01, 0.0025])
    values = np.array([-behind(d) for d in distances])
    edge = np.linalg.solve(np.stack([np.ones(3), np.sqrt(distances), distances], axis=1), values)[0]
    added = hertz.edge_tension(peak, nu, mu) - hertz.edge_tension(peak, nu)
    assert float(added) == pytest.approx(edge, rel=0.02)
    # A nose of 20 mm under 33.2 N, aluminium on aluminium, mu = 0.3: 180 MPa in the body where 32.7 MPa stand without
    # traction, and 905 MPa in a coating of dense alumina, strained alike.
    contact = hertz.point_contact(33.2, 20e-3, np.inf, hertz.contact_modulus(68.9e9, nu, 68.9e9, nu))
    still = (1 - 2 * nu) / 3
    assert float(contact.peak_pressure) * still == pytest.approx(32.7e6, rel=2e-3)
    assert float(contact.peak_pressure) * (still + edge) == pytest.approx(179.9e6, rel=0.02)
    body = float(hertz.edge_tension(contact.peak_pressure, nu, mu))
    assert body == pytest.approx(179.9e6, rel=2e-3)
    assert body * 370e9 / (1 - 0.22**2) / (68.9e9 / (1 - nu**2)) == pytest.approx(905e6, rel=2e-3)


def test_slender_ellipses_lines_and_extreme_curvatures_have_their_asymptotes():
    contact = hertz.point_contact(1.0, 1e-3, np.inf, 1e11, radius_1_minor=1e7)
    peak = hertz.point_shear_peak(contact, 0.3)
    line = hertz.line_contact(1.0, 1.0, 1e-3, np.inf, 1e11)
    line_peak = hertz.line_shear_peak(line)
    assert peak.depth / contact.semi_axis_minor == pytest.approx(line_peak.depth / line.half_width, rel=1e-3)
    assert peak.shear / contact.peak_pressure == pytest.approx(line_peak.shear / line.peak_pressure, rel=1e-3)
    line = hertz.line_contact(100.0, 0.02, 0.05, np.inf, 70e9)
    a = line.half_width
    load, _ = quad(lambda x: line.peak_pressure * np.sqrt(1 - (x / a) ** 2), -a, a)
    assert load == pytest.approx(100.0 / 0.02, rel=1e-8)
    # the elliptic pressure's own curvature: dp/dx field gives p0 = E* b/(2R)
    assert line.peak_pressure == pytest.approx(70e9 * line.half_width / (2 * 0.05), rel=1e-12)
    peak = hertz.line_shear_peak(line)
    assert peak.shear / line.peak_pressure == pytest.approx(0.30028, abs=1e-5)
    assert peak.depth / line.half_width == pytest.approx(0.78615, abs=1e-5)
    # slender: A/B = k^2 (ln(4/k) - 1), from the expansion of the complete integrals
    for ratio in (1e-150, 1e-30, 1e-8):
        k = float(hertz.ellipse_ratio(ratio))
        assert k**2 * (np.log(4 / k) - 1) == pytest.approx(ratio, rel=1e-6)
    # nearly circular: B/A = k^(-3/2) to second order
    assert float(hertz.ellipse_ratio(1 - 1e-7)) == pytest.approx((1 - 1e-7) ** (2 / 3), abs=1e-13)


@given(st.floats(1e-3, 1e4), st.floats(1e-4, 1e2), st.floats(1e-6, 1e6), st.floats(1e6, 1e12))
def test_load_is_the_slope_of_the_energy(load, radius, aspect, modulus):
    def energy_and_approach(force):
        contact = hertz.point_contact(force, radius, np.inf, modulus, radius_1_minor=radius * aspect)
        # U = 2/5 F delta, the integral of F ~ delta^1.5
        return float(0.4 * contact.load * contact.approach), contact

    assume(load < 0.05 * modulus * (radius * min(aspect, 1.0)) ** 2)  # a contact small compared with the radii
    h = 1e-4
    low, first = energy_and_approach(load * (1 - h))
    high, last = energy_and_approach(load * (1 + h))
    _, middle = energy_and_approach(load)
    assert (high - low) / float(last.approach - first.approach) == pytest.approx(load, rel=1e-6)
    assert 2 * load * h / float(last.approach - first.approach) == pytest.approx(float(middle.stiffness), rel=1e-6)
    assert float(last.approach / first.approach) == pytest.approx(((1 + h) / (1 - h)) ** (2 / 3), rel=1e-12)
    mean_pressure = load / (np.pi * middle.semi_axis_major * middle.semi_axis_minor)
    assert float(middle.peak_pressure) == pytest.approx(1.5 * float(mean_pressure), rel=1e-9)


def test_contact_in_series_with_stacks_closes_the_depth_and_pulses_have_their_limits():
    for depth in (1e-9, 3e-6, 12e-6):
        force = float(pressed_force(np.array(depth), RATE, STACKS))
        exact = brentq(lambda F, depth=depth: (F / RATE) ** (2 / 3) + F / STACKS - depth, 0.0, 1e4, xtol=1e-12)
        assert force == pytest.approx(exact, rel=1e-9)
    assert float(pressed_force(np.array(-1e-6), RATE, STACKS)) == 0.0
    assert peak_of_mean(33.2, 0.0, RATE, STACKS) == pytest.approx(33.2, rel=1e-6)
    # Contact for a small part of the period: d^1.5 over a share of time (d/Y)^0.5 has the mean, so that d ~ Y^(1/4).
    small, large = (peak_of_mean(0.01, rise, RATE, 1e15) for rise in (1e-3, 16e-3))
    assert large / small == pytest.approx(16 ** (1.5 / 4), rel=1e-3)


@pytest.mark.parametrize("mean", [2.0, 33.2, 108.0])
def test_the_pulses_of_the_peak_have_the_mean(mean):
    rise = 12.02e-6
    peak = peak_of_mean(mean, rise, RATE, STACKS)
    depth = (peak / RATE) ** (2 / 3) + peak / STACKS

    def force(phase):
        return float(pressed_force(np.array(depth - rise / 2 * (1 - np.cos(phase))), RATE, STACKS))

    found = quad(force, 0, np.pi, limit=200)[0] / np.pi
    assert found == pytest.approx(mean, rel=1e-3)
