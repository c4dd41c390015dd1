"""Time stamps as seconds: ISO 8601 dates, day.month.year, clock times of 24 or 12 hours, minutes and seconds, or a
format of the user's."""

from __future__ import annotations

from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import Column, to_numpy
from sysid.experiment.toml_table import shown

DAY = 86400.0


def seconds(column: Any, kind: str, time_format: str | None, file: str, label: str) -> Column:
    """Seconds (n,) since the first row of a column of time stamps, exact to a nanosecond."""
    import pyarrow
    from pyarrow import compute

    pc: Any = compute
    if column.null_count:
        row = int(np.flatnonzero(~np.array(column.is_valid()))[0])
        raise InputError(f"{file}: value {row + 1} of column '{label}': is empty; every row needs its time")
    first = column[0].as_py().strip()
    written = pc.utf8_trim_whitespace(column)
    text = pc.replace_substring(written, ",", ".")
    try:
        if kind == "stamp":
            nanoseconds = _own_format(written, time_format or "")
        elif kind in ("clock", "half_day", "minutes"):
            nanoseconds = _clock(text, kind)
        else:
            if kind == "day_first":
                text = pc.replace_substring_regex(text, r"^(\d)\.", r"0\1.")
                text = pc.replace_substring_regex(text, r"\.(\d)\.", r".0\1.")
                text = pc.replace_substring_regex(text, r"^(\d\d)\.(\d\d)\.(\d{4})[ T]", r"\3-\2-\1 ")
                text = pc.replace_substring_regex(text, r" (\d):", r" 0\1:")
            zone = first[-1] == "Z" or first[-6:-5] in ("+", "-") or first[-5:-4] in ("+", "-")
            nanoseconds = text.cast(pyarrow.timestamp("ns", "UTC" if zone else None)).cast(pyarrow.int64())
    except (pyarrow.ArrowInvalid, ValueError) as error:
        reason = str(error).partition("\n")[0]
        raise InputError(
            f"{file}: column '{label}': a time stamp is not of the form of the first, {shown(first)} ({reason}); "
            "name the form: [format] time_format"
        ) from None
    origin = nanoseconds[0].as_py()
    counted = to_numpy(pc.subtract(nanoseconds, origin).cast(pyarrow.float64())) / 1e9
    said = f"'{label}' is counted from its first row, {first}"
    midnights = (
        np.cumsum(np.diff(counted, prepend=counted[:1]) < -DAY / 2) if kind in ("clock", "half_day") else np.zeros(1)
    )
    if midnights[-1]:
        counted = counted + DAY * midnights
        said += "; it passes midnight"
    return Column(counted, origin / 1e9, said)


def _clock(text: Any, kind: str) -> Any:
    """Nanoseconds of times of the day (`H:MM:SS.f`, with AM or PM in `half_day`) or of `M:SS.f`."""
    import pyarrow
    from pyarrow import compute

    pc: Any = compute
    pattern = {
        "clock": r"^(?P<h>\d+):(?P<m>\d+):(?P<s>\d+)(?P<f>\.\d+)?$",
        "half_day": r"^(?P<h>\d+):(?P<m>\d+):(?P<s>\d+)(?P<f>\.\d+)?\s?(?P<half>[AaPp])\.?[Mm]\.?$",
        "minutes": r"^(?P<m>\d+):(?P<s>\d+)(?P<f>\.\d+)?$",
    }[kind]
    parts = pc.extract_regex(text, pattern)
    if parts.null_count:
        raise ValueError("another form")

    def whole(name: str, most: int) -> Any:
        values = pc.struct_field(parts, name).cast(pyarrow.int64())
        if pc.max(values).as_py() > most:
            raise ValueError(f"a number above {most}")
        return values

    seconds_ = pc.add(pc.multiply(whole("m", 59 if kind != "minutes" else 9999), 60), whole("s", 60))
    if kind != "minutes":
        hours = whole("h", 24 if kind == "clock" else 12)
        if kind == "half_day":
            noon = pc.if_else(pc.equal(hours, 12), 0, hours)
            late = pc.equal(pc.utf8_lower(pc.struct_field(parts, "half")), "p")
            hours = pc.add(noon, pc.if_else(late, 12, 0))
        seconds_ = pc.add(seconds_, pc.multiply(hours, 3600))
    digits = pc.utf8_slice_codeunits(pc.replace_substring(pc.struct_field(parts, "f"), ".", ""), 0, 9)
    fraction = pc.utf8_rpad(pc.if_else(pc.equal(digits, ""), "0", digits), 9, "0").cast(pyarrow.int64())
    return pc.add(pc.multiply(seconds_, 1_000_000_000), fraction)


def _own_format(text: Any, time_format: str) -> Any:
    import pandas
    import pyarrow

    stamps = pandas.to_datetime(pandas.Series(text.to_pylist()), format=time_format)
    return pyarrow.chunked_array([pyarrow.array(stamps.astype("datetime64[ns]").to_numpy().astype(np.int64))])
