"""Further requirements of the thesis: extension to two axes, replaceable modules, access."""

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, show
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_SECTION = "thesis 2.2, 'other pertinent issues'"


def checks(design: Design) -> list[CheckFunction]:
    """Two axes, replaceable piezos, symmetric base, payload and adjustments within reach."""
    return [two_axes, replaceable, way_and_tip, payload_face]


def two_axes(r: DesignInputs) -> Check:
    """All three tips stay under the stage, whose whole underside is the drive surface then."""
    places = r.design.derived.actuator_places
    far_along = r.given("farthest actuator along", max(abs(x) for x, _ in places) * 1e-3, "m", "layout of the pockets")
    far_across = r.given(
        "farthest actuator across", max(abs(y) for _, y in places) * 1e-3, "m", "layout of the pockets"
    )
    margin, half_pad, across = r("sea.contact_margin"), r("pads.width") / 2, r("pads.spacing_across") / 2
    face = r("base.way_gap") / 2
    # Across the travel too, the pads must stay on the running faces of the ways.
    on_way = min(
        across - half_pad - face, face + r("bearing_way.width") - r("bearing_way.ledge_width") - across - half_pad
    )
    room = {
        "along": r("stage.length") / 2 - far_along - margin,
        "across": min(r("stage.width") / 2 - far_across - margin, on_way),
    }
    travel = 2 * min(room.values())
    wanted = r("requirements.travel")
    return Check(
        "travel with three actuators, for two axes",
        at_least(travel, 0.0, "m"),
        source="geometry; thesis 2.5: the base is already capable of accommodating two more actuators",
        formula="2 min(L/2 - |x|, W/2 - |y|, running face next to the pads) less margins > 0",
        substituted=f"along {show(2 * room['along'], 'm')}, across {show(2 * room['across'], 'm')}",
        proposal=f"a stage {show(2 * (far_along + margin), 'm')} long",
        requirement="Section 2.2: open to two axes",
        note=f"the full {show(wanted, 'm')} would need a stage of {show(wanted + 2 * (far_along + margin), 'm')} by "
        f"{show(wanted + 2 * (far_across + margin), 'm')}, and ways whose running faces are "
        f"{show(wanted + 2 * half_pad, 'm')} wide",
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
