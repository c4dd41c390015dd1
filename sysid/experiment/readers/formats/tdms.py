"""TDMS files of LabVIEW: channels by group and name, with their units, and the time of evenly sampled ones."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sysid.experiment.readers.base import Column, Format, Header
from sysid.experiment.readers.formats.arrays import columns_of, damaged, header_of, missing_library, remarks_on_texts

KINDS = "iufbM"
"""Kinds of data types that are read: numbers and time stamps."""
_UNIT_KEYS = ("unit_string", "NI_UnitDescription", "unit")


def read_header(path: Path, name: str, settings: Format) -> Header:
    """The labels of a TDMS file: `group.channel`, or the channel where that is unique.

    Where no channel is called time and those of the commonest length are evenly sampled at one rate, `time` is made of
    the rate in the file.
    """
    with _open(path, name) as file:
        channels = _channels(file)
        units: dict[str, str] = {}
        for key, channel in channels.items():
            unit = next((str(channel.properties[k]) for k in _UNIT_KEYS if channel.properties.get(k)), "")
            units |= {key: "s"} if channel.dtype.kind == "M" else {key: unit} if unit else {}
        steps = {channel.properties.get("wf_increment") for channel in _usual(channels)}
        others = [f"{g.name}.{c.name}" for g in file.groups() for c in g.channels() if c.dtype.kind not in KINDS]
        paths, remarks = list(channels), remarks_on_texts(others)
        remarks = ("the file is cut off", *remarks) if file.file_status.incomplete_final_segment else remarks
        timed = any(path.rsplit(".", 1)[-1].lower() == "time" or units.get(path) == "s" for path in paths)
        step = steps.pop() if len(steps) == 1 else None
        if not timed and isinstance(step, float) and step > 0.0:
            paths, units["time"] = [*paths, "time"], "s"
            remarks = (*remarks, f"time from the file's step of {step:g} s")
    found = header_of(paths, units, name)
    return Header(found.labels, found.units, remarks, layout=paths)


def read_columns(path: Path, name: str, header: Header, indices: Sequence[int], settings: Format) -> list[Column]:
    """Columns of a TDMS file; see `Reader`."""
    arrays = []
    with _open(path, name) as file:
        channels = _channels(file)
        for index in indices:
            key = header.layout[index]
            if key in channels:
                values = channels[key][:]
                values = (values - values[0]) / np.timedelta64(1, "s") if values.dtype.kind == "M" else values
                arrays.append(np.asarray(values, dtype=float))
            else:
                usual = _usual(channels)[0]
                start = float(usual.properties.get("wf_start_offset", 0.0))
                arrays.append(start + float(usual.properties["wf_increment"]) * np.arange(len(usual)))
    return columns_of(arrays, name, header, indices)


def _open(path: Path, name: str) -> Any:
    try:
        from nptdms import TdmsFile
    except ImportError:
        raise missing_library(name, "npTDMS") from None
    try:
        return TdmsFile.open(path)
    except Exception:  # npTDMS raises whatever struct and numpy do on damaged bytes
        raise damaged(name, "tdms") from None


def _usual(channels: Mapping[str, Any]) -> list[Any]:
    """The channels of the commonest length, the larger of two that are as common."""
    sizes = Counter(len(channel) for channel in channels.values())
    usual = max(sizes, key=lambda size: (sizes[size], size), default=0)
    return [channel for channel in channels.values() if len(channel) == usual]


def _channels(file: Any) -> dict[str, Any]:
    """Channels of numbers by `group.channel`."""
    return {
        f"{group.name}.{channel.name}": channel
        for group in file.groups()
        for channel in group.channels()
        if len(channel) > 1 and channel.dtype.kind in KINDS
    }
