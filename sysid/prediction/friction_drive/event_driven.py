"""The pass of `follow_exactly` over a record, in compiled code: states between events, and the events."""

from __future__ import annotations

from functools import partial

import numpy as np

from sim.numerics.compilation import compile_function
from sysid.prediction.friction_drive import sliding_motion
from sysid.prediction.friction_drive.sliding_motion import holds, moved_on, resists

LOOKS_BY_SPEED = 3
"""Looks in the place of one, each a step of Runge and Kutta's method, where friction goes by the speed: as the level
rises while a slip slows down, a contact may slip and hold again within less than a row."""


@partial(compile_function, also=(sliding_motion.__file__,))
def follow_events(
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
    share: np.ndarray,
    slip_curves: np.ndarray,
    slip_top: float,
    pad_share: np.ndarray,
    pad_curves: np.ndarray,
    pad_top: float,
    seen: np.ndarray,
    part_of_place: float,
    part_of_speed: float,
) -> np.ndarray:
    """Position (n,) of the stage, m: arguments as of `follow_exactly`, curves as (6, k) and their highest speeds.

    With `part_of_place` above zero each row is told from the one before, which goes on from nearer to where the stage
    was `seen`, m, (n,).
    """
    n = tip.size
    out = np.zeros(n)
    k, c, m = stiffness, damping, mass
    sigma = 0.5 * c / m
    square = k / m - sigma * sigma
    swing = np.sqrt(max(abs(square), 1e-12 * k / m))
    natural = np.sqrt(k / m)
    by_speed = slip_curves.shape[1] > 0 or pad_curves.shape[1] > 0
    if by_speed:
        parts *= LOOKS_BY_SPEED
    regular = step / parts
    # How a free oscillation goes on over one regular part of a row.
    e = np.exp(-sigma * regular)
    if square > 0.0:
        cosine, sine = np.cos(swing * regular), np.sin(swing * regular) / swing
    else:
        cosine, sine = np.cosh(swing * regular), np.sinh(swing * regular) / swing
    r11, r12 = e * (cosine + sigma * sine), e * sine
    r21, r22 = -e * k / m * sine, e * (cosine - sigma * sine)

    longest = regular * 1.000001
    soon = 1e-3 * regular

    x, v, q = 0.0, 0.0, 0.0
    pad_side, slip_side = 0.0, 0.0  # 0: sticks; else the way it slides
    # A contact that slips holds its most, by spring and dashpot; its spring alone may still be behind that.
    behind = False
    touching = load[0] > 0.0
    for i in range(1, n):
        u = (tip[i] - tip[i - 1]) / step
        f_rate = (push[i] - push[i - 1]) / step
        pad_share_rate = (pad_share[i] - pad_share[i - 1]) / step
        share_rate = (share[i] - share[i - 1]) / step
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
                    level_now = level[i - 1] + level_rate * now if slips else np.inf
                    share_now = share[i - 1] + share_rate * now
                    pad_now, pad_share_now = pads[i - 1] + pad_rate * now, pad_share[i - 1] + pad_share_rate * now
                    f = push[i - 1] + f_rate * now
                    # Where a row begins tip, levels and push may ask for another state at once.
                    w = u - v
                    beside = resists(slip_curves, w, slip_top) if touching else 0.0
                    if not touching:
                        force = 0.0
                    elif slip_side != 0.0:
                        most = holds(slip_curves, level_now, share_now, slip_side, slip_side * w, slip_top)
                        force = slip_side * most
                        if slip_side * w < 0.0:
                            # A tip that turned round from row to row ends the slip at once.
                            q = slip_side * min(slip_side * q, most)
                            slip_side, force, behind = 0.0, q + c * w, True
                        # One that slows down may raise the most at once, and no spring follows that.
                        behind = behind or slip_side * q < most * (1.0 - 1e-12)
                        if slip_side != 0.0 and behind and slip_side * (q + c * w) <= most:
                            slip_side, force = 0.0, q + c * w
                    else:
                        force = q + c * w
                        side = 1.0 if force > 0.0 else -1.0
                        most = holds(slip_curves, level_now, share_now, side, side * w, slip_top)
                        if abs(force) > most:
                            force, slip_side, behind = side * most, side, True
                    pulled = force + beside + f
                    side = 1.0 if pulled > 0.0 else -1.0
                    if pad_side == 0.0 and abs(pulled) > holds(
                        pad_curves, pad_now, pad_share_now, side, 0.0, pad_top
                    ):  # fmt: skip
                        pad_side = side
                    # The state after a time t, and by how much (m) it is past the next event.
                    low, high, t = 0.0, left, left
                    past_low, past_high = 0.0, 0.0
                    weight = 0
                    happened = False
                    xt, vt, qt, past, kind = x, v, q, 0.0, 0
                    for look in range(60):
                        if pad_side == 0.0:
                            xt, vt, qt = x, 0.0, q + k * u * t
                        elif by_speed:
                            xt, vt, qt = moved_on(
                                x, v, q, t, longest, u, k, c, m, touching, slip_side, pad_side, level_now, level_rate,
                                share_now, share_rate, slip_curves, slip_top, pad_now, pad_rate, pad_share_now,
                                pad_share_rate, pad_curves, pad_top, f, f_rate,
                            )  # fmt: skip
                        elif touching and slip_side == 0.0:
                            slope = u + (f_rate - pad_side * pad_rate) / k
                            shift = (q + c * u + f - pad_side * pad_now - c * slope) / k
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
                            a = (force + f - pad_side * pad_now) / m
                            rate = ((slip_side * level_rate if touching else 0.0) + f_rate - pad_side * pad_rate) / m
                            vt = v + t * (a + 0.5 * rate * t)
                            xt = x + t * (v + t * (0.5 * a + rate * t / 6.0))
                            qt = q
                        if slip_side != 0.0:
                            qt = q + k * (u * t - (xt - x))
                        past, kind = -1.0, 0
                        wt = u - vt
                        level_t, share_t = level_now + level_rate * t, share_now + share_rate * t
                        pad_t, pad_share_t = pad_now + pad_rate * t, pad_share_now + pad_share_rate * t
                        f_t = f + f_rate * t
                        beside_t = resists(slip_curves, wt, slip_top) if touching else 0.0
                        if not touching:
                            force_t = 0.0
                        elif slip_side != 0.0:
                            most_t = holds(slip_curves, level_t, share_t, slip_side, slip_side * wt, slip_top)
                            force_t = slip_side * most_t
                            if behind:
                                over = (most_t - slip_side * (qt + c * wt)) / k
                                if over > past:
                                    past, kind = over, 3
                                over = (slip_side * qt - most_t) / k
                                if over > past:
                                    past, kind = over, 4
                            else:
                                qt = force_t
                                rising = level_rate
                                if by_speed:
                                    speeding = 0.0
                                    if pad_side != 0.0:
                                        held = resists(pad_curves, vt, pad_top) + pad_side * holds(
                                            pad_curves, pad_t, pad_share_t, pad_side, pad_side * vt, pad_top
                                        )
                                        speeding = -(force_t + beside_t + f_t - held) / m
                                    rising = holds(
                                        slip_curves, level_t + level_rate * soon, share_t + share_rate * soon,
                                        slip_side, slip_side * (wt + speeding * soon), slip_top,
                                    )  # fmt: skip
                                    rising = (rising - most_t) / soon
                                over = (rising - slip_side * k * wt) / (k * natural)
                                if slip_curves.shape[1] > 0:
                                    # A slip ends before it goes back, however the level falls there by the speed; one
                                    # whose level falls by the load may go back slipping.
                                    over = max(over, -slip_side * wt / natural)
                                if over > past:
                                    past, kind = over, 5
                        else:
                            force_t = qt + c * wt
                            side = 1.0 if force_t > 0.0 else -1.0
                            over = (abs(force_t) - holds(slip_curves, level_t, share_t, side, side * wt, slip_top)) / k
                            if over > past:
                                past, kind = over, 2
                        pulled_t = force_t + beside_t + f_t
                        if pad_side == 0.0:
                            side = 1.0 if pulled_t > 0.0 else -1.0
                            over = (abs(pulled_t) - holds(pad_curves, pad_t, pad_share_t, side, 0.0, pad_top)) / k
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
                            pad_side = 1.0 if pulled_t > 0.0 else -1.0
                        else:
                            v = 0.0
                            held = force_t if slip_side != 0.0 or not touching else q + c * u
                            pulled = held + f_t + (resists(slip_curves, u, slip_top) if touching else 0.0)
                            side = 1.0 if pulled > 0.0 else -1.0
                            room = holds(pad_curves, pad_t, pad_share_t, side, 0.0, pad_top)
                            pad_side = 0.0 if abs(pulled) <= room else side
                    elif kind == 2:
                        slip_side, behind = (1.0 if force_t > 0.0 else -1.0), True
                    elif kind == 3:
                        slip_side = 0.0
                    elif kind == 4:
                        behind = False
                    elif kind == 5:
                        behind = True
                now = until
        out[i] = x
        if part_of_place > 0.0:
            miss = seen[i] - x
            x += part_of_place * miss
            if pad_side != 0.0:
                v += part_of_speed * miss / step
            if touching and not slips:
                # A contact that never slips is wound by what lies between tip and stage.
                q -= k * part_of_place * miss
    return out
