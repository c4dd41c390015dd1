"""Tolerance chains against what the machine can take up: worst case of each."""

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, show
from designcalc.friction_stage.physics.clamp import wedge
from designcalc.friction_stage.physics.tolerance_chains import (
    Chain,
    holder_in_pocket,
    pad_plane,
    tip_height,
    tip_to_drive_surface,
    tooth_gap,
)
from stagecad.parameters.design import Design

SOURCE = "tolerance chain by worst case, ISO/TR 16015"


def checks(design: Design) -> list[CheckFunction]:
    """Height of the tip, holder in its pocket, plane of the pads, gap of the teeth."""
    found: list[CheckFunction] = [tip_over_base, tip_at_stage, loosest_holder, tightest_holder, plane_of_pads]
    return [*found, gap_of_teeth] if design.teeth.fitted else found


def _read(r: DesignInputs, chain: Chain) -> str:
    """Record the dimensions of a chain; the chain with its numbers."""
    for key in dict.fromkeys(link.key for link in chain.links):
        r(key)
    low, high = chain.worst_case
    likely = chain.statistical
    return (
        f"{show(low, 'm')} to {show(high, 'm')} about {show(chain.nominal, 'm')}; 99.73 %: "
        f"{show(likely[0], 'm')} to {show(likely[1], 'm')}"
    )


def _spread(chain: Chain) -> float:
    """Greatest deviation from the nominal value, m."""
    low, high = chain.worst_case
    return max(chain.nominal - low, high - chain.nominal)


def tip_over_base(r: DesignInputs) -> Check:
    chain = tip_height(r.design)
    numbers, adjustment = _read(r, chain), wedge(r).range / 2
    return Check(
        "tolerance chain: tip height",
        at_most(_spread(chain), adjustment, "m"),
        source=SOURCE,
        formula="sum |a_i| t_i <= s stroke/2",
        substituted=numbers,
        proposal="a longer stroke of height pin 1, or tighter lengths of piezo, pins and tip",
    )


def tip_at_stage(r: DesignInputs) -> Check:
    chain = tip_to_drive_surface(r.design)
    numbers, adjustment = _read(r, chain), wedge(r).range / 2
    low, high = chain.worst_case
    return Check(
        "tolerance chain: tip to drive surface",
        at_most(max(abs(low), abs(high)), adjustment, "m"),
        source=SOURCE,
        formula="max |gap| <= s stroke/2",
        substituted=numbers,
        proposal="a longer stroke of height pin 1, or tighter lengths of piezo, pins and tip",
    )


def loosest_holder(r: DesignInputs) -> Check:
    chain = holder_in_pocket(r.design)
    return Check(
        "tolerance chain: greatest play of the holder",
        at_most(chain.worst_case[1], r("making.largest_fit"), "m"),
        source=SOURCE,
        formula="D + t_D - d + t_d <= largest fit",
        substituted=_read(r, chain),
        proposal="a smaller pocket, or tighter classes of pocket and holder",
    )


def tightest_holder(r: DesignInputs) -> Check:
    chain = holder_in_pocket(r.design)
    return Check(
        "tolerance chain: least play of the holder",
        at_least(chain.worst_case[0], 0.0, "m"),
        source=SOURCE,
        formula="D - t_D - d - t_d >= 0",
        substituted=_read(r, chain),
        proposal="a wider pocket, or tighter classes of pocket and holder",
    )


def plane_of_pads(r: DesignInputs) -> Check:
    chain = pad_plane(r.design)
    return Check(
        "tolerance chain: plane of the pads",
        at_most(_spread(chain), r("drawing.tolerance_x_xx"), "m"),
        source=f"{SOURCE}; the ways may tilt the stage no more than its drive surface may be out of parallel",
        formula="pair + 3 flatness <= parallelism of the drive surface",
        substituted=_read(r, chain),
        proposal="ways lapped together as a pair, to a tighter bearing_way.pair_tolerance",
    )


def gap_of_teeth(r: DesignInputs) -> Check:
    chain = tooth_gap(r.design)
    return Check(
        "tolerance chain: gap of the teeth",
        at_most(_spread(chain), r("teeth.gap_tolerance"), "m"),
        source=SOURCE,
        formula="sum |a_i| t_i <= deviation that the preload admits",
        substituted=_read(r, chain),
        proposal="tighter heights of ways, pads, irons and bars, or shims under the bars",
    )
