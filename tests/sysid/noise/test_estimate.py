"""The noise floor against noise whose size is known, and against two real rigs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.errors import InputError
from sysid.experiment.record import Record
from sysid.noise.estimate import Noise, estimate_noise
from sysid.noise.quantisation import find_quantisation_step

SHARED = Path(__file__).parents[4] / "shared"
N, STEP = 12000, 1e-3
SIGMA = 0.02


def _record(force: np.ndarray, position: np.ndarray | None = None, **other: np.ndarray) -> Record:
    time = np.arange(force.size) * STEP
    position = _wandering(time) if position is None else position
    channels = {"position": position, "friction_force": force, **other}
    units = {"position": "m", "friction_force": "N", "normal_load": "N"}
    return Record("fit", "fit", "fit.csv", time, channels, units, False, (), "", STEP, True)


def _wandering(time: np.ndarray) -> np.ndarray:
    """A motion that never repeats: three sines with no common period."""
    return 0.01 * (np.sin(2.1 * time) + 0.6 * np.sin(np.sqrt(2) * 3.3 * time + 1) + 0.3 * np.sin(np.pi * 5.1 * time))


def _friction(position: np.ndarray) -> np.ndarray:
    """Friction with jumps at reversals, a Stribeck bump, and a slope in position: what noise must not be taken for."""
    velocity = np.gradient(position, STEP)
    return 2.0 * np.sign(velocity) * (1.0 + 0.5 / (1.0 + (velocity / 0.004) ** 2)) + 3.0 * velocity + 20.0 * position


def _white(seed: int) -> np.ndarray:
    return SIGMA * np.random.default_rng(seed).standard_normal(N)


def _autoregressive(seed: int, correlation: float) -> np.ndarray:
    drive = np.random.default_rng(seed).standard_normal(N)
    noise = np.empty(N)
    state = drive[0]
    for i in range(N):
        state = correlation * state + np.sqrt(1 - correlation**2) * drive[i]
        noise[i] = state
    return SIGMA * noise


def _estimate(force: np.ndarray, **other: np.ndarray) -> Noise:
    return estimate_noise([_record(force, **other)], "friction_force")


CLEAN = _friction(_wandering(np.arange(N) * STEP))


@pytest.mark.parametrize("seed", range(3))
def test_white_noise_under_a_rough_signal(seed):
    noise = _estimate(CLEAN + _white(seed))
    assert noise.value == pytest.approx(SIGMA, rel=0.08)
    assert noise.source == "difference" and noise.correlation < 0.15 and not noise.filtered and noise.unit == "N"


@pytest.mark.parametrize("correlation", [0.5, 0.7, 0.85])
def test_coloured_noise_is_not_taken_for_smaller_white_noise(correlation):
    # Differences alone would give sqrt((1 - r)/(1 + r)) of it: 0.5, 0.28 and 0.16 of the truth.
    noise = _estimate(CLEAN + _autoregressive(1, correlation))
    assert noise.value == pytest.approx(SIGMA, rel=0.25)
    assert noise.correlation == pytest.approx(correlation, abs=0.1)
    assert noise.correlation_time == pytest.approx(-STEP / np.log(noise.correlation))


def test_outliers_gaps_and_uneven_noise_do_not_count():
    generator = np.random.default_rng(5)
    force = CLEAN + _white(4)
    places = generator.choice(N, N // 50, replace=False)
    force[places] += 30 * SIGMA * generator.standard_normal(places.size)
    for start in generator.choice(N - 50, 40, replace=False):
        force[start : start + 20] = np.nan
    assert _estimate(force).value == pytest.approx(SIGMA, rel=0.12)


def test_a_filtered_log_is_noticed_and_its_cycles_tell_the_noise():
    generator = np.random.default_rng(6)
    time = np.arange(N) * STEP
    # Low-passed noise: forty random sines below 8 Hz, nothing above.
    waves = [(generator.uniform(0.2, 8.0), generator.uniform(0, 6.28)) for _ in range(40)]
    smooth = SIGMA * np.sqrt(2 / 40) * sum(np.sin(2 * np.pi * f * time + p) for f, p in waves)
    triangle = 0.001 * (2 * np.abs((time / 0.8) % 1 - 0.5) - 0.5)
    force = 2.0 * np.tanh(np.sin(2 * np.pi * time / 0.8) / 0.1) + smooth
    noise = estimate_noise([_record(force, triangle)], "friction_force")
    assert noise.source == "repeats" and noise.filtered and "filtered" in noise.note
    assert noise.value == pytest.approx(SIGMA, rel=0.3)
    alone = _estimate(2.0 * np.sin(2.3 * time) + smooth)
    assert alone.filtered and alone.source == "difference" and "lower bound" in alone.note


def test_white_noise_on_a_repeating_motion_comes_from_its_cycles():
    time = np.arange(N) * STEP
    position = 0.01 * np.sin(2 * np.pi * time / 1.5)
    noise = estimate_noise([_record(_friction(position) + _white(7), position)], "friction_force")
    assert noise.source == "repeats" and noise.value == pytest.approx(SIGMA, rel=0.08)


def test_cycles_that_differ_by_their_load_are_no_noise():
    time = np.arange(N) * STEP
    position = 0.01 * np.sin(2 * np.pi * time / 1.5)
    load = 10.0 + 3.0 * np.sin(0.9 * time)
    force = _friction(position) * load / 10.0 + _white(8)
    noise = estimate_noise([_record(force, position, normal_load=load)], "friction_force")
    assert noise.source != "repeats" and noise.value == pytest.approx(SIGMA, rel=0.1)


def test_quiet_stretches_are_used_where_the_input_stands_still():
    time = np.arange(N) * STEP
    position = np.where((time % 2.0) < 1.0, 0.01 * np.floor(time / 2.0) ** 1.3 + 0.005 * time**1.1, np.nan)
    held = np.maximum.accumulate(np.nan_to_num(position, nan=-1.0))
    noise = estimate_noise([_record(30.0 * np.sqrt(1 + held) + _white(9), held)], "friction_force")
    assert noise.source == "quiet" and noise.value == pytest.approx(SIGMA, rel=0.08)


@pytest.mark.parametrize("correlation", [0.5, 0.8, 0.95])
def test_coloured_noise_in_quiet_stretches(correlation):
    time = np.arange(N) * STEP
    held = np.floor(time / 2.0) ** 1.3 + np.where((time % 2.0) < 1.0, 0.0, (time % 2.0) - 1.0)
    force = 30.0 * np.sqrt(1 + held) + _autoregressive(3, correlation)
    noise = estimate_noise([_record(force, held)], "friction_force")
    assert noise.source == "quiet" and noise.value == pytest.approx(SIGMA, rel=0.2)
    assert noise.correlation == pytest.approx(correlation, abs=0.06)


@pytest.mark.parametrize("step", [0.05, 0.3])
def test_a_grid_is_found_and_does_not_hide_the_noise(step):
    noise = _estimate(step * np.round((CLEAN + 0.05 * np.random.default_rng(10).standard_normal(N)) / step))
    assert noise.quantisation_step == pytest.approx(step, rel=1e-6)
    if step == 0.05:
        assert noise.value == pytest.approx(0.05, rel=0.15)
    else:
        # Noise of a sixth of a step can only be bounded.
        assert 0.1 * step <= noise.value < 0.5 * step
    assert "grid" in noise.note


def test_values_on_no_grid_have_no_quantum():
    assert find_quantisation_step([CLEAN + _white(11)]) is None
    assert find_quantisation_step([np.arange(500) * 0.1 + 5e-3 * np.random.default_rng(0).standard_normal(500)]) is None
    assert find_quantisation_step([np.round(CLEAN / 1e-3) * 1e-3]) == pytest.approx(1e-3, rel=1e-6)


def test_uneven_times():
    generator = np.random.default_rng(12)
    time = np.cumsum(STEP * generator.uniform(0.3, 1.7, N))
    force = np.sin(3.0 * time) + _white(12)
    record = Record("fit", "fit", "fit.csv", time, {"position": force, "friction_force": force},
                    {"position": "m", "friction_force": "N"}, False, (), "", STEP, False)  # fmt: skip
    noise = estimate_noise([record], "friction_force")
    assert noise.value == pytest.approx(SIGMA, rel=0.08) and "uneven" in noise.note


def test_what_is_given_is_taken_and_only_the_colour_is_read_off():
    noise = estimate_noise([_record(CLEAN + _autoregressive(2, 0.85))], "friction_force", 0.5)
    assert (noise.value, noise.source) == (0.5, "given") and noise.correlation > 0.7
    assert noise.to_json() == {"value": 0.5, "unit": "N", "from": "given"}


@pytest.mark.parametrize("force", [np.zeros(N), np.full(N, 3.0), np.arange(N) ** 1.5 * 1e-5])
def test_a_channel_without_noise_still_has_a_floor_to_divide_by(force):
    noise = _estimate(force)
    assert 0.0 < noise.value <= 1e-7 and "no noise is seen" in noise.note


def test_a_channel_that_nobody_recorded():
    with pytest.raises(InputError, match="no record holds 'velocity'"):
        estimate_noise([_record(CLEAN)], "velocity")


@pytest.mark.skipif(not SHARED.is_dir(), reason="the records of the real rigs are not at hand")
def test_real_rigs():
    from sysid.experiment.experiment import load_experiment
    from sysid.experiment.record import load_records

    emps = load_records(load_experiment(SHARED / "data" / "emps"))
    assert 0.12 <= round(estimate_noise(emps, "drive_force").value, 2) <= 0.15
    assert estimate_noise(emps, "position").value < 2e-8
    records = load_records(load_experiment(SHARED / "data" / "reciprocating_tribometer"))
    tribometer = estimate_noise(records, "friction_force")
    assert tribometer.source == "repeats" and tribometer.filtered
    # 0.05 N is what the rig's own account gives, to one digit, for the scatter from cycle to cycle.
    assert tribometer.value == pytest.approx(0.05, rel=0.25)


@pytest.mark.skipif(not SHARED.is_dir(), reason="the practice records are not at hand")
def test_practice_records_whose_noise_is_given():
    from sysid.experiment.experiment import load_experiment
    from sysid.experiment.record import load_records
    from sysid.experiment.rigs import RIGS

    ratios = []
    for folder in sorted((SHARED / "practice").glob("case*")):
        experiment = load_experiment(folder)
        records = load_records(experiment)
        for channel, given in experiment.noise.items():
            if channel in (*RIGS[experiment.rig.kind].measured_channels, "drive_force"):
                noise = estimate_noise(records, channel)
                # Under a coarse grid the noise leaves no trace.
                if noise.quantisation_step is None or noise.quantisation_step < 3.0 * given:
                    ratios.append(noise.value / given)
    assert len(ratios) > 30
    assert np.quantile(ratios, 0.1) > 0.9 and np.quantile(ratios, 0.9) < 1.1
    assert min(ratios) > 0.75 and max(ratios) < 1.25


def test_the_colour_of_noise_that_comes_and_goes_is_found():
    level = np.exp(0.6 * np.sin(2.0 * np.pi * 3.0 * np.arange(N) / N))
    slow = 1e3 * SIGMA * np.sin(2.0 * np.pi * 0.3 * np.arange(N) * STEP)
    found = _estimate(slow + level * _autoregressive(6, 0.7))
    # The least colour that agrees, and the usual size.
    assert 0.5 <= found.correlation <= 0.8
    assert found.value == pytest.approx(SIGMA * np.median(level), rel=0.3)


def test_even_noise_in_many_short_pieces_is_not_taken_for_uneven():
    noise = _autoregressive(7, 0.7)
    noise[::80] = np.nan
    found, whole = _estimate(noise), _estimate(_autoregressive(7, 0.7))
    assert found.correlation == pytest.approx(whole.correlation, abs=0.1)
    assert found.value == pytest.approx(whole.value, rel=0.1)
