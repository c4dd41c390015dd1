"""When exactly a body turned or came to rest, from a noisy position: sharper than its smoothed velocity can say.

Where friction jumps, the acceleration does, and smoothing the position over that kink shifts the zero of the velocity
by up to half the filter's width. At ten reversals a second that shift, times twice the Coulomb force, would be the
largest error of a force balance. Here each event is fitted by two pieces that meet at rest. With the known drive
acceleration u(t) integrated twice from t0, U(t; t0), and a friction that is constant on each side,

    x = x0 + U + a1 (t - t0)^2 / 2  before t0,   x0 + U + a2 (t - t0)^2 / 2  after,   or x0 after: it stays,

so that t0 comes out free of that bias, to a few hundredths of a sampling step.
"""

from __future__ import annotations

import numpy as np

from sim.numerics.compilation import compiled
from sysid.prediction.force_balance.sticking import SlipPhases
from sysid.signals.intervals import runs


@compiled
def event_times(position: np.ndarray, drive: np.ndarray, events: np.ndarray, reach: int, search: float) -> np.ndarray:
    """Times (in samples) at which the motion around each event stood still.

    Args:
        position: measured, unfiltered, (n,).
        drive: known force over mass, in position units per sample squared, (n,); zeros where not known.
        events: first guesses, in samples, (k,).
        reach: samples on each side that are fitted.
        search: how far from the guess t0 is looked for, in samples: on a grid of a quarter, then of a 1/32 sample.

    Returns:
        (k,); the guess itself where the window would leave the record.
    """

    def error_at(window, once, twice, t0):  # type: ignore[no-untyped-def]
        # `once` and `twice` are the first and second integral of the drive over the window.
        k = int(t0)
        f = t0 - k
        rate = once[k] + f * (once[min(k + 1, window.size - 1)] - once[k])
        base = twice[k] + f * once[k] + 0.5 * f * (rate - once[k])
        n = window.size
        s_b, s_bb, s_a, s_aa, y_b, y_a = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        y_1, yy = 0.0, 0.0
        after, r_1, rr, p_1, pp = 0, 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            y = window[i] - (twice[i] - base - rate * (i - t0))
            q = 0.5 * (i - t0) ** 2
            if i < t0:
                y_1 += y
                yy += y * y
                s_b += q
                s_bb += q * q
                y_b += q * y
            else:
                after += 1
                p_1 += y
                pp += y * y
                s_a += q
                s_aa += q * q
                y_a += q * y
                r_1 += window[i]
                rr += window[i] ** 2
        if s_bb <= 0.0 or s_aa <= 0.0:
            return np.inf
        # Moving on: two curvatures that do not overlap are eliminated, then x0 is solved for.
        determinant = n - s_b * s_b / s_bb - s_a * s_a / s_aa
        moving = np.inf
        if determinant > 1e-9:
            x0 = (y_1 + p_1 - s_b * y_b / s_bb - s_a * y_a / s_aa) / determinant
            moving = yy + pp - x0 * (y_1 + p_1) - (y_b - s_b * x0) / s_bb * y_b - (y_a - s_a * x0) / s_aa * y_a
        # Staying: one curvature before, none after.
        determinant = n - s_b * s_b / s_bb
        staying = np.inf
        if determinant > 1e-9:
            x0 = (y_1 + r_1 - s_b * y_b / s_bb) / determinant
            staying = yy + rr - x0 * (y_1 + r_1) - (y_b - s_b * x0) / s_bb * y_b
        # A curvature more explains a little noise by itself.
        return min(moving, staying * (1.0 - 1.0 / n))

    out = events.copy()
    size = 2 * reach + 1
    once, twice = np.zeros(size), np.zeros(size)
    for k in range(events.size):
        centre = int(np.round(events[k]))
        low = centre - reach
        if low < 0 or centre + reach >= position.size:
            continue
        window = position[low : low + size] - position[centre]
        for i in range(1, size):
            a0, a1 = drive[low + i - 1], drive[low + i]
            once[i] = once[i - 1] + 0.5 * (a0 + a1)
            twice[i] = twice[i - 1] + once[i - 1] + a0 / 3.0 + a1 / 6.0
        best = np.inf
        width, spacing = min(search, reach - 3.0), 0.25
        middle = events[k] - low
        for _ in range(2):
            count = 2 * int(np.ceil(width / spacing)) + 1
            for j in range(count):
                t0 = middle + (j - count // 2) * spacing
                if t0 < 1.0 or t0 > size - 2.0:
                    continue
                error = error_at(window, once, twice, t0)
                if error < best:
                    best = error
                    out[k] = low + t0
            middle, width, spacing = out[k] - low, spacing, 0.03125
    return out


def resolve_events(
    position: np.ndarray,
    velocity: np.ndarray,
    drive: np.ndarray,
    resting: np.ndarray,
    reach: int,
    search: float,
    shortest: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, SlipPhases]:
    """Direction of motion with its flips where they happened, and how much of each step was spent at rest.

    Args:
        position: measured, unfiltered, (n,).
        velocity: smoothed, (n,).
        drive: known force over mass, in position units per sample squared, (n,).
        resting: where the smoothed velocity is indistinguishable from rest, (n,).
        reach: samples fitted on each side of an event.
        search: how far a flip may lie from where the smoothed velocity puts it, in samples.
        shortest: a motion of fewer samples is noise.

    Returns:
        direction (n,), in [-1, 1]: the sign of the motion, averaged over the step around each sample; 0 at rest.
        rest (n,), in [0, 1]: the part of the step around each sample spent at rest.
        turns (k,): times of the turns without a rest between, in samples, signed by the direction after them.
        stops: all the ends of motion, turns among them.
    """
    n = velocity.size
    sign = np.where(resting, 0.0, np.sign(velocity))
    # Noise at rest looks like motion for a sample or two.
    for start, stop in runs(sign != 0.0):
        if stop - start < shortest:
            sign[start:stop] = 0.0
    moving = np.flatnonzero(sign)
    direction, rest = np.zeros(n), np.zeros(n)
    if moving.size == 0:
        return direction, np.ones(n), np.empty(0), SlipPhases(*(np.empty(0) for _ in range(5)))
    # Where one stretch of motion ends (sample i) and the next begins (sample j), with or without a rest between.
    last, first = moving[:-1], moving[1:]
    ends = np.flatnonzero((first - last > 1) | (sign[first] != sign[last]))
    i, j = last[ends], first[ends]
    through = j - i == 1
    fall = np.where(through, velocity[i] / np.where(through, velocity[i] - velocity[j], 1.0), 0.5)
    guesses = (i + fall).astype(float)
    times = event_times(np.ascontiguousarray(position), np.ascontiguousarray(drive), guesses, reach, search)
    departures = np.where(through, times, np.maximum(j - 0.5, times))
    start = -0.5
    if moving[0] > 0:
        _paint(rest, start, moving[0] - 0.5, 1.0)
        start = moving[0] - 0.5
    for stop, departure, heading in zip(times.tolist(), departures.tolist(), sign[i].tolist(), strict=True):
        _paint(direction, start, stop, heading)
        _paint(rest, stop, departure, 1.0)
        start = max(departure, stop)
    end = float(moving[-1]) + 0.5
    _paint(direction, start, end, float(sign[moving[-1]]))
    _paint(rest, end, n - 0.5, 1.0)
    turns = times[through] * sign[j[through]]
    # A creep that is lost in the noise for a while is no stop; the last stretch ends too, with nothing after it.
    stopped = np.append((departures > times) | (sign[i] != sign[j]), True)
    times, departures = np.append(times, end)[stopped], np.append(np.maximum(departures, times), n - 0.5)[stopped]
    began = np.concatenate([moving[:1] - 0.5, departures[:-1]])
    headings, nexts = np.append(sign[i], sign[moving[-1]])[stopped], np.append(sign[j], 0.0)[stopped]
    return direction, rest, turns, SlipPhases(began, times, headings, departures, nexts)


def at_times(
    direction: np.ndarray, rest: np.ndarray, stops: SlipPhases, times: np.ndarray, leaves: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`direction` (n,), `rest` (n,) and `turns` (k,) of `resolve_events` with its stops and departures moved.

    Args:
        direction, rest, stops: as `resolve_events` gave them.
        times: of the stops, in samples, (k,).
        leaves: of the departures, in samples, (k,); not looked at where the body turned without a rest.
    """
    direction, rest = direction.copy(), rest.copy()
    through = stops.break_away <= stops.end
    after = np.where(through, stops.next_direction, 0.0)
    _move(direction, rest, stops.end, times, stops.direction, after)
    held = ~through
    _move(direction, rest, stops.break_away[held], leaves[held], np.zeros(held.sum()), stops.next_direction[held])
    return direction, rest, times[through] * stops.next_direction[through]


@compiled
def _move(
    direction: np.ndarray, rest: np.ndarray, old: np.ndarray, new: np.ndarray, before: np.ndarray, after: np.ndarray
) -> None:
    """Repaint the steps between old and new events, `before` and `after` which the heading is that, 0 for a rest."""
    for k in range(old.size):
        low, high = max(min(old[k], new[k]), -0.5), min(max(old[k], new[k]), direction.size - 0.5)
        later = new[k] > old[k]
        turned = before[k] - after[k] if later else after[k] - before[k]
        still = (1.0 if before[k] == 0.0 else 0.0) - (1.0 if after[k] == 0.0 else 0.0)
        if not later:
            still = -still
        i = int(np.floor(low + 0.5))
        while low < high and i < direction.size:
            part = min(high, i + 0.5) - low
            direction[i] += turned * part
            rest[i] += still * part
            low = i + 0.5
            i += 1


@compiled
def sharp_friction(
    direction: np.ndarray,
    rest: np.ndarray,
    turns: np.ndarray,
    applied: np.ndarray,
    level: np.ndarray,
    stretch: float,
    scale: float,
) -> np.ndarray:
    """Coulomb friction (n,) of a body that forces act on, before any filter.

    While it moves, the level against the motion. While it rests, what is applied, up to the level. After a turn the
    bristle that was stretched one way is followed to the other, from rest, step by step in sixteenths of a sample: it
    passes its 2 `stretch` in a fraction of a sample where the drive is strong, and holds the body where it is weak, for
    a time too short for the position to show, but not for the balance.

    Args:
        direction: mean sign of the motion over each step, (n,).
        rest: part of each step spent at rest, (n,).
        turns: times of the turns without a visible rest, in samples, signed by the direction after them, (k,).
        applied: force that friction has to hold at rest, N, (n,).
        level: friction level, N, (n,).
        stretch: displacement at which the bristle slips, m.
        scale: step^2 / mass: displacement in m that one N makes of a body in one sample squared.
    """
    n = direction.size
    out = np.empty(n)
    for i in range(n):
        out[i] = rest[i] * min(level[i], max(-level[i], applied[i])) + direction[i] * level[i]
    parts = 16
    for k in range(turns.size):
        t0, heading = abs(turns[k]), (1.0 if turns[k] > 0.0 else -1.0)
        i = int(np.floor(t0 + 0.5))
        if i < 0 or i >= n:
            continue
        gone, speed = 0.0, 0.0
        before = t0 - (i - 0.5)
        slipped = False
        first = True
        while i < n and not slipped:
            share = 1.0 - before if first else 1.0
            if not first and direction[i] * heading < 0.999:
                break
            g, u = level[i], applied[i] * heading
            if g <= 0.0:
                break
            total = 0.0
            pause = share / parts
            for _ in range(parts):
                force = g * min(1.0, gone / stretch - 1.0)
                push = u - force
                if u < g:
                    # Held: the bristle, well damped, rests where it balances what is applied.
                    speed = 0.0
                    force = max(-g, min(g, u))
                    gone = stretch * (force / g + 1.0)
                else:
                    speed += push * scale * pause
                    gone = max(0.0, gone + speed * pause)
                    if gone >= 2.0 * stretch:
                        slipped = True
                        force = g
                total += force / parts
            out[i] = heading * (share * total - (before * g if first else 0.0))
            first = False
            i += 1
    return out


def _paint(cells: np.ndarray, start: float, stop: float, value: float) -> None:
    """Add `value` times the part of each sample's step (half before, half after it) that lies in [start, stop]."""
    start, stop = max(start, -0.5), min(stop, cells.size - 0.5)
    if stop <= start:
        return
    first, last = int(np.floor(start + 0.5)), min(int(np.floor(stop + 0.5)), cells.size - 1)
    if first == last:
        cells[first] += value * (stop - start)
        return
    cells[first] += value * (first + 0.5 - start)
    cells[first + 1 : last] += value
    cells[last] += value * (stop - (last - 0.5))
