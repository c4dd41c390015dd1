"""The clamp of the actuator: whether it closes the play, holds, and bears its own bending."""

import math

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, show
from designcalc.friction_stage.physics.clamp import clamp_finger, clamp_gap, grip, screw_preload
from designcalc.friction_stage.physics.tip_dynamics import peak_tip_force
from stagecad.parameters.design import Design

_SOURCE = "notch hinge of the neck, twist of the finger, wedge at its end; within 20 % of three-dimensional elements"


def checks(design: Design) -> list[CheckFunction]:
    """Closing, holding, stress with and without an actuator."""
    return [closing, holding, neck_stress, free_finger]


def _looser(r: DesignInputs) -> float:
    """Play beyond the nominal one by the tolerances of pocket and holder, m."""
    return 2 * r("drawing.tolerance_x_xx")


def closing(r: DesignInputs) -> Check:
    held = grip(r, _looser(r))
    return Check(
        "play closed by the clamp",
        at_least(held.closure, 1.5 * held.gap, "m"),
        source=_SOURCE + "; largest play of the tolerances, half as much again",
        formula="closure x F >= 1.5 c (1 + cos(phi)), F = M/(K d)",
        substituted=f"F = {show(held.screw, 'N')} turns the finger {show(held.closure, 'm')}; the fingers push the "
        f"actuator to the far wall through {show(held.gap, 'm')}",
        proposal="a longer lever of the screw about the neck, a thinner neck, or a closer fit",
        requirement="Section 2.2: access to payload and adjustments",
    )


def holding(r: DesignInputs) -> Check:
    """The tip's forces must not shift the actuator: the height pin is out of the loop once it is clamped."""
    held, peak = grip(r, _looser(r)), peak_tip_force(r)
    acting = peak * math.hypot(1.0, r("drive.friction"))
    return Check(
        "force with which the clamp holds the actuator",
        at_least(held.hold, 1.5 * acting, "N"),
        source=_SOURCE + "; Coulomb friction of both fingers and of the far wall; largest play",
        formula="mu 2 N (1 + cos(phi)) >= 1.5 sqrt(1 + mu_tip^2) F_peak, N = (closure F - gap)/give",
        substituted=f"N = {show(held.press, 'N')} of {show(held.screw, 'N')} of the screw: {show(held.hold, 'N')} "
        f"against {show(acting, 'N')}",
        proposal="a longer lever of the screw about the neck, or more torque",
        requirement="Section 2.2: access to payload and adjustments",
    )


def neck_stress(r: DesignInputs) -> Check:
    held, limit = grip(r, _looser(r)), r.material("base", "strength")
    return Check(
        "stress of the clamp's neck",
        at_most(held.stress, limit / 1.5, "Pa"),
        source=_SOURCE + "; factor 1.5; largest play",
        formula="K_t [6 (m + v x)/t^2 + n/t] <= strength/1.5",
        substituted=f"t = {show(r('base.clamp_neck'), 'm')}, gap {show(held.gap, 'm')}: {show(held.stress, 'Pa')}",
        proposal="a closer fit of the holder, or a longer finger",
    )


def free_finger(r: DesignInputs) -> Check:
    """A screw tightened over an empty pocket bends the neck by its whole force: the assembly must not allow it."""
    finger, limit = clamp_finger(r), r.material("base", "strength")
    stress = finger.stress(1.0)
    torque = limit / stress * r("screws.clamp_long.torque") / screw_preload(r, "clamp_long")
    needed = 1.5 * clamp_gap(r, _looser(r)) / finger.closure * stress
    return Check(
        "yield of the clamp's neck before the play is closed",
        at_most(needed, limit, "Pa"),
        source=_SOURCE + "; the screw's force that closes one and a half times the largest play",
        formula="stress at 1.5 gap/closure <= strength",
        substituted=f"{show(needed, 'Pa')} against {show(limit, 'Pa')}",
        proposal="a thinner neck",
        note=f"over an empty pocket the screw may have {show(torque, 'N*m')}, not its "
        f"{show(r('screws.clamp_long.torque'), 'N*m')}",
    )
