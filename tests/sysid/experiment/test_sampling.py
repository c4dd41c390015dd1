"""Times of rows: stamps rounded in printing, missing rows, and stamps that are uneven."""

import numpy as np
import pytest

from sysid.experiment.record import sampled_times, stamp_rounding


@pytest.mark.parametrize("rate", [10.0, 30.0, 60.0, 70.0, 333.0, 1000.0, 10_000.0])
@pytest.mark.parametrize("digits", [6, 4, 3, 2])
def test_rows_sampled_evenly_are_even_whatever_the_rounding(rate: float, digits: int) -> None:
    time = np.arange(3000) / rate
    printed, notes = np.round(time, digits), []
    rounding = stamp_rounding(printed)
    found = sampled_times(printed, rounding, notes)
    # Stamps that are all equal to their neighbours are treated before, as repeated times.
    assert np.max(np.abs(np.diff(found) * rate - 1.0)) < 1e-3
    if 0.0 < rounding < 0.5 / rate:
        # The slope over 3000 rows has the error of the rounding over 3000^1.5.
        assert np.max(np.abs(np.diff(found) * rate - 1.0)) < 1e-9 + 10.0 * rounding * rate / 3000.0**1.5
    assert found[0] == printed[0]
    assert bool(notes) == (rounding > 0.01 / rate and np.max(np.abs(printed - time)) > 1e-4 * rounding)


def test_missing_rows_stay_missing() -> None:
    time = np.delete(np.arange(500) / 60.0, [100, 101, 250])
    found = sampled_times(np.round(time, 6), 1e-6, [])
    assert np.abs(found - time).max() < 1e-6
    assert np.allclose(np.diff(found)[[99, 247]] * 60.0, [3.0, 2.0])


def test_uneven_stamps_are_kept() -> None:
    time = np.cumsum(np.random.default_rng(1).uniform(0.8e-3, 1.2e-3, 500))
    assert np.array_equal(sampled_times(np.round(time, 6), 1e-6, []), np.round(time, 6))
