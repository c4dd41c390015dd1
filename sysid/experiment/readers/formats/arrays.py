"""Files of named arrays: what their readers have in common."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from stagecad.parameters.errors import InputError, require
from sysid.experiment.readers.base import Column, Format, Header, check_finite
from sysid.experiment.readers.texts import TextColumns

MOST_COLUMNS = 64
"""Columns of a matrix up to which each is a column of the record."""

KINDS = {
    "mat": "a MAT file up to version 7.3",
    "parquet": "a Parquet file",
    "hdf5": "an HDF5 file",
    "npz": "a NumPy file of numbers",
    "json": "a JSON file of numbers",
    "tdms": "a TDMS file",
}
"""What a file should be, by module of this package."""


def header_of(paths: Sequence[str], units: Mapping[str, str], remarks: Sequence[str], name: str) -> Header:
    """The labels of arrays by their paths in a file: the last part of the path where that is unique."""
    require(paths, f"{name}: contains no vector of numbers; required: time, position, ...")
    leaves = [path.rsplit(".", 1)[-1] for path in paths]
    labels = tuple(
        leaf if leaves.count(leaf) == 1 and not leaf.isdecimal() else path for path, leaf in zip(paths, leaves)
    )
    by_label = {label: units[path] for label, path in zip(labels, paths) if path in units}
    by_label = {**{key: unit for key, unit in units.items() if key not in paths}, **by_label}
    return Header(labels, by_label, tuple(remarks))


def read_arrays(
    header: Header, arrays: Mapping[int, np.ndarray], indices: Sequence[int], name: str, settings: Format
) -> tuple[Header, list[Column]]:
    """The header, and the columns at `indices`, of arrays by index. Arrays of texts are read as the columns of a text
    file, and the header has their units."""
    texts = TextColumns.of(arrays, header.labels, name, settings)

    def column(index: int) -> Column:
        if texts is not None and index in texts.cells:
            return texts.column(index)
        values = arrays[index]
        if values.dtype.kind not in "biuf":
            raise InputError(f"{name}: column '{header.labels[index]}': holds {values.dtype}, numbers are required")
        return Column(values.astype(float))

    columns = {index: column(index) for index in indices}
    if len({found.values.size for found in columns.values()}) > 1:
        sizes = ", ".join(f"'{header.labels[index]}' {found.values.size}" for index, found in columns.items())
        raise InputError(f"{name}: variables differ in length: {sizes}")
    for index, found in columns.items():
        check_finite(found.values, name, header.labels[index])
    return texts.described(header) if texts else header, [columns[index] for index in indices]


def reader_of(
    load: Callable[[Path, str], tuple[Mapping[str, np.ndarray], Mapping[str, str], Sequence[str]]],
) -> Callable[[Path, str, Format, Sequence[int]], tuple[Header, list[Column]]]:
    """`read` of a format (`isolated`) whose file is loaded as arrays and units by path, and remarks."""

    def read(path: Path, name: str, settings: Format, indices: Sequence[int]) -> tuple[Header, list[Column]]:
        arrays, units, remarks = load(path, name)
        header = header_of([*arrays], units, remarks, name)
        return read_arrays(header, dict(enumerate(arrays.values())), indices, name, settings)

    return read


def vectors(array: np.ndarray, path: str) -> Iterator[tuple[str, np.ndarray]]:
    """The vectors of numbers in an array by their paths: itself, its fields, or the columns of a matrix, from 1."""
    for place, pick in vector_places(array.dtype, array.shape, path):
        yield place, pick(array).astype(float)


def vector_places(
    dtype: np.dtype, shape: tuple[int, ...], path: str
) -> Iterator[tuple[str, Callable[[np.ndarray], np.ndarray]]]:
    """Path of each vector in an array of this type and shape, and the function that takes it from the array."""
    if dtype.names:
        for field in dtype.names:
            for place, pick in vector_places(dtype[field], shape, f"{path}.{field}"):
                yield place, lambda array, field=field, pick=pick: pick(array[field])
    elif dtype.kind in "iufb" and max(shape, default=0) >= 2:
        if len(shape) == 1 or (len(shape) == 2 and 1 in shape):
            yield path, np.ravel
        elif len(shape) == 2 and min(shape) <= MOST_COLUMNS:
            for k in range(min(shape)):
                upright = shape[0] >= shape[1]
                yield f"{path}.{k + 1}", lambda array, k=k, upright=upright: array[:, k] if upright else array[k]


def missing_library(name: str, library: str) -> InputError:
    """The error for a format whose library is not installed."""
    return InputError(f"{name}: reading this format needs {library}: pip install 'stagecad[formats]'")


def objects_of_matlab(paths: Sequence[str], objects: Sequence[str], name: str) -> tuple[str, ...]:
    """The remark on variables that only MATLAB can unpack, such as a table; an error where a file holds no others."""
    if not objects:
        return ()
    remark = (
        f"'{objects[0]}' is an object of MATLAB, such as a timetable: not read; save its columns as a structure: "
        f"log = table2struct(timetable2table({objects[0]}), 'ToScalar', true); log.Time = seconds(log.Time)"
    )
    require(paths, f"{name}: {remark}")
    return (remark,)


def remarks_on_texts(paths: Sequence[str]) -> tuple[str, ...]:
    """The remark on the columns of a file of which the texts are not read."""
    return (f"{', '.join(paths)} holds text, not numbers: left out",) if paths else ()


def damaged(name: str, module: str) -> InputError:
    """The error for a file that the reader of a module of this package cannot read."""
    return InputError(f"{name}: is not {KINDS[module]}, or is damaged")
