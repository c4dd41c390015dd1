"""Friction that goes by the speed, as curves that a pass over a record looks up at the speed that it has itself.

    most that holds = level(t) factor(side, s) + share(t) extra(side, s),    other force = force(side, s)

for a speed s = |v| and a side, the sign of the motion. A measured motion would blur what happens within a few rows, a
slip or a turn. Values stand at speeds that grow with the square of their number: finely near rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.library.effect import Axis, Effect
from sysid.prediction.effect_terms import Values, values_of

COUNT = 400
"""Speeds of a curve."""
OF_SPEED = ("velocity", "direction")
"""Coordinates of a law that a curve takes in."""


@dataclass(frozen=True)
class Curves:
    """Laws of one contact that go by its speed.

    Args:
        values: factor, extra level (N) and other force (N), each forward and backward, (6, k); (6, 0) for none.
        top: speed of the last value, m/s; beyond it that value holds.
    """

    values: np.ndarray
    top: float


NO_CURVES = Curves(np.empty((6, 0)), 1.0)


def depends_on_velocity_only(effect: Effect) -> bool:
    """Whether a law of friction reads the speed or its sign, and nothing else that changes."""
    has_law = effect.level is not None or effect.factor is not None or effect.force is not None
    read = set(effect.coordinates)
    return has_law and effect.friction_state is None and effect.memory is None and bool(read) and read <= set(OF_SPEED)


def curves_of(effects: Sequence[Effect], values: Values, axis: Axis, top: float) -> Curves:
    """The curves of those `effects` that go by speed (`depends_on_velocity_only`), up to the speed `top`, m/s.

    Args:
        effects: of one contact, all of which go by speed.
        values: of their parameters.
        axis: of the record, for the mean of whatever else a law is handed.
        top: m/s.
    """
    if not effects:
        return NO_CURVES
    speed = top * np.linspace(0.0, 1.0, COUNT) ** 2
    out = np.zeros((6, COUNT))
    for row, side in enumerate((1.0, -1.0)):
        at: Any = Axis(*[np.full(COUNT, float(np.mean(quantity))) for quantity in axis])
        at = at._replace(velocity=side * speed, direction=np.full(COUNT, side))
        factor: Any = 1.0
        for effect in effects:
            p = values_of(effect, values)
            if effect.factor is not None:
                factor = factor * effect.factor(at, p)
            if effect.level is not None:
                out[2 + row] += effect.level(at, p)
            if effect.force is not None:
                out[4 + row] += effect.force(at, p)
        out[row] = factor
        out[2 + row] *= factor
    return Curves(out, top)
