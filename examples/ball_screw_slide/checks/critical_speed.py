"""critical_speed: whirling of the screw at the speed of the carriage."""

import math

from designcalc.checks.check import Check, at_most

SUBJECT = "ball screw"
LEAD = 5e-3  # m


def check(r):
    """First bending resonance of the shaft between a fixed and a free end, four fifths of it as the limit."""
    length, diameter = r("screw.length"), r("screw.journal")
    modulus, density = r("materials.steel.youngs_modulus"), r("materials.steel.density")
    resonance = 3.516 / (2 * math.pi * length**2) * diameter / 4 * math.sqrt(modulus / density)
    turns = r("requirements.speed") / LEAD
    return Check(
        "critical speed of the screw",
        at_most(turns, 0.8 * resonance, "Hz"),
        source="cantilever, Blevins, Formulas for Natural Frequency, table 8-1",
        formula="v/lead <= 0.8 (3.516/(2 pi L^2)) (d/4) sqrt(E/rho)",
        substituted=f"{turns:.3g} turns a second against {resonance:.3g} Hz; carriage {r('carriage.mass'):.3g} kg",
        proposal="a longer lead, or a shorter or thicker screw",
    )
