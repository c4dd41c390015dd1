"""The regression on the recorded motion: what it explains, and the noise that it removes."""

import numpy as np
import pytest

from sysid.experiment.record import Record
from sysid.noise.motion_regression import motion_residual
from tests.sysid.noise.test_autocorrelation import autoregression

N, STEP = 12_000, 2e-3
TIME = STEP * np.arange(N)
POSITION = 0.02 * np.sin(2.1 * TIME) + 0.008 * np.sin(5.3 * TIME + 1.0)
VELOCITY = np.gradient(POSITION, STEP)
FORCE = 2.0 * np.sign(VELOCITY) + 30.0 * VELOCITY + 40.0 * POSITION + 5.0 * np.gradient(VELOCITY, STEP)


def _record(force: np.ndarray, **other: np.ndarray) -> Record:
    channels = {"position": POSITION, "friction_force": force, **other}
    units = dict.fromkeys(channels, "m")
    return Record("fit", "fit", "fit.csv", TIME, channels, units, False, (), "", STEP, True)


def test_forces_of_the_motion_are_explained() -> None:
    found = motion_residual(_record(FORCE), FORCE, "friction_force")
    assert found is not None
    assert np.median(np.abs(found.values)) < 5e-3 * float(np.std(FORCE))


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_removed_part_of_noise_is_that_of_generated_noise(correlation: float) -> None:
    removed = []
    for seed in range(12):
        noise = autoregression(N, correlation, seed)
        found = motion_residual(_record(noise), noise, "friction_force")
        assert found is not None
        removed.append(1.0 - float(np.sum(found.values**2) / np.sum((noise - noise.mean()) ** 2)))
    angle = np.linspace(0.0, np.pi, found.removed.size)
    power = (1.0 - correlation**2) / (1.0 - 2.0 * correlation * np.cos(angle) + correlation**2)
    expected = float(np.mean(found.removed * power) / np.mean(power))
    assert np.mean(removed) == pytest.approx(expected, rel=0.25)


def test_motion_itself_and_a_record_of_nothing_else_are_not_regressed() -> None:
    record = _record(FORCE)
    assert motion_residual(record, POSITION, "position") is None
    still = _record(FORCE, position=np.zeros(N))
    assert motion_residual(still, FORCE, "friction_force") is None
