"""Hum of the mains is found and taken out; decimation of long records by means of blocks."""

import numpy as np
import pytest

from sysid.experiment.record import Record
from sysid.noise import mains
from sysid.noise.autocorrelation import Series
from sysid.noise.estimate import MOST_ROWS_FITTED, Noise, decimated, decimation_factor, noise_of_means
from sysid.noise.mains import without_hum
from sysid.signals import NoiseSpectrum
from tests.sysid.autoregression import autoregression

ROWS = 6000


def _noise(seed: int, correlation: float) -> np.ndarray:
    return autoregression(np.random.default_rng(seed).standard_normal(ROWS), correlation)


@pytest.mark.parametrize("rate", [80.0, 200.0, 1000.0])
@pytest.mark.parametrize("frequency", [50.0, 59.95])
def test_hum_is_taken_out_and_its_variance_is_known(rate: float, frequency: float) -> None:
    # At 80 rows per second the line is seen at its alias.
    time = np.arange(ROWS) / rate
    noise, hum = _noise(3, 0.8), 0.9 * np.sin(2.0 * np.pi * frequency * time + 0.4)
    found = without_hum(Series(time, noise + hum, 1.0 / rate))
    assert found.variance == pytest.approx(0.9**2 / 2.0, rel=0.12)
    assert np.std(found.series.values - noise) < 0.35 * np.std(hum)


def test_rows_that_are_missing_or_uneven_do_not_matter() -> None:
    random = np.random.default_rng(5)
    time = np.cumsum(5e-3 * (1.0 + 0.1 * random.uniform(-1.0, 1.0, ROWS)))
    values = _noise(4, 0.5) + 1.2 * np.sin(2.0 * np.pi * 60.0 * time)
    values[random.random(ROWS) < 0.05] = np.nan
    found = without_hum(Series(time, values, 5e-3))
    assert found.variance == pytest.approx(1.2**2 / 2.0, rel=0.1)
    assert np.array_equal(np.isnan(found.series.values), np.isnan(values))


def test_a_slow_motion_in_rows_of_two_rates_is_no_hum() -> None:
    """Rows 10 ms apart see 100 Hz as nearly constant, which a step between the two rates does not show."""
    random = np.random.default_rng(1)
    steps = np.repeat([4.2e-3, 10e-3], 2000) + 4e-5 * random.standard_normal(4000)
    time = np.cumsum(steps)
    slow, hum = np.sin(2.0 * np.pi * 0.4 * time), np.sin(2.0 * np.pi * 49.98 * time)
    noise = 1e-3 * random.standard_normal(time.size)
    assert mains.hum_frequencies(Series(time, 20.0 * slow + noise, 6e-3)) == []
    assert 50.0 in mains.hum_frequencies(Series(time, 0.05 * slow + 0.01 * hum + noise, 6e-3))


def _kept(kind: str) -> np.ndarray:
    """Rows of a log that has gaps in time."""
    if kind == "three gaps":
        return np.delete(np.arange(ROWS), np.r_[700:900, 2000:2003, 4100:4700])
    return np.flatnonzero(np.random.default_rng(7).random(ROWS) < 0.8)


@pytest.mark.parametrize("kind", ["three gaps", "a fifth of the rows"])
def test_gaps_in_time_do_not_matter(kind: str) -> None:
    rows = _kept(kind)
    time, values = rows * 2e-3, _noise(6, 0.7)[rows]
    hum = 0.8 * np.sin(2.0 * np.pi * 50.0 * time + 1.0)
    found = without_hum(Series(time, values + hum, 2e-3))
    # The noise has a part in phase with the hum, which is not distinguishable from it: its power is 1.43 at 0.2 pi, and
    # 1.5 times that in a Hann window.
    apart = 2.0 * 0.8 / np.sqrt(2.0) * np.sqrt(1.5 * 1.43 / rows.size)
    assert abs(found.variance - np.mean(hum**2)) < 3.0 * apart
    assert np.std(found.series.values - values) < 0.35 * np.std(hum)
    assert without_hum(Series(time, values, 2e-3)).variance == 0.0


def test_slow_motions_short_records_and_tones_are_no_hum() -> None:
    time = np.arange(ROWS) / 500.0
    motion = 25.0 * np.sin(2.0 * np.pi * 0.3 * time)
    found = without_hum(Series(time, motion + 0.05 * np.sin(2.0 * np.pi * 50.0 * time) + 1e-3 * _noise(3, 0.0), 2e-3))
    assert found.variance == pytest.approx(0.05**2 / 2.0, rel=0.01)
    series = Series(np.arange(100) * 1e-3, np.sin(2.0 * np.pi * 50.0 * np.arange(100) * 1e-3), 1e-3)
    assert without_hum(series).series is series
    series = Series(np.arange(ROWS) / 400.0, np.sin(2.0 * np.pi * 50.0 * np.arange(ROWS) / 400.0), 2.5e-3)
    assert without_hum(series, "drive_force").series is series
    assert without_hum(series, "friction_force").variance == pytest.approx(0.5, rel=0.05)


