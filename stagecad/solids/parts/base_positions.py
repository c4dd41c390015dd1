"""Where on the base things are: pockets, and the rows of holes that other parts are screwed to. Millimetres."""

from __future__ import annotations

import math
from typing import Any

Flat = tuple[float, float]


def pocket_centres(design: Any) -> list[Flat]:
    """Axes (x, y) of pockets 1, 2, 3, mm: an equilateral triangle with actuator 1 at the origin, the others at -x."""
    spacing = design.base.actuator_spacing
    back = -spacing * math.sqrt(3.0) / 2
    return [(0.0, 0.0), (back, spacing / 2), (back, -spacing / 2)]


def reach_side(pocket: int) -> float:
    """The side face from which a pocket's height screw is reached: +1 for +x (pocket 1), -1 for -x (2 and 3)."""
    return 1.0 if pocket == 1 else -1.0


def way_hole_places(design: Any) -> list[Flat]:
    """Places (x, y) of the tapped holes under the ways, mm: the left way's (y > 0) first, each by rising x.

    The ways end flush with the base's side faces, and their screws' rows count from there.
    """
    way = design.bearing_way
    count = int(way.bolt_count)
    across = design.base.width / 2 - way.bolt_edge
    return [((i - (count - 1) / 2) * way.bolt_spacing, side * across) for side in (1, -1) for i in range(count)]


def bar_hole_places(design: Any) -> list[Flat]:
    """Places (x, y) of the tapped holes for the tooth bars' screws, mm."""
    bar = design.tooth_bar
    along = bar.screw_span / 2
    across = design.teeth.bar_spacing / 2
    return [
        (x, side * across + step)
        for side in (1, -1)
        for x in (-along, along)
        for step in (-bar.screw_spacing / 2, bar.screw_spacing / 2)
    ]
