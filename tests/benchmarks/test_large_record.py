"""A record of ten million rows is compared within two gigabytes."""

from pathlib import Path

import pytest

from benchmarks.large_record import ROWS, measure, write_record


@pytest.mark.slow
def test_ten_million_rows_take_less_than_two_gigabytes(tmp_path: Path) -> None:
    write_record(tmp_path, ROWS)
    memory, _, printed = measure(tmp_path)
    (tmp_path / "long.csv").unlink()
    assert 0.2e9 < memory < 2e9
    assert "× the noise: the residual is at the noise level" in printed
