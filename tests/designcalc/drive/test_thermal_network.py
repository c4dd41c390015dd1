"""Heat of the stacks: the periodic state against a time integration, the balance of heat, and its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from designcalc.checks.check import DesignInputs
from designcalc.drive.thermal_network import ThermalNetwork
from designcalc.friction_stage.physics.heat import growth, network, warmed
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design

TWO = ThermalNetwork(np.array([3.0, 50.0]), np.array([[0.0, 1.5], [1.5, 0.0]]), np.array([0.1, 0.4]))
POWER = np.array([20.0, 0.0])


def test_the_periodic_state_is_that_of_a_time_integration() -> None:
    """A chain of two bodies written out, through 200 periods from the temperature of the surroundings."""

    def rate(time: float, T: np.ndarray) -> list[float]:
        heat = 20.0 if time % 8.0 < 3.0 else 0.0
        flow = 1.5 * (T[0] - T[1])
        return [(heat - flow - 0.1 * T[0]) / 3.0, (flow - 0.4 * T[1]) / 50.0]

    T = np.zeros(2)
    for period in range(200):
        begin = T
        for start, end in ((0.0, 3.0), (3.0, 8.0)):
            span = (8.0 * period + start + 1e-9, 8.0 * period + end - 1e-9)
            T = solve_ivp(rate, span, T, rtol=1e-9, atol=1e-9).y[:, -1]
            if end == 3.0:
                hottest = T
    found = TWO.cycle(POWER, 3.0, 8.0)
    assert found[0] == pytest.approx(hottest, rel=1e-4)
    assert found[1] == pytest.approx(begin, rel=1e-4)


def test_heat_balances_and_limits_are_those_of_one_body() -> None:
    # Steady: all heat leaves to the surroundings; heated always: the steady state.
    assert TWO.outside @ TWO.steady(POWER) == pytest.approx(20.0)
    assert TWO.cycle(POWER, 8.0, 8.0)[0] == pytest.approx(TWO.steady(POWER))
    one = ThermalNetwork(np.array([3.0]), np.zeros((1, 1)), np.array([0.5]))
    assert one.after(np.zeros(1), np.array([20.0]), 2.0)[0] == pytest.approx(40.0 * -math.expm1(-2.0 / 6.0))
    with pytest.raises(InputError, match="outside"):
        ThermalNetwork(np.array([1.0]), np.zeros((1, 1)), np.zeros(1))
    with pytest.raises(InputError, match="period"):
        TWO.cycle(POWER, 9.0, 8.0)


def test_a_stack_heats_at_the_rate_of_its_heat_capacity() -> None:
    """57.1 W in two stacks warm one without losses by 9.7 K/s: 25 mm^2 of ceramic, 36 mm long, 3.3 MJ/m^3/K."""
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
