"""The set screw, wedge and spring of the height adjustment."""

from designcalc.checks.check import Check, CheckFunction, DesignInputs
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design


def checks(design: Design) -> list[CheckFunction]:
    """The set screw and wedge."""
    return [
        sensitivity,
        self_locking,
        wedge_angle,
        wedge_contact,
        adjustment_range,
        shim,
        thickest_shim,
        return_spring,
        clamping,
    ]


sensitivity = stated(
    "height adjustment within the ellipse",
    "actuator.key_angle/360 deg*set_screw.pitch*height_pin_1.slope <= ellipse.rise/2",
    source="wedge on a set screw, turned by hand",
    proposal="a finer slope, or a fine-pitch screw",
    thesis="the tip height is to be set within the 1-10 um of its ellipse",
    requirement="Section 2.2: access to payload and adjustments",
    note="{set_screw.pitch*height_pin_1.slope} a turn, {set_screw.pitch*height_pin_1.slope/360} a degree",
)


self_locking = stated(
    "self-locking of the wedge",
    "height_pin_1.friction >= 1.5*tan(atan(height_pin_1.slope)/2)",
    source="friction angles of both faces of the wedge",
    proposal="a flatter slope",
)


adjustment_range = stated(
    "range of the height adjustment",
    "height_pin_1.slope*height_pin_1.stroke/2 >= 4*drawing.tolerance_x_x + 2*drawing.tolerance_x_xx",
    source="worst case of the height chain: holder, piezo, two pins at X.X; way and pad at X.XX",
    proposal="a stroke of {2*check.limit/height_pin_1.slope}, or tighter pins",
)


shim = stated(
    "thinnest shim against the ellipse",
    "shim.thinnest <= ellipse.rise",
    source="thesis 2.3.3: a shim sets the gap between tip and stage",
    proposal="touch off by the piezos' own signal, or turn the screw "
    "{360*shim.thinnest/(set_screw.pitch*height_pin_1.slope)} degrees after the shim is out",
)


thickest_shim = stated(
    "range of the adjustment against the thickest shim",
    "height_pin_1.slope*height_pin_1.stroke/2 >= shim.thickest",
    ("height_pin_1.stroke", "2*shim.thickest/height_pin_1.slope", True),
    ("shim.thickest", "height_pin_1.slope*height_pin_1.stroke/2", False),
    source="thesis 2.3.3: gap of 0.0005 to 0.030 in held by a shim; lowered by half the range, the tip must let it out",
    proposal="thinner shims, or a longer stroke",
)


_PUSHED_BACK = (
    "(pi/4*holder.diameter^2*holder.height*holder.material.density"
    " + 3*pi/4*piezo.diameter^2*piezo.length*piezo.material.density + tip.mass_limit)*environment.gravity"
)
return_spring = stated(
    "spring that returns the height pin",
    "spring.rate*(spring.free_length - spring.installed_length - height_pin_1.stroke/2)"
    f" >= 2*2*height_pin_1.friction_dry*{_PUSHED_BACK}",
    ("spring.free_length", "spring.free_length + (check.limit - check.value)/spring.rate", True),
    source="Coulomb friction on both faces of the wedge under holder, piezos and tip, by plain volumes; factor 2",
    proposal="more compression at the far end of the stroke, by a longer spring or a shorter stroke",
)


_TILT = "(base.pocket_diameter - holder.diameter)/holder.height"
_APEX = "(holder.floor + piezo.length + actuator.tip_height)"
clamping = stated(
    "shift of the tip's height by clamping",
    "2*holder.material.poisson_ratio*force.on_rim/(pi*holder.diameter*holder.material.youngs_modulus)"
    f" + 2*{_APEX}*sin({_TILT}/2)^2 <= 0.1*ellipse.rise",
    source="the clamp tightened after the height is set: theorem of mean stress, growth by Poisson's ratio; tilt "
    "within the pocket's play",
    proposal="less torque, or a closer fit of the holder; set the height again after clamping",
    requirement="Section 2.2: access to payload and adjustments",
    note=f"sideways the tip may go by {{{_APEX}*sin({_TILT}) + (base.pocket_diameter - holder.diameter)/2}}: set its "
    "place after clamping",
)


wedge_angle = stated(
    "lift of the wedge by its angle's tolerance",
    "tan(atan(height_pin_1.slope) + drawing.wedge_angularity/height_pin_1.length*1 rad)/height_pin_1.slope - 1 <= 0.1",
    (
        "drawing.wedge_angularity",
        "0.1*height_pin_1.slope*cos(atan(height_pin_1.slope))^2*height_pin_1.length",
        False,
    ),
    source="face turned within the zone of its angularity over its length; a tenth as rule of thumb",
    proposal="an angularity of {0.1*height_pin_1.slope*height_pin_1.length} or closer",
)


def wedge_contact(r: DesignInputs) -> Check:
    """Two wedge faces of unlike angles touch at an edge, unless pin 2 can turn in its bore by the difference."""
    # Both fits in the middle of their tolerances.
    middle = {key: 1e-3 * sum(r.design.deviations(key)) / 2 for key in ("base.pin_2_bore", "height_pin_2.diameter")}
    bore, pin = (r(key) + deviation for key, deviation in middle.items())
    faces = "(1 rad/height_pin_1.length + 1 rad/height_pin_2.diameter)"
    return stated(
        "contact of the two wedges over their faces",
        f"drawing.wedge_angularity*{faces} <= 1 rad*play.of_pin_2/height_pin_2.length",
        ("drawing.wedge_angularity", f"check.limit/{faces}", False),
        given={"play.of_pin_2": (bore - pin, "m")},
        source="both faces turned within the zones of their angularity; pin 2 turns within the play of its bore, or "
        "stands on an edge",
        proposal="both wedges ground in one setting, or the foot of pin 2 crowned as its top is",
    )(r)
