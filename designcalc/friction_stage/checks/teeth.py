"""Magnetic teeth: position of the chosen ones on the map, preload, saturation, and relief of the pads."""

import math

import numpy as np
from scipy.optimize import root_scalar

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, change, show
from designcalc.drive.magnetic_teeth import teeth_field
from designcalc.friction_stage.physics.teeth import CIRCUITS, MagnetCircuit, attraction, circuit, magnets, tooth_field
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_MAGNETS = "finite elements in the cross-section of magnet, irons and bar, leakage included; virtual work"
_FIELD = "field of one cell by mode matching (K_x = -d2W/dx2, K_z = d2W/de2)"


def checks(design: Design) -> list[CheckFunction]:
    """Every check of the teeth; none where no teeth are fitted."""
    return [ratio, lateral, preload, preload_share, saturation, against_pads] if design.teeth.fitted else []


def ratio(r: DesignInputs) -> Check:
    """The thesis places the largest ratio at l/p = 0.4; by the field solution it rises towards thin teeth."""
    pitch, width, gap, depth = (r(f"teeth.{name}") for name in ("pitch", "width", "gap", "groove_depth"))
    here = teeth_field(pitch, width, gap, depth).lateral_over_normal
    at_rule = teeth_field(pitch, 0.4 * pitch, gap, depth).lateral_over_normal
    thin = teeth_field(pitch, 0.2 * pitch, gap, depth).lateral_over_normal
    return Check(
        "ratio of lateral to normal stiffness of the teeth",
        at_least(here / thin, 0.8, ""),
        source=_FIELD,
        formula="K_x/K_z over that of l/p = 0.2, about the thinnest that iron saturation and machining allow",
        substituted=f"e/p = {gap / pitch:.3g}: {here:.4g} at l/p = {width / pitch:.3g}, {thin:.4g} at 0.2",
        proposal="narrower teeth, as far as the flux density in them allows",
        changes=change("teeth.width", 0.24 * pitch, "m", up=False),
        thesis=f"'l/p about 0.4 of the gap e' mixes up dimensions, and K_x/K_z has no optimum there: it rises steadily "
        f"as l/p falls, {at_rule:.4g} at 0.4, {thin:.4g} at 0.2",
    )


def lateral(r: DesignInputs) -> Check:
    field, pitch, gap = tooth_field(r), r("teeth.pitch"), r("teeth.gap")
    widths = np.arange(0.10, 0.81, 0.05)
    fields = [teeth_field(pitch, w * pitch, gap, r("teeth.groove_depth"), functions=8) for w in widths]
    values = np.array([f.lateral_stiffness for f in fields])
    best = int(np.argmax(values))
    return Check(
        "lateral stiffness of the teeth against the best width",
        at_least(field.lateral_stiffness / values[best], 0.85, ""),
        source=_FIELD,
        formula="K_x(l)/max K_x over l/p at this gap",
        substituted=f"l/p = {r('teeth.width') / pitch:.3g}, e/p = {gap / pitch:.3g}: K_x/K_z = "
        f"{field.lateral_over_normal:.4g}; best K_x at l/p = {widths[best]:.2f}",
        proposal="the best width",
        changes=change("teeth.width", float(widths[best] * pitch), "m", up=False),
    )


preload = stated(
    "attraction of the magnets as preload",
    "load.magnets >= preload.force",
    source=_MAGNETS + ": F = -u^T (dP/de) u/2 of both pockets",
    proposal="a smaller gap, a longer iron, or a stronger magnet",
    note="gap flux density {flux.gap}",
)


def preload_share(r: DesignInputs) -> Check:
    pull, wanted = attraction(r), r("preload.force")
    gap = gap_for(circuit(r), 1.2 * wanted) if r.advise and wanted > 0 and pull > 1.5 * wanted else None
    changes = change("preload.force", pull / 1.2, "N", up=False)
    if gap is not None:
        changes = change("teeth.gap", gap, "m", up=True) + changes
    return Check(
        "attraction of the magnets beyond the required preload",
        at_most(pull, 1.5 * wanted, "N"),
        source=_MAGNETS,
        formula="F <= 1.5 x required preload (friction grows with it)",
        substituted=f"two pockets pull {show(pull, 'N')}, required {show(wanted, 'N')}",
        proposal="a wider gap, smaller magnets, none (teeth.fitted = false), or require the preload that they give",
        changes=changes,
        note=f"{100 * magnets(r).leakage:.2g} % of the magnets' flux leaks past the bars; every check takes this pull "
        "as the preload",
    )


def gap_for(one: MagnetCircuit, pull: float) -> float | None:
    """Gap at which the magnets pull as much as `pull`, m; none up to five pitches."""

    def excess(logarithm: float) -> float:
        return CIRCUITS * one.forces(0.4, gap=math.exp(logarithm)).attraction / pull - 1

    low, high = math.log(one.section.gap), math.log(5 * one.section.pitch)
    if excess(low) < 0 or excess(high) > 0:
        return None
    # To 1 % of the gap, which suffices for a proposal.
    return math.exp(float(root_scalar(excess, bracket=(low, high), xtol=1e-2).root))


saturation = stated(
    "flux density in the teeth",
    "flux.gap*teeth.pitch/teeth.width <= 0.8*teeth.saturation",
    source=_MAGNETS + "; all flux of a pitch gathered in its tooth",
    proposal="wider teeth, or a thinner magnet",
)


against_pads = stated(
    "negative stiffness of the teeth against the pads'",
    "stiffness.teeth <= stiffness.pads/10",
    source=_MAGNETS + "; pads as crowned contacts",
    proposal="a wider gap",
)
