"""Standard parts by designation, from `standard_parts.csv`.

`ISO 4762 M6x20` (cap screw), `ISO 10642 M6x20` (countersunk), `ISO 4026 M6x20` (set screw), `ISO 4032 M6` (nut),
`ISO 7089 6` (washer), `ISO 8734 6x20` (dowel pin m6), `6204` (deep groove ball bearing, ISO 15). The designation is the
number in the parts list, so it follows size and length; a length that is not of the series is refused. Millimetres; the
axis is z, and the origin where the part rests. Threads are cosmetic.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from stagecad.parameters.dimension import Datum, Dimension
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.threads import thread
from stagecad.solids.modelling.kernel import cq

CAP, SUNK, SET, NUT, WASHER, PIN, BEARING = (f"ISO {number}" for number in (4762, 10642, 4026, 4032, 7089, 8734, 15))
WORDS = {
    CAP: "Hexagon socket head cap screw",
    SUNK: "Hexagon socket countersunk screw",
    SET: "Hexagon socket set screw, flat point",
    NUT: "Hexagon nut",
    WASHER: "Plain washer",
    PIN: "Dowel pin, hardened",
    BEARING: "Deep groove ball bearing",
}
SERIES = (2, 2.5, 3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 25, 26, 28, 30, 32, *range(35, 100, 5))
SERIES = (*SERIES, *range(100, 161, 10), 180, 200)
"""Lengths of screws and pins, mm."""
NOT_OF = {PIN: (25, 110, 120, 130, 140, 150, 160, 180, 200), "screws": (14, 18, 22, 24, 26, 28, 32, 75, 85, 95)}
"""Those that pins, and screws, have not."""
RACE, SHIELD = 0.3, 0.42
"""Of a bearing: width of a ring over the radial section, and depth of the recess beside the balls over the width. The
mass is then that of the catalogues within 5 %."""
_WRITTEN = re.compile(r"(ISO \d+)?[ -]*(M?\d+(?:\.\d+)?)(?: *m6)?(?: *[xX\u00d7] *(\d+(?:\.\d+)?))?(?: mm)?")


def is_designation(text: str) -> bool:
    """Whether a text is meant as a designation."""
    return text.startswith("ISO ") or text.isdigit()


def standard_part(text: str) -> StandardPart:
    """The part of a designation.

    Raises:
        InputError: no such standard, size or length.
    """
    match = _WRITTEN.fullmatch(text.strip())
    standard, size, length = match.groups() if match else (None, "", None)
    standard, table = standard or BEARING, _table()
    # A washer is named by the thread, too.
    size = size.removeprefix("M") if standard == WASHER else size
    sizes = [known for of, known in table if of == standard]
    if not sizes:
        raise InputError(f"no standard part '{text}'{nearest(standard, list(WORDS))}; write it like ISO 4762 M6x20")
    if (standard, size) not in table:
        raise InputError(f"{standard} has no size '{size}'{nearest(size, sizes)}")
    row = table[standard, size]
    lengths = [one for one in SERIES if row["shortest"] <= one <= row["longest"]] if row["longest"] else []
    lengths = [one for one in lengths if one not in NOT_OF[PIN if standard == PIN else "screws"]]
    if bool(lengths) != bool(length) or (length and float(length) not in lengths):
        shown = f"its lengths: {', '.join(f'{one:g}' for one in lengths)} mm" if lengths else "it has no length"
        raise InputError(f"'{text}': no such length of {standard} {size}; {shown}")
    kind = StandardScrew if standard in (CAP, SUNK, SET) else StandardPart
    return kind(standard, size, row, float(length or 0.0))


@cache
def _table() -> dict[tuple[str, str], dict[str, float]]:
    text = files("stagecad.declared").joinpath("standard_parts.csv").read_text("utf-8")
    return {
        (row.pop("standard"), row.pop("size")): {key: float(value or 0.0) for key, value in row.items()}
        for row in csv.DictReader(text.splitlines())
    }


@dataclass(frozen=True)
class StandardPart:
    """A standard part as a part (`stagecad.solids.modelling.part.Part`)."""

    standard: str
    size: str
    row: dict[str, float]  # its sizes, mm
    length: float  # 0 for a part without

    def build(self, design: Any) -> cq.Solid:
        """The part as one solid, mm."""
        body = cq.Workplane("XZ").polyline(self._outline()).close().revolve(360.0, (0, 0), (0, 1))
        if self.row["socket"]:
            top = self._outline()[-1][1]
            deep = 0.5 * (self.row["height"] or self.row["diameter"])
            socket = cq.Workplane("XY").workplane(offset=top - deep).polygon(6, self.row["socket"] / 0.75**0.5)
            body = body.cut(socket.extrude(2 * deep))
        if self.standard == NUT:
            hexagon = cq.Workplane("XY").polygon(6, self.row["outer"] / 0.75**0.5).extrude(self.row["height"])
            body = hexagon.cut(cq.Workplane("XY").circle(self._drill() / 2).extrude(self.row["height"]))
        return body.solids().val()  # type: ignore[return-value]

    def _drill(self) -> float:
        return thread(self.size.lower().replace(".", "_")).tap_drill

    def _outline(self) -> list[tuple[float, float]]:
        """Half of the section through the axis: radius and height."""
        r, outer, high, low = self.row["diameter"] / 2, self.row["outer"] / 2, self.row["height"], -self.length
        edge = 0.16 * r
        shank = [(0.0, low), (r - edge, low), (r, low + edge)]
        if self.standard == CAP:
            rim = 0.06 * high
            return [*shank, (r, 0.0), (outer, 0.0), (outer, high - rim), (outer - rim, high), (0.0, high)]
        if self.standard == SUNK:
            return [*shank, (r, r - outer), (outer, 0.0), (0.0, 0.0)]
        if self.standard == SET:
            return [*shank, (r, 0.0), (0.0, 0.0)]
        if self.standard == PIN:
            chamfer, top = 0.27 * high, self.length
            sides = [(r - chamfer, 0.0), (r, high), (r, top - high), (r - chamfer, top)]
            return [(0.0, 0.0), *sides, (0.0, top)]
        if self.standard == BEARING:
            inner, race = r + RACE * (outer - r), outer - RACE * (outer - r)
            deep = SHIELD * high
            below = [(r, 0.0), (inner, 0.0), (inner, deep), (race, deep), (race, 0.0), (outer, 0.0)]
            return [*below, *((radius, high - level) for radius, level in reversed(below))]
        return [(r, 0.0), (outer, 0.0), (outer, high), (r, high)]

    def material(self, design: Any) -> str:
        return "alloy_steel" if self.standard in (CAP, SUNK, SET, PIN) else "steel"

    @property
    def _size(self) -> str:
        between = " m6" if self.standard == PIN else ""
        return f"{self.size}{between} x {self.length:g}" if self.length else self.size

    def part_number(self, design: Any) -> str:
        return self.size if self.standard == BEARING else f"{self.standard} - {self._size}"

    def description(self, design: Any) -> str:
        return f"{WORDS[self.standard]} {self._size}"

    def datums(self, design: Any) -> dict[str, Datum]:
        """``seat``, ``end`` of screws and ``head`` where the seat is under it; else ``bottom`` and ``top``."""
        down, up, x = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
        if isinstance(self, StandardScrew):
            names = {"seat": 0.0, "head": 0.0, "end": -self.length}
            return {name: Datum(name, (0.0, 0.0, level), down, x) for name, level in names.items()}
        top = self.length or self.row["height"]
        return {
            "bottom": Datum("bottom", (0.0, 0.0, 0.0), down, x),
            "middle": Datum("middle", (0.0, 0.0, top / 2), down, x),
            "top": Datum("top", (0.0, 0.0, top), up, x),
        }

    def dimensions(self, design: Any) -> tuple[Dimension, ...]:
        """None but the thread of a nut: it is purchased."""
        if self.standard != NUT:
            return ()
        major, points = self.row["diameter"], ((0.0, 0.0, self.row["height"] / 2),)
        return (Dimension("thread", "tap_drill", self._drill(), "", points, (0.0, 0.0, 1.0), major=major),)


class StandardScrew(StandardPart):
    """One with an outer thread."""

    def thread(self, design: Any) -> tuple[float, float]:
        """Major diameter and length of the thread, mm."""
        return self.row["diameter"], self.length
