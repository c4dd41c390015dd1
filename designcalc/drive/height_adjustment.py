"""A set screw that pushes a wedge that lifts the actuator."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import InputError, require

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WedgeDrive:
    """Lift and forces of set screw and wedge per turn; SI units."""

    lift_per_turn: Array  # m
    lift_per_degree: Array  # m per degree of the key
    range: Array  # m
    locking_friction: Array  # coefficient of friction above which the wedge does not slide back by itself


def wedge_drive(thread_pitch: ArrayLike, slope: ArrayLike, stroke: ArrayLike, faces: int = 2) -> WedgeDrive:
    """Lift of a wedge of slope ``s`` pushed by a screw of pitch ``P``: ``P s`` a turn, ``stroke s`` in all.

    The wedge holds itself when the friction angles of its sliding faces together exceed its slope:
    ``mu >= tan(atan(s)/faces)``.

    Args:
        thread_pitch: P, m.
        slope: rise over run, 0 to 1.
        stroke: of the wedge, m.
        faces: sliding faces that hold it (two: above and below).
    """
    P, s, reach = (np.asarray(v, float) for v in (thread_pitch, slope, stroke))
    if not (np.all(P > 0) and np.all(reach > 0) and np.all((s > 0) & (s < 1)) and faces >= 1):
        raise InputError("height adjustment: pitch and stroke must be above 0, the slope 0 to 1")
    turn = P * s
    return WedgeDrive(turn, turn / 360, reach * s, np.tan(np.arctan(s) / faces))


@dataclass(frozen=True)
class ClampShift:
    """Effects of closing the clamp on the tip; SI units."""

    squeeze: Array  # growth of the holder's height as the clamp squeezes it, m
    drop: Array  # of the apex as the holder tilts within its pocket's play, m
    sideways: Array  # of the apex by the same tilt and by the play itself, m


def clamp_shift(
    rim_force: ArrayLike,
    holder_diameter: ArrayLike,
    holder_height: ArrayLike,
    play: ArrayLike,
    apex_height: ArrayLike,
    modulus: ArrayLike,
    poisson: ArrayLike,
) -> ClampShift:
    """A cylindrical holder pressed at its rim by the fingers of a clamp and by the pocket's wall.

    With normal forces on the rim that add up to S, the theorem of mean stress gives the two stresses in the plane the
    mean sum ``-S R/(pi R^2 H)``, and the height grows on the mean by ``nu S/(pi R E)``, whatever it is. The holder
    tilts within its play by at most ``play/H``.

    Args:
        rim_force: S, N, >= 0.
        holder_diameter: 2 R, m.
        holder_height: H, m.
        play: pocket diameter less holder diameter, m, >= 0.
        apex_height: of the tip over the holder's foot, m.
        modulus, poisson: of the holder, Pa and -.

    Raises:
        InputError: outside the range.

    Source: theorem of mean stress: Love, Mathematical Theory of Elasticity (1927), section 123.
    """
    rim, D, H = (np.asarray(v, float) for v in (rim_force, holder_diameter, holder_height))
    slack, h, E, nu = (np.asarray(v, float) for v in (play, apex_height, modulus, poisson))
    if not (all(np.all(v > 0) for v in (D, H, h, E)) and np.all(slack >= 0) and np.all(rim >= 0)):
        raise InputError("height adjustment: diameter, heights and modulus must be above 0, play and force 0 or more")
    require(np.all((nu >= 0) & (nu <= 0.5)), "height adjustment: Poisson's ratio must lie in 0 to 0.5")
    tilt = slack / H
    return ClampShift(
        squeeze=nu * rim / (np.pi * D / 2 * E),
        drop=2 * h * np.sin(tilt / 2) ** 2,
        sideways=h * np.sin(tilt) + slack / 2,
    )


def screw_force(lift: ArrayLike, slope: ArrayLike, friction: ArrayLike) -> Array:
    """Axial force on the wedge to raise a load, N: ``lift [tan(lambda + phi) + tan(phi)]``, phi = atan(mu).

    Args:
        lift: vertical load, N.
        slope: rise over run.
        friction: mu of both faces.
    """
    load, s, mu = (np.asarray(v, float) for v in (lift, slope, friction))
    if not (np.all(load >= 0) and np.all((s > 0) & (s < 1)) and np.all(mu >= 0)):
        raise InputError("height adjustment: load and friction must be 0 or more, the slope 0 to 1")
    angle, rub = np.arctan(s), np.arctan(mu)
    return load * (np.tan(angle + rub) + np.tan(rub))
