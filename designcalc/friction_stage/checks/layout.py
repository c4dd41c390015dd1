"""Further requirements of the thesis: extension to two axes, replaceable modules, access."""

from __future__ import annotations

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, show
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


def replaceable(r: DesignInputs) -> Check:
    play = r("holder.bore_diameter") - r("piezo.diameter")
    fit = r("drawing.tolerance_x_xx")
    return Check(
        "play of a piezo in its bore",
        at_least(play, 2 * fit, "m"),
        source=_SECTION + "; worst case of bore and case, both within X.XX",
        formula="bore - case >= 2 x tolerance: a stack slides out when it is defective",
        note="the tip, bonded to all three piezos, is released by solvent first: last step of the assembly procedure",
        substituted=f"{show(r('holder.bore_diameter'), 'm')} - {show(r('piezo.diameter'), 'm')} = {show(play, 'm')}",
        proposal=f"a bore of {show(r('piezo.diameter') + 2 * fit, 'm')}",
        requirement="Section 2.2: modular",
    )


def way_and_tip(r: DesignInputs) -> Check:
    """Holder with piezos and tip comes out upwards: the clamp opens wider than the holder."""
    play = r("base.pocket_diameter") - r("holder.diameter")
    fit = r("drawing.tolerance_x_xx")
    return Check(
        "play of the actuator in its pocket",
        at_least(play, 2 * fit, "m"),
        source=_SECTION + "; worst case of pocket and holder, both within X.XX",
        formula="pocket - holder >= 2 x tolerance: the actuator lifts out as a module",
        substituted=f"{show(r('base.pocket_diameter'), 'm')} - {show(r('holder.diameter'), 'm')} = {show(play, 'm')}",
        proposal=f"a pocket of {show(r('holder.diameter') + 2 * fit, 'm')}",
        requirement="Section 2.2: modular",
    )


def payload_face(r: DesignInputs) -> Check:
    """Payloads are bolted from above: threads long enough, and a floor that keeps the sea flat below them."""
    thread, floor = r("stage.payload_thread_depth"), r("stage.payload_floor")
    size = r.given("payload thread", 6e-3, "m", "M6, as the drill and pitch in [threads]")
    return Check(
        "thread for the payload from above",
        at_least(thread, size, "m"),
        source=_SECTION + "; one diameter of thread in aluminium under a payload that gravity holds",
        formula="thread depth >= d",
        substituted=f"M6: {show(thread, 'm')} over a floor of {show(floor, 'm')}",
        proposal=f"a stage {show(r('stage.thickness') + size - thread, 'm')} thick",
        requirement="Section 2.2: access to payload and adjustments",
    )
