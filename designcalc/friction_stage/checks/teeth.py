"""Magnetic teeth: position of the chosen ones on the map, saturation, and relief of the pads."""

import numpy as np

from designcalc.checks.check import Check, CheckFunction, DesignInputs
from designcalc.drive.magnetic_teeth import teeth_field
from designcalc.friction_stage.checks.preload import attraction_as_preload, attraction_beyond_preload
from designcalc.friction_stage.physics.loads import MAGNETS, tooth_field
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_FIELD = "field of one cell by mode matching (K_x = -d2W/dx2, K_z = d2W/de2)"


def checks(design: Design) -> list[CheckFunction]:
    """Every check of the teeth; none where no teeth are fitted."""
    return (
        [ratio, lateral, attraction_as_preload, attraction_beyond_preload, saturation, against_pads]
        if design.teeth.fitted
        else []
    )


def ratio(r: DesignInputs) -> Check:
    """The thesis places the largest ratio at l/p = 0.4; by the field solution it rises towards thin teeth."""
    pitch, width, gap, depth = (r(f"teeth.{name}") for name in ("pitch", "width", "gap", "groove_depth"))
    widths = {"of_teeth": width, "by_rule": 0.4 * pitch, "of_thin_teeth": 0.2 * pitch}
    found = {f"ratio.{name}": teeth_field(pitch, w, gap, depth).lateral_over_normal for name, w in widths.items()}
    return stated(
        "ratio of lateral to normal stiffness of the teeth",
        "ratio.of_teeth/ratio.of_thin_teeth >= 0.8",
        ("teeth.width", "0.24*teeth.pitch", False),
        given={name: (value, "") for name, value in found.items()},
        source=_FIELD + ", against that of l/p = 0.2, about the thinnest that iron saturation and machining allow",
        proposal="narrower teeth, as far as the flux density in them allows",
        thesis="'l/p about 0.4 of the gap e' mixes up dimensions, and K_x/K_z has no optimum there: it rises steadily "
        "as l/p falls, {ratio.by_rule} at 0.4, {ratio.of_thin_teeth} at 0.2",
    )(r)


def lateral(r: DesignInputs) -> Check:
    pitch, gap, depth = r("teeth.pitch"), r("teeth.gap"), r("teeth.groove_depth")
    widths = np.arange(0.10, 0.81, 0.05)
    fields = [teeth_field(pitch, w * pitch, gap, depth, functions=8).lateral_stiffness for w in widths]
    best = int(np.argmax(fields))
    return stated(
        "lateral stiffness of the teeth against the best width",
        "stiffness.lateral/stiffness.best_lateral >= 0.85",
        ("teeth.width", "width.best", False),
        given={
            "stiffness.lateral": (tooth_field(r).lateral_stiffness, "N/m"),
            "stiffness.best_lateral": (fields[best], "N/m"),
            "width.best": (widths[best] * pitch, "m"),
        },
        source=_FIELD + ", largest over the width of the teeth at this gap",
        proposal="the best width, {width.best}",
    )(r)


saturation = stated(
    "flux density in the teeth",
    "flux.gap*teeth.pitch/teeth.width <= 0.8*teeth.saturation",
    source=MAGNETS + "; all flux of a pitch gathered in its tooth",
    proposal="wider teeth, or a thinner magnet",
)


against_pads = stated(
    "negative stiffness of the teeth against the pads'",
    "stiffness.teeth <= stiffness.pads/10",
    source=MAGNETS + "; pads as crowned contacts",
    proposal="a wider gap",
)
