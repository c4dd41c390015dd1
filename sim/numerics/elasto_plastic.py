"""Parallel elasto-plastic elements: springs of constant stiffness side by side that slip one after another.

    F = sum_k F_k,    stick: F_k' = k_k v,    slip: F_k' = sign(v) min(C (w_k - |F_k|/g), k_k |v|)

Element k slips where |F_k| reaches the part w_k of the friction limit g, and sticks again where the motion reverses. At
the limit g = g_0, at which the stretches s_k are stated, it slips at the stretch s_k: k_k = w_k g_0/s_k. The virgin
curve is then a broken line with a knot at each s_k; after a reversal the same curve follows at twice its size
(Masing's rule). This is the generalised Maxwell-slip model; at a constant limit it is Iwan's.

Its force follows a change of the limit at the rate C. Here C is so large that the force follows at once (g/C: 10 us in
an integration, nothing along a record), except that no force rises faster than its spring is stretched, k_k |v|: a law
without that bound charges its springs at rest, and returns more energy than it received. With it the heat

    F_k (v - F_k'/k_k) >= 0

in every element at every instant, for any history of the limit.

Source: Al-Bender, Lampaert, Swevers, IEEE Trans. Automatic Control 50 (2005) 1883, eq. 10-12; Iwan, J. Appl. Mech. 33
(1966) 893.
"""

from typing import NamedTuple

import numpy as np

from sim.numerics.compilation import SUMS_IN_ANY_ORDER, compiled, inlined


class Elements(NamedTuple):
    """Stretches at which the elements yield at the friction limit `force`, m, and the parts of the limit that they
    carry, each (b,); that limit, N."""

    stretches: np.ndarray
    weights: np.ndarray
    force: float = 1.0

    @property
    def stiffness(self) -> np.ndarray:
        """Stiffness (b,) of each element, N/m."""
        return self.force * self.weights / np.maximum(self.stretches, 1e-300)


class Springs(NamedTuple):
    """State of elements in a simulation: force, stiffness, and largest force over the friction limit of each, (b,);
    the force is written in place."""

    force: np.ndarray
    stiffness: np.ndarray
    limit: np.ndarray


def elements_along(stretches: np.ndarray, curve: np.ndarray, force: float = 1.0) -> Elements:
    """Elements whose virgin curve meets a concave `curve` (b,), force over the limit `force` (N), at the stretches
    (b,), m, ascending: w_k = (m_k - m_(k+1)) s_k, m_k the slope of the curve up to s_k."""
    slope = np.diff(curve, prepend=0.0) / np.diff(stretches, prepend=0.0)
    return Elements(stretches, np.maximum((slope - np.append(slope[1:], 0.0)) * stretches, 0.0), force)


def springs_of(elements: Elements) -> Springs:
    """Unloaded springs of the elements."""
    weights = np.ascontiguousarray(elements.weights, dtype=float)
    return Springs(np.zeros(weights.size), np.ascontiguousarray(elements.stiffness, dtype=float), weights)


AT_LIMIT = 1e-9
"""Distance of an element's force from its limit, over the limit, below which the element slips."""


@compiled(fastmath=SUMS_IN_ANY_ORDER, forceinline=True, _nrt=False)
def displace(springs: Springs, displacement: float, level: float) -> float:
    """Move all elements at a friction limit `level`, N; returns the sum of their forces, N."""
    total = 0.0
    for k in range(springs.force.size):
        force, most = springs.force[k] + springs.stiffness[k] * displacement, level * springs.limit[k]
        force = min(max(force, -most), most)
        springs.force[k] = force
        total += force
    return total


@inlined
def mean_force(springs: Springs, loss: float, displacement: float, level: float) -> tuple[float, float]:
    """Sum of the forces at half of a displacement (m), N, with a dashpot `loss` to each spring (over the duration of
    the displacement, N/m), and its tangent, N/m; the limit `level`, N, includes the dashpot's force."""
    total, tangent = 0.0, 0.0
    for k in range(springs.force.size):
        rate, most = 0.5 * springs.stiffness[k] + loss, level * springs.limit[k]
        force = springs.force[k] + rate * displacement
        if force > most:
            total += most
        elif force < -most:
            total -= most
        else:
            total += force
            tangent += rate
    return total, tangent


