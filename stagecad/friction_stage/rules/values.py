"""Rules between numbers that are no geometry: ranges the right way round, drive within the piezo's voltage."""

from collections.abc import Iterator

from stagecad.parameters.design import Design
from stagecad.parameters.rules import rule

_ORDERED = (
    ("shim.thinnest", "shim.thickest"),
    ("bearing.static_friction_low", "bearing.static_friction_high"),
    ("bearing.dynamic_friction_low", "bearing.dynamic_friction_high"),
    ("bearing.dynamic_friction", "bearing.static_friction"),
    ("friction.coulomb", "friction.breakaway"),
    ("friction.lag_low", "friction.lag_high"),
    ("requirements.resolution", "requirements.resolution_coarse"),
    ("requirements.acceleration_low", "requirements.acceleration"),
    ("actuator.bias_voltage", "piezo.highest_voltage"),
    ("drawing.tolerance_x_xx", "drawing.tolerance_x_x"),
    ("drawing.tolerance_x_x", "drawing.tolerance_x"),
)


@rule
def ordered(d: Design) -> Iterator[str]:
    """A value named as the smaller of two is not larger than the other one."""
    for small, large in _ORDERED:
        if d.si(small) > d.si(large):
            yield f"<{small}> is more than <{large}>"


_HOLES = {
    "screws.way": ("3/8-16 UNC", "threads.unc_3_8_pitch"),
    "screws.clamp_long": ("3/8-16 UNC", "threads.unc_3_8_pitch"),
    "screws.clamp_short": ("3/8-16 UNC", "threads.unc_3_8_pitch"),
    "screws.bar": ("M5x0.8", "threads.m5_pitch"),
    "set_screw": ("1-8 UNC", "threads.unc_1_pitch"),
}
"""Thread that the base has for each screw, and the key of its pitch."""


@rule
def screws_in_their_threads(d: Design) -> Iterator[str]:
    """Screws have the threads of their tapped holes."""
    for screw, (designation, pitch) in _HOLES.items():
        thread = str(d.value(f"{screw}.thread"))
        if thread.replace(" ", "") != designation.replace(" ", ""):
            yield f"{screw}.thread = '{thread}' does not go into its hole in the base, which is tapped {designation}"
        elif abs(d.value(f"{screw}.pitch") - d.value(pitch)) > 0.01:
            yield f"<{screw}.pitch> is not that of its tapped hole: <{pitch}>"


@rule
def purchased_shapes(d: Design) -> Iterator[str]:
    """Purchased parts have the shape of their kind: heads wider than shanks, coils wider than wire."""
    for name in ("way", "clamp_long", "clamp_short", "bar"):
        screw = getattr(d.screws, name)
        key = f"screws.{name}"
        if screw.head_diameter <= screw.diameter:
            yield f"<{key}.head_diameter> is no wider than <{key}.diameter>"
        if screw.socket_width >= screw.head_diameter * 0.85:
            yield f"<{key}.socket_width> does not go into <{key}.head_diameter>"
    if d.set_screw.socket_width >= d.set_screw.diameter * 0.85:
        yield "<set_screw.socket_width> does not go into <set_screw.diameter>"
    if 2 * d.spring.wire_diameter >= d.spring.outer_diameter:
        yield "<spring.wire_diameter> leaves no inside in <spring.outer_diameter>"
    if d.piezo.end_radius <= d.piezo.diameter / 2:
        yield "<piezo.end_radius> is too small for an end on <piezo.diameter>"
