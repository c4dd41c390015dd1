"""Lost motion between the drive and the load."""

from typing import Any

import numpy as np

from sim.effects.effect import Axis, Backlash, Effect, Parameter, Scan
from sim.numerics.record_operators import play


def _memory(axis: Axis, p: Any) -> Axis:
    position = play(np.ascontiguousarray(axis.position), 0.5 * p.gap)
    velocity = np.where(np.diff(position, prepend=position[0]) != 0.0, axis.velocity, 0.0)
    return axis._replace(position=position, velocity=velocity)


EFFECT = Effect(
    name="backlash",
    meaning="lost motion between the drive and the load",
    equation="the load rests, without force, while the drive crosses the gap: after a reversal and the unloading of "
    "its elastic contacts; spring force 0 within +-gap/2",
    shows="after each reversal the force is missing until the gap is crossed; stretch without spring force. The "
    "position is that of the drive, before the gap, on a velocity-drive, and that of the load, behind it, on a "
    "spring-pull, where the spring force must be recorded too. On a force-drive force and position are of one body: a "
    "gap has no influence there",
    source="Nordin and Gutman, Automatica 38 (2002) 1633",
    acts_on="structure",
    coordinates=("distance_since_reversal", "position"),
    parameters=(
        Parameter("gap", "m", 1e-5, 0.0, 1.0, "full width of the lost motion", "a gap is not negative").shape(
            Scan("position", 1e-4, 0.2, 10)
        ),
    ),
    memory=_memory,
    time_domain=lambda p: Backlash(p.gap),
)
