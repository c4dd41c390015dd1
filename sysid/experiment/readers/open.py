"""The reader of a record file, chosen by the suffix of its name."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import cast

from stagecad.parameters.errors import InputError
from sysid.experiment.readers import base, csv
from sysid.experiment.readers.isolated import IsolatedReader
from sysid.experiment.readers.memory import MemoryTable

TEXT_SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".asc", ".log", ".lvm", ".prn")
"""Text files with columns, also with .gz behind."""

_BINARY = {
    "parquet": (".parquet", ".pq"),
    "mat": (".mat",),
    "hdf5": (".h5", ".hdf5", ".hdf"),
    "npz": (".npz", ".npy"),
    "tdms": (".tdms",),
    "json": (".json", ".jsonl", ".ndjson"),
}
READERS = {suffix: module for module, some in {"csv": TEXT_SUFFIXES, **_BINARY}.items() for suffix in some}
"""Module by suffix: `csv`, or one of `formats`, which another process loads and runs."""

SUFFIXES = (*READERS, *(f"{suffix}.gz" for suffix in TEXT_SUFFIXES))
"""Every suffix of a record file."""


@dataclass(frozen=True)
class RecordFile:
    """An open record file, or a table in memory: its header, and its columns on demand; `name` stands in messages."""

    path: Path | MemoryTable
    name: str
    settings: base.Format
    reader: base.Reader
    header: base.Header

    def columns(self, indices: Sequence[int]) -> list[base.Column]:
        """The columns at `indices`; see `Reader.read_columns`."""
        return self.reader.read_columns(cast(Path, self.path), self.name, self.header, indices, self.settings)

    def row_name(self, row: int) -> str:
        """Name under which a user finds row `row` (from 0) of the columns in the file."""
        if self.reader is csv and isinstance(self.path, Path):
            row = csv.row_number(self.path, self.name, self.header, row) - 1
        return f"row {row + 1}"

    @cached_property
    def sha256(self) -> str:
        """Hash of the file's bytes, or of the labels and values of a table in memory."""
        return self.path.sha256() if isinstance(self.path, MemoryTable) else base.file_sha256(self.path)


def record_suffix(name: str) -> str | None:
    """The suffix of a record file that determines its format, without `.gz`; None for another file."""
    suffixes = [suffix.lower() for suffix in Path(name).suffixes]
    suffix = suffixes[-1] if suffixes else ""
    if suffix == ".gz":
        suffix = suffixes[-2] if len(suffixes) > 1 and suffixes[-2] in TEXT_SUFFIXES else ".csv"
    return suffix if suffix in READERS else None


def unknown_format(name: str) -> str:
    """Error of a file whose suffix is not known, with the suffixes that are allowed."""
    suffix = Path(name).suffix.lower()
    instead = next((f"; {f['instead']}" for f in base.OTHER_FORMATS if suffix in f.get("suffixes", ())), "")
    found = f"'{suffix}'" if suffix else "a name without a suffix"
    return (
        f"{found} is not a record format{instead}; allowed: "
        f"{', '.join(TEXT_SUFFIXES[:4])} (also .gz), .parquet, .mat, .h5, .npz, .tdms, .json"
    )


def open_record_file(path: Path | MemoryTable, name: str, settings: base.Format | None = None) -> RecordFile:
    """Open a record file by its suffix, or a table in memory."""
    settings = settings or base.Format()
    if isinstance(path, MemoryTable):
        return RecordFile(path, name, settings, path, path.read_header(Path(), name, settings))
    suffix = record_suffix(path.name)
    if suffix is None and not base.is_folder(path):
        raise InputError(f"{base.shown_path(name)}: {unknown_format(path.name)}")
    module = READERS.get(suffix or "", "csv")
    base.check_file(path, name, tuple(READERS), module == "csv")
    reader = cast(base.Reader, csv) if module == "csv" else IsolatedReader(module)
    header = reader.read_header(path, name, settings)
    if len(header.labels) > base.MOST_COLUMNS:
        raise InputError(
            f"{base.shown_path(name)}: has {len(header.labels)} columns; at most {base.MOST_COLUMNS} are read"
        )
    return RecordFile(path, name, settings, reader, header)
