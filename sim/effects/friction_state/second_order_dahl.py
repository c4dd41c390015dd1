"""The second-order Dahl model: the difference of two Dahl models of different lengths, so that the force overshoots its
level along the path after each reversal (Bliman and Sorine).

    z_k' = v - a_k |v| z_k/g,    a_1 = a0/ratio, a_2 = a0,    friction = (1 + overshoot) a_1 z_1 - overshoot a_2 z_2

The overshoot is a break-away force that depends on the path alone: in steady sliding the force is the level.
"""

from typing import Any

import numpy as np

from sim.effects.effect import Effect, Parameter
from sim.effects.friction_state.lugre import FORCE, RELEASE, STIFFNESS, level, spring_force
from sim.effects.friction_state_model import FrictionStateModel, Slopes


def law(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, float]:
    if g <= 0.0:
        return -z / RELEASE, 0.0
    stiff = p.stiffness / p.ratio if k == 0 else p.stiffness
    share = 1.0 + p.overshoot if k == 0 else -p.overshoot
    return v - stiff * direction * v * z / g, share * stiff * z


def slopes(k: int, z: float, v: float, direction: float, g: float, p: Any) -> Slopes:
    if g <= 0.0:
        return -1.0 / RELEASE, 0.0, 0.0, 0.0, 0.0, 0.0
    stiff = p.stiffness / p.ratio if k == 0 else p.stiffness
    share = 1.0 + p.overshoot if k == 0 else -p.overshoot
    steep = stiff * direction / g
    return -steep * v, 1.0 - steep * z, steep * v * z / g, share * stiff, 0.0, 0.0


def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    fast, slow = (spring_force(position, time, level, stiff) for stiff in (p.stiffness / p.ratio, p.stiffness))
    return (1.0 + p.overshoot) * fast - p.overshoot * slow


def stored(k: int, z: Any, g: Any, p: Any) -> Any:
    share, stiff = (1.0 + p.overshoot, p.stiffness / p.ratio) if k == 0 else (-p.overshoot, p.stiffness)
    return 0.5 * share * stiff * z * z


EFFECT = Effect(
    name="second_order_dahl",
    meaning="bristles whose force overshoots the level along the path after each reversal, without rate effects",
    equation="z_k' = v - a_k |v| z_k/g,  a_1 = stiffness/ratio,  a_2 = stiffness;\n"
    "friction = (1 + overshoot) a_1 z_1 - overshoot a_2 z_2",
    shows="A peak of the force over the first micrometres after a reversal, alike at every speed, unlike `stribeck`.",
    dissipation="Not passive just after a reversal, where the slow part returns energy; takes energy over a cycle.",
    source="Bliman, Sorine, Proc. 3rd European Control Conference (1995) 3028; thesis 3.2.2",
    parameters=(
        FORCE,
        STIFFNESS,
        Parameter("ratio", "1", 0.3, 1e-3, 1.0, "length of the fast part over that of the slow one", "below one").shape(
            natural="high"
        ),
        Parameter("overshoot", "1", 0.5, 0.0, 100.0, "level of the slow part over that of the whole", "not negative"),
    ),
    coordinates=("distance_since_reversal", "direction"),
    level=level,
    friction_state=FrictionStateModel(
        "second_order_dahl",
        law,
        slopes,
        along,
        lambda p: max(p.force, 1e-9) / p.stiffness * p.ratio,
        elements=lambda p: 2,
        stored=stored,
    ),
    acts_on="friction",
)
