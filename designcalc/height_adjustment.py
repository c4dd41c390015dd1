"""A set screw that pushes a wedge that lifts the actuator."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stagecad.parameters.errors import InputError


@dataclass(frozen=True)
class WedgeDrive:
    """What the set screw and wedge make of a turn; SI units."""

    lift_per_turn: float
    """m"""
    lift_per_degree: float
    """m per degree of the key"""
    range: float
    """m"""
    locking_friction: float
    """coefficient of friction above which the wedge does not slide back by itself"""


def wedge_drive(thread_pitch: float, slope: float, stroke: float, faces: int = 2) -> WedgeDrive:
    """Lift of a wedge of slope ``s`` pushed by a screw of pitch ``P``: ``P s`` a turn, ``stroke s`` in all.

    The wedge holds itself when the friction angles of its sliding faces together exceed its slope:
    ``mu >= tan(atan(s)/faces)``.

    Args:
        thread_pitch: P, m.
        slope: rise over run, 0 to 1.
        stroke: of the wedge, m.
        faces: sliding faces that hold it (two: above and below).
    """
    if not (thread_pitch > 0 and stroke > 0 and 0 < slope < 1 and faces >= 1):
        raise InputError("height adjustment: pitch and stroke must be above 0, the slope 0 to 1")
    turn = thread_pitch * slope
    return WedgeDrive(turn, turn / 360, stroke * slope, math.tan(math.atan(slope) / faces))


def screw_force(lift: float, slope: float, friction: float) -> float:
    """Axial force on the wedge to raise a load, N: ``lift [tan(lambda + phi) + tan(phi)]``, phi = atan(mu).

    Args:
        lift: vertical load, N.
        slope: rise over run.
        friction: mu of both faces.
    """
    angle, rub = math.atan(slope), math.atan(friction)
    return lift * (math.tan(angle + rub) + math.tan(rub))
