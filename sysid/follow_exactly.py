"""The stage that follows a tip where pads and contact only stick or slip: from event to event, in closed form.

Pads hold up to their level, the contact is a spring and a dashpot that hold up to theirs. Between two events the
stage is an oscillator on the contact, a body under friction, or at rest; each is solved exactly while the tip and the
levels go straight from row to row. What is found depends smoothly on every number, and on no step.
"""

from __future__ import annotations

import numpy as np

from sim.compilation import compiled

LONGEST_PHASE = 0.6
"""rad of the stage's oscillation on its contact between two looks for events."""


def looks(stiffness: float, mass: float, step: float) -> int:
    """How often in a row events are looked for."""
    return max(1, int(np.ceil(np.sqrt(stiffness / mass) * step / LONGEST_PHASE)))


@compiled
def follow_exactly(
    tip: np.ndarray,
    push: np.ndarray,
    load: np.ndarray,
    level: np.ndarray,
    stiffness: float,
    damping: float,
    pads: np.ndarray,
    mass: float,
    step: float,
    parts: int,
) -> np.ndarray:
    """Position (n,) of the stage from its rest at the first row, m.

    Args:
        tip: along the axis, m, (n,).
        push: other forces on the stage, N, (n,), each held over the interval that ends at its row.
        load: of the contact over its mean, (n,); the tip touches where it is above zero.
        level: most that the contact holds while it touches, N, (n,); infinite where it never slips.
        stiffness, damping: of the contact, N/m and N s/m.
        pads: friction of the pads, N, (n,).
        mass: kg.
        step: of the record, s.
        parts: looks for events in each interval (`looks`).
    """
    n = tip.size
    out = np.zeros(n)
    k, c, m = stiffness, damping, mass
    sigma = 0.5 * c / m
    square = k / m - sigma * sigma
    swing = np.sqrt(max(abs(square), 1e-12 * k / m))
    natural = np.sqrt(k / m)
    regular = step / parts
    # How a free oscillation goes on over one regular part of a row.
    e = np.exp(-sigma * regular)
    if square > 0.0:
        cosine, sine = np.cos(swing * regular), np.sin(swing * regular) / swing
    else:
        cosine, sine = np.cosh(swing * regular), np.sinh(swing * regular) / swing
    r11, r12 = e * (cosine + sigma * sine), e * sine
    r21, r22 = -e * k / m * sine, e * (cosine - sigma * sine)

    x, v, q = 0.0, 0.0, 0.0
    pad_side, slip_side = 0.0, 0.0  # 0: sticks; else the way it slides
    touching = load[0] > 0.0
    for i in range(1, n):
        u = (tip[i] - tip[i - 1]) / step
        f = push[i]
        pad_rate = (pads[i] - pads[i - 1]) / step
        slips = level[i] < np.inf and level[i - 1] < np.inf
        level_rate = (level[i] - level[i - 1]) / step if slips else 0.0
        crossing = load[i - 1] * load[i] < 0.0
        change = step * load[i - 1] / (load[i - 1] - load[i]) if crossing else step
        now = 0.0
        for segment in range(2 if crossing else 1):
            end = step if segment == 1 or not crossing else change
            touches = (load[i - 1] if segment == 0 and crossing else load[i]) > 0.0
            if touches and not touching:
                q, slip_side = 0.0, 0.0
            touching = touches
            begin = now
            for part in range(parts):
                until = end if part == parts - 1 else begin + (end - begin) * (part + 1) / parts
                whole = not crossing
                for _ in range(40):
                    left = until - now
                    if left <= 0.0:
                        break
                    most = level[i - 1] + level_rate * now if slips else np.inf
                    pad = pads[i - 1] + pad_rate * now
                    # Where a row begins tip, levels and push may ask for another state at once.
                    w = u - v
                    if not touching:
                        force = 0.0
                    elif slip_side != 0.0:
                        force = slip_side * most
                        if slip_side * k * w <= level_rate:
                            # The spring is stretched to its limit; the dashpot feels the turn at once.
                            q, slip_side = force, 0.0
                            force = q + c * w
                    else:
                        force = q + c * w
                        if force > most or force < -most:
                            side = 1.0 if force > 0.0 else -1.0
                            force = side * most
                            if side * k * w > level_rate:
                                slip_side = side
                            else:
                                q = force - c * w
                    if pad_side == 0.0 and abs(force + f) > pad:
                        pad_side = 1.0 if force + f > 0.0 else -1.0
                    # The state after a time t, and by how much (m) it is past the next event.
                    low, high, t = 0.0, left, left
                    past_low, past_high = 0.0, 0.0
                    weight = 0
                    happened = False
                    xt, vt, qt, past, kind = x, v, q, 0.0, 0
                    for look in range(60):
                        if pad_side == 0.0:
                            xt, vt, qt = x, 0.0, q + k * u * t
                        elif touching and slip_side == 0.0:
                            slope = u - pad_side * pad_rate / k
                            shift = (q + c * u + f - pad_side * pad - c * slope) / k
                            if look == 0 and whole:
                                m11, m12, m21, m22 = r11, r12, r21, r22
                            else:
                                e = np.exp(-sigma * t)
                                if square > 0.0:
                                    cosine, sine = np.cos(swing * t), np.sin(swing * t) / swing
                                else:
                                    cosine, sine = np.cosh(swing * t), np.sinh(swing * t) / swing
                                m11, m12 = e * (cosine + sigma * sine), e * sine
                                m21, m22 = -e * k / m * sine, e * (cosine - sigma * sine)
                            y0, y1 = -shift, v - slope
                            moved = shift + slope * t + m11 * y0 + m12 * y1
                            xt, vt = x + moved, slope + m21 * y0 + m22 * y1
                            qt = q + k * (u * t - moved)
                        else:
                            a = (force + f - pad_side * pad) / m
                            rate = ((slip_side * level_rate if touching else 0.0) - pad_side * pad_rate) / m
                            vt = v + t * (a + 0.5 * rate * t)
                            xt = x + t * (v + t * (0.5 * a + rate * t / 6.0))
                            qt = q
                        past, kind = -1.0, 0
                        most_t = most + level_rate * t
                        if not touching:
                            force_t = 0.0
                        elif slip_side != 0.0:
                            force_t = slip_side * most_t
                            over = (level_rate - slip_side * k * (u - vt)) / (k * natural)
                            if over > past:
                                past, kind = over, 3
                        else:
                            force_t = qt + c * (u - vt)
                            over = (abs(force_t) - most_t) / k
                            if over > past:
                                past, kind = over, 2
                        if pad_side == 0.0:
                            over = (abs(force_t + f) - pad - pad_rate * t) / k
                        else:
                            over = -pad_side * vt / natural
                        if over > past:
                            past, kind = over, 1
                        if look == 0:
                            if past <= 1e-18:
                                break
                            happened = True
                            past_high = past
                        elif past > 0.0:
                            high, past_high = t, past
                            if weight == 1:
                                past_low *= 0.5
                            weight = 1
                        else:
                            low, past_low = t, past
                            if weight == -1:
                                past_high *= 0.5
                            weight = -1
                        if high - low <= 1e-10 * step or 0.0 < past < 1e-16:
                            if t == high:
                                break
                            t = high
                            continue
                        if past_low < 0.0:
                            t = low + (high - low) * past_low / (past_low - past_high)
                            t = min(max(t, low + 0.02 * (high - low)), high - 0.02 * (high - low))
                        else:
                            t = 0.5 * (low + high)
                    whole = False
                    x, v, q = xt, vt, qt
                    now += t
                    if not happened:
                        break
                    if kind == 1:
                        if pad_side == 0.0:
                            pad_side = 1.0 if force_t + f > 0.0 else -1.0
                        else:
                            v = 0.0
                            held = force_t if slip_side != 0.0 or not touching else q + c * u
                            room = pad + pad_rate * t
                            pad_side = 0.0 if abs(held + f) <= room else (1.0 if held + f > 0.0 else -1.0)
                    elif kind == 2:
                        slip_side = 1.0 if force_t > 0.0 else -1.0
                    elif kind == 3:
                        q, slip_side = force_t, 0.0
                now = until
        out[i] = x
    return out
