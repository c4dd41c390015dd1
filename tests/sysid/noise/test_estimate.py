"""The noise floor against noise whose size is known, and against two real rigs."""

from dataclasses import replace

import numpy as np
import pytest

from sysid.experiment.experiment import load_experiment
from sysid.experiment.record import Record, load_records
from sysid.experiment.rigs import RIGS
from sysid.noise.estimate import Noise, estimate_noise, noise_by_channel, noise_warnings, with_quantisation
from sysid.noise.repeats import find_quantisation_step
from tests.beside import beside
from tests.experiments import write_rig
from tests.refusals import refused
from tests.sysid.autoregression import autoregression

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
    return SIGMA * autoregression(np.random.default_rng(seed).standard_normal(N), correlation)


def _estimate(force: np.ndarray, **other: np.ndarray) -> Noise:
    return estimate_noise([_record(force, **other)], "friction_force")


CLEAN = _friction(_wandering(np.arange(N) * STEP))


@pytest.mark.parametrize("seed", range(3))
def test_white_noise_under_a_rough_signal(seed):
    noise = _estimate(CLEAN + _white(seed))
    assert noise.value == pytest.approx(SIGMA, rel=0.08)
    assert noise.source == "difference" and noise.autocorrelation < 0.15 and not noise.filtered and noise.unit == "N"


