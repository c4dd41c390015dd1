"""Tip on stage: pressure, stroke lost in the contact, stiffness; with the results of the thesis's printed formulas."""

from designcalc.checks.check import CheckFunction, FormulaCheck
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_JOHNSON = "Johnson, Contact Mechanics (1985), section 4.2"
_PRESSURE = "(6*load.peak_of_tip*modulus.tip_contact^2/(pi^3*tip.nose_radius^2))^(1/3)"
_APPROACH = "(9*load.of_tip^2/(16*tip.nose_radius*modulus.tip_contact^2))^(1/3)"


def checks(design: Design) -> list[CheckFunction]:
    """Every check of the tip's contact."""
    return [pressure, coating(design), lost_stroke, contact_stiffness]


pressure = stated(
    "tip contact pressure",
    f"{_PRESSURE} <= min(tip.material.strength/mises.tip, stage.material.strength/mises.stage)",
    # The pressure falls as R^(-2/3), while the stiffer contact raises the peak force.
    ("tip.nose_radius", "tip.nose_radius*(check.value/check.limit)^2.5", True),
    source=_JOHNSON + "; first yield below the surface by the largest von Mises stress over the peak pressure, section "
    "6.1; peak of a tip that carries the load in pulses",
    proposal="a larger nose radius (pressure falls as R^(-2/3)), or a harder tip",
    thesis="appendix A prints q = 3F/(3 pi c d), which gives {check.value*2/3}; right is 3F/(2 pi c d), {check.value}",
    note="peak shear {shear.under_tip} at a depth of {depth.of_shear}",
)


def coating(design: Design) -> FormulaCheck:
    """The nose's coating is thin compared with the contact: it has the strain of the body under it."""
    layer = f"materials.{design.value('tip.coating_material')}"
    nu = "tip.material.poisson_ratio"
    return stated(
        "cracking of the tip's coating",
        f"{_PRESSURE}*((1 - 2*{nu})/3 + drive.friction*pi*(4 + {nu})/8)*{layer}.youngs_modulus"
        f"/(1 - {layer}.poisson_ratio^2)/(tip.material.youngs_modulus/(1 - {nu}^2)) <= {layer}.strength",
        source="Hamilton, Goodman (1966): tension at the trailing edge of the sliding contact; coating strained with "
        "the body",
        proposal="a larger nose radius, or a softer coating",
        requirement="Table 2: friction layer",
    )


# The printed deflection is the law of the semi-axes, ~F^(1/3); as a force's potential it must go as F^(2/3).
# On a flat, Re = R/2 and lambda = 0.75.
lost_stroke = stated(
    "tip stroke lost to the contact",
    f"{_APPROACH} + bend.above_tip + max(lift.above_tip, 0 m) <= 0.2*ellipse.rise",
    source=_JOHNSON + "; stage as a plate on its pads, its modes shaken by the pulses of the tip, at the peak of the "
    "force; a fifth of the rise left as rule of thumb",
    proposal="less preload, a stiffer stage, or a larger nose radius",
    thesis="appendix A prints delta = lambda (3 F Re/(2 Ee))^(1/3), which gives "
    "{0.75*(3*load.of_tip*tip.nose_radius/(4*modulus.tip_contact))^(1/3)}; right is lambda (2 F^2/(3 Re Ee^2))^(1/3), "
    f"{{{_APPROACH}}}",
)


contact_stiffness = stated(
    "tip contact against piezo stiffness",
    "stiffness.contact >= stiffness.stack/2",
    ("tip.nose_radius", "tip.nose_radius*(check.limit/check.value)^3", True),
    source=_JOHNSON + "; dF/ddelta = 1.5 F/delta, so that less than two thirds of the deflection is the contact's; "
    "catalogue line of the piezo",
    proposal="a larger nose radius, or more preload (stiffness grows as (F R)^(1/3))",
)
