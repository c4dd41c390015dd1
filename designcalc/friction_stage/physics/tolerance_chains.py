"""Tolerance chains of a design: the dimensions that add up to a functional distance, by worst case and statistically.

A chain is a sum of dimensions with signs, ``Y = sum(a_i x_i)``, each ``x_i`` within its deviations ``[l_i, u_i]``.
Worst case: ``Y`` is within ``sum(a_i l_i)`` to ``sum(a_i u_i)`` of its nominal value, the ends of a term exchanged
where ``a_i`` is negative. Statistically: each dimension is normal about the middle of its limits, these at three
standard deviations; then ``Y`` is within ``sqrt(sum((a_i (u_i - l_i)/2)^2))`` of its mean with a probability of
99.73 %.
Source: ISO/TR 16015; Bjorke, Computer-Aided Tolerancing, 2nd ed., chapters 3 and 5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stagecad.parameters.units import as_json

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

MM = 1e-3


@dataclass(frozen=True)
class Link:
    """One dimension of a chain.

    Args:
        key: parameter; a geometrical tolerance by its own key.
        coefficient: change of the result per change of the dimension.
        nominal: m; 0 for a geometrical tolerance.
        low, high: limit deviations, m.
    """

    key: str
    coefficient: float
    nominal: float
    low: float
    high: float

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and greatest contribution to the deviation of the result, m."""
        ends = self.coefficient * self.low, self.coefficient * self.high
        return min(ends), max(ends)


@dataclass(frozen=True)
class Chain:
    """A functional distance and the dimensions that it is the sum of.

    Args:
        name: of the distance.
        links: its dimensions.
        offset: constant part of the nominal value, m.
    """

    name: str
    links: tuple[Link, ...]
    offset: float = 0.0

    @property
    def nominal(self) -> float:
        """Value with all dimensions at their nominal sizes, m."""
        return self.offset + sum(link.coefficient * link.nominal for link in self.links)

    @property
    def worst_case(self) -> tuple[float, float]:
        """Smallest and greatest value, m."""
        return (
            self.nominal + sum(link.ends[0] for link in self.links),
            self.nominal + sum(link.ends[1] for link in self.links),
        )

    @property
    def statistical(self) -> tuple[float, float]:
        """Limits that hold with a probability of 99.73 %, m."""
        low, high = self.worst_case
        half = math.sqrt(sum(((link.ends[1] - link.ends[0]) / 2) ** 2 for link in self.links))
        return (low + high) / 2 - half, (low + high) / 2 + half

    def as_json(self) -> dict[str, Any]:
        """The chain as a JSON document, lengths in m."""
        return {
            "name": self.name,
            "nominal": as_json(self.nominal, "m"),
            "worst_case": [as_json(value, "m") for value in self.worst_case],
            "statistical": [as_json(value, "m") for value in self.statistical],
            "links": [
                {
                    "key": link.key,
                    "coefficient": link.coefficient,
                    "nominal": as_json(link.nominal, "m"),
                    "low": as_json(link.low, "m"),
                    "high": as_json(link.high, "m"),
                }
                for link in self.links
            ],
        }


def chains(design: Design) -> tuple[Chain, ...]:
    """All tolerance chains of a design."""
    found = [tip_height(design), tip_to_drive_surface(design), holder_in_pocket(design), pad_plane(design)]
    return (*found, tooth_gap(design)) if design.teeth.fitted else tuple(found)


UNDER_TIP = (
    ("base.pin_1_axis_depth", -1.0),
    ("height_pin_1.flat_height", 1.0),
    ("height_pin_2.length", 1.0),
    ("holder.floor", 1.0),
    ("piezo.length", 1.0),
    ("actuator.tip_height", 1.0),
)
"""Dimensions from the top of the base to the tip's apex, with the height adjustment in the middle."""


def tip_height(design: Design) -> Chain:
    """Height of the tip's apex over the top of the base, the height adjustment in the middle."""
    return Chain("tip height", _sizes(design, UNDER_TIP))


def tip_to_drive_surface(design: Design) -> Chain:
    """Gap between drive surface and apex, the height adjustment in the middle."""
    above = (("bearing_way.height", 1.0), ("pads.height", 1.0))
    below = tuple((key, -coefficient) for key, coefficient in UNDER_TIP)
    links = (*_sizes(design, (*above, *below)), _zone(design, "drawing.tolerance_x_xx", 0.5))
    return Chain("tip to drive surface", links)


def holder_in_pocket(design: Design) -> Chain:
    """Clearance between holder and pocket, on the diameter."""
    return Chain("holder in pocket", _sizes(design, (("base.pocket_diameter", 1.0), ("holder.diameter", -1.0))))


def pad_plane(design: Design) -> Chain:
    """Difference in height of the two running faces under the pads: pair of ways, their flatness, that of the base."""
    zones = (
        _zone(design, "bearing_way.pair_tolerance", 1.0),
        _zone(design, "bearing.way_straightness", 1.0),
        _zone(design, "bearing.way_straightness", 1.0),
        _zone(design, "bearing.way_straightness", 1.0),
    )
    return Chain("pad plane", zones)


def tooth_gap(design: Design) -> Chain:
    """Gap between the crests of the tooth irons and of the tooth bar."""
    sizes = (
        ("bearing_way.height", 1.0),
        ("pads.height", 1.0),
        ("stage.iron_pocket_depth", 1.0),
        ("tooth_iron.height", -1.0),
        ("base.seat_height", 1.0),
        ("tooth_bar.height", -1.0),
    )
    return Chain("tooth gap", _sizes(design, sizes))


def _sizes(design: Design, terms: tuple[tuple[str, float], ...]) -> tuple[Link, ...]:
    """Links of dimensions with the tolerances of their classes."""
    links = []
    for key, coefficient in terms:
        low, high = design.deviations(key)
        links.append(Link(key, coefficient, design.si(key), low * MM, high * MM))
    return tuple(links)


def _zone(design: Design, key: str, share: float) -> Link:
    """Link of a geometrical tolerance or a difference: either way by a share of the width of its zone."""
    width = share * design.si(key)
    return Link(key, 1.0, 0.0, -width, width)