def test_a_sensor_that_is_slower_than_the_logger() -> None:
    own = np.arange(N) % 5 == 0
    assert _estimate(np.where(own, CLEAN + _white(1), np.nan)).value == pytest.approx(SIGMA, rel=0.15)
    coloured = _estimate(np.where(own, np.repeat(_autoregressive(1, 0.7)[: N // 5], 5), np.nan))
    assert coloured.value == pytest.approx(SIGMA, rel=0.15)
    assert coloured.autocorrelation == pytest.approx(0.7**0.2, abs=0.05)


@pytest.mark.parametrize("correlation", [0.5, 0.7, 0.9, 0.95])
def test_coloured_noise_is_not_taken_for_smaller_white_noise(correlation):
    # Differences of neighbours alone would give 0.58, 0.45, 0.26 and 0.18 of it.
    noise = _estimate(CLEAN + _autoregressive(1, correlation))
    assert noise.value == pytest.approx(SIGMA, rel=0.25)
    assert noise.autocorrelation == pytest.approx(correlation, abs=0.06)
    assert noise.to_json()["autocorrelation"] == pytest.approx(noise.autocorrelation, abs=1e-4)
    assert "autocorrelated over" in noise.note


def test_jitter_outliers_gaps_and_uneven_noise_do_not_count():
    generator = np.random.default_rng(13)
    time = np.arange(N) * STEP
    force = _friction(_wandering(time)) + _white(13)
    record = replace(_record(force, _wandering(time)), time=time + 0.2 * STEP * generator.uniform(-1.0, 1.0, N))
    assert estimate_noise([record], "friction_force").value == pytest.approx(SIGMA, rel=0.08)
    generator = np.random.default_rng(5)
    force = CLEAN + _white(4)
    places = generator.choice(N, N // 50, replace=False)
    force[places] += 30 * SIGMA * generator.standard_normal(places.size)
    for start in generator.choice(N - 50, 40, replace=False):
        force[start : start + 20] = np.nan
    assert _estimate(force).value == pytest.approx(SIGMA, rel=0.12)


def test_cycles_of_a_motion_tell_the_noise():
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
    position = 0.01 * np.sin(2 * np.pi * time / 1.5)
    noise = estimate_noise([_record(_friction(position) + _white(7), position)], "friction_force")
    assert noise.source == "repeats" and noise.value == pytest.approx(SIGMA, rel=0.08)
    load = 10.0 + 3.0 * np.sin(0.9 * time)
    force = _friction(position) * load / 10.0 + _white(8)
    noise = estimate_noise([_record(force, position, normal_load=load)], "friction_force")
    assert noise.source != "repeats" and noise.value == pytest.approx(SIGMA, rel=0.1)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.8, 0.95])
def test_noise_of_a_motion_with_rests(correlation):
    time = np.arange(N) * STEP
    held = np.floor(time / 2.0) ** 1.3 + np.where((time % 2.0) < 1.0, 0.0, (time % 2.0) - 1.0)
    force = 30.0 * np.sqrt(1 + held) + _autoregressive(3, correlation)
    noise = estimate_noise([_record(force, held)], "friction_force")
    assert noise.value == pytest.approx(SIGMA, rel=0.2)
    assert noise.autocorrelation == pytest.approx(correlation, abs=0.06)


@pytest.mark.parametrize("step", [0.05, 0.3])
def test_a_grid_is_found_and_does_not_hide_the_noise(step):
    noise = _estimate(step * np.round((CLEAN + 0.05 * np.random.default_rng(10).standard_normal(N)) / step))
    assert noise.quantisation_step == pytest.approx(step, rel=1e-6)
    # The rounding is part of the noise; noise of a sixth of a step can only be bounded.
    assert noise.value == pytest.approx(np.hypot(0.05, step / np.sqrt(12.0)), rel=0.15)
    assert noise.without_quantisation == pytest.approx(0.05, rel=0.15 if step == 0.05 else 0.8)
    assert "grid" in noise.note


def test_a_sensor_on_two_levels_is_quantised_where_its_noise_is_stated(tmp_path):
    time = np.arange(2000) * STEP
    velocity = np.where(np.sin(8.0 * np.pi * time) > 0.0, 0.01, -0.01)
    columns = {"time": time, "velocity": velocity, "friction_force": 6.0 * np.sign(velocity)}
    steps = []
    for noise in (None, {"friction_force": "0.01 N"}):
        experiment = load_experiment(write_rig(tmp_path, "velocity-drive", {"fit": columns}, ["coulomb"], noise=noise))
        found, _ = noise_by_channel(experiment, load_records(experiment))
        steps.append(found["friction_force"].quantisation_step)
    assert steps == [None, pytest.approx(12.0)]


def test_stated_noise_is_taken_with_its_rounding_and_colour():
    step = 0.05
    values = step * np.round((CLEAN + 0.03 * np.random.default_rng(10).standard_normal(N)) / step)
    total = float(np.hypot(0.03, step / np.sqrt(12.0)))
    # Whether the stated value contains the rounding follows from the records.
    for stated in (0.03, total):
        noise = estimate_noise([_record(values)], "friction_force", stated)
        assert noise.source == "given" and noise.value == pytest.approx(total, rel=0.08)
    # Less than the rounding itself is kept, and an effect can be missing; with the effect the floor contains it.
    noise = estimate_noise([_record(values)], "friction_force", 0.005)
    assert noise.value == 0.005 and noise.without_quantisation is None
    added = with_quantisation({"friction_force": noise}, ["sensor_quantisation"])["friction_force"]
    assert added.value == pytest.approx(np.hypot(0.005, step / np.sqrt(12.0)))
    assert with_quantisation({"friction_force": added}, ["sensor_quantisation"])["friction_force"] == added
    noise = estimate_noise([_record(CLEAN + _autoregressive(2, 0.85))], "friction_force", 0.5)
    assert (noise.value, noise.source) == (0.5, "given") and noise.autocorrelation == pytest.approx(0.85, abs=0.06)
    stated = {"value": 0.5, "unit": "N", "from": "given"}
    assert noise.to_json() == stated | {"autocorrelation": round(noise.autocorrelation, 4)}
    assert estimate_noise([_record(CLEAN + _white(2))], "friction_force", 0.5).to_json() == stated


def test_uneven_times_and_values_on_no_grid():
    time = np.cumsum(STEP * np.random.default_rng(12).uniform(0.3, 1.7, N))
    force = np.sin(3.0 * time) + _white(12)
    record = Record("fit", "fit", "fit.csv", time, {"position": _wandering(time), "friction_force": force},
                    {"position": "m", "friction_force": "N"}, False, (), "", STEP, False)  # fmt: skip
    assert estimate_noise([record], "friction_force").value == pytest.approx(SIGMA, rel=0.08)
    square = 0.8 * np.sign(np.sin(0.01 * np.arange(N)))
    assert find_quantisation_step([square]) is None
    assert find_quantisation_step([square + 0.8 * np.sign(np.sin(0.037 * np.arange(N)))]) is None
    assert find_quantisation_step([CLEAN + _white(11)]) is None
    assert find_quantisation_step([np.arange(500) * 0.1 + 5e-3 * np.random.default_rng(0).standard_normal(500)]) is None
    assert find_quantisation_step([np.round(CLEAN / 1e-3) * 1e-3]) == pytest.approx(1e-3, rel=1e-6)


@pytest.mark.parametrize("force", [np.zeros(N), np.full(N, 3.0), np.arange(N) ** 1.5 * 1e-5])
def test_a_channel_without_noise_still_has_a_floor_to_divide_by(force):
    noise = _estimate(force)
    assert 0.0 < noise.value <= 1e-7 and "no noise is detected" in noise.note


def test_channels_without_values_or_noise():
    refused("no record holds 'velocity'", estimate_noise, [_record(CLEAN)], "velocity")
    coarse = np.round(2.0 * np.sin(np.arange(N) * 0.01))
    assert "5 different values: if these are the steps of its sensor, give [noise]" in _estimate(coarse).note
    # A constant channel has no steps, and one with noise is measured.
    assert "different values" not in _estimate(np.full(N, 3.0)).note
    assert "different values" not in _estimate(coarse + _white(3)).note
    position = np.where(np.arange(N) > 0.8 * N, _wandering(np.arange(N) * STEP), 0.0)
    force = np.where(np.arange(N) > 0.8 * N, CLEAN + _white(14), 0.7)
    assert _estimate(force, position=position).value == pytest.approx(SIGMA, rel=0.15)


def test_real_rigs():
    emps = load_records(load_experiment(beside("data", "emps")))
    # The differences of neighbours give 0.13 N; at constant speed the force scatters by 0.77 N within 0.1 s, with an
    # autocorrelation of 0.95, ripple of the drive included.
    assert 0.13 < estimate_noise(emps, "drive_force").value < 0.77 and estimate_noise(emps, "position").value < 2e-8
    records = load_records(load_experiment(beside("data", "reciprocating_tribometer")))
    tribometer = estimate_noise(records, "friction_force")
    assert tribometer.source == "repeats" and tribometer.filtered
    # 0.05 N is what the rig's own account gives, to one digit, for the scatter from cycle to cycle.
    assert tribometer.value == pytest.approx(0.05, rel=0.25)


@pytest.mark.slow
def test_practice_records_whose_noise_is_given():
    ratios = []
    for folder in sorted(beside("practice").glob("case*")):
        experiment = load_experiment(folder)
        records = load_records(experiment)
        for channel, given in experiment.noise.items():
            if channel in (*RIGS[experiment.rig.kind].measured_channels, "drive_force"):
                noise = estimate_noise(records, channel)
                # The key states the noise before rounding; under a coarse grid it leaves no trace.
                if noise.quantisation_step is None:
                    ratios.append(noise.value / given)
                elif noise.quantisation_step < 3.0 * given:
                    assert noise.without_quantisation is not None
                    ratios.append(noise.without_quantisation / given)
    assert len(ratios) > 30 and np.quantile(ratios, 0.1) > 0.9 and np.quantile(ratios, 0.9) < 1.1
    # A signal that changes within a few samples is not distinguishable from noise of a short correlation time.
    assert min(ratios) > 0.75 and max(ratios) < 1.3


def test_the_colour_of_noise_that_comes_and_goes():
    level = np.exp(0.6 * np.sin(2.0 * np.pi * 3.0 * np.arange(N) / N))
    slow = 1e3 * SIGMA * np.sin(2.0 * np.pi * 0.3 * np.arange(N) * STEP)
    found = _estimate(slow + level * _autoregressive(6, 0.7))
    assert 0.5 <= found.autocorrelation <= 0.8 and found.value == pytest.approx(SIGMA * np.median(level), rel=0.3)
    noise = _autoregressive(7, 0.7)
    noise[::80] = np.nan
    found, whole = _estimate(noise), _estimate(_autoregressive(7, 0.7))
    assert found.autocorrelation == pytest.approx(whole.autocorrelation, abs=0.1)
    assert found.value == pytest.approx(whole.value, rel=0.1)


@pytest.mark.parametrize("force", [np.full(N, np.nan), np.r_[1.0, 2.0, 3.0, np.full(N - 3, np.nan)]])
def test_channel_without_enough_values_is_refused_or_stated(force):
    refused("too few samples to estimate its noise; give it under", _estimate, force)
    assert estimate_noise([_record(force)], "friction_force", 0.1).value == 0.1


def test_warning_of_an_error_far_below_the_noise():
    noise = {"friction_force": Noise(0.5, "N", "given"), "position": Noise(1e-6, "m", "difference")}
    lines = noise_warnings(noise, {"friction_force": (0.4, 5000), "position": (0.95, 5000)})
    assert len(lines) == 1 and "friction_force" in lines[0] and "stated noise (0.5 N)" in lines[0]
    assert noise_warnings(noise, {"position": (0.3, 5000)})[0].endswith("state it under [noise]")
    assert not noise_warnings(noise, {"friction_force": (0.4, 100)})


@pytest.mark.parametrize("correlation", [0.0, 0.8])
def test_hum_of_the_mains_is_part_of_the_noise(correlation: float) -> None:
    hum = 1.2 * SIGMA * np.sin(2.0 * np.pi * 60.0 * np.arange(N) * STEP)
    found = _estimate(CLEAN + _autoregressive(7, correlation) + hum)
    assert found.value == pytest.approx(SIGMA * np.hypot(1.0, 1.2 / np.sqrt(2.0)), rel=0.12)
