"""HDF5 files, among them MATLAB's of version 7.3: every vector of numbers by its path."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import MEMORY, Column, Format, Header
from sysid.experiment.readers.formats import arrays

ELSEWHERE = "is stored in another file, which is not read; copy it into this one (h5repack)"
_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def is_hdf5(path: Path) -> bool:
    """Whether the signature of HDF5 stands at one of the first places where it may."""
    with path.open("rb") as file:
        head = file.read(2048 + len(_SIGNATURE))
    return any(head[place : place + len(_SIGNATURE)] == _SIGNATURE for place in (0, 512, 1024, 2048))


def read(path: Path, name: str, settings: Format, indices: Sequence[int]) -> tuple[Header, list[Column]]:
    """Data sets by their path, with points in place of slashes; the attribute `unit` or `units` is their unit."""
    with _open(path, name) as file:
        paths: list[str] = []
        sets: dict[str, tuple[str, Any]] = {}
        units: dict[str, str] = {}
        objects: list[str] = []
        texts: list[str] = []
        for place, data in _data_sets(file, name, objects):
            own = [key for key, _ in arrays.vector_places(data.dtype, data.shape, place)]
            paths += own
            sets |= dict.fromkeys(own, (place, data))
            is_text = data.dtype.kind == "S" or (data.dtype.metadata or {}).get("vlen") is str
            texts += [place] if is_text and data.size > 1 else []
            unit = next((data.attrs[key] for key in data.attrs if key.lower() in ("unit", "units")), None)
            if isinstance(unit, bytes):
                unit = unit.decode("utf-8", errors="replace")
            units |= dict.fromkeys(own, str(unit)) if unit is not None else {}
        remarks = (*arrays.objects_of_matlab(paths, objects, name), *arrays.remarks_on_texts(texts))
        header = arrays.header_of(paths, units, remarks, name)
        wanted = dict(sets[paths[index]] for index in indices)
        # A small file may declare large data sets without storing them.
        if sum(8 * data.size for data in wanted.values()) > MEMORY:
            raise MemoryError
        found: dict[str, np.ndarray] = {}
        for place, data in wanted.items():
            try:
                found |= dict(arrays.vectors(_unpacked(data), place))
            except OSError as error:
                raise InputError(f"{name}: '{place}' cannot be read: {error}") from None
    return arrays.read_arrays(header, {index: found[paths[index]] for index in indices}, indices, name, settings)


def _unpacked(data: Any) -> np.ndarray:
    """The values of a data set, unpacked by its attributes (CF conventions 1.11, sections 2.5 and 8.1)."""
    values = data[()]
    if values.dtype.kind not in "iuf":
        return values
    gaps = [values == data.attrs[key] for key in ("_FillValue", "missing_value") if key in data.attrs]
    if gaps or "scale_factor" in data.attrs or "add_offset" in data.attrs:
        values = values * data.attrs.get("scale_factor", 1.0) + data.attrs.get("add_offset", 0.0)
    return np.where(np.logical_or.reduce(gaps), np.nan, values) if gaps else values


def _open(path: Path, name: str) -> Any:
    try:
        import h5py
    except ImportError:
        raise arrays.missing_library(name, "h5py") from None
    try:
        return h5py.File(path, "r")
    except OSError:
        raise arrays.damaged(name, "hdf5") from None


def _data_sets(file: Any, name: str, objects: list[str]) -> Iterator[tuple[str, Any]]:
    """Data sets of numbers by their paths. MATLAB's own groups (`#refs#`) and texts are left out; the paths of its
    objects are put into `objects`."""
    import h5py

    groups = set()

    def inside(group: Any, prefix: str) -> Iterator[tuple[str, Any]]:
        address = hash(group.id)
        if address in groups:  # a group within itself
            return
        groups.add(address)
        for key in group:
            place = f"{prefix}{key}"
            if key.startswith("#"):
                continue
            # A link is looked at before it is followed: another file may be anything.
            if isinstance(group.get(key, getlink=True), h5py.ExternalLink):
                raise InputError(f"{name}: '{place}' {ELSEWHERE}")
            item = group.get(key)
            if isinstance(item, h5py.Group):
                yield from inside(item, f"{place}.")
            elif isinstance(item, h5py.Dataset) and "MATLAB_object_decode" in item.attrs:
                objects.append(place)
            elif isinstance(item, h5py.Dataset) and item.attrs.get("MATLAB_class", b"") not in (b"char", b"cell"):
                if item.external or item.is_virtual:
                    raise InputError(f"{name}: '{place}' {ELSEWHERE}")
                yield place, item

    yield from inside(file, "")
