"""Apache Parquet files."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from stagecad.deferred import compute, pyarrow
from stagecad.parameters.errors import InputError, require
from sysid.experiment.readers.base import MOST_ROWS, Column, Format, Header, check_finite, to_numpy
from sysid.experiment.readers.formats.arrays import damaged
from sysid.experiment.readers.texts import SAMPLE, TextColumns, as_texts


def read(path: Path, name: str, settings: Format, indices: Sequence[int]) -> tuple[Header, list[Column]]:
    """The header, and the columns at `indices`; a column of time stamps is in seconds."""
    file = _open(path, name)
    schema = file.schema_arrow
    stamps = [field.name for field in schema if pyarrow.types.is_temporal(field.type)]
    remarks = ("time stamps in " + ", ".join(f"'{label}'" for label in stamps),) if stamps else ()
    header = Header(tuple(schema.names), dict.fromkeys(stamps, "s"), remarks)
    texts = _texts(file, name, settings)
    unique = len(set(header.labels)) == len(header.labels)
    wanted = list(dict.fromkeys(header.labels[index] for index in indices))
    try:
        # Of columns that share a name, all are read.
        table = file.read(columns=wanted if unique or not wanted else None, use_threads=False)
    except pyarrow.ArrowMemoryError:
        raise
    except (pyarrow.ArrowException, OSError, UnicodeDecodeError):
        raise InputError(f"{name}: is a damaged Parquet file") from None
    found = []
    for index in indices:
        if texts is not None and index in texts.cells:
            whole = {k: file.read(columns=[header.labels[k]]).column(0).to_pylist() for k in texts.parts(index)}
            cells = {**texts.cells, **{k: as_texts(values) for k, values in whole.items()}}
            found.append(replace(texts, cells=cells).column(index))
        else:
            label = header.labels[index]
            found.append(_numbers(table.column(label if unique else index), name, label))
    return texts.described(header) if texts else header, found


def _texts(file: Any, name: str, settings: Format) -> TextColumns | None:
    """The first rows of the columns of texts; None without such columns."""
    names = file.schema_arrow.names
    indices = [k for k, field in enumerate(file.schema_arrow) if _is_text(field.type) and names.count(field.name) == 1]
    if not indices or not file.metadata.num_rows:
        return None
    batch = next(file.iter_batches(batch_size=SAMPLE, columns=[names[k] for k in indices]))
    return TextColumns.of({k: as_texts(batch.column(names[k]).to_pylist()) for k in indices}, names, name, settings)


def _is_text(kind: Any) -> bool:
    kind = kind.value_type if pyarrow.types.is_dictionary(kind) else kind
    return pyarrow.types.is_string(kind) or pyarrow.types.is_large_string(kind)


def _numbers(column: Any, name: str, label: str) -> Column:
    """A column of numbers or of time stamps."""
    if pyarrow.types.is_temporal(column.type):
        return _seconds(column, name, label)
    kinds = pyarrow.types.is_integer, pyarrow.types.is_floating, pyarrow.types.is_decimal
    if not any(kind(column.type) for kind in kinds):
        raise InputError(f"{name}: column '{label}': holds {column.type}, numbers are required")
    origin = column[0].as_py() if pyarrow.types.is_integer(column.type) and len(column) else 0
    # Larger counts have more digits than a float.
    origin = origin if origin and origin >= 2**53 and not column.null_count else 0
    column = compute.subtract(column, origin) if origin else column  # type: ignore[attr-defined]
    values = to_numpy(column.cast(pyarrow.float64(), safe=False))
    check_finite(values, name, label)
    return Column(values, float(origin), f"'{label}' is counted from its first row" if origin else "")


def _seconds(column: Any, name: str, label: str) -> Column:
    """Seconds since the first row of a column of time stamps."""
    require(not column.null_count, f"{name}: column '{label}': has empty rows; every row needs its time")
    kind = column.type
    if pyarrow.types.is_date(kind):
        kind, column = pyarrow.timestamp("ns"), column.cast(pyarrow.timestamp("ms"))
    exact: Any = pyarrow.timestamp("ns", getattr(kind, "tz", None))
    exact = pyarrow.duration("ns") if pyarrow.types.is_duration(kind) else exact
    exact = pyarrow.time64("ns") if pyarrow.types.is_time(kind) else exact
    counts = column.cast(exact).cast(pyarrow.int64())
    first = counts[0].as_py()
    counted = compute.subtract(counts, first).cast(pyarrow.float64())  # type: ignore[attr-defined]
    return Column(to_numpy(counted) / 1e9, first / 1e9, f"'{label}' is counted from its first row")


def _open(path: Path, name: str) -> Any:
    from pyarrow import parquet

    try:
        file = parquet.ParquetFile(path)
        # The names are decoded here.
        rows = file.metadata.num_rows if file.schema_arrow.names else 0
    except (pyarrow.ArrowException, OSError, UnicodeDecodeError):
        raise damaged(name, "parquet") from None
    if rows > MOST_ROWS:
        raise InputError(f"{name}: has {rows} rows; at most {MOST_ROWS} are read")
    return file
