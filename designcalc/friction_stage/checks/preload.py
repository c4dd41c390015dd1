"""Preload: against the required share of the load, with the required acceleration, and by the magnets of the teeth."""

import math

from scipy.optimize import root_scalar

from designcalc.checks.check import Check, DesignInputs
from designcalc.friction_stage.physics.loads import CIRCUITS, MAGNETS, MagnetCircuit, attraction, circuit, magnets
from designcalc.friction_stage.quantities import stated

share_of_load = stated(
    "preload against the required share of the load",
    "load.preload >= preload.ratio*load.weight",
    source="thesis 2.3.2: 10 % of the applied load",
    proposal="preload of {check.limit}",
)


preload_and_acceleration = stated(
    "acceleration of 1 G with the required preload",
    "drive.friction*(1 + preload.ratio)*environment.gravity >= requirements.acceleration",
    ("preload.ratio", "requirements.acceleration/drive.friction/environment.gravity - 1", True),
    source="the tip presses at most with weight and preload",
    proposal="ask for more preload "
    "({load.weight*(requirements.acceleration/drive.friction/environment.gravity - 1)}), and magnets that give it",
    thesis="a light preload of 10 % and 1 G do not go together: 0.33 g at mu = 0.3",
    requirement="Table 1: acceleration",
)
"""Two requirements that exclude each other, whatever the magnets really pull."""


attraction_as_preload = stated(
    "attraction of the magnets as preload",
    "load.magnets >= preload.force",
    source=MAGNETS + ": F = -u^T (dP/de) u/2 of both pockets",
    proposal="a smaller gap, a longer iron, or a stronger magnet",
    note="gap flux density {flux.gap}",
)


def attraction_beyond_preload(r: DesignInputs) -> Check:
    pull, wanted = attraction(r), r("preload.force")
    gap = gap_for(circuit(r), 1.2 * wanted) if r.advise and wanted > 0 and pull > 1.5 * wanted else None
    return stated(
        "attraction of the magnets beyond the required preload",
        "load.magnets <= 1.5*preload.force",
        ("teeth.gap", "gap.of_preload", True),
        ("preload.force", "load.magnets/1.2", False),
        given={"gap.of_preload": (gap or 0.0, "m"), "share.of_leakage": (magnets(r).leakage, "")},
        source=MAGNETS + "; friction grows with the preload",
        proposal="a wider gap, smaller magnets, none (teeth.fitted = false), or require the preload that they give",
        note="{100*share.of_leakage} % of the magnets' flux leaks past the bars; every check takes this pull as the "
        "preload",
    )(r)


def gap_for(one: MagnetCircuit, pull: float) -> float | None:
    """Gap at which the magnets pull as much as `pull`, m; none up to five pitches."""

    def excess(logarithm: float) -> float:
        return CIRCUITS * one.forces(0.4, gap=math.exp(logarithm)).attraction / pull - 1

    low, high = math.log(one.section.gap), math.log(5 * one.section.pitch)
    if excess(low) < 0 or excess(high) > 0:
        return None
    # To 1 % of the gap, which suffices for a proposal.
    return math.exp(float(root_scalar(excess, bracket=(low, high), xtol=1e-2).root))