@inlined
def slips_alike(springs: Springs, loss: float, one: float, other: float, level: float) -> bool:
    """Whether the same elements slip, in the same direction, at the middle of two displacements, m."""
    alike = True
    for k in range(springs.force.size):
        rate, most = 0.5 * springs.stiffness[k] + loss, level * springs.limit[k]
        before, after = springs.force[k] + rate * one, springs.force[k] + rate * other
        alike &= (before > most) == (after > most) and (before < -most) == (after < -most)
    return alike


@compiled(fastmath=SUMS_IN_ANY_ORDER, forceinline=True, _nrt=False)
def displace_to(springs: Springs, total: float, wanted: float, level: float) -> tuple[float, float]:
    """Move all elements at a friction limit `level` until the sum of their forces, now `total`, is `wanted`, N, or all
    slip.

    The sum is piecewise linear in the displacement and is inverted exactly, from yield point to yield point.

    Returns:
        Displacement, m, and the sum of the forces.
    """
    side = 1.0 if wanted > total else -1.0
    moved = 0.0
    for _ in range(springs.force.size + 1):
        tangent, reach = 0.0, np.inf
        for k in range(springs.force.size):
            most = level * springs.limit[k]
            room = most - side * springs.force[k]
            # What rounding leaves of an element at its limit is no room: a step of that size would lead nowhere.
            if room > AT_LIMIT * most:
                tangent += springs.stiffness[k]
                reach = min(reach, room / springs.stiffness[k])
        left = (wanted - total) * side
        if tangent <= 0.0 or left <= 0.0:
            break
        step = min(left / tangent, reach)
        for k in range(springs.force.size):
            force, most = side * springs.force[k] + springs.stiffness[k] * step, level * springs.limit[k]
            # The element that yields now is set to its limit exactly.
            slips = step == reach and most - force < AT_LIMIT * most
            springs.force[k] = side * (most if slips else min(force, most))
        total += side * step * tangent
        moved += side * step
        if step == left / tangent:
            break
    return moved, total


@compiled
def _force_along(displacements: np.ndarray, level: np.ndarray, springs: Springs) -> np.ndarray:
    force = np.empty(level.size)
    # A record that begins in motion begins in slip: the first interval is taken to have preceded it.
    springs.force[:] = np.sign(displacements[0]) * max(level[0], 0.0) * springs.limit
    force[0] = np.sum(springs.force)
    for i in range(1, level.size):
        force[i] = displace(springs, displacements[i - 1], max(level[i], 0.0))
    return force


def force_along(position: np.ndarray, level: np.ndarray, elements: Elements) -> np.ndarray:
    """Force (n,) of elements along a record of positions (n,), m, at a friction limit (n,), N."""
    displacements = np.diff(np.ascontiguousarray(position, dtype=float))
    return _force_along(displacements, np.ascontiguousarray(level, dtype=float), springs_of(elements))


@compiled
def _behind_gap(
    displacements: np.ndarray, level: np.ndarray, springs: Springs, gap: float, crossed: float
) -> np.ndarray:
    moved = np.zeros(level.size)
    before = np.empty(springs.force.size)
    if not 0.0 <= crossed <= gap:
        springs.force[:] = np.sign(displacements[0]) * max(level[0], 0.0) * springs.limit
        crossed = gap if displacements[0] > 0.0 else 0.0
    for i in range(1, level.size):
        limit, left = max(level[i], 0.0), displacements[i - 1]
        side = 1.0 if left > 0.0 else -1.0
        total = displace(springs, 0.0, limit)
        moved[i] = moved[i - 1]
        if side * total < 0.0:
            before[:] = springs.force
            if side * displace(springs, left, limit) <= 0.0:
                moved[i] += left
                continue
            springs.force[:] = before
            unloading, total = displace_to(springs, total, 0.0, limit)
            moved[i] += unloading
            left -= unloading
        free = min(side * left, gap - crossed if side > 0.0 else crossed)
        crossed += side * free
        left -= side * free
        displace(springs, left, limit)
        moved[i] += left
    return moved


def position_behind_gap(
    position: np.ndarray, level: np.ndarray, elements: Elements, gap: float, crossed: float = np.nan
) -> np.ndarray:
    """Position (n,) of elements that are moved through a gap of full width `gap`, m: they rest, without force, while it
    is crossed.

    After a reversal the elements unload first; where the sum of their forces is zero, the contact opens. Rigid elements
    unload at once: then it is the play operator. A record begins in contact, and in slip, unless the part of the gap
    that is `crossed` then is given, m.
    """
    position = np.ascontiguousarray(position, dtype=float)
    moved = _behind_gap(np.diff(position), np.ascontiguousarray(level, dtype=float), springs_of(elements), gap, crossed)
    return position[0] + moved


