"""A delay of part of a row: what it must not do to waves and steps."""

import numpy as np
import pytest

from sim.effects.catalogue import find


def test_a_wave_of_eight_rows_a_period_keeps_its_height_and_a_step_is_not_overshot() -> None:
    effect = find("sensor_delay:of_curves")
    p = effect.values_type(delay=0.5e-3)
    assert effect.signal is not None
    index = np.arange(800)
    wave = effect.signal(np.sin(2 * np.pi * index / 8.0), 1e-3, p)
    straight = np.interp(index - 0.5, index, np.sin(2 * np.pi * index / 8.0))
    wanted = np.sin(2 * np.pi * (index - 0.5) / 8.0)
    assert np.std((wave - wanted)[10:-10]) < 0.5 * np.std((straight - wanted)[10:-10])
    step = effect.signal((index > 400).astype(float), 1e-3, p)
    assert (step.min(), step.max()) == (0.0, 1.0)


@pytest.mark.parametrize("name", ["sensor_delay", "sensor_delay:of_curves"])
def test_whole_rows_are_the_rows_before_and_before_the_record_is_its_first_value(name: str) -> None:
    effect = find(name)
    assert effect.signal is not None
    signal = np.array([3.0, 1.0, 4.0, 1.0, 5.0])
    for delay, wanted in ((0.0, signal), (2e-3, [3.0, 3.0, 3.0, 1.0, 4.0])):
        assert effect.signal(signal, 1e-3, effect.values_type(delay=delay)) == pytest.approx(np.array(wanted))


@pytest.mark.parametrize("name", ["sensor_delay", "drive_delay"])
def test_a_command_that_goes_straight_between_rows_comes_late_as_it_is(name: str) -> None:
    effect = find(name)
    assert effect.signal is not None
    signal = np.array([0.0, 2.0, 1.0, 5.0])
    late = effect.signal(signal, 1e-3, effect.values_type(delay=0.25e-3))
    assert late == pytest.approx([0.0, 1.5, 1.25, 4.0])
