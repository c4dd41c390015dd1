"""Piezo stacks of a friction drive: stiffness, tension, side load, tilt, heat, current; inertia of the tip on them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import InputError, require

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SideLoad:
    """A stack bent by a force across its end."""

    # largest bending stress while the force rises to its value, at the foot or at the mouth of the bore, Pa
    stress: Array
    deflection: Array  # of the free end, m
    touch_force: Array  # at which the stack touches the mouth of its bore, N
    touches: NDArray[np.bool_]  # whether it touches, so that the mouth props it


def stack_tension(
    mass: ArrayLike, inertia: ArrayLike, frequency: ArrayLike, rise: ArrayLike, tilt: ArrayLike, spacing: ArrayLike
) -> Array:
    """Peak pull on each of the two driven stacks by the inertia of the tip on them, N.

    ``sqrt[(m w^2 Y/4)^2 + (J w^2 theta/D)^2]``: the two stacks share the force of the rise, and take the moment of the
    rocking as a pair of forces D apart. Rise and rocking, mean and difference of two sines of one amplitude, are a
    quarter of a period apart, so the two forces add by squares.

    Args:
        mass: m, tip and what moves with it, kg.
        inertia: J of the same about an axis in the plane of the stacks' ends, kg m^2.
        frequency: w/(2 pi) of the drive, Hz.
        rise: Y, peak to peak along the stacks, m.
        tilt: theta, amplitude of the rocking, rad.
        spacing: D of the driven stacks, m.
    """
    m, J, f, Y, theta, D = (np.asarray(v, float) for v in (mass, inertia, frequency, rise, tilt, spacing))
    if not (all(np.all(v >= 0) for v in (m, J, f, Y, theta)) and np.all(D > 0)):
        raise InputError("piezo stack: mass, inertia, frequency and motion must be above 0")
    square = (2 * np.pi * f) ** 2
    return np.hypot(m * square * Y / 4, J * square * theta / D)


def drive_pull(force: ArrayLike, tip_height: ArrayLike, piezo_spacing: ArrayLike) -> Array:
    """Push and pull on two stacks by a force across the tip's apex: ``F h/D``, N (moments about a stack's end).

    Args:
        force: F along the stage at the apex, N.
        tip_height: h, m.
        piezo_spacing: D, m, > 0.
    """
    F, h, D = (np.asarray(v, float) for v in (force, tip_height, piezo_spacing))
    require(np.all(D > 0) and np.all(h >= 0), "piezo stack: tip height and piezo spacing must be above 0")
    return np.abs(F) * h / D


def side_load(
    force: ArrayLike,
    length: ArrayLike,
    free_length: ArrayLike,
    area: ArrayLike,
    modulus: ArrayLike,
    clearance: ArrayLike,
) -> SideLoad:
    """A square ceramic element bent by a force across its end, in a bore with clearance.

    Up to the force that closes the clearance g at the mouth of the bore, at ``b = L - free`` from the foot, a
    cantilever, ``F b^2 (3 L - b)/(6 E I) = g``; beyond, a cantilever propped at the mouth by ``R = 3 [F b^2 (3 L - b)/6
    - E I g]/b^3``. Its moments are ``F L - R b`` at the foot and ``F (L - b)`` at the mouth. The foot is bent most when
    the stack touches, so the largest stress while the force rises never falls with the force.

    Args:
        force: F on one stack, N.
        length: L of the stack from its foot, m.
        free_length: proud of its bore, m, at most L.
        area: A of the element, m^2; ``I = A^2/12``, and the edge is ``sqrt(A)/2`` off the axis.
        modulus: E, Pa.
        clearance: g of the stack in its bore, on the radius, m.

    Returns:
        `SideLoad` of the broadcast shape. The case's own stiffness is left out: the true stress is smaller.

    Raises:
        InputError: an argument not above zero, or a free length beyond the whole.

    Source: superposition of cantilevers (Roark's Formulas for Stress and Strain, table 8.1, case 1a).
    """
    arrays = (np.asarray(v, float) for v in (force, length, free_length, area, modulus, clearance))
    F, L, free, A, E, play = np.broadcast_arrays(*arrays)
    if not (all(np.all(v > 0) for v in (L, free, A, E)) and np.all(play >= 0)):
        raise InputError("piezo stack: lengths, area and modulus must be above 0")
    require(np.all(free <= L), "piezo stack: the free length: at most the whole length, and both must be above 0")
    F, EI, b = np.abs(F), E * A**2 / 12, L - free
    # Without a bore (b = 0) nothing props the stack.
    inside = b > 0
    b = np.where(inside, b, 1.0)
    touch = np.where(inside, 6 * EI * play / (b**2 * (3 * L - b)), np.inf)
    touches = touch < F
    prop = np.where(touches, (F - np.where(touches, touch, 0.0)) * (3 * L - b) / (2 * b), 0.0)
    foot = np.maximum(np.minimum(F, touch) * L, np.abs(F * L - prop * b))
    moment = np.maximum(foot, F * free)
    deflection = F * L**3 / (3 * EI) - prop * b**2 * (3 * L - b) / (6 * EI)
    return SideLoad(moment * np.sqrt(A) / 2 / (A**2 / 12), deflection, touch, touches)


def rocking_stiffness(stack_stiffness: ArrayLike, piezo_spacing: ArrayLike) -> Array:
    """Stiffness of the tip about the axis across the travel, on two stacks D apart: ``k D^2/2``, N m/rad."""
    k, D = np.asarray(stack_stiffness, float), np.asarray(piezo_spacing, float)
    require(np.all(k > 0) and np.all(D > 0), "piezo stack: stiffness and spacing must be above 0")
    return k * D**2 / 2


def sway_stiffness(length: ArrayLike, area: ArrayLike, modulus: ArrayLike) -> Array:
    """Stiffness across the end of a square element clamped at its foot, within its bore's play: ``3 E I/L^3``, N/m.

    Args:
        length: L, m.
        area: A, m^2; ``I = A^2/12``.
        modulus: E, Pa.
    """
    L, A, E = (np.asarray(v, float) for v in (length, area, modulus))
    require(all(np.all(v > 0) for v in (L, A, E)), "piezo stack: length, area and modulus must be above 0")
    return 3 * E * A**2 / 12 / L**3


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
    require(np.all(m > 0) and np.all(R > 0) and np.all(h > 0), "piezo stack: mass and lengths must be above 0")
    return m * (R**2 / 4 + h**2 / 12)


def piezo_stiffness(blocking_force: ArrayLike, free_stroke: ArrayLike) -> Array:
    """Stiffness of a stack from the ends of its catalogue line, blocking force (N) over free stroke (m), N/m."""
    force, stroke = np.asarray(blocking_force, float), np.asarray(free_stroke, float)
    require(np.all(force > 0) and np.all(stroke > 0), "piezo stack: blocking force and free stroke must be above 0")
    return force / stroke


def stack_heat(capacitance: ArrayLike, voltage: ArrayLike, frequency: ArrayLike, loss_factor: ArrayLike) -> Array:
    """Heat of one piezo stack driven by a sine: ``P = pi f C (V/2)^2 tan(delta)``, W.

    Args:
        capacitance: C, F.
        voltage: V, peak to peak, V.
        frequency: f, Hz.
        loss_factor: tan(delta) at large signal, 0 to 1.
    """
    C, V, f, loss = (np.asarray(v, float) for v in (capacitance, voltage, frequency, loss_factor))
    if not (np.all(C > 0) and np.all(f >= 0) and np.all((loss >= 0) & (loss <= 1))):
        raise InputError("piezo stack: capacitance must be above 0, frequency 0 or more, the loss factor 0 to 1")
    return np.pi * f * C * (V / 2) ** 2 * loss


def stack_current(capacitance: ArrayLike, voltage: ArrayLike, frequency: ArrayLike) -> Array:
    """Peak current of a stack driven by a sine: ``2 pi f C V/2``, A; V peak to peak."""
    f, C, V = (np.asarray(v, float) for v in (frequency, capacitance, voltage))
    require(np.all(C > 0) and np.all(f >= 0), "piezo stack: capacitance must be above 0, frequency 0 or more")
    return np.pi * f * C * V
