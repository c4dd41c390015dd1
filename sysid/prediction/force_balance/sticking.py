"""When a driven mass came to rest, by the momentum of its own model: sharper than the position near the stop can say.

Some filter widths before a stop the smoothed velocity is free of the kink that the stop makes in it. From there the
balance m v' = applied - friction is followed to v = 0. What is wrong with that time is wrong with the momentum, by no
more than the velocity's noise and the model's own misfit over the way: the filtered balance across the stop is then as
good as beside it, whatever the force that the stop ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.numerics.compilation import compiled

CLEAR = 3.0
"""Widths of the light filter from a kink of the motion on from which the smoothed velocity knows nothing of it."""


def _clear(light: float) -> int:
    return int(np.ceil(CLEAR * light)) + 1


@dataclass(frozen=True)
class SlipPhases:
    """Phases of sliding motion, each array of shape (k,), times in samples.

    Args:
        start: start of the phase.
        end: its end by the position alone: sticking onset, or reversal of the velocity.
        direction: sign of the velocity in it, 1 or -1.
        break_away: start of the next phase; equal to `end` at a reversal without sticking.
        next_direction: sign of the velocity in the next phase; 0 after the last one.
    """

    start: np.ndarray
    end: np.ndarray
    direction: np.ndarray
    break_away: np.ndarray
    next_direction: np.ndarray


@compiled
def _followed(
    out: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    drive: np.ndarray,
    start: int,
    limit: int,
    at: int,
    heading: float,
    light: float,
) -> int:
    """Write the velocity from `start` on until it is zero; the first sample there, -1 if none is before `limit`.

    Back from a motion under way the friction may be too small for the sticking it came from: then it is as large as
    brings the body to rest at `at`.
    """
    way = 1 if limit > start else -1
    # The filter has added half its width squared times the bend of the velocity.
    v = (velocity[start] - 0.25 * light**2 * (drive[start + 1] - drive[start - 1])) * heading
    here, own = acceleration[start] * heading, (acceleration[start] - drive[start]) * heading
    i, end = start, -1
    found = np.zeros(abs(limit - start) + 1)
    while i != limit:
        i += way
        there = own + drive[i] * heading
        v += way * 0.5 * (here + there)
        if v <= 0.0:
            end = i
            break
        found[abs(i - start)] = heading * v
        here = there
    if end < 0 and way < 0:
        pushed = 0.0
        for i in range(at, start):
            pushed += 0.5 * (drive[i] + drive[i + 1]) * heading
        first = (velocity[start] - 0.25 * light**2 * (drive[start + 1] - drive[start - 1])) * heading
        friction = (pushed - first) / (start - at)
        v, i = first, start
        while i - 1 > at:
            i -= 1
            v -= 0.5 * (drive[i] + drive[i + 1]) * heading - friction
            found[start - i] = heading * max(v, 0.0)
        end = at
    if end >= 0:
        j = start + way
        while j != end:
            out[j] = found[abs(j - start)]
            j += way
    return end


def restored_kinks(
    velocity: np.ndarray, acceleration: np.ndarray, drive: np.ndarray, stops: SlipPhases, light: float
) -> np.ndarray:
    """Velocity (n,) with its kinks at stops and departures, which a filter rounds off.

    From some widths of the filter beside a kink the acceleration goes on as it was there, but for what the drive adds
    to it: friction is taken to stay what it is over so short a way. Between the two sides the body rests.

    Args:
        velocity: smoothed, m per sample, (n,).
        acceleration: smoothed, m per sample squared, (n,).
        drive: known force over mass, m per sample squared, (n,).
        stops: ends of the stretches of motion.
        light: width of the filter, in samples.
    """
    out, clear, n = velocity.copy(), _clear(light), velocity.size
    begins, ends = np.floor(stops.end).astype(int), np.ceil(stops.break_away).astype(int)
    until = np.append(stops.end[1:], n - 1.0)
    fits = (begins - clear >= np.maximum(stops.start + clear, 1.0)) & (ends + clear <= until - clear)
    for k in np.flatnonzero(fits & (ends + clear < n - 1)):
        past, before = begins[k] + clear, ends[k] - clear
        stop = _followed(
            out, velocity, acceleration, drive, begins[k] - clear, past, begins[k], stops.direction[k], light
        )
        leave = _followed(
            out, velocity, acceleration, drive, ends[k] + clear, before, ends[k] - 1, stops.next_direction[k], light
        )
        if stop >= 0 and leave >= 0 and past >= before:
            out[stop : leave + 1] = 0.0
            continue
        if stop >= 0:
            out[stop : min(past, ends[k])] = 0.0
        if leave >= 0:
            out[max(before, begins[k]) + 1 : leave + 1] = 0.0
    return out


@compiled
def stop_times(
    first: np.ndarray,
    time: np.ndarray,
    heading: np.ndarray,
    latest: np.ndarray,
    velocity: np.ndarray,
    push: np.ndarray,
    level: np.ndarray,
    rate: float,
    light: float,
    search: float,
) -> np.ndarray:
    """Times (k,) at which the motion ends, in samples; as given where a stretch is too short to follow.

    Args:
        first, time, heading: of the stretches.
        latest: time that may not be passed.
        velocity: smoothed, (n,).
        push: applied force less what is not friction, N, (n,).
        level: friction level, N, (n,).
        rate: step / mass, change of velocity that one N makes in one sample.
        light: width of the filter of the velocity, in samples.
        search: farthest that a time may move, in samples.
    """
    out, clear = time.copy(), int(np.ceil(CLEAR * light)) + 1
    for k in range(time.size):
        i = int(np.floor(time[k])) - clear
        if i < first[k] + clear or i < 1:
            continue
        h = heading[k]
        # The filter has added half its width squared times the bend of the velocity.
        bend = (push[i + 1] - push[i - 1]) * h - (level[i + 1] - level[i - 1])
        v = velocity[i] * h - 0.25 * light**2 * bend * rate
        if v <= 0.0:
            continue
        last = min(int(np.ceil(time[k] + search)) + 1, push.size - 1)
        before = (push[i] * h - level[i]) * rate
        found = -1.0
        while i < last:
            after = (push[i + 1] * h - level[i + 1]) * rate
            gained = 0.5 * (before + after)
            if v + gained <= 0.0:
                # Straight between the rows: v + before s + (after - before) s^2 / 2 = 0.
                root = before * before - 2.0 * (after - before) * v
                found = i + 2.0 * v / (-before + np.sqrt(max(root, 0.0)))
                break
            v += gained
            before = after
            i += 1
        if found >= 0.0:
            out[k] = min(max(found, time[k] - search), time[k] + search, latest[k])
    return out


@compiled
def departures(
    stops: np.ndarray, given: np.ndarray, heading: np.ndarray, push: np.ndarray, level: np.ndarray, search: float
) -> np.ndarray:
    """Times (k,) from which friction no longer holds the body, in samples.

    A rest ends no sooner than the push reaches the level: the smoothed velocity starts before.

    Args:
        stops: when it came to rest.
        given: when the position alone says that it moves again.
        heading: direction in which it then does.
        push, level: as above.
        search: farthest that a time may move, in samples.
    """
    out = given.copy()
    for k in range(given.size):
        if given[k] <= stops[k]:
            continue
        i = max(0, int(np.floor(given[k])))
        while i < push.size - 1 and i < given[k] + search:
            here, there = push[i] * heading[k] - level[i], push[i + 1] * heading[k] - level[i + 1]
            if there >= 0.0:
                if here < 0.0:
                    out[k] = max(given[k], i + here / (here - there))
                break
            i += 1
            out[k] = min(float(i), given[k] + search)
    return out
