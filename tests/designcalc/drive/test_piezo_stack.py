"""Stacks: inertia by differentiating the motion, bending by a beam solved numerically, side load and play."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from designcalc.drive import piezo_stack as stack
from stagecad.parameters.errors import InputError

L, A, E = 36e-3, 25e-6, 50e9


def beam_moment(force, tilt=None):
    """Largest bending moment of a cantilever: a force across its end, or its end tilted and held sideways."""
    inertia = A**2 / 12

    def slopes(x, y):
        return np.vstack([y[1], y[2] / (E * inertia), y[3], np.zeros_like(x)])

    def ends(foot, end):
        last = [end[2], end[3] + force] if tilt is None else [end[0], end[1] - tilt]
        return np.array([foot[0], foot[1], *last])

    x = np.linspace(0, L, 50)
    found = solve_bvp(slopes, ends, x, np.zeros((4, x.size)), tol=1e-8)
    assert found.success
    return np.abs(found.y[2]).max(), found.y[0, -1]


def test_tension_is_mass_times_the_acceleration_of_a_sine():
    f, Y = 5e3, 12e-6
    t = np.linspace(0, 1 / f, 20001)
    acceleration = np.gradient(np.gradient(Y / 2 * np.sin(2 * np.pi * f * t), t), t)[2:-2]
    pull = 0.032 * np.abs(acceleration).max() / 2
    assert float(stack.stack_tension(0.032, f, Y)) == pytest.approx(pull, rel=1e-4)


def test_drive_force_and_its_reactions_balance():
    push = float(stack.drive_pull(10.0, 20e-3, 46e-3))
    assert push * 46e-3 == pytest.approx(10.0 * 20e-3)


def test_side_load_is_that_of_a_beam_until_the_bore_holds_it():
    free = stack.side_load(3.3, L, 5.4e-3, A, E, 1e-3)
    moment, end = beam_moment(3.3)
    assert not free.touches
    assert float(free.deflection) == pytest.approx(end, rel=1e-5)
    assert float(free.stress) == pytest.approx(moment * np.sqrt(A) / 2 / (A**2 / 12), rel=1e-5)
    held = stack.side_load(3.3, L, 5.4e-3, A, E, 5e-6)
    assert held.touches
    assert float(held.stress / free.stress) == pytest.approx(5.4 / 36)
    many = stack.side_load(np.array([1.0, 3.3, 10.0]), L, 5.4e-3, A, E, 25e-6)
    np.testing.assert_array_equal(many.touches, [False, False, True])


def test_a_flat_end_that_tilts_bends_the_stack_as_a_clamped_beam():
    moment, _ = beam_moment(0.0, tilt=5e-4)
    assert float(stack.tilt_stress(5e-4, L, A, E)) == pytest.approx(moment * np.sqrt(A) / 2 / (A**2 / 12), rel=1e-5)


def test_rocking_stiffness_is_that_of_two_springs():
    angle, k, D = 1e-6, 47e6, 46e-3
    moment = 2 * k * (D / 2 * angle) * (D / 2)
    assert float(stack.rocking_stiffness(k, D)) * angle == pytest.approx(moment)


def test_inertia_of_the_packaged_tip_is_that_of_its_solid():
    """4.694e-6 kg m^2 about the piezos' plane at 22.93 g, by integrating the exact solid."""
    assert float(stack.tip_inertia(0.022933, 46e-3 / np.sqrt(3), 20e-3)) == pytest.approx(4.694e-6, rel=0.05)


@pytest.mark.parametrize(
    "call",
    [
        lambda: stack.stack_tension(-1.0, 1.0, 1.0),
        lambda: stack.drive_pull(1.0, 1.0, 0.0),
        lambda: stack.side_load(1.0, L, 2 * L, A, E, 0.0),
        lambda: stack.tilt_stress(1e-4, 0.0, A, E),
        lambda: stack.rocking_stiffness(0.0, 1.0),
        lambda: stack.tip_inertia(1.0, 1.0, 0.0),
    ],
)
def test_outside_the_range_is_said(call):
    with pytest.raises(InputError, match="above 0"):
        call()
