"""The lag of an input that goes in steps, against the sum of the closed-form answers to each step."""

import numpy as np
import pytest

from sim.effects.catalogue import find

STEP, TIME_CONSTANT = 1e-3, 4.2e-3


@pytest.mark.parametrize("name", ["drive_lag:of_steps", "sensor_lag:of_steps"])
@pytest.mark.parametrize("early", [0.0, 0.3, 1.0])
def test_every_step_is_answered_as_a_step_is(name: str, early: float) -> None:
    effect = find(name)
    signal = np.random.default_rng(4).standard_normal(80)
    rows = STEP * np.arange(signal.size)
    wanted = np.full(signal.size, signal[0])
    for k in range(1, signal.size):
        since = rows - (rows[k] - early * STEP)
        wanted += (signal[k] - signal[k - 1]) * np.where(since > 0.0, -np.expm1(-since / TIME_CONSTANT), 0.0)
    found = effect.signal(signal, STEP, effect.values(time_constant=TIME_CONSTANT, early=early))
    assert found == pytest.approx(wanted, abs=1e-12)


def test_a_change_a_whole_step_early_is_the_usual_digital_low_pass() -> None:
    effect = find("drive_lag:of_steps")
    signal = np.sin(0.3 * np.arange(50.0))
    share, y = -np.expm1(-STEP / TIME_CONSTANT), signal[0]
    found = effect.signal(signal, STEP, effect.values(time_constant=TIME_CONSTANT, early=1.0))
    for k in range(1, signal.size):
        y += share * (signal[k] - y)
        assert found[k] == pytest.approx(y, abs=1e-12)
