"""Load of the piezo stacks of a friction drive: tension, side load, tilt; inertia and stiffness of the tip on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SideLoad:
    """A stack bent by a force across its end."""

    stress: Array
    """largest bending stress, at the foot or where the bore holds it, Pa"""
    deflection: Array
    """of the free end, m"""
    touches: NDArray[np.bool_]
    """whether the end bends as far as its bore, which then holds it"""


def stack_tension(mass: ArrayLike, frequency: ArrayLike, travel: ArrayLike, stacks: ArrayLike = 2) -> Array:
    """Peak pull on each of the stacks that swing a mass between them: ``m (2 pi f)^2 (Y/2)/n``, N.

    Args:
        mass: m, tip and what moves with it, kg.
        frequency: f of the drive, Hz.
        travel: Y, peak to peak along the stacks, m.
        stacks: n that share it.
    """
    m, f, Y, n = (np.asarray(v, float) for v in (mass, frequency, travel, stacks))
    _require(np.all(m >= 0) and np.all(f >= 0) and np.all(Y >= 0) and np.all(n >= 1), "mass, frequency and travel")
    return m * (2 * np.pi * f) ** 2 * Y / 2 / n


def drive_pull(force: ArrayLike, tip_height: ArrayLike, piezo_spacing: ArrayLike) -> Array:
    """Push and pull on two stacks by a force across the tip's apex: ``F h/D``, N (moments about a stack's end).

    Args:
        force: F along the stage at the apex, N.
        tip_height: h, m.
        piezo_spacing: D, m, > 0.
    """
    F, h, D = (np.asarray(v, float) for v in (force, tip_height, piezo_spacing))
    _require(np.all(D > 0) and np.all(h >= 0), "tip height and piezo spacing")
    return np.abs(F) * h / D


def side_load(
    force: ArrayLike,
    length: ArrayLike,
    free_length: ArrayLike,
    area: ArrayLike,
    modulus: ArrayLike,
    clearance: ArrayLike,
) -> SideLoad:
    """A square ceramic element bent as a cantilever by a force across its end.

    ``deflection = F L^3/(3 E I)``, ``stress = F L c/I`` with ``I = A^2/12``, ``c = sqrt(A)/2``. While the deflection
    is less than the bore's clearance, the whole length bends; beyond, the bore holds the stack and the length that
    projects from it bends.

    Args:
        force: F on one stack, N.
        length: L of the stack from its foot, m.
        free_length: proud of its bore, m, at most L.
        area: A of the element, m^2.
        modulus: E, Pa.
        clearance: of the stack in its bore, on the radius, m.

    Returns:
        `SideLoad` of the broadcast shape. The case's own stiffness is left out: the true stress is smaller.

    Raises:
        InputError: an argument not above zero, or a free length beyond the whole.
    """
    F, L, free, A, E, play = (np.asarray(v, float) for v in (force, length, free_length, area, modulus, clearance))
    _require(all(np.all(v > 0) for v in (L, free, A, E)) and np.all(play >= 0), "lengths, area and modulus")
    _require(np.all(free <= L), "the free length: at most the whole length, and both")
    inertia, edge = A**2 / 12, np.sqrt(A) / 2
    deflection = np.abs(F) * L**3 / (3 * E * inertia)
    touches = deflection > play
    stress = np.abs(F) * np.where(touches, free, L) * edge / inertia
    return SideLoad(stress, deflection, touches)


def tilt_stress(angle: ArrayLike, length: ArrayLike, area: ArrayLike, modulus: ArrayLike) -> Array:
    """Bending stress of a stack with flat, bonded ends whose end is tilted and held sideways: ``4 E c theta/L``, Pa.

    A rounded end rolls instead, and has almost none of this stress.

    Args:
        angle: theta, rad.
        length: L, m.
        area: A of a square element, m^2; ``c = sqrt(A)/2``.
        modulus: E, Pa.
    """
    theta, L, A, E = (np.asarray(v, float) for v in (angle, length, area, modulus))
    _require(all(np.all(v > 0) for v in (L, A, E)), "length, area and modulus")
    return 4 * E * (np.sqrt(A) / 2) * np.abs(theta) / L


def rocking_stiffness(stack_stiffness: ArrayLike, piezo_spacing: ArrayLike) -> Array:
    """Of the tip about the axis across the travel, on two stacks D apart: ``k D^2/2``, N m/rad."""
    k, D = np.asarray(stack_stiffness, float), np.asarray(piezo_spacing, float)
    _require(np.all(k > 0) and np.all(D > 0), "stiffness and spacing")
    return k * D**2 / 2


def tip_inertia(mass: ArrayLike, circle: ArrayLike, tip_height: ArrayLike) -> Array:
    """Moment of inertia of the tip about an axis in the piezos' plane, kg m^2, as a disc and a column.

    ``m (R^2/4 + h^2/12)``: a spider out to the piezos' circle has about the R^2/4 of a thin disc, its cone most of its
    mass near the foot. Holds to a fifth for such tips (the packaged one, measured on its solid: to 3 %), so that a
    resonance holds to a tenth.

    Args:
        mass: m, kg.
        circle: radius R through the piezos, m.
        tip_height: h, m.
    """
    m, R, h = (np.asarray(v, float) for v in (mass, circle, tip_height))
    _require(np.all(m > 0) and np.all(R > 0) and np.all(h > 0), "mass and lengths")
    return m * (R**2 / 4 + h**2 / 12)


def _require(condition: object, what: str) -> None:
    if not condition:
        raise InputError(f"piezo stack: {what} must be above 0")
