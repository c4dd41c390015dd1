"""A planar stage with a flexible plate and a tip on swaying stacks, by its own equations and its own steps.

The plate is Kirchhoff's, by Ritz's method in Legendre polynomials (the rigid motions are its first terms); contacts
are Hertz's; friction of the pads is one elasto-plastic spring each, that of the tip follows Mindlin's curve by twelve.
Semi-implicit Euler in steps of 0.1 us. It shares no code with the simulator.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.polynomial import legendre
from scipy.linalg import eigh


class Ritz(NamedTuple):
    """Modes of a free plate, unit modal mass: angular frequency, (m,), coefficients of the products of Legendre
    polynomials, (m, p, p), and half sides, m."""

    rates: np.ndarray
    coefficients: np.ndarray
    half: tuple[float, float]


def free_plate(length: float, width: float, thickness: float, material: tuple[float, float, float], points, order=14):
    """Modes of a free plate with point masses; material: modulus, Poisson's ratio, density; points: (x, y, mass), or
    (feet, mass, height) of a rigid body that turns by the mean slopes of its feet."""
    modulus, nu, density = material
    a, b = 0.5 * length, 0.5 * width
    nodes, weights = legendre.leggauss(order + 2)

    def one(derivative: int) -> np.ndarray:
        return np.array([legendre.legval(nodes, legendre.legder(np.eye(order)[i], derivative)) for i in range(order)])

    p0, p1, p2 = one(0), one(1), one(2)

    def product(f, g):
        return (f * weights) @ g.T

    i00, i11, i22, i02 = product(p0, p0), product(p1, p1), product(p2, p2), product(p0, p2)

    def both(along, across):
        return np.einsum("ij,kl->ikjl", along, across).reshape(order**2, order**2)

    rigidity = modulus * thickness**3 / (12 * (1 - nu**2))
    bend = both(i22, i00) * b / a**3 + both(i00, i22) * a / b**3
    bend += nu * (both(i02.T, i02) + both(i02, i02.T)) / (a * b) + 2 * (1 - nu) * both(i11, i11) / (a * b)
    mass = density * thickness * a * b * both(i00, i00)
    for first, second, third in points:
        if np.ndim(first) == 0:
            row = _row(order, a, b, first, second, 0, 0)
            mass += third * np.outer(row, row)
            continue
        feet = [_row(order, a, b, x, y, 0, 0) for x, y in first]
        for row in feet:
            mass += second / len(feet) * np.outer(row, row)
        for axis in (0, 1):
            away = [place[axis] for place in first]
            slope = sum(x * row for x, row in zip(away, feet)) / sum(x * x for x in away)
            mass += second * third**2 * np.outer(slope, slope)
    values, vectors = eigh(rigidity * bend, mass)
    return Ritz(np.sqrt(np.maximum(values, 0.0)), vectors.T.reshape(-1, order, order), (a, b))


def _row(order, a, b, x, y, dx, dy):
    along = [legendre.legval(x / a, legendre.legder(np.eye(order)[i], dx)) / a**dx for i in range(order)]
    across = [legendre.legval(y / b, legendre.legder(np.eye(order)[i], dy)) / b**dy for i in range(order)]
    return np.outer(along, across).ravel()


def shapes(ritz: Ritz, x: float, y: float, dx: int = 0) -> np.ndarray:
    """Deflection of each mode at a place, or its slope along x."""
    count, order = ritz.coefficients.shape[:2]
    return ritz.coefficients.reshape(count, -1) @ _row(order, *ritz.half, x, y, dx, 0)


class Planar(NamedTuple):
    """Numbers of the planar model, SI; (m,) modes, rigid ones first; `at_pads` (pads, m)."""

    mass: float
    load: float
    rates: np.ndarray
    damping: float
    lever: float  # centre over the drive surface
    pad_lever: float
    at_pads: np.ndarray
    slope_at_pads: np.ndarray
    gravity: np.ndarray  # modal force of the weight
    polynomials: np.ndarray  # deflection of each mode on y = 0: coefficients of powers of x, (m, k)
    pad: np.ndarray  # rate, damping, static, dynamic, Stribeck velocity, presliding
    tip: np.ndarray  # mass, inertia, moment, height, stiffness, damping, squared arm sum, sway stiffness, sway damping
    contact: np.ndarray  # rate, damping, friction, ratio
    springs: np.ndarray  # stiffness over that at rest, and limit over the friction limit, of each spring, (2, s)


def mindlin_springs(count: int) -> np.ndarray:
    """Springs, (2, count), whose first loading is F/(mu N) = 1 - (1 - x/x_s)^1.5, x_s = 1.5 mu N/k."""
    u = np.arange(count + 1) / count
    slopes = np.append(np.diff(1.0 - (1.0 - u) ** 1.5) * count, 0.0)
    parts = slopes[:-1] - slopes[1:]
    return np.array([parts / 1.5, parts * u[1:]])


@njit(cache=False)
def _on_line(polynomials, x, value, slope):
    for m in range(polynomials.shape[0]):
        f, d = 0.0, 0.0
        for k in range(polynomials.shape[1] - 1, -1, -1):
            d = d * x + f
            f = f * x + polynomials[m, k]
        value[m], slope[m] = f, d


@njit(cache=False)
def planar_run(c, drive, eta, apex_height, x, v, duration, h):
    """Mean velocity and mean and peak tip load over the last two fifths; drive: along, normal, frequency, rise time;
    eta: modal deflections at rest; apex_height: over the unloaded drive surface."""
    modes, pads = eta.size, c.at_pads.shape[0]
    rate = np.zeros(modes)
    push = np.zeros(modes)
    value, slope = np.zeros(modes), np.zeros(modes)
    shear = np.zeros(pads)
    held, before = np.zeros(c.springs.shape[1]), 0.0
    gone, mean, peak, counted = 0.0, 0.0, 0.0, 0
    m, inertia, moment, height, k, damping, arms, sway, sway_damping = c.tip
    z, a, s, vz, va, vs = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    along, normal, frequency, rise = drive
    steps = int(duration / h)
    eta = eta.copy()
    for n in range(steps):
        t = (n + 1) * h
        part = min(t / rise, 1.0)
        turn = 2.0 * math.pi * frequency * t
        up, lean = normal * math.sin(turn) * part, -along / height * math.cos(turn) * part
        push[:] = c.gravity
        # Pads.
        total = 0.0
        for p in range(pads):
            deep, sink, slip = 0.0, 0.0, v
            for i in range(modes):
                deep -= c.at_pads[p, i] * eta[i]
                sink -= c.at_pads[p, i] * rate[i]
                slip += c.pad_lever * c.slope_at_pads[p, i] * rate[i]
            if deep <= 0.0:
                shear[p] = 0.0
                continue
            normal_force = max(c.pad[0] * deep**1.5 * (1.0 + c.pad[1] * sink), 0.0)
            mu = c.pad[3] + (c.pad[2] - c.pad[3]) * math.exp(-((slip / c.pad[4]) ** 2))
            stiffness = 2.0 * c.pad[2] * normal_force / c.pad[5]
            cap = mu * normal_force
            shear[p] = min(max(shear[p] + stiffness * slip * h, -cap), cap)
            total -= shear[p]
            for i in range(modes):
                push[i] += c.at_pads[p, i] * normal_force - c.pad_lever * c.slope_at_pads[p, i] * shear[p]
        # Tip.
        at = -x + s + height * a
        _on_line(c.polynomials, at, value, slope)
        sea, lift, tilt, turning = 0.0, 0.0, 0.0, 0.0
        for i in range(modes):
            sea += value[i] * eta[i]
            lift += value[i] * rate[i]
            tilt += slope[i] * eta[i]
            turning += slope[i] * rate[i]
        slide = v + c.lever * turning - vs - height * va
        deep = apex_height + z - sea
        force, pull = 0.0, 0.0
        if deep > 0.0:
            closing = vz - lift + tilt * slide
            force = max(c.contact[0] * deep**1.5 * (1.0 + c.contact[1] * closing), 0.0)
            stiffness = c.contact[3] * 1.5 * c.contact[0] * math.sqrt(deep)
            cap = c.contact[2] * force
            # A spring loses force in proportion when its stiffness falls with the load.
            kept = min(stiffness / before, 1.0) if before > 0.0 else 1.0
            for e in range(held.size):
                most = cap * c.springs[1, e]
                held[e] = min(max(kept * held[e] + stiffness * c.springs[0, e] * slide * h, -most), most)
                pull -= held[e]
            before = stiffness
            pull -= tilt * force
            for i in range(modes):
                push[i] += value[i] * force + c.lever * slope[i] * pull
        else:
            held[:] = 0.0
            before = 0.0
        torque = k * arms * (lean - a) - damping * arms * va - height * pull
        across = -pull - sway * s - sway_damping * vs
        det = m * inertia - moment * moment
        vz += h * (3.0 * k * (up - z) - 3.0 * damping * vz - force) / m
        va += h * (m * torque - moment * across) / det
        vs += h * (inertia * across - moment * torque) / det
        z, a, s = z + h * vz, a + h * va, s + h * vs
        v += h * (total + pull) / c.mass
        x += h * v
        for i in range(modes):
            rate[i] += h * (push[i] - c.rates[i] ** 2 * eta[i] - 2.0 * c.damping * c.rates[i] * rate[i])
            eta[i] += h * rate[i]
        if n >= 0.6 * steps:
            gone += h * v
            mean += force
            peak = max(peak, force)
            counted += 1
    return gone / (counted * h), mean / counted, peak
