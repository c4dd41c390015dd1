"""Piezo stacks: stiffness, load, currents, and heat over a duty cycle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from designcalc.checks.check import DesignInputs
from designcalc.drive import piezo_stack as stack
from designcalc.drive.thermal_network import ThermalNetwork
from designcalc.friction_stage.physics.heat import growth, network, warmed
from stagecad.parameters.load import load_design
from tests.refusals import refused

L, A, E = 36e-3, 25e-6, 50e9
TWO = ThermalNetwork(np.array([3.0, 50.0]), np.array([[0.0, 1.5], [1.5, 0.0]]), np.array([0.1, 0.4]))
POWER = np.array([20.0, 0.0])


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


def test_tension_is_the_largest_pull_while_the_tip_rises_and_rocks():
    """Forces of two stacks by Newton and Euler over a period, their strokes a quarter of a period apart."""
    m, J, f, h, D, A = 0.0319, 7.87e-6, 5e3, 20e-3, 46e-3, 8.5e-6
    t = np.linspace(0, 1 / f, 40001)
    d1, d2 = A * np.sin(2 * np.pi * f * t), A * np.sin(2 * np.pi * f * t - np.pi / 2)

    def acceleration(y):
        return np.gradient(np.gradient(y, t), t)[2:-2]

    lift, turn = m * acceleration((d1 + d2) / 2), J * acceleration((d2 - d1) / D)
    pull = -np.minimum(lift / 2 - turn / D, lift / 2 + turn / D)
    X, Y = 4 * A * h / D * np.sin(np.pi / 4), 2 * A * np.cos(np.pi / 4)
    found = float(stack.stack_tension(m, J, f, Y, X / 2 / h, D))
    assert found == pytest.approx(pull.max(), rel=1e-3)
    # 94.7 N of the rise and 44.1 N of the rocking of the packaged tip, 104.5 N together, worked out separately.
    assert float(stack.stack_tension(m, 0.0, f, Y, X / 2 / h, D)) == pytest.approx(94.7, rel=2e-3)
    assert float(stack.stack_tension(0.0, J, f, Y, X / 2 / h, D)) == pytest.approx(44.1, rel=2e-3)
    assert found == pytest.approx(104.5, rel=2e-3)


def test_drive_force_balances_and_stress_never_falls_with_it():
    assert float(stack.drive_pull(10.0, 20e-3, 46e-3)) * 46e-3 == pytest.approx(10.0 * 20e-3)
    stress = stack.side_load(np.linspace(0.0, 100.0, 300), L, 5.4e-3, A, E, 25e-6).stress
    assert np.all(np.diff(stress) >= 0) and stress[-1] > stress[60]


def test_side_load_is_that_of_a_beam_until_the_bore_holds_it():
    free = stack.side_load(3.3, L, 5.4e-3, A, E, 1e-3)
    moment, end = beam_moment(3.3)
    assert not free.touches and float(free.deflection) == pytest.approx(end, rel=1e-5)
    assert float(free.stress) == pytest.approx(moment * np.sqrt(A) / 2 / (A**2 / 12), rel=1e-5)
    # It touches at 5.39 N, with 9.3 MPa at the foot, by a separate solution of the propped cantilever.
    touching = stack.side_load(5.39, L, 5.4e-3, A, E, 25e-6)
    assert float(touching.touch_force) == pytest.approx(5.39, rel=2e-3)
    assert float(touching.stress) == pytest.approx(9.3e6, rel=5e-3)
    many = stack.side_load(np.array([1.0, 3.3, 10.0]), L, 5.4e-3, A, E, 25e-6)
    np.testing.assert_array_equal(many.touches, [False, False, True])
    assert float(stack.side_load(3.3, L, L, A, E, 0.0).stress) == pytest.approx(float(free.stress))


def test_sway_rocking_and_inertia_of_stacks_and_tip():
    bent = stack.side_load(1.0, L, 5.4e-3, A, E, 1e-3)
    assert float(stack.sway_stiffness(L, A, E)) == pytest.approx(1 / float(bent.deflection))
    assert float(stack.sway_stiffness(L, A, E)) == pytest.approx(0.167e6, rel=5e-3)
    angle, k, D = 1e-6, 47e6, 46e-3
    moment = 2 * k * (D / 2 * angle) * (D / 2)
    assert float(stack.rocking_stiffness(k, D)) * angle == pytest.approx(moment)
    # 4.694e-6 kg m^2 about the piezos' plane at 22.93 g, by integrating the exact solid.
    assert float(stack.tip_inertia(0.022933, 46e-3 / np.sqrt(3), 20e-3)) == pytest.approx(4.694e-6, rel=0.05)


def test_heat_of_a_stack_and_its_balance():
    C, V, f, loss = 1.5e-6, 150.0, 1000.0, 0.05
    t = np.linspace(0, 1 / f, 100001)
    voltage = V / 2 * np.sin(2 * np.pi * f * t)
    delay = np.arctan(loss)
    charge = C / np.cos(delay) * V / 2 * np.sin(2 * np.pi * f * t - delay)
    heat = f * np.trapezoid(voltage * np.gradient(charge, t), t)
    assert float(stack.stack_heat(C, V, f, loss)) == pytest.approx(heat, rel=1e-4)
    assert float(stack.stack_current(C, V, f)) == pytest.approx(np.max(np.gradient(C * voltage, t)), rel=1e-6)
    # Steady: all heat leaves to the surroundings; heated always: the steady state.
    assert TWO.outside @ TWO.steady(POWER) == pytest.approx(20.0)
    assert TWO.cycle(POWER, 8.0, 8.0)[0] == pytest.approx(TWO.steady(POWER))
    one = ThermalNetwork(np.array([3.0]), np.zeros((1, 1)), np.array([0.5]))
    assert one.after(np.zeros(1), np.array([20.0]), 2.0)[0] == pytest.approx(40.0 * -math.expm1(-2.0 / 6.0))
    refused("period", TWO.cycle, POWER, 9.0, 8.0)
    # 57.1 W in two stacks warm one without losses by 9.7 K/s: 25 mm^2 of ceramic, 36 mm long, 3.3 MJ/m^3/K.
    r = DesignInputs(load_design(None, ["heat.capacity=3.27e6 J/m^3/K"]))
    assert 57.1 / 2 / (r("heat.capacity") * 25e-6 * 36e-3) == pytest.approx(9.7, rel=0.01)
    warm = network(r).after(np.zeros(4), np.array([1.5 * 57.1, 0.0, 0.0, 0.0]), 1e-3)
    assert warm[0] == pytest.approx(9.7e-3, rel=0.02)


def test_temperature_and_drift_of_the_duty_cycle() -> None:
    """Twice the rest, nearly half of the mean heat: holder and base are half as warm; a move still warms the stacks."""
    often, seldom = (DesignInputs(load_design(None, [f"heat.period={s} s"])) for s in (10, 20))
    assert warmed(seldom).hottest[3] == pytest.approx(warmed(often).hottest[3] / 2, rel=0.01)
    assert warmed(seldom).hottest[0] > 0.7 * warmed(often).hottest[0]
    # The ceramic shrinks as it warms, and aluminium grows: the tip sinks by most of the stacks' shrinking.
    whole, comes_and_goes = growth(often)
    stacks = often.material("piezo", "expansion") * often("piezo.length") * warmed(often).hottest[0]
    assert stacks < whole < 0.7 * stacks and comes_and_goes == pytest.approx(whole, rel=0.2)
