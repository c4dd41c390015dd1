"""`[format]` of an experiment: what its files are like, where the program should not find it out by itself."""

from dataclasses import dataclass
from typing import Any, Literal

from stagecad.parameters.errors import InputError
from sysid.experiment.toml_table import TomlTable, kind_of, quantity, shown

DELIMITERS = {",": "comma", ";": "semicolon", "\t": "tab", "|": "bar", " ": "blanks"}
"""Characters between columns, and their names; any run of blanks and tabs is one delimiter for ' '."""

SAMPLE = "0.5;-1e3\n"
"""A row that an encoding of texts must be able to write and to read."""

REPEATED_TIME = ("first", "mean", "spread")


@dataclass(frozen=True)
class Format:
    """Settings of `[format]` (docs/records.md); what is None is detected in the file.

    Rows are numbered from 1, as an editor counts them; 0 stands for none. Blanks and apostrophes between digits mean
    nothing but groups, so that a blank as `thousands` is none. `missing` are cells that mark a gap, besides empty ones;
    `time_format` has the codes of `strptime`; `repeated_time` says what to make of rows with the time of the row
    before; `sample_rate` is in Hz."""

    delimiter: str | None = None
    decimal: str | None = None
    thousands: str | None = None
    header: int | None = None
    units_row: int | None = None
    first_row: int | None = None
    encoding: str | None = None
    missing: tuple[str, ...] = ()
    time_format: str | None = None
    repeated_time: Literal["first", "mean", "spread"] | None = None
    sample_rate: float | None = None


def read_format(table: TomlTable) -> Format:
    """The settings in a table `[format]`."""
    table.allow(Format.__dataclass_fields__)
    delimiter = encoding = None
    if "delimiter" in table.data:
        names = {name: sign for sign, other in DELIMITERS.items() for name in (sign, other)} | {"space": " "}
        written = table.text("delimiter")
        if written not in names:
            raise InputError(
                f"{table.where('delimiter')}: {shown(written)} is not allowed; allowed: comma, semicolon, tab, bar, "
                "blanks, or the character itself"
            )
        delimiter = names[written]
    decimal = table.choice("decimal", (".", ",")) if "decimal" in table.data else None
    thousands = table.choice("thousands", (".", ",", "'", " ", "none")) if "thousands" in table.data else None
    thousands = "" if thousands == "none" else thousands
    if thousands and thousands == decimal:
        raise InputError(f"{table.where('thousands')}: {shown(thousands)} is the decimal sign too")
    if thousands in (".", ",") and decimal is None:
        decimal = "," if thousands == "." else "."
    if decimal == "," and delimiter == ",":
        raise InputError(f"{table.where('decimal')}: a comma cannot be both the decimal sign and the delimiter")
    if "encoding" in table.data:
        encoding = table.text("encoding")
        try:
            known = SAMPLE.encode(encoding).decode(encoding, "replace") == SAMPLE
        except (LookupError, ValueError):
            known = False
        if not known:
            raise InputError(
                f"{table.where('encoding')}: {shown(encoding)} is no text encoding; such as utf-8, utf-16, cp1252"
            )
    repeated: Any = table.choice("repeated_time", REPEATED_TIME) if "repeated_time" in table.data else None
    rate = quantity(table, "sample_rate", "Hz", positive=True) if "sample_rate" in table.data else None
    return Format(
        delimiter=delimiter,
        decimal=decimal,
        thousands=thousands,
        header=_row(table, "header", absent=True),
        units_row=_row(table, "units_row", absent=True),
        first_row=_row(table, "first_row"),
        encoding=encoding,
        missing=table.texts("missing"),
        time_format=table.text("time_format") if "time_format" in table.data else None,
        repeated_time=repeated,
        sample_rate=rate,
    )


def _row(table: TomlTable, key: str, absent: bool = False) -> int | None:
    """A row number from 1; with `absent`, `false` for no such row is 0."""
    value = table.data.get(key)
    if value is None:
        return None
    if absent and value is False:
        return 0
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        wanted = "a row number from 1, or false if there is none," if absent else "a row number from 1"
        kind = f"{shown(value)} is {kind_of(value)}" if not isinstance(value, int) else f"{shown(value)} is not allowed"
        raise InputError(f"{table.where(key)}: {kind}; {wanted} is required")
    return value
