"""The resonance of a record against the closed form of its answer to a step and to a ramp."""

import numpy as np
import pytest

from sim.effects.catalogue import find

STEP, FREQUENCY, DAMPING = 1e-3, 40.0, 0.05
TIME = STEP * np.arange(300)
W = 2.0 * np.pi * FREQUENCY
WD = W * np.sqrt(1.0 - DAMPING**2)


def _answer(name: str, signal: np.ndarray) -> np.ndarray:
    effect = find(name)
    return effect.signal(signal, STEP, effect.values(frequency=FREQUENCY, damping=DAMPING))


def _step_answer(time: np.ndarray) -> np.ndarray:
    """Answer to a unit step at time zero: 1 - e^(-d w t) (cos wd t + d w/wd sin wd t)."""
    t = np.maximum(time, 0.0)
    return np.where(
        time > 0.0, 1.0 - np.exp(-DAMPING * W * t) * (np.cos(WD * t) + DAMPING * W / WD * np.sin(WD * t)), 0.0
    )


def test_a_voltage_held_from_row_to_row_rings_as_steps_do():
    # Steps of 1 at row 10 and of -3 at row 90, held: the answers add up.
    rows = np.arange(TIME.size)
    signal = np.where(rows >= 10, 1.0, 0.0) - np.where(rows >= 90, 3.0, 0.0)
    wanted = _step_answer(TIME - TIME[10]) - 3.0 * _step_answer(TIME - TIME[90])
    assert _answer("flexible_mode:of_steps", signal) == pytest.approx(wanted, abs=1e-12)


def test_a_signal_that_is_straight_between_rows_rings_as_a_ramp_does():
    # A ramp is the integral of a step: so is its answer, here by fine trapezia.
    fine = np.linspace(0.0, TIME[-1], 200 * (TIME.size - 1) + 1)
    rise = _step_answer(fine)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (rise[1:] + rise[:-1]) * np.diff(fine))])[::200]
    assert _answer("flexible_mode", TIME) == pytest.approx(integral, abs=1e-8)
