"""Time stamps as seconds: ISO 8601 dates, clock times, or a format of the user's."""

from __future__ import annotations

from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import Column, to_numpy
from sysid.experiment.toml_table import shown

DAY = 86400.0


def seconds(column: Any, kind: str, time_format: str | None, file: str, label: str) -> Column:
    """Seconds (n,) since the first row of a column of time stamps, exact to a nanosecond.

    Raises:
        InputError: a stamp of another form than the first.
    """
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
        elif kind == "clock":
            text = pc.replace_substring_regex(text, r"^(\d):", r"0\1:")
            dated = pc.binary_join_element_wise("1970-01-01", text, " ")
            nanoseconds = dated.cast(pyarrow.timestamp("ns")).cast(pyarrow.int64())
        else:
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
    midnights = np.cumsum(np.diff(counted, prepend=counted[:1]) < -DAY / 2) if kind == "clock" else np.zeros(1)
    if midnights[-1]:
        counted = counted + DAY * midnights
        said += "; it passes midnight"
    return Column(counted, origin / 1e9, said)


def _own_format(text: Any, time_format: str) -> Any:
    import pandas
    import pyarrow

    stamps = pandas.to_datetime(pandas.Series(text.to_pylist()), format=time_format)
    return pyarrow.chunked_array([pyarrow.array(stamps.astype("datetime64[ns]").to_numpy().astype(np.int64))])
