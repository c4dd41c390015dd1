"""The axis of a driven stage as it was predicted to move, for what a measured motion blurs.

A measured motion comes to rest some rows late, and creeps by its noise. A strength that grows at rest and fades over a
tenth of a micrometre is read off the predicted motion once there is one, and the motion is predicted again. What goes
by a remembered speed is not: there each prediction drives the next one away.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sim.library.effect import Axis, Effect
from sysid.prediction.force_balance.record import rest_age


def ages_at_rest(effects: Sequence[Effect]) -> bool:
    """Whether some level goes by the time at rest."""
    return any(e.level is not None and "contact_age" in e.coordinates for e in effects)


def as_it_moved(axis: Axis, moved: np.ndarray, step: float) -> Axis:
    """The axis at rest where the stage `moved` nowhere from row to row, with its speeds and ways.

    Args:
        axis: as measured; its load and temperature stay.
        moved: position of the stage, m from its rest at the first row, (n,).
        step: of the record, s.
    """
    gone: Any = np.concatenate([[0.0], np.diff(moved)])
    velocity = np.gradient(moved, step)
    return axis._replace(
        position=moved + axis.position[0], velocity=velocity, acceleration=np.gradient(velocity, step),
        contact_age=rest_age(axis.time, gone == 0.0), travelled=np.cumsum(np.abs(gone)),
    )  # fmt: skip
