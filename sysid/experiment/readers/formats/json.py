"""JSON files: arrays of numbers by their path, or rows with named values, in a list or one a line."""

import json
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from sysid.experiment.readers.formats.arrays import damaged, readers_of, vectors


@lru_cache(maxsize=1)
def _load(path: Path, name: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    try:
        text = path.read_text(encoding="utf-8-sig")
        try:
            document = json.loads(text)
        except ValueError:
            document = [json.loads(line) for line in text.splitlines() if line.strip()]
        return dict(_arrays(document, "")), {}
    except (ValueError, RecursionError):
        raise damaged(name, "json") from None


def _arrays(value: Any, path: str) -> Iterator[tuple[str, np.ndarray]]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _arrays(item, f"{path}.{key}".removeprefix("."))
    elif isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
        for key in value[0]:
            yield from _arrays([row.get(key) for row in value], f"{path}.{key}".removeprefix("."))
    elif isinstance(value, list) and value:
        rows = [np.nan if item is None else item for item in value]
        try:
            array = np.array(rows)
        except ValueError:
            return
        yield from vectors(array, path or "array")


read_header, read_columns = readers_of(_load)
