"""What counts as every hidden effect found; a record of ten million rows within two gigabytes."""

from pathlib import Path

import pytest

from benchmarks.large_record import ROWS, measure, write_record
from benchmarks.scoring import all_found, established, not_hidden


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
    assert all_found(["sensor_delay", "run_in"], told) is right


def test_false_effects_of_a_ledger() -> None:
    rows = [
        ("viscous", "established", []),
        ("cable_spring", "established", ["constant_bias"]),
        ("run_in", "possible", []),
    ]
    ledger = [{"effect": name, "state": state, "indistinguishable": ties} for name, state, ties in rows]
    told = established({"ledger": ledger})
    assert told == [["viscous"], ["cable_spring", "constant_bias"]]
    entry = {"effect": "constant_bias+stribeck", "accept": ["stribeck", "constant_bias"]}
    assert not_hidden(told, entry) == ("viscous",)
    assert not_hidden(told, {"effect": "none", "accept": ["adequate"]}) == ("viscous", "cable_spring")


@pytest.mark.slow
def test_ten_million_rows_take_less_than_two_gigabytes(tmp_path: Path) -> None:
    write_record(tmp_path, ROWS, "compare")
    memory, _, _, printed = measure(tmp_path, "compare")
    (tmp_path / "long.csv").unlink()
    assert 0.2e9 < memory < 2e9
    assert "× the noise: the residual is at the noise level" in printed
