"""The reader of a record file, chosen by the suffix of its name."""

from __future__ import annotations

import csv
from pathlib import Path

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import MOST_COLUMNS, SUFFIXES, RecordFile, is_folder, shown_path
from sysid.experiment.readers.csv import CsvFile
from sysid.experiment.readers.isolated import IsolatedFile
from sysid.experiment.readers.memory import MemoryFile, MemoryTable


def open_record_file(path: Path | MemoryTable, name: str) -> RecordFile:
    """Open a record file by its suffix, or a table in memory.

    Raises:
        InputError: as `RecordFile`.
    """
    if isinstance(path, MemoryTable):
        return MemoryFile(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES and not is_folder(path):
        raise InputError(f"{shown_path(name)}: '{suffix}' is no record format; allowed: .csv, .parquet, .mat")
    kind = SUFFIXES.get(suffix, "CSV")
    try:
        opened = CsvFile(path, name) if kind == "CSV" else IsolatedFile(path, name, kind)
    except csv.Error as error:
        raise InputError(f"{shown_path(name)}: not readable as CSV: {error}") from None
    if len(opened.labels) > MOST_COLUMNS:
        raise InputError(f"{shown_path(name)}: has {len(opened.labels)} columns; at most {MOST_COLUMNS} are read")
    return opened
