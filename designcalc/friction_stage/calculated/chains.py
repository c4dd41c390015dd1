"""Tolerance chains of the machine, and the play of a fit that is in no chain."""

from designcalc.checks.chain import Chain, Link, link_of
from designcalc.checks.check import DesignInputs, Quantities
from stagecad.friction_stage.rules.height import UNDER_TIP
from stagecad.parameters.design import Design

SURFACE = {"bearing_way.height": 1.0, "pads.height": 1.0}
"""Dimensions from the top of the base to the drive surface."""
SIZES: dict[str, dict[str, float]] = {
    # Height of the apex over the top of the base, and the gap between drive surface and apex.
    "tip height": UNDER_TIP,
    "tip to drive surface": SURFACE | {key: -c for key, c in UNDER_TIP.items()},
    # Clearance on the diameter.
    "holder in pocket": {"base.pocket_diameter": 1.0, "holder.diameter": -1.0},
    # Difference in height of the two running faces under the pads.
    "pad plane": {},
    # Between the crests of the tooth irons and of the tooth bar.
    "tooth gap": SURFACE
    | {"stage.iron_pocket_depth": 1.0, "tooth_iron.height": -1.0, "base.seat_height": 1.0, "tooth_bar.height": -1.0},
}
"""Dimensions of each chain with their coefficients."""
ZONES = {
    "tip to drive surface": [("drawing.tolerance_x_xx", 0.5)],
    # The pair of ways, their flatness, and that of the base.
    "pad plane": [("bearing_way.pair_tolerance", 1.0), *[("bearing.way_straightness", 1.0)] * 3],
}
"""Geometrical tolerances and differences of a chain: either way by a share of the width of the zone."""


def chains(design: Design) -> tuple[Chain, ...]:
    """All tolerance chains of a design."""
    return tuple(chain(name, design) for name in SIZES if name != "tooth gap" or design.teeth.fitted)


def chain(name: str, design: Design) -> Chain:
    """One tolerance chain of a design."""
    widths = [(key, share * design.si(key)) for key, share in ZONES.get(name, ())]
    zones = [Link(key, 1.0, 0.0, -width, width) for key, width in widths]
    return Chain(name, (*(link_of(design, key, coefficient) for key, coefficient in SIZES[name].items()), *zones))


def wedge_contact(r: DesignInputs) -> Quantities:
    """Play of height pin 2 in its bore, within which it turns."""
    # Both fits in the middle of their tolerances.
    middle = {key: 1e-3 * sum(r.design.deviations(key)) / 2 for key in ("base.pin_2_bore", "height_pin_2.diameter")}
    bore, pin = (r(key) + deviation for key, deviation in middle.items())
    return {"play.of_pin_2": (bore - pin, "m")}


def chain_numbers(name: str, r: DesignInputs) -> Quantities:
    """Nominal value of a chain, and its limits by worst case and statistically."""
    found = chain(name, r.design)
    for key in dict.fromkeys(link.key for link in found.links):
        r(key)
    (least, greatest), (low, high) = found.worst_case, found.statistical
    numbers = {"nominal": found.nominal, "least": least, "greatest": greatest, "low": low, "high": high}
    return {f"chain.{key}": (value, "m") for key, value in numbers.items()}


OF_CHECKS = {name.replace(" ", "_"): name for name in SIZES if name != "holder in pocket"}
OF_CHECKS |= dict.fromkeys(("greatest_play", "least_play"), "holder in pocket")
"""Chain by the key of its check."""
