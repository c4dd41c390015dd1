"""Laws along whole records against closed forms: delay, lag, strength after a rest, resonance, and a piezo's past."""

import numpy as np
import pytest

from sim.effects.catalogue import find
from sysid.prediction.force_balance.record import make_axis

STEP, TIME_CONSTANT = 1e-3, 4.2e-3
REST_STEP = 1e-3
FORCE, CUT_OFF, LENGTH, SPEED = 0.3, 0.02, 4e-5, 2e-3


def test_a_wave_of_eight_rows_a_period_keeps_its_height_and_a_step_is_not_overshot() -> None:
    effect = find("sensor_delay:of_curves")
    p = effect.values_type(delay=0.5e-3)
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
    signal = np.array([3.0, 1.0, 4.0, 1.0, 5.0])
    for delay, wanted in ((0.0, signal), (2e-3, [3.0, 3.0, 3.0, 1.0, 4.0])):
        assert effect.signal(signal, 1e-3, effect.values_type(delay=delay)) == pytest.approx(np.array(wanted))


@pytest.mark.parametrize("name", ["sensor_delay", "drive_delay"])
def test_a_command_that_goes_straight_between_rows_comes_late_as_it_is(name: str) -> None:
    effect = find(name)
    late = effect.signal(np.array([0.0, 2.0, 1.0, 5.0]), 1e-3, effect.values_type(delay=0.25e-3))
    assert late == pytest.approx([0.0, 1.5, 1.25, 4.0])


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
    effect, signal = find("drive_lag:of_steps"), np.sin(0.3 * np.arange(50.0))
    share, y = -np.expm1(-STEP / TIME_CONSTANT), signal[0]
    found = effect.signal(signal, STEP, effect.values(time_constant=TIME_CONSTANT, early=1.0))
    for k in range(1, signal.size):
        y += share * (signal[k] - y)
        assert found[k] == pytest.approx(y, abs=1e-12)


def _axis(noise: float = 0.0):
    """A slide, a rest of a second, a slide."""
    time = REST_STEP * np.arange(3000)
    velocity = np.where((time >= 1.0) & (time < 2.0), 0.0, SPEED)
    position = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * REST_STEP)])
    position = position + noise * np.random.default_rng(1).standard_normal(time.size)
    return make_axis(time, position, velocity, np.zeros(time.size), None, None, 1e-6)


def _level(axis):
    effect = find("dwell_strengthening:fading")
    return effect.level(axis, effect.values(force=FORCE, cut_off=CUT_OFF, memory_length=LENGTH))


def test_strength_after_a_rest_fades_with_the_way_and_noise_renews_no_contact():
    axis = _axis()
    level = _level(axis)
    resting = (axis.time >= 1.05) & (axis.time < 1.99)
    rise = FORCE * np.log1p(np.maximum(axis.time - 1.0, 0.0) / CUT_OFF)
    assert level[resting] == pytest.approx(rise[resting], rel=0.03)  # a rest begins between two rows
    assert not level[axis.time < 1.0].any()
    sliding = axis.time > 2.005
    gone = axis.position - axis.position[2001]
    assert level[sliding] == pytest.approx((level[2001] * np.exp(-gone / LENGTH))[sliding], rel=1e-6, abs=1e-12)
    quiet, noisy = _axis(), _axis(noise=2e-7)
    end = 1990
    for name in ("dwell_strengthening", "dwell_strengthening:kato"):
        effect = find(name)
        p = effect.values(memory_length=1e-5)
        ages = [effect.memory(axis, p).contact_age[end] for axis in (quiet, noisy)]
        assert ages[0] == pytest.approx(0.99, abs=0.01) and ages[1] == pytest.approx(ages[0], rel=0.01)
    assert _level(noisy)[end] == pytest.approx(_level(quiet)[end], rel=0.01)


MODE_STEP, FREQUENCY, DAMPING = 1e-3, 40.0, 0.05
TIME = MODE_STEP * np.arange(300)
W = 2.0 * np.pi * FREQUENCY
WD = W * np.sqrt(1.0 - DAMPING**2)


def _answer(name: str, signal: np.ndarray) -> np.ndarray:
    effect = find(name)
    return effect.signal(signal, MODE_STEP, effect.values(frequency=FREQUENCY, damping=DAMPING))


def _step_answer(time: np.ndarray) -> np.ndarray:
    """Answer to a unit step at time zero: 1 - e^(-d w t) (cos wd t + d w/wd sin wd t)."""
    t = np.maximum(time, 0.0)
    rings = np.cos(WD * t) + DAMPING * W / WD * np.sin(WD * t)
    return np.where(time > 0.0, 1.0 - np.exp(-DAMPING * W * t) * rings, 0.0)


def test_a_mode_rings_as_steps_and_ramps_do():
    # Steps of 1 at row 10 and of -3 at row 90, held: the answers add up.
    rows = np.arange(TIME.size)
    signal = np.where(rows >= 10, 1.0, 0.0) - np.where(rows >= 90, 3.0, 0.0)
    wanted = _step_answer(TIME - TIME[10]) - 3.0 * _step_answer(TIME - TIME[90])
    assert _answer("flexible_mode:of_steps", signal) == pytest.approx(wanted, abs=1e-12)
    # A ramp is the integral of a step: so is its answer, here by fine trapezia.
    fine = np.linspace(0.0, TIME[-1], 200 * (TIME.size - 1) + 1)
    rise = _step_answer(fine)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (rise[1:] + rise[:-1]) * np.diff(fine))])[::200]
    assert _answer("flexible_mode", TIME) == pytest.approx(integral, abs=1e-8)


@pytest.mark.parametrize("name", ["piezo_hysteresis", "piezo_hysteresis:bouc_wen", "piezo_hysteresis:free_plays"])
@pytest.mark.parametrize("settled", [0.0, 0.4, 1.0])
def test_the_way_to_the_first_voltage_counts(name: str, settled: float) -> None:
    effect = find(name)
    voltage = 20.0 * np.cos(np.linspace(0.0, 25.0, 400)) + 5.0
    before = np.linspace(settled * voltage[0], voltage[0], 40)
    longer = effect.signal(np.concatenate([before, voltage]), 1e-3, effect.values(width=30.0, settled=1.0))
    record = effect.signal(voltage, 1e-3, effect.values(width=30.0, settled=settled))
    # The steps of Bouc-Wen's law are finite, those of plays are exact.
    assert record == pytest.approx(longer[before.size :], abs=0.02 if "bouc" in name else 1e-12)
    if settled < 1.0:
        assert abs(record[0] - voltage[0]) > 0.05
