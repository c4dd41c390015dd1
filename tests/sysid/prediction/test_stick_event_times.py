"""Stops and departures of a sliding mass against a motion known in closed form."""

import numpy as np
import pytest

from sysid.prediction.force_balance.stick_event_times import (
    Forces,
    SlipPhases,
    SmoothedMotion,
    break_away_times,
    restored_kinks,
    sticking_onsets,
)
from sysid.signals.gaussian_filter import GaussianFilter

MASS, LEVEL, STEP = 0.5, 1.2, 1e-3
N, STOP, LEAVE = 400, 160.3, 240.7
ROWS = np.arange(N)
LIGHT = 2.6


def _force() -> np.ndarray:
    """Constant -0.3 N while it slows down, then a ramp that passes the level at LEAVE."""
    return np.where(ROWS < 200, -0.3, -0.3 + (LEVEL + 0.3) * (ROWS - 200.0) / (LEAVE - 200.0))


def _velocity() -> np.ndarray:
    """Exact velocity, m/s: to rest at STOP, and away from LEAVE on, under `_force` less the level."""
    slowing = (LEVEL + 0.3) / MASS * STEP * (STOP - ROWS)
    slope = (LEVEL + 0.3) / (LEAVE - 200.0)
    leaving = 0.5 * slope / MASS * STEP * (ROWS - LEAVE) ** 2
    return np.where(ROWS < STOP, slowing, np.where(ROWS > LEAVE, leaving, 0.0))


def _smooth(signal: np.ndarray, order: int = 0) -> np.ndarray:
    return GaussianFilter(LIGHT * STEP, STEP, N)(signal, order)


STOPS = SlipPhases(np.array([-0.5]), np.array([STOP + 2.5]), np.array([1.0]), np.array([LEAVE - 6.0]), np.array([1.0]))


def test_the_momentum_tells_the_stop_that_the_position_put_late() -> None:
    found = sticking_onsets(STOPS, _smooth(_velocity()), Forces(_force(), np.full(N, LEVEL)), STEP / MASS, LIGHT, 10.0)
    # What the filter tails still bring of the kink from over three widths away.
    assert found == pytest.approx([STOP], abs=0.01)
    # No farther than asked.
    near = sticking_onsets(STOPS, _smooth(_velocity()), Forces(_force(), np.full(N, LEVEL)), STEP / MASS, LIGHT, 1.0)
    assert near == pytest.approx([STOP + 1.5])


def test_a_rest_lasts_until_the_push_reaches_the_level() -> None:
    found = break_away_times(STOPS, Forces(_force(), np.full(N, LEVEL)), 20.0)
    assert found == pytest.approx([LEAVE], abs=1e-9)
    assert break_away_times(STOPS, Forces(_force(), np.full(N, LEVEL)), 2.0) == pytest.approx([LEAVE - 4.0], abs=1.0)


def test_the_velocity_gets_back_the_kinks_that_a_filter_rounds_off() -> None:
    velocity, blurred = _velocity(), _smooth(_velocity())
    motion = SmoothedMotion(blurred * STEP, _smooth(velocity, 1) * STEP**2, _force() / MASS * STEP**2, LIGHT)
    found = restored_kinks(motion, STOPS) / STEP
    near = np.abs(ROWS - STOP) < 8
    assert np.max(np.abs(blurred - velocity)[near]) > 2e-3
    assert np.max(np.abs(found - velocity)[near]) < 1e-4
    beside = (ROWS > LEAVE - 8) & (ROWS < LEAVE + 3)
    assert np.max(np.abs(found - velocity)[beside]) < 0.5 * np.max(np.abs(blurred - velocity)[beside])
