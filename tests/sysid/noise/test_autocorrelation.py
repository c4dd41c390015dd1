"""Noise from differences at several lags and from the regression on the recorded motion."""

import numpy as np
import pytest

from sysid.experiment.record import Record
from sysid.noise.autocorrelation import Series, _differences, fit_noise, without_outliers
from sysid.noise.estimate import motion_residual
from tests.sysid.autoregression import autoregression

STEP = 1e-3


def noise_of(size: int, correlation: float, seed: int) -> np.ndarray:
    return autoregression(np.random.default_rng(seed).standard_normal(size), correlation)


def _series(values: np.ndarray, time: np.ndarray | None = None) -> Series:
    return Series(STEP * np.arange(values.size) if time is None else time, values, STEP)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9, 0.98, 0.99])
def test_level_and_autocorrelation_of_noise_alone(correlation: float) -> None:
    values = [noise_of(20_000, correlation, seed) for seed in range(2)]
    # The second argument: no motion is compared with, and the range of lags is not limited.
    alone = [Series(STEP * np.arange(v.size), v, STEP, np.zeros(9)) for v in values]
    found = fit_noise([_series(v) for v in values], alone)
    assert not found.filtered
    assert found.value == pytest.approx(1.0, rel=0.25 if correlation > 0.95 else 0.08)
    assert found.spectrum.correlation == pytest.approx(correlation, abs=max(0.01, 0.2 * (1.0 - correlation)))
    assert 1.0 / found.factor <= 1.05 * found.value and found.value / found.factor <= 1.05


def test_outliers_rest_and_constant_values() -> None:
    values = noise_of(20_000, 0.0, 5)
    places = np.random.default_rng(6).choice(values.size, 400, replace=False)
    with_outliers = values.copy()
    with_outliers[places] += 40.0
    # A row between two outliers is left out, too.
    cleaned = without_outliers(with_outliers)
    assert np.isnan(cleaned[places]).all() and np.isnan(cleaned).sum() < 460
    clean, dirty = fit_noise([_series(values)]), fit_noise([_series(cleaned)])
    assert dirty.value == pytest.approx(clean.value, rel=0.03)
    values = np.full(20_000, 0.7)
    values[15_000:] += np.sin(0.01 * np.arange(5000)) + 0.01 * noise_of(5000, 0.0, 7)
    found = fit_noise([_series(values)])
    assert found.value == pytest.approx(0.01, rel=0.1)
    found = fit_noise([_series(np.full(200, 2.5))])
    assert found.value == 0.0
    kernel = np.exp(-0.5 * (np.arange(-120, 121) / 15.0) ** 2)
    found = fit_noise([_series(np.convolve(noise_of(20_000, 0.0, 8), kernel, mode="same"))])
    assert found.filtered


@pytest.mark.parametrize("values", [np.full(3, np.nan), np.arange(3.0), np.full(200, np.nan), np.zeros(0)])
def test_too_few_values_give_no_estimate(values: np.ndarray) -> None:
    assert fit_noise([_series(values)]) is None


@pytest.mark.parametrize("order", [2, 4, 6, 8])
@pytest.mark.parametrize("lag", [1, 3, 40])
def test_differences_at_even_spacing_are_the_limit_of_those_at_any(order: int, lag: int) -> None:
    rows = np.delete(np.arange(1200), np.r_[300:340, 800:803])
    random = np.random.default_rng(4)
    values = np.sin(0.01 * rows) + random.standard_normal(rows.size)
    even = _series(values, STEP * rows)
    # A deviation of 1e-6 of a step is not a rounding error.
    uneven = _series(values, STEP * (rows + 1e-6 * random.uniform(-1.0, 1.0, rows.size)))
    assert even.even and not uneven.even
    found, expected = (_differences(one, lag, order) for one in (even, uneven))
    assert found.size == expected.size and found == pytest.approx(expected, abs=2e-4)


N, INTERVAL = 12_000, 2e-3
TIME = INTERVAL * np.arange(N)
POSITION = 0.02 * np.sin(2.1 * TIME) + 0.008 * np.sin(5.3 * TIME + 1.0)
VELOCITY = np.gradient(POSITION, INTERVAL)
FORCE = 2.0 * np.sign(VELOCITY) + 30.0 * VELOCITY + 40.0 * POSITION + 5.0 * np.gradient(VELOCITY, INTERVAL)


def _record(force: np.ndarray, **other: np.ndarray) -> Record:
    channels = {"position": POSITION, "friction_force": force, **other}
    units = dict.fromkeys(channels, "m")
    return Record("fit", "fit", "fit.csv", TIME, channels, units, False, (), "", INTERVAL, True)


def test_forces_of_the_motion_are_explained_and_the_motion_itself_is_not() -> None:
    found = motion_residual(_record(FORCE), FORCE, "friction_force")
    assert np.median(np.abs(found.values)) < 5e-3 * float(np.std(FORCE))
    assert motion_residual(_record(FORCE), POSITION, "position") is None
    assert motion_residual(_record(FORCE, position=np.zeros(N)), FORCE, "friction_force") is None


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_removed_part_of_noise_is_that_of_generated_noise(correlation: float) -> None:
    removed = []
    for seed in range(12):
        noise = noise_of(N, correlation, seed)
        found = motion_residual(_record(noise), noise, "friction_force")
        removed.append(1.0 - float(np.sum(found.values**2) / np.sum((noise - noise.mean()) ** 2)))
    angle = np.linspace(0.0, np.pi, found.removed.size)
    power = (1.0 - correlation**2) / (1.0 - 2.0 * correlation * np.cos(angle) + correlation**2)
    expected = float(np.mean(found.removed * power) / np.mean(power))
    assert np.mean(removed) == pytest.approx(expected, rel=0.25)
