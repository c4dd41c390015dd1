"""JSON files: arrays of numbers by their path, or rows with named values, in a list or one a line."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from sysid.experiment.readers.formats.arrays import damaged, reader_of, vectors
from sysid.experiment.readers.texts import as_texts


def _load(path: Path, name: str) -> tuple[dict[str, np.ndarray], dict[str, str], list[str]]:
    remarks: list[str] = []
    try:
        text = path.read_text(encoding="utf-8-sig")
        try:
            document = json.loads(text)
        except ValueError:
            document = _rows(text, remarks)
        units: dict[str, str] = {}
        return dict(_arrays(document, "", units)), units, remarks
    except (ValueError, RecursionError):
        raise damaged(name, "json") from None


def _rows(text: str, remarks: list[str]) -> list[Any]:
    """The values of lines, but for a last one that is cut off, which is put into `remarks`."""
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip("\0 \t")]
    rows = [json.loads(line) for _, line in lines[:-1]]
    try:
        rows += [json.loads(line) for _, line in lines[-1:]]
    except ValueError:
        if len(rows) < 2:
            raise
        remarks.append(f"row {lines[-1][0]} at the end is cut off; left out")
    return rows


def _arrays(value: Any, path: str, units: dict[str, str]) -> Iterator[tuple[str, np.ndarray]]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _arrays(item, f"{path}.{key}".removeprefix("."), units)
    elif isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
        for key in dict.fromkeys(key for row in value for key in row):
            yield from _arrays([row.get(key) for row in value], f"{path}.{key}".removeprefix("."), units)
    elif isinstance(value, list) and value:
        rows = [np.nan if item is None else item for item in value]
        try:
            array = np.array(rows)
            array = array.astype(float) if array.dtype.kind == "O" else array
        except (TypeError, ValueError):
            return
        if array.dtype.kind == "U" and array.ndim == 1:
            *above, leaf = path.split(".")
            if leaf in ("unit", "units") and len(set(rows)) == 1:
                units |= {".".join([*above, value]): str(rows[0]) for value in ("value", "values", "data")}
            elif len(rows) > 1:
                yield path or "array", as_texts(value)
            return
        yield from vectors(array, path or "array")


read = reader_of(_load)
