"""JSON files: arrays of numbers by their path, or rows with named values, in a list or one a line."""

import json
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.deferred import pyarrow
from sysid.experiment.readers.base import Format
from sysid.experiment.readers.dialect import kind_of_cell
from sysid.experiment.readers.formats.arrays import damaged, readers_of, vectors
from sysid.experiment.readers.numbers import GAPS, STAMPS, NumberForm, seconds


@lru_cache(maxsize=1)
def _load(path: Path, name: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    try:
        text = path.read_text(encoding="utf-8-sig")
        try:
            document = json.loads(text)
        except ValueError:
            document = [json.loads(line) for line in text.splitlines() if line.strip()]
        units: dict[str, str] = {}
        return dict(_arrays(document, "", units)), units
    except (ValueError, RecursionError):
        raise damaged(name, "json") from None


def _arrays(value: Any, path: str, units: dict[str, str]) -> Iterator[tuple[str, np.ndarray]]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _arrays(item, f"{path}.{key}".removeprefix("."), units)
    elif isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
        for key in value[0]:
            yield from _arrays([row.get(key) for row in value], f"{path}.{key}".removeprefix("."), units)
    elif isinstance(value, list) and value:
        rows = [np.nan if item is None else item for item in value]
        try:
            array = np.array(rows)
        except ValueError:
            return
        if array.dtype.kind == "U" and array.ndim == 1:
            array, stamps = _numbers(array.tolist(), path)
            units |= {path: "s"} if stamps else {}
            *above, leaf = path.split(".")
            if leaf in ("unit", "units") and len(set(rows)) == 1:
                units |= {".".join([*above, value]): str(rows[0]) for value in ("value", "values", "data")}
        yield from vectors(array, path or "array")


def _numbers(cells: list[str], path: str) -> tuple[np.ndarray, bool]:
    """The numbers (n,) in texts, or seconds from the first of time stamps, and whether they are such."""
    form, kind = NumberForm(), kind_of_cell(cells[0], NumberForm(), Format())
    values = [np.nan if cell in GAPS else form.value(cell) for cell in cells]
    if None not in values:
        return np.array(values, dtype=float), False
    if kind not in STAMPS:
        return np.array(cells), False
    return seconds(pyarrow.chunked_array([pyarrow.array(cells)]), kind, None, path, path).values, True


read_header, read_columns = readers_of(_load)
