"""Parallel elasto-plastic elements: springs side by side that yield one after another.

    F = g sum_k w_k z_k/s_k,    z_k' = x' while |z_k| < s_k, and 0 while the element slips

Element k yields at the stretch s_k and carries the part w_k of the friction limit g. The virgin curve is a broken line
with a knot at each s_k; after a reversal the same curve follows at twice its size (Masing's rule). Such elements are
called Iwan elements, generalised Maxwell-slip, or Prandtl-Ishlinskii stops.

Source: Iwan, J. Appl. Mech. 33 (1966) 893; Al-Bender, Lampaert, Swevers, IEEE Trans. Automatic Control 50 (2005) 1883.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sim.numerics.compilation import SUMS_IN_ANY_ORDER, compiled, inlined


class Elements(NamedTuple):
    """Stretches at which the elements yield, m, and the parts of the friction limit that they carry, each (b,)."""

    stretches: np.ndarray
    weights: np.ndarray


class Springs(NamedTuple):
    """State of elements in a simulation: force, stiffness and largest force of each, (b,); the force is written in
    place."""

    force: np.ndarray
    stiffness: np.ndarray
    limit: np.ndarray


def elements_along(stretches: np.ndarray, curve: np.ndarray) -> Elements:
    """Elements whose virgin curve meets a concave `curve` (b,), force over limit, at the stretches (b,), m.

    w_k = (m_k - m_(k+1)) s_k,    m_k: slope of the curve up to s_k
    """
    slope = np.diff(curve, prepend=0.0) / np.diff(stretches, prepend=0.0)
    return Elements(stretches, np.maximum((slope - np.append(slope[1:], 0.0)) * stretches, 0.0))


def springs_of(elements: Elements) -> Springs:
    """Unloaded springs of the elements, at a friction limit of one."""
    weights = np.ascontiguousarray(elements.weights, dtype=float)
    return Springs(np.zeros(weights.size), weights / elements.stretches, weights)


@compiled(fastmath=SUMS_IN_ANY_ORDER, forceinline=True, _nrt=False)
def displace(springs: Springs, displacement: float) -> float:
    """Move all elements; returns the sum of their forces."""
    total = 0.0
    for k in range(springs.force.size):
        force = springs.force[k] + springs.stiffness[k] * displacement
        force = min(max(force, -springs.limit[k]), springs.limit[k])
        springs.force[k] = force
        total += force
    return total


@inlined
def mean_force(springs: Springs, loss: float, displacement: float) -> tuple[float, float]:
    """Sum of the forces at half of a displacement, N, with a dashpot to each spring, and its tangent, N/m.

    Args:
        springs: state before the displacement.
        loss: dashpot over the duration of the displacement, N/m, of each spring; the limit includes its force.
        displacement: m.
    """
    total, tangent = 0.0, 0.0
    for k in range(springs.force.size):
        rate = 0.5 * springs.stiffness[k] + loss
        force = springs.force[k] + rate * displacement
        if force > springs.limit[k]:
            total += springs.limit[k]
        elif force < -springs.limit[k]:
            total -= springs.limit[k]
        else:
            total += force
            tangent += rate
    return total, tangent


@inlined
def slips_alike(springs: Springs, loss: float, one: float, other: float) -> bool:
    """Whether the same elements slip, in the same direction, at the middle of two displacements, m."""
    alike = True
    for k in range(springs.force.size):
        rate, most = 0.5 * springs.stiffness[k] + loss, springs.limit[k]
        before, after = springs.force[k] + rate * one, springs.force[k] + rate * other
        alike &= (before > most) == (after > most) and (before < -most) == (after < -most)
    return alike


@compiled(fastmath=SUMS_IN_ANY_ORDER, forceinline=True, _nrt=False)
def displace_to(springs: Springs, total: float, wanted: float) -> tuple[float, float]:
    """Move all elements until the sum of their forces, now `total`, is `wanted`, or all slip.

    The sum is piecewise linear in the displacement and is inverted exactly, from yield point to yield point.

    Returns:
        Displacement, m, and the sum of the forces.
    """
    side = 1.0 if wanted > total else -1.0
    moved = 0.0
    for _ in range(springs.force.size + 1):
        tangent, reach = 0.0, np.inf
        for k in range(springs.force.size):
            room = springs.limit[k] - side * springs.force[k]
            if room > 0.0:
                tangent += springs.stiffness[k]
                reach = min(reach, room / springs.stiffness[k])
        left = (wanted - total) * side
        if tangent <= 0.0 or left <= 0.0:
            break
        step = min(left / tangent, reach)
        for k in range(springs.force.size):
            force = side * springs.force[k] + springs.stiffness[k] * step
            # The element that yields now is set to its limit exactly.
            slips = step == reach and springs.limit[k] - force < 1e-9 * springs.limit[k]
            springs.force[k] = side * (springs.limit[k] if slips else min(force, springs.limit[k]))
        total += side * step * tangent
        moved += side * step
        if step == left / tangent:
            break
    return moved, total


@compiled
def _force_along(displacements: np.ndarray, level: np.ndarray, springs: Springs) -> np.ndarray:
    force = np.empty(level.size)
    # A record that begins in motion begins in slip: the first interval is taken to have preceded it.
    displace(springs, np.sign(displacements[0]) * 1e300)
    force[0] = max(level[0], 0.0) * np.sum(springs.force)
    for i in range(1, level.size):
        force[i] = max(level[i], 0.0) * displace(springs, displacements[i - 1])
    return force


def force_along(position: np.ndarray, level: np.ndarray, elements: Elements) -> np.ndarray:
    """Force (n,) of elements along a record of positions (n,), m, at a friction level (n,), N."""
    displacements = np.diff(np.ascontiguousarray(position, dtype=float))
    return _force_along(displacements, np.ascontiguousarray(level, dtype=float), springs_of(elements))


@compiled
def _sticking_fraction(position: np.ndarray, stretch: float) -> np.ndarray:
    out = np.ones(position.size)
    z = 0.0
    for i in range(1, position.size):
        way = (position[i] - position[i - 1]) / stretch
        after = min(1.0, max(-1.0, z + way))
        if way != 0.0:
            out[i] = (after - z) / way
        else:
            out[i] = 1.0 if abs(z) < 1.0 else 0.0
        z = after
    out[:-1] = 0.5 * (out[:-1] + out[1:])
    return out


def sticking_fraction(position: np.ndarray, elements: Elements) -> np.ndarray:
    """Weighted part, 0 to 1, of the steps at a row in which the elements stick: mean of the steps before and after each
    row, (n,)."""
    position = np.ascontiguousarray(position, dtype=float)
    parts = zip(elements.stretches, elements.weights)
    return sum((weight * _sticking_fraction(position, stretch) for stretch, weight in parts), np.zeros(position.size))


YIELD_POWER = 40.0
"""n of an element that yields smoothly: where an ideal one yields, its force is 2 % lower; with n = 8 it is 11 % lower,
which shows in a force balance, and an integration is a fifth faster."""

ElementTerms = tuple[float, float, float, float, float, float, float, float]


def smooth_element(
    z: float, v: float, direction: float, limit: float, stretch: float, weight: float, damping: float
) -> ElementTerms:
    """An element that yields smoothly, for implicit integration: its rate falls with a high power of the stretch.

        z' = v (1 - |z/s|^n) where it is stretched in the direction of the motion, else v
        F = g w z/s + c z'

    Args:
        z: stretch, m.
        v: velocity, m/s.
        direction: of the motion, 1 or -1, kept within a step.
        limit: g, N; a negative one is zero.
        stretch, weight, damping: s, m; w; c, N s/m.

    Returns:
        Rate, force, and the derivatives rate_z, rate_v, rate_g, force_z, force_v, force_g.
    """
    ratio, elastic = z / stretch, max(limit, 0.0) * weight
    rate_z, rate_v = 0.0, 1.0
    if ratio * direction > 0.0:
        size = abs(ratio)
        falls = size**YIELD_POWER
        rate_z, rate_v = -YIELD_POWER * v * falls / size * direction / stretch, 1.0 - falls
    rate = v * rate_v
    force_g = weight * ratio if limit > 0.0 else 0.0
    force = elastic * ratio + damping * rate
    return rate, force, rate_z, rate_v, 0.0, elastic / stretch + damping * rate_z, damping * rate_v, force_g
