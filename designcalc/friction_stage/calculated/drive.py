"""Friction drive: the share of the load that the tip may carry, and the way in which the stage stops."""

import numpy as np

from designcalc.checks.check import Check, DesignInputs, Quantities
from designcalc.drive.friction_drive import tip_force_limit
from designcalc.friction_stage.physics import loads, pads
from designcalc.friction_stage.quantities import stated


def tip_over(r: DesignInputs) -> Quantities:
    mu, mu_pad, end = r("drive.friction"), r("bearing.dynamic_friction"), r("stage.travel") / 2
    share = min(tip_force_limit(pads.pad_positions(r), loads.load_centre(r), (side * end, 0.0)) for side in (-1, 1))
    # share needed, from a = g (1+p) [mu s - mu_pad (1-s)], and the half-span that gives it
    pull = r("environment.gravity") * (1 + loads.preload_ratio(r))
    needed = (r("requirements.acceleration_low") / pull + mu_pad) / (mu + mu_pad)
    span = needed * end / (1 - needed) if needed < 1 else np.inf
    return {"share.of_tip": (share, ""), "span.needed": (span, "m")}


_ENERGY, _BRAKE = "load.moved_mass*requirements.speed^2/2", "(bearing.dynamic_friction*load.whole)"
_BUFFERS = "(end_stop.count*end_stop.stiffness)"
_ROOM = "(bearing_way.length - stage.travel - pads.spacing_along - pads.length)/2"


def stopping(r: DesignInputs) -> Check:
    """Without drive the stage meets its end stops at full speed; without end stops only the pads brake it."""
    formula = f"{_ENERGY}/{_BRAKE} <= {_ROOM}"
    if r("end_stop.count") * r("end_stop.stiffness") > 0:
        # Friction, and the buffers from their gap on: k s^2/2 + f (gap + s) = E.
        left = f"max({_ENERGY} - {_BRAKE}*end_stop.gap, 0 J)"
        pressed = f"(sqrt({_BRAKE}^2 + 2*{_BUFFERS}*{left}) - {_BRAKE})/{_BUFFERS}"
        formula = f"end_stop.gap + {pressed} <= min({_ROOM}, end_stop.gap + end_stop.compression)"
    return stated(
        "stopping at the end of the travel",
        formula,
        source="energy of stage and payload at full speed against end stops and the pads' friction",
        proposal=f"end stops that take {{{_ENERGY}: J}}, or less speed near the ends",
        requirement="Table 1: travel",
        note=f"without end stops the pads' friction alone needs {{{_ENERGY}/{_BRAKE}}} of {{{_ROOM}}}",
    )(r)
