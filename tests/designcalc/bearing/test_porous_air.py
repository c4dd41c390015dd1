"""Porous air bearing: against the catalogue, a film solved by finite differences, and its limits."""

import numpy as np
import pytest
from scipy.linalg import solve_banded

from designcalc.bearing import porous_air as air
from stagecad.parameters.errors import InputError

D, SUPPLY, LOAD, GAP = 25.4e-3, 413e3, 90.0, 5e-6


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


def test_the_catalogues_stiffness_follows_from_its_load():
    """90 N at 5 um and 413 kPa; stated stiffness 24.5 N/um. The load alone fixes the one unknown."""
    assert float(air.stiffness_of_gap(GAP, GAP, LOAD, D, SUPPLY)) == pytest.approx(24.5e6, rel=0.1)
    assert 0.2 < LOAD / (SUPPLY * np.pi / 4 * D**2) < 0.5


@pytest.mark.parametrize("feed", [0.3, 1.92, 8.0])
def test_load_agrees_with_finite_differences(feed):
    assert float(air.load_of_feed(feed, D, SUPPLY)) == pytest.approx(solved_load(feed), rel=2e-3)


def test_a_rich_feed_carries_supply_times_area_and_a_poor_one_nothing():
    area = np.pi / 4 * D**2
    assert float(air.load_of_feed(800.0, D, SUPPLY)) == pytest.approx(SUPPLY * area, rel=5e-3)
    # little feed: P - Pa = (Ps - Pa)(lambda^2/4)(1 - x^2), so the load is lambda^2 (Ps - Pa)/(16 pa) of the area
    poor = 1e-4**2 * ((air.ATMOSPHERE + SUPPLY) ** 2 - air.ATMOSPHERE**2) / (16 * air.ATMOSPHERE) * area
    assert float(air.load_of_feed(1e-4, D, SUPPLY)) == pytest.approx(poor, rel=1e-4)


def test_stiffness_is_the_slope_of_the_load():
    gaps = np.array([3e-6, 5e-6, 9e-6])
    up, down = (air.load_of_gap(gaps * s, GAP, LOAD, D, SUPPLY) for s in (1 + 1e-5, 1 - 1e-5))
    slope = -(up - down) / (2e-5 * gaps)
    np.testing.assert_allclose(air.stiffness_of_gap(gaps, GAP, LOAD, D, SUPPLY), slope, rtol=1e-5)
    assert float(air.load_of_gap(GAP, GAP, LOAD, D, SUPPLY)) == pytest.approx(LOAD)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: air.feed_for(300.0, D, SUPPLY), "supply times area"),
        (lambda: air.load_of_feed(0.0, D, SUPPLY), "above 0"),
        (lambda: air.load_of_gap(-1e-6, GAP, LOAD, D, SUPPLY), "gap"),
    ],
)
def test_outside_the_range_is_said(call, words):
    with pytest.raises(InputError, match=words):
        call()
