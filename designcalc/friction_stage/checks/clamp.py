"""The clamp of the actuator: whether it closes the play, holds, and bears its own bending."""

from designcalc.checks.check import CheckFunction
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_SOURCE = "notch hinge of the neck, twist of the finger, wedge at its end; within 20 % of three-dimensional elements"
_ACCESS = "Section 2.2: access to payload and adjustments"


def checks(design: Design) -> list[CheckFunction]:
    """Closing, holding, stress with and without an actuator."""
    return [closing, holding, neck_stress, free_finger]


closing = stated(
    "play closed by the clamp",
    "closure.of_finger*force.of_clamp_screw >= 1.5*gap.of_clamp",
    source=_SOURCE + "; the fingers push the actuator to the far wall through the largest play of the tolerances, half "
    "as much again",
    proposal="a longer lever of the screw about the neck, a thinner neck, or a closer fit",
    requirement=_ACCESS,
)


# The tip's forces must not shift the actuator: the height pin is out of the loop once it is clamped.
holding = stated(
    "force with which the clamp holds the actuator",
    "base.clamp_friction*2*force.of_finger*(1 + cos(angle.of_finger))"
    " >= 1.5*sqrt(1 + drive.friction^2)*load.peak_of_tip",
    source=_SOURCE + "; Coulomb friction of both fingers and of the far wall; largest play",
    proposal="a longer lever of the screw about the neck, or more torque",
    requirement=_ACCESS,
    note="{force.of_finger} of the {force.of_clamp_screw} of the screw press",
)


neck_stress = stated(
    "stress of the clamp's neck",
    "stress.of_neck <= base.material.strength/1.5",
    source=_SOURCE + "; concentration, bending by screw and actuator, and tension; factor 1.5; largest play",
    proposal="a closer fit of the holder, or a longer finger",
)


# A screw tightened over an empty pocket bends the neck by its whole force: the assembly must not allow it.
free_finger = stated(
    "yield of the clamp's neck before the play is closed",
    "1.5*gap.of_clamp/closure.of_finger*stress.of_free_neck <= base.material.strength",
    source=_SOURCE + "; the screw's force that closes one and a half times the largest play",
    proposal="a thinner neck",
    note="over an empty pocket the screw may have {base.material.strength/stress.of_free_neck*screws.clamp_long.torque"
    "/force.of_clamp_screw}, not its {screws.clamp_long.torque}",
)