@pytest.mark.parametrize("kind", ["even", "three gaps", "a fifth of the rows"])
def test_the_power_is_that_of_the_sum_over_all_rows(kind: str) -> None:
    rows = np.arange(ROWS) if kind == "even" else _kept(kind)
    time, values = rows * 2e-3, _noise(8, 0.5)[rows]
    series, known = Series(time, values, 2e-3), np.delete(np.arange(rows.size), [5, 6, 2500])
    blocks = mains._blocks(series, known)
    expected = [
        sum(abs(np.sum(_windowed(values[own]) * np.exp(-2j * np.pi * f * time[own]))) ** 2 for own in blocks)
        for f in 49.8 + 0.05 * np.arange(9)
    ]
    assert mains._powers(mains._windowed_blocks(series, known), 49.8, 0.05, 9) == pytest.approx(expected, rel=1e-9)


def _windowed(values: np.ndarray) -> np.ndarray:
    return np.hanning(values.size) * (values - np.mean(values))


@pytest.mark.parametrize("correlation", [0.0, 0.9, 0.98])
def test_noise_has_no_hum(correlation: float) -> None:
    time = np.arange(ROWS) / 400.0
    assert all(without_hum(Series(time, _noise(seed, correlation), 2.5e-3)).variance == 0.0 for seed in range(20))


@pytest.mark.parametrize("cycle", [2.5, 5.0, 10.0])
def test_harmonics_of_a_periodic_motion_are_no_hum(cycle: float) -> None:
    # Friction of a motion whose harmonics lie at 50 Hz; the others lie beside it.
    time = np.arange(ROWS) / 1000.0
    force = np.tanh(20.0 * np.sin(2.0 * np.pi * cycle * time + 0.3)) + 1e-3 * _noise(1, 0.0)
    assert without_hum(Series(time, force, 1e-3)).variance == 0.0


def _record(time: np.ndarray, **channels: np.ndarray) -> Record:
    step = float(np.median(np.diff(time)))
    units = {"position": "m", "drive_force": "N"}
    return Record("fit", "fit", "fit.csv", time, channels, {c: units[c] for c in channels}, False, (), "", step, True)


def test_means_of_blocks_keep_motion_and_force():
    time = np.arange(MOST_ROWS_FITTED) * 1e-3
    assert decimation_factor([_record(time, position=time)]) == 1
    assert decimation_factor([_record(time, position=time)] * 2) == 2
    assert decimation_factor([_record(time, position=time), _record(time[:10], position=time[:10])]) == 2
    time = 5.0 + np.arange(1003) * 1e-3
    short = decimated(_record(time, position=2.0 * time), 10)
    assert short.size == 100
    np.testing.assert_allclose(short.channels["position"], 2.0 * short.time, rtol=1e-12)
    assert short.step == pytest.approx(0.01)
    assert "1003 rows are averaged over 10 rows each: 100 rows, a band of 50 Hz" in short.notes[-1]
    # A force that is held from each row to the next has, at the centre of a block, the value half a step earlier.
    time = np.arange(1000) * 1e-3
    short = decimated(_record(time, drive_force=time), 10, ("drive_force",))
    np.testing.assert_allclose(short.channels["drive_force"][1:], short.time[1:] - 0.5e-3, atol=1e-12)
    time = np.concatenate([np.arange(50) * 1e-3, 10.0 + np.arange(55) * 1e-3])
    position = np.ones(105)
    position[10:20] = np.nan
    position[20:23] = np.nan
    short = decimated(_record(time, position=position), 10)
    assert short.size == 10 and np.isnan(short.channels["position"]).tolist() == [False, True] + [False] * 8
    across = decimated(_record(np.delete(time, 3), position=np.delete(position, 3)), 10)
    assert np.all(np.diff(across.time) > 0.0) and not np.any((across.time > 0.06) & (across.time < 9.99))
    time = np.arange(ROWS) / 400.0
    time[ROWS // 2 :] += 1e5
    values = _noise(6, 0.3) + 1.1 * np.sin(2.0 * np.pi * 50.0 * time)
    assert without_hum(Series(time, values, 2.5e-3)).variance == pytest.approx(1.1**2 / 2.0, rel=0.12)
    assert without_hum(Series(time[::600] * 600.0, values[::600], 1.5)).variance == 0.0


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9, 0.98])
@pytest.mark.parametrize("k", [2, 10, 37])
def test_noise_of_the_means_is_that_of_simulated_autoregressions(correlation: float, k: int):
    copies = 400
    x = autoregression(np.random.default_rng(k).standard_normal((copies, 50 * k)), correlation)
    means = 3.0 * x.reshape(copies, 50, k).mean(axis=2)
    noise = Noise(3.0, "m", "given", NoiseSpectrum(correlation, 0.0), quantisation_step=1.0)
    found = noise_of_means({"position": noise}, k)["position"]
    assert found.value == pytest.approx(float(np.std(means)), rel=0.05)
    lag_one = float(np.mean(means[:, 1:] * means[:, :-1])) / float(np.var(means))
    assert found.autocorrelation == pytest.approx(lag_one, abs=0.03) and found.quantisation_step is None
