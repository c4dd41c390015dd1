"""Tolerance chains against what the machine can take up: worst case of each."""

from collections.abc import Callable
from functools import partial

from designcalc.checks.check import Check, CheckFunction, DesignInputs
from designcalc.friction_stage.physics.tolerance_chains import (
    Chain,
    holder_in_pocket,
    pad_plane,
    tip_height,
    tip_to_drive_surface,
    tooth_gap,
)
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

SOURCE = "tolerance chain by worst case, ISO/TR 16015"
_ADJUSTED = "height_pin_1.slope*height_pin_1.stroke/2"
_SPREAD = "max(chain.nominal - chain.least, chain.greatest - chain.nominal)"
_LONGER = "a longer stroke of height pin 1, or tighter lengths of piezo, pins and tip"


def checks(design: Design) -> list[CheckFunction]:
    """Height of the tip, holder in its pocket, plane of the pads, gap of the teeth."""
    found: list[CheckFunction] = [
        partial(_check, "tip height", tip_height, f"{_SPREAD} <= {_ADJUSTED}", _LONGER),
        partial(
            _check,
            "tip to drive surface",
            tip_to_drive_surface,
            f"max(abs(chain.least), abs(chain.greatest)) <= {_ADJUSTED}",
            _LONGER,
        ),
        partial(
            _check,
            "greatest play of the holder",
            holder_in_pocket,
            "chain.greatest <= making.largest_fit",
            "a smaller pocket, or tighter classes of pocket and holder",
        ),
        partial(
            _check,
            "least play of the holder",
            holder_in_pocket,
            "chain.least >= 0 m",
            "a wider pocket, or tighter classes of pocket and holder",
        ),
        # The ways may tilt the stage no more than its drive surface may be out of parallel.
        partial(
            _check,
            "plane of the pads",
            pad_plane,
            f"{_SPREAD} <= drawing.tolerance_x_xx",
            "ways lapped together as a pair, to a tighter bearing_way.pair_tolerance",
        ),
    ]
    teeth = partial(
        _check,
        "gap of the teeth",
        tooth_gap,
        f"{_SPREAD} <= teeth.gap_tolerance",
        "tighter heights of ways, pads, irons and bars, or shims under the bars",
    )
    return [*found, teeth] if design.teeth.fitted else found


def _check(name: str, chain_of: Callable[[Design], Chain], formula: str, proposal: str, r: DesignInputs) -> Check:
    chain = chain_of(r.design)
    for key in dict.fromkeys(link.key for link in chain.links):
        r(key)
    (least, greatest), (low, high) = chain.worst_case, chain.statistical
    numbers = {"nominal": chain.nominal, "least": least, "greatest": greatest, "low": low, "high": high}
    return stated(
        f"tolerance chain: {name}",
        formula,
        given={f"chain.{key}": (value, "m") for key, value in numbers.items()},
        source=SOURCE,
        proposal=proposal,
        note="{chain.least} to {chain.greatest} about {chain.nominal}; 99.73 %: {chain.low} to {chain.high}",
    )(r)
