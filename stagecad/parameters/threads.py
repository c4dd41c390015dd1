"""Screw threads by name, from `threads.csv`: metric coarse and fine, unified, and pipe threads."""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from stagecad.parameters.errors import require_known

BOTTOMING_TAP = 1.5
"""Incomplete threads at the end of a bottoming tap (ISO 8830, lead form C), pitches."""


@dataclass(frozen=True)
class Thread:
    """A screw thread; lengths in mm."""

    name: str  # as parts write it: `m8`, `m8x1`, `unc_3_8`, `g_1_4`
    designation: str  # on a sheet: `M8x1.25`
    major: float
    pitch: float
    tap_drill: float
    source: str  # standard of the sizes


@cache
def threads() -> dict[str, Thread]:
    """All threads by name."""
    rows = csv.reader(files("stagecad.parameters").joinpath("threads.csv").read_text("utf-8").splitlines()[1:])
    return {
        name: Thread(name, designation, float(major), float(pitch), float(drill), source)
        for name, designation, major, pitch, drill, source in rows
    }


def thread(name: str, own: Mapping[str, Thread] | None = None) -> Thread:
    """A thread by its name, of the table or of one's own.

    Raises:
        InputError: there is none of this name.
    """
    known = {**threads(), **(own or {})}
    require_known(name, known, f"no thread '{name}'")
    return known[name]
