"""Further requirements of the thesis: extension to two axes, replaceable modules, access."""

from collections.abc import Callable

from designcalc.checks.check import CheckFunction, DesignInputs
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_SECTION = "thesis 2.2, 'other pertinent issues'"


def checks(design: Design) -> list[CheckFunction]:
    """Two axes, replaceable piezos, symmetric base, payload and adjustments within reach."""
    return [two_axes, replaceable, way_and_tip, payload_face]


def _farthest(axis: int, name: str) -> Callable[[DesignInputs], float]:
    """Distance of the farthest actuator from the middle along an axis, m."""
    return lambda r: r.given(
        f"farthest actuator {name}",
        max(abs(place[axis]) for place in r.design.derived.actuator_places) * 1e-3,
        "m",
        "layout of the pockets",
    )


# All three tips stay under the stage, whose whole underside is the drive surface then; across the travel too, the pads
# must stay on the running faces of the ways.
two_axes = stated(
    "travel with three actuators, for two axes",
    "2*min(stage.length/2 - farthest.along - sea.contact_margin,"
    " stage.width/2 - farthest.across - sea.contact_margin,"
    " (pads.spacing_across - pads.width - base.way_gap)/2, base.way_gap/2 + bearing_way.width - bearing_way.ledge_width"
    " - (pads.spacing_across + pads.width)/2) >= 0 m",
    given={"farthest.along": (_farthest(0, "along"), "m"), "farthest.across": (_farthest(1, "across"), "m")},
    source="geometry; thesis 2.5: the base is already capable of accommodating two more actuators",
    proposal="a stage {2*(farthest.along + sea.contact_margin)} long",
    requirement="Section 2.2: open to two axes",
    note="the full {requirements.travel} would need a stage of {requirements.travel + 2*(farthest.along"
    " + sea.contact_margin)} by {requirements.travel + 2*(farthest.across + sea.contact_margin)}, and ways whose "
    "running faces are {requirements.travel + pads.width} wide",
)


replaceable = stated(
    "play of a piezo in its bore",
    "holder.bore_diameter - piezo.diameter >= 2*drawing.tolerance_x_xx",
    source=_SECTION + "; worst case of bore and case, both within X.XX: a stack slides out when it is defective",
    proposal="a bore of {piezo.diameter + check.limit}",
    requirement="Section 2.2: modular",
    note="the tip, bonded to all three piezos, is released by solvent first: last step of the assembly procedure",
)


way_and_tip = stated(
    "play of the actuator in its pocket",
    "base.pocket_diameter - holder.diameter >= 2*drawing.tolerance_x_xx",
    source=_SECTION + "; worst case of pocket and holder, both within X.XX: the actuator lifts out as a module",
    proposal="a pocket of {holder.diameter + check.limit}",
    requirement="Section 2.2: modular",
)


payload_face = stated(
    "thread for the payload from above",
    "stage.payload_thread_depth >= 6 mm",
    source=_SECTION + "; one diameter of the M6 thread in aluminium under a payload that gravity holds",
    proposal="a stage {stage.thickness + check.limit - check.value} thick",
    requirement="Section 2.2: access to payload and adjustments",
    note="over a floor of {stage.payload_floor}, which keeps the sea flat below",
)
