"""A tip that presses in pulses: its force against a root finder, its mean against a quadrature, and simple limits."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from designcalc.contact.pulsed import peak_of_mean, pressed_force

RATE, STACKS = 7.3e9, 1.41e8
"""K of the packaged nose on the stage, and three stacks."""


def test_the_force_of_contact_and_stacks_in_series_closes_the_depth():
    for depth in (1e-9, 3e-6, 12e-6):
        force = float(pressed_force(np.array(depth), RATE, STACKS))
        exact = brentq(lambda F, depth=depth: (F / RATE) ** (2 / 3) + F / STACKS - depth, 0.0, 1e4, xtol=1e-12)
        assert force == pytest.approx(exact, rel=1e-9)
    assert float(pressed_force(np.array(-1e-6), RATE, STACKS)) == 0.0


@pytest.mark.parametrize("mean", [2.0, 33.2, 108.0])
def test_the_pulses_of_the_peak_have_the_mean(mean):
    rise = 12.02e-6
    peak = peak_of_mean(mean, rise, RATE, STACKS)
    depth = (peak / RATE) ** (2 / 3) + peak / STACKS

    def force(phase):
        return float(pressed_force(np.array(depth - rise / 2 * (1 - np.cos(phase))), RATE, STACKS))

    found = quad(force, 0, np.pi, limit=200)[0] / np.pi
    assert found == pytest.approx(mean, rel=1e-3)


def test_limits_of_no_rise_and_of_a_large_one():
    assert peak_of_mean(33.2, 0.0, RATE, STACKS) == pytest.approx(33.2, rel=1e-6)
    # Contact for a small part of the period: d^1.5 over a share of time (d/Y)^0.5 has the mean, so that d ~ Y^(1/4).
    small, large = (peak_of_mean(0.01, rise, RATE, 1e15) for rise in (1e-3, 16e-3))
    assert large / small == pytest.approx(16 ** (1.5 / 4), rel=1e-3)
