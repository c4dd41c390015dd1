"""Limit cycles of stick-slip against closed forms: break-away by Kato's law, size by the dwell, critical speed."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from sim.experiments.friction_models import Friction
from sim.experiments.limit_cycles import SPEEDS, cycle, limit_cycles

FRICTION = Friction()
RISE = FRICTION.breakaway - FRICTION.coulomb


@pytest.mark.parametrize("speed", [2e-3, 2e-2])
def test_the_size_of_a_cycle_follows_from_its_dwell(speed: float) -> None:
    """2 A, A = (Fs - Fc)(1 - exp(-gamma (2 A/(k v))^m)), with the speed of the slip added: sqrt(A^2 + m k v^2)."""
    found = cycle(replace(FRICTION, viscous=0.0), "lugre", speed, 2.0, 1.0)
    dwell = brentq(lambda a: a - RISE * (1.0 - math.exp(-1.66 * (2.0 * a / (2.0 * speed)) ** 0.65)), 1e-9, RISE)
    assert found.size == pytest.approx(2.0 * math.hypot(dwell, math.sqrt(2.0) * speed), rel=0.06)
    assert found.first == pytest.approx(FRICTION.breakaway, rel=0.01)


def test_a_stiff_spring_breaks_away_earlier_with_the_force_of_its_shorter_dwell() -> None:
    for speed in SPEEDS[:2]:
        found = cycle(FRICTION, "lugre", speed, 200.0, 1.0)
        expected = FRICTION.coulomb + RISE * (1.0 - math.exp(-1.66 * found.dwell**0.65))
        assert found.top < found.first - 0.02
        assert found.top == pytest.approx(expected, rel=0.05)


def test_above_the_critical_speed_the_mass_slides() -> None:
    found = limit_cycles(FRICTION, "lugre", 20.0)
    assert found.critical is not None and SPEEDS[0] < found.critical < SPEEDS[-1]
    sticks = np.array(SPEEDS) < found.critical
    assert np.all(found.sizes[sticks] > 0.5 * RISE) and np.all(found.sizes[~sticks] < 0.05 * RISE)
    # A mass that slides is driven by Coulomb and viscous friction alone.
    last = found.cycles[-1].simulation
    assert last.drive[-1] == pytest.approx(FRICTION.coulomb + FRICTION.viscous * SPEEDS[-1], rel=0.03)
