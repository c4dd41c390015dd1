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


@dataclass(frozen=True)
class ClampShift:
    """What closing the clamp does to the tip; SI units."""

    squeeze: float
    """growth of the holder's height as the clamp squeezes it, m"""
    drop: float
    """of the apex as the holder tilts within its pocket's play, m"""
    sideways: float
    """of the apex by the same tilt and by the play itself, m"""


def clamp_shift(
    screw_force: float,
    wrap: float,
    holder_diameter: float,
    holder_height: float,
    play: float,
    apex_height: float,
    modulus: float,
    poisson: float,
) -> ClampShift:
    """A finger drawn round a cylindrical holder like a band, and the pocket's wall that takes the reaction.

    Normal forces on the rim add up to ``S = T (theta + 2 sin(theta/2))``, band and reaction; by the theorem of mean
    stress the two stresses in the plane then have the mean sum ``-S R/(pi R^2 H)``, and the height grows on the mean by
    ``nu S/(pi R E)``, whatever its height. The holder tilts within its play by at most ``play/H``.

    Args:
        screw_force: T, preload of the clamp screw, N, >= 0; the neck takes part of it, so this bounds the squeeze.
        wrap: theta, angle over which the finger lies on the holder, rad, 0 to pi.
        holder_diameter: 2 R, m.
        holder_height: H, m.
        play: pocket diameter less holder diameter, m, >= 0.
        apex_height: of the tip over the holder's foot, m.
        modulus, poisson: of the holder, Pa and -.

    Raises:
        InputError: outside the range.

    Source: theorem of mean stress: Love, Mathematical Theory of Elasticity (1927), section 123.
    """
    if not (min(holder_diameter, holder_height, apex_height, modulus) > 0 and play >= 0 and screw_force >= 0):
        raise InputError("height adjustment: diameter, heights and modulus must be above 0, play and force 0 or more")
    if not (0 <= wrap <= math.pi and 0 <= poisson <= 0.5):
        raise InputError("height adjustment: the wrap must lie in 0 to 180 deg, Poisson's ratio in 0 to 0.5")
    rim = screw_force * (wrap + 2 * math.sin(wrap / 2))
    tilt = play / holder_height
    return ClampShift(
        squeeze=poisson * rim / (math.pi * holder_diameter / 2 * modulus),
        drop=2 * apex_height * math.sin(tilt / 2) ** 2,
        sideways=apex_height * math.sin(tilt) + play / 2,
    )


def screw_force(lift: float, slope: float, friction: float) -> float:
    """Axial force on the wedge to raise a load, N: ``lift [tan(lambda + phi) + tan(phi)]``, phi = atan(mu).

    Args:
        lift: vertical load, N.
        slope: rise over run.
        friction: mu of both faces.
    """
    angle, rub = math.atan(slope), math.atan(friction)
    return lift * (math.tan(angle + rub) + math.tan(rub))
