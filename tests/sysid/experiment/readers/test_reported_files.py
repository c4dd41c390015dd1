"""Small files of public reports that were once refused or read wrong; they stand beside the project."""

from pathlib import Path

import pytest

from stagecad.parameters.errors import InputError
from sysid.experiment.columns.proposal import propose, read_numbers
from sysid.experiment.readers.open import open_record_file

REPORTS = Path(__file__).parents[5] / "shared" / "failing"
READ = {
    "am_pm": ("fit.csv", 199),
    "d_exponent": ("fit.dat", 200),
    "last_row_cut_off": ("fit.csv", 1499),
    "left_out_without_reason": ("fit.csv", 299),
    "minutes_seconds": ("fit.csv", 199),
    "rows_wider_than_header": ("fit.csv", 199),
    "thousands_dot_decimal_comma": ("fit.csv", 199),
    "unicode_minus": ("fit.csv", 199),
    "units_of_motors": ("fit.csv", 300),
}


@pytest.mark.parametrize("name", READ)
def test_it_is_read(name: str) -> None:
    file, rows = READ[name]
    if not (REPORTS / name).is_dir():
        pytest.skip("the reported files are not beside the project")
    opened = open_record_file(REPORTS / name / file, file)
    numbers = read_numbers(opened)
    assert {values.size for values in numbers.columns.values()} in ({rows}, {rows + 1})
    if not opened.header.numbered:
        channels = {column.channel for column in propose(opened, numbers).columns}
        assert {"time", "position", "friction_force"} <= channels


def test_a_header_alone_is_one_line() -> None:
    file = REPORTS / "ux_header_only" / "header_only.csv"
    if not file.is_file():
        pytest.skip("the reported files are not beside the project")
    opened = open_record_file(file, file.name)
    assert all(values.size == 0 for values in read_numbers(opened).columns.values())


def test_commas_as_delimiter_and_decimal_sign_are_one_line(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("t [s],x [mm]\n" + "".join(f"0,{k},1,{k % 7}\n" for k in range(20)), encoding="utf-8")
    with pytest.raises(InputError, match="row 2: has 4 cells, the header 2; is the decimal sign a comma"):
        open_record_file(file, file.name)


def test_a_spreadsheet_is_to_be_saved_as_csv(tmp_path: Path) -> None:
    file = tmp_path / "log.xlsx"
    file.write_bytes(b"PK")
    with pytest.raises(InputError, match="save the sheet as CSV"):
        open_record_file(file, file.name)