@compiled
def _contact(displacements: np.ndarray, direction: np.ndarray, gap: float, crossed: float) -> np.ndarray:
    touches = np.empty(direction.size)
    side = 1.0 if crossed >= gap else (-1.0 if crossed <= 0.0 else 0.0)
    touches[0] = abs(side)
    for i in range(1, direction.size):
        crossed = min(max(crossed + displacements[i - 1], 0.0), gap)
        if side == 0.0:
            side = 1.0 if crossed >= gap else (-1.0 if crossed <= 0.0 else 0.0)
        elif side * direction[i] < 0.0:
            side = 0.0
        touches[i] = abs(side)
    return touches


def contact_across_gap(position: np.ndarray, direction: np.ndarray, gap: float, crossed: float = np.nan) -> np.ndarray:
    """Whether rigid sides of a gap of full width `gap` touch along a record of positions, m, (n,), 0 or 1: a contact
    opens where the `direction` of the motion (n,) is against it, 0 where that is not known. It is closed at first
    unless the part of the gap that is `crossed` then is given, m."""
    displacements = np.diff(np.ascontiguousarray(position, dtype=float))
    first = crossed if np.isfinite(crossed) else (gap if displacements[0] > 0.0 else 0.0)
    return _contact(displacements, np.ascontiguousarray(direction, dtype=float), gap, first)


def stretch_along(position: np.ndarray, level: np.ndarray, elements: Elements) -> np.ndarray:
    """Stretch (b, n) of each element along a record, m; arguments as `force_along`."""
    each = [Elements(np.array([s]), np.ones(1), elements.force) for s in elements.stretches]
    return np.array([force_along(position, level, one) / one.stiffness for one in each])


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

RELAXATION = 1e-5
"""s, g/C of the law: time in which the force of a slipping element falls onto a limit that has fallen below it."""

ElementTerms = tuple[float, float, float, float, float, float, float, float]


def smooth_element(
    z: float, v: float, direction: float, limit: float, stretch: float, weight: float, damping: float, force: float
) -> ElementTerms:
    """An element that yields smoothly, for implicit integration: its rate falls with a high power of the stretch.

        F = k z + c z',    k = w g_0/s,    yields at |z| = r = s g/g_0
        z' = v (1 - |z/r|^n) where it is stretched in the direction of the motion, else v
        beyond r, where the limit has fallen: z' = -(z - r sign(z))/T, plus v where the motion unloads it

    Args:
        z: stretch, m.
        v: velocity, m/s.
        direction: of the motion, 1 or -1, kept within a step.
        limit: g, N; a negative one is zero.
        stretch, weight, damping: s, m; w; c, N s/m.
        force: g_0, N; with zero the element yields at its stretch s, whatever the limit, and has no spring.

    Returns:
        Rate, force, and the derivatives rate_z, rate_v, rate_g, force_z, force_v, force_g.
    """
    stiffness, reach, grows = force * weight / stretch, stretch, 0.0
    if force > 0.0:
        reach, grows = stretch * max(limit, 0.0) / force, stretch / force if limit > 0.0 else 0.0
    side = (1.0 if z > 0.0 else -1.0) if z != 0.0 else direction
    rate, rate_z, rate_v, rate_g = v, 0.0, 1.0, 0.0
    if abs(z) > reach or reach <= 0.0:
        rate_v = 1.0 if side * direction < 0.0 else 0.0
        rate = rate_v * v - (z - side * reach) / RELAXATION
        rate_z, rate_g = -1.0 / RELAXATION, side * grows / RELAXATION
    elif z * direction > 0.0:
        size = abs(z) / reach
        steep = size ** (YIELD_POWER - 1.0)
        rate_v = 1.0 - steep * size
        rate, rate_z = v * rate_v, -YIELD_POWER * v * steep * side / reach
        rate_g = YIELD_POWER * v * steep * size * grows / reach
    return (
        rate,
        stiffness * z + damping * rate,
        rate_z,
        rate_v,
        rate_g,
        stiffness + damping * rate_z,
        damping * rate_v,
        damping * rate_g,
    )
