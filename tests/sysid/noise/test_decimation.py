"""Decimation of long records by means of blocks."""

import numpy as np
import pytest

from sysid.experiment.record import Record
from sysid.noise.decimation import MOST_ROWS, decimated, decimation_factor, noise_of_means
from sysid.noise.estimate import Noise
from sysid.signals.gaussian_filter import NoiseSpectrum


def _record(time: np.ndarray, **channels: np.ndarray) -> Record:
    step = float(np.median(np.diff(time)))
    units = {"position": "m", "drive_force": "N"}
    return Record("fit", "fit", "fit.csv", time, channels, {c: units[c] for c in channels}, False, (), "", step, True)


def test_the_factor_keeps_all_records_together_within_the_limit():
    time = np.arange(MOST_ROWS) * 1e-3
    assert decimation_factor([_record(time, position=time)]) == 1
    assert decimation_factor([_record(time, position=time)] * 2) == 2
    assert decimation_factor([_record(time, position=time), _record(time[:10], position=time[:10])]) == 2


def test_a_uniform_motion_stays_the_same_motion():
    time = 5.0 + np.arange(1003) * 1e-3
    short = decimated(_record(time, position=2.0 * time), 10)
    assert short.size == 100
    np.testing.assert_allclose(short.channels["position"], 2.0 * short.time, rtol=1e-12)
    assert short.step == pytest.approx(0.01)
    assert "1003 rows are averaged over 10 rows each: 100 rows, a band of 50 Hz" in short.notes[-1]


def test_a_held_force_acts_half_a_step_later_than_its_row():
    """A force that is held from each row to the next has, at the centre of a block, the value half a step earlier."""
    time = np.arange(1000) * 1e-3
    record = _record(time, drive_force=time)
    short = decimated(record, 10, ("drive_force",))
    np.testing.assert_allclose(short.channels["drive_force"][1:], short.time[1:] - 0.5e-3, atol=1e-12)


def test_blocks_without_values_or_across_a_hole_are_left_out():
    time = np.concatenate([np.arange(50) * 1e-3, 10.0 + np.arange(55) * 1e-3])
    position = np.ones(105)
    position[10:20] = np.nan
    position[20:23] = np.nan
    short = decimated(_record(time, position=position), 10)
    assert short.size == 10
    assert np.isnan(short.channels["position"]).tolist() == [False, True] + [False] * 8
    across = decimated(_record(np.delete(time, 3), position=np.delete(position, 3)), 10)
    assert np.all(np.diff(across.time) > 0.0)
    assert not np.any((across.time > 0.06) & (across.time < 9.99))


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9, 0.98])
@pytest.mark.parametrize("k", [2, 10, 37])
def test_noise_of_the_means_is_that_of_simulated_autoregressions(correlation: float, k: int):
    rng = np.random.default_rng(k)
    n, copies = 50 * k, 400
    x = np.empty((copies, n))
    x[:, 0] = rng.standard_normal(copies)
    for i in range(1, n):
        x[:, i] = correlation * x[:, i - 1] + np.sqrt(1.0 - correlation**2) * rng.standard_normal(copies)
    means = 3.0 * x.reshape(copies, 50, k).mean(axis=2)
    found = noise_of_means(
        {"position": Noise(3.0, "m", "given", NoiseSpectrum(correlation, 0.0), quantisation_step=1.0)}, k
    )["position"]
    assert found.value == pytest.approx(float(np.std(means)), rel=0.05)
    lag_one = float(np.mean(means[:, 1:] * means[:, :-1])) / float(np.var(means))
    assert found.autocorrelation == pytest.approx(lag_one, abs=0.03)
    assert found.quantisation_step is None
