"""What counts as both effects of a pair found."""

from __future__ import annotations

import pytest

from benchmarks.scoring import both_found


@pytest.mark.parametrize(
    "told,right",
    [
        ([["run_in"], ["sensor_delay"]], True),
        ([["sensor_lag", "sensor_delay"], ["run_in"]], True),
        ([["run_in"], ["stribeck"], ["sensor_delay"]], True),
        ([["run_in"]], False),
        ([["run_in", "sensor_delay"]], False),  # one round names one effect
        ([["run_in"], ["a", "b", "c", "sensor_delay"]], False),  # a tie of four says nothing
        ([], False),
    ],
)
def test_each_of_a_pair_needs_a_round_of_its_own(told: list[list[str]], right: bool) -> None:
    assert both_found("sensor_delay+run_in", told) is right
