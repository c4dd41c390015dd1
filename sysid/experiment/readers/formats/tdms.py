"""TDMS files of LabVIEW: channels by group and name, with their units, and the time of evenly sampled ones."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sysid.experiment.readers.base import Column, Format, Header
from sysid.experiment.readers.formats.arrays import damaged, header_of, missing_library, read_arrays, remarks_on_texts

KINDS = "iufbM"
"""Kinds of data types that are read: numbers and time stamps."""
_UNIT_KEYS = ("unit_string", "NI_UnitDescription", "unit")


def read(path: Path, name: str, settings: Format, indices: Sequence[int]) -> tuple[Header, list[Column]]:
    """Channels as `group.channel`, or the channel where that is unique.

    Where no channel is called time and those of the commonest length are evenly sampled at one rate, `time` is made of
    the rate in the file.
    """
    with _open(path, name) as file:
        channels = _channels(file)
        units: dict[str, str] = {}
        for key, channel in channels.items():
            unit = next((str(channel.properties[k]) for k in _UNIT_KEYS if channel.properties.get(k)), "")
            units |= {key: "s"} if channel.dtype.kind == "M" else {key: unit} if unit else {}
        usual = _usual(channels)
        steps = {channel.properties.get("wf_increment") for channel in usual}
        others = [f"{g.name}.{c.name}" for g in file.groups() for c in g.channels() if c.dtype.kind not in KINDS]
        paths, remarks = list(channels), remarks_on_texts(others)
        remarks = ("the file is cut off", *remarks) if file.file_status.incomplete_final_segment else remarks
        timed = any(path.rsplit(".", 1)[-1].lower() == "time" or units.get(path) == "s" for path in paths)
        step = steps.pop() if len(steps) == 1 else None
        if not timed and isinstance(step, float) and step > 0.0:
            paths, units["time"] = [*paths, "time"], "s"
            remarks = (*remarks, f"time from the file's step of {step:g} s")

        def values_of(path: str) -> np.ndarray:
            if path not in channels:
                start = float(usual[0].properties.get("wf_start_offset", 0.0))
                return start + float(usual[0].properties["wf_increment"]) * np.arange(len(usual[0]))
            values = channels[path][:]
            return (values - values[0]) / np.timedelta64(1, "s") if values.dtype.kind == "M" else values

        arrays = {index: np.asarray(values_of(paths[index]), dtype=float) for index in indices}
    return read_arrays(header_of(paths, units, remarks, name), arrays, indices, name, settings)


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
