"""Friction at a speed, and a stage that moves under it, in compiled code: by Runge and Kutta's method of order four."""

from __future__ import annotations

import numpy as np

from sim.numerics.compilation import compile_function


@compile_function
def looked_up(curve: np.ndarray, speed: float, top: float) -> float:
    """Value of a curve (k,) at a speed either way, m/s."""
    place = np.sqrt(abs(speed) / top) * (curve.size - 1)
    k = min(int(place), curve.size - 2)
    low, high = (k / (curve.size - 1.0)) ** 2 * top, ((k + 1.0) / (curve.size - 1.0)) ** 2 * top
    part = min((abs(speed) - low) / (high - low), 1.0)
    return curve[k] + part * (curve[k + 1] - curve[k])


@compile_function
def holds(curves: np.ndarray, level: float, share: float, side: float, speed: float, top: float) -> float:
    """Most that a contact holds, N, at a speed towards a side."""
    if curves.shape[1] == 0:
        return level
    row = 0 if side > 0.0 else 1
    most = level * looked_up(curves[row], speed, top) + share * looked_up(curves[2 + row], speed, top)
    return max(most, 0.0)


@compile_function
def resists(curves: np.ndarray, velocity: float, top: float) -> float:
    """The other force, N, at a velocity."""
    if curves.shape[1] == 0:
        return 0.0
    return looked_up(curves[4 if velocity > 0.0 else 5], abs(velocity), top)


@compile_function
def yielded(q, w, curves, level, share, top):
    """Force of a spring, N, that would be q: the dashpot may pull back what the spring alone has beyond the most."""
    side = 1.0 if q > 0.0 else -1.0
    return side * min(side * q, holds(curves, level, share, side, side * w, top))


@compile_function
def rates(
    v, q, t, u, k, c, m, touching, slip_side, pad_side, level, level_rate, share, share_rate, slip_curves, slip_top,
    pad, pad_rate, pad_share, pad_share_rate, pad_curves, pad_top, f, f_rate,
):  # fmt: skip
    """Rates of speed and of the spring's force, a time t after the levels given."""
    w = u - v
    force, wound = 0.0, 0.0
    if touching:
        if slip_side != 0.0:
            force = slip_side * holds(
                slip_curves, level + level_rate * t, share + share_rate * t, slip_side, slip_side * w, slip_top
            )
        else:
            spring = yielded(q, w, slip_curves, level + level_rate * t, share + share_rate * t, slip_top)
            force, wound = spring + c * w, k * w
        force += resists(slip_curves, w, slip_top)
    friction = pad_side * holds(
        pad_curves, pad + pad_rate * t, pad_share + pad_share_rate * t, pad_side, pad_side * v, pad_top
    )
    friction += resists(pad_curves, v, pad_top)
    return (force + f + f_rate * t - friction) / m, wound


@compile_function
def moved_on(
    x, v, q, t, longest, u, k, c, m, touching, slip_side, pad_side, level, level_rate, share, share_rate, slip_curves,
    slip_top, pad, pad_rate, pad_share, pad_share_rate, pad_curves, pad_top, f, f_rate,
):  # fmt: skip
    """Position, speed and force of the spring a time t on."""
    count = max(1, int(np.ceil(t / longest)))
    h = t / count
    if touching and slip_side == 0.0:
        # A tip that turns round from row to row may lower the most at once.
        q = yielded(q, u - v, slip_curves, level, share, slip_top)
    for n in range(count):
        at = n * h
        a1, w1 = rates(
            v, q, at, u, k, c, m, touching, slip_side, pad_side, level, level_rate, share, share_rate, slip_curves,
            slip_top, pad, pad_rate, pad_share, pad_share_rate, pad_curves, pad_top, f, f_rate,
        )  # fmt: skip
        a2, w2 = rates(
            v + 0.5 * h * a1, q + 0.5 * h * w1, at + 0.5 * h, u, k, c, m, touching, slip_side, pad_side, level,
            level_rate, share, share_rate, slip_curves, slip_top, pad, pad_rate, pad_share, pad_share_rate, pad_curves,
            pad_top, f, f_rate,
        )  # fmt: skip
        a3, w3 = rates(
            v + 0.5 * h * a2, q + 0.5 * h * w2, at + 0.5 * h, u, k, c, m, touching, slip_side, pad_side, level,
            level_rate, share, share_rate, slip_curves, slip_top, pad, pad_rate, pad_share, pad_share_rate, pad_curves,
            pad_top, f, f_rate,
        )  # fmt: skip
        a4, w4 = rates(
            v + h * a3, q + h * w3, at + h, u, k, c, m, touching, slip_side, pad_side, level, level_rate, share,
            share_rate, slip_curves, slip_top, pad, pad_rate, pad_share, pad_share_rate, pad_curves, pad_top, f, f_rate,
        )  # fmt: skip
        x += h * (v + h / 6.0 * (a1 + a2 + a3))
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        q += h / 6.0 * (w1 + 2.0 * w2 + 2.0 * w3 + w4)
        if touching and slip_side == 0.0:
            end = at + h
            q = yielded(q, u - v, slip_curves, level + level_rate * end, share + share_rate * end, slip_top)
    return x, v, q
