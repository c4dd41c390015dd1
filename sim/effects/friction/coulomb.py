"""Coulomb friction: the base of the friction level, and the plain core that turns a level into a force."""

import math

from sim.effects.effect import Effect, Parameter
from sim.effects.friction_state.coulomb import core
from sim.effects.friction_state.lugre import level

EFFECT = Effect(
    name="coulomb",
    meaning="dry friction: a constant force against the direction of motion, held at rest",
    equation="level = force;  friction = level * sign(v), at rest its last value",
    shows="Force steps from minus to plus at each reversal, by twice its size.",
    dissipation="Passive at any speed and level: the bristle's stiffness is constant.",
    source="Coulomb 1785; Armstrong-Helouvry, Dupont, Canudas de Wit 1994, Automatica 30(7), eq. 1",
    parameters=(
        Parameter("force", "N", 1.0, 0.0, math.inf, "friction force in slow sliding", "thesis Table 3", "level"),
        Parameter(
            "stretch",
            "m",
            1e-8,
            1e-12,
            1e-3,
            "stretch of the bristle at the level: below what the record resolves",
            "chosen: 1e-3 of the thesis's bristle deflection; for a record, a few times its position noise",
            "reference",
            fixed=True,
            reported=False,
        ),
    ),
    coordinates=("direction",),
    level=level,
    friction_state=core,
    acts_on="friction",
)
