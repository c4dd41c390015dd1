"""Columns of texts in files and tables whose other columns are numbers: read as the cells of a text file are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import Column, Format, Header
from sysid.experiment.readers.csv import number_of
from sysid.experiment.readers.dialect import Dialect, find_dialect
from sysid.experiment.toml_table import shown

SAMPLE = 1000
"""Rows by which the form of the numbers is found."""


def as_texts(values: Sequence[object]) -> np.ndarray:
    """Any values as texts (n,), empty where there is none."""
    return np.array(["" if value is None or value != value else str(value) for value in values], dtype=np.str_)


@dataclass(frozen=True)
class TextColumns:
    """Columns of texts (n,) by index of the column, and their form, of which the columns are numbered in this order."""

    cells: Mapping[int, np.ndarray]
    dialect: Dialect
    name: str

    @classmethod
    def of(
        cls, arrays: Mapping[int, np.ndarray], labels: Sequence[str], name: str, settings: Format
    ) -> TextColumns | None:
        """The columns of texts with the form of their first rows; None without any. InputError: numbers that have two
        readings."""
        cells = {index: array for index, array in arrays.items() if array.dtype.kind == "U"}
        if not cells:
            return None
        rows = zip(*([cell.replace("\t", " ") for cell in column[:SAMPLE].tolist()] for column in cells.values()))
        plain = replace(settings, delimiter="\t", header=0, units_row=0, first_row=1)
        found = find_dialect(["\t".join(row) for row in rows], "utf-8", plain, name, complete=True)
        texts = {}
        together = {k for places in found.dates.values() for k in places}
        for place, (index, column) in enumerate(cells.items()):
            kinds = [(found.kind(cell.strip()), cell) for cell in column[:SAMPLE].tolist()]
            words = [cell for kind, cell in kinds if kind == "text"]
            if words and place not in together and all(kind in ("text", "gap") for kind, _ in kinds):
                texts[labels[index]] = words[0]
        return cls(cells, replace(found, labels=tuple(labels[k] for k in cells), texts=texts), name)

    def described(self, header: Header) -> Header:
        """The header with the units and dates of these columns, and those that hold text."""
        found, places = self.dialect, [*self.cells]
        behind = {k: unit for k, unit in found.spelled.items() if unit}
        units = {found.labels[k]: unit for k, unit in {**dict.fromkeys(found.stamps, "s"), **behind}.items()}
        dates = {places[k] for apart in found.dates.values() for k in apart} - {places[k] for k in found.dates}
        return replace(header, units={**header.units, **units}, texts=found.texts, dates=tuple(dates))

    def parts(self, index: int) -> tuple[int, ...]:
        """The columns whose cells are read together for the one at `index`."""
        places = [*self.cells]
        return tuple(places[k] for k in self.dialect.dates.get(places.index(index), (places.index(index),)))

    def column(self, index: int) -> Column:
        """Numbers, or seconds of time stamps. InputError: another cell, with its row from 1."""
        place = [*self.cells].index(index)
        if place in self.dialect.stamps:
            parts = [self.cells[k].tolist() for k in self.parts(index)]
            return self.dialect.seconds([" ".join(row) for row in zip(*parts)], place, self.name)
        if (label := self.dialect.labels[place]) in self.dialect.texts:
            words = shown(self.dialect.texts[label])
            raise InputError(f"{self.name}: column '{label}': holds text, such as {words}, numbers are required")
        rows = enumerate(self.cells[index].tolist(), start=1)
        return Column(np.array([number_of(cell.strip(), self.name, row, place, self.dialect) for row, cell in rows]))
