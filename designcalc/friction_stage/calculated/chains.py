"""Tolerance chains of the machine, and the play of a fit that is in no chain."""

from collections.abc import Callable

from designcalc.checks.chain import Chain, Link, link_of
from designcalc.checks.check import DesignInputs, Quantities
from stagecad.parameters.design import Design


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
    return tuple(link_of(design, key, coefficient) for key, coefficient in terms)


def _zone(design: Design, key: str, share: float) -> Link:
    """Link of a geometrical tolerance or a difference: either way by a share of the width of its zone."""
    width = share * design.si(key)
    return Link(key, 1.0, 0.0, -width, width)


def wedge_contact(r: DesignInputs) -> Quantities:
    """Play of height pin 2 in its bore, within which it turns."""
    # Both fits in the middle of their tolerances.
    middle = {key: 1e-3 * sum(r.design.deviations(key)) / 2 for key in ("base.pin_2_bore", "height_pin_2.diameter")}
    bore, pin = (r(key) + deviation for key, deviation in middle.items())
    return {"play.of_pin_2": (bore - pin, "m")}


def chain_numbers(chain_of: Callable[[Design], Chain], r: DesignInputs) -> Quantities:
    """Nominal value of a chain, and its limits by worst case and statistically."""
    chain = chain_of(r.design)
    for key in dict.fromkeys(link.key for link in chain.links):
        r(key)
    (least, greatest), (low, high) = chain.worst_case, chain.statistical
    numbers = {"nominal": chain.nominal, "least": least, "greatest": greatest, "low": low, "high": high}
    return {f"chain.{key}": (value, "m") for key, value in numbers.items()}


OF_CHECKS = {
    "tip_height": tip_height,
    "tip_to_drive_surface": tip_to_drive_surface,
    "greatest_play": holder_in_pocket,
    "least_play": holder_in_pocket,
    "pad_plane": pad_plane,
    "tooth_gap": tooth_gap,
}
"""Chain by the key of its check."""
