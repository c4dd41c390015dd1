"""A piezo that rested elsewhere before the record answers as the later part of a longer record does."""

import numpy as np
import pytest

from sim.effects.catalogue import find


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
