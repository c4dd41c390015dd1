"""Sticking onsets and break-away of a driven mass, from its own momentum and friction.

The smoothed velocity is disturbed within some filter widths of a kink of the motion. From outside that range the
balance m v' = applied - friction is integrated to v = 0. The error of that time is an error of momentum, no larger
than the velocity's noise and the model's own misfit over the distance: the filtered balance across a sticking onset is
then as accurate as away from it, for any force.

After the onset a presliding contact lets the mass oscillate on its bristles. The position's noise hides their stretch;
the force does not need it: with all bristles stretched one way at the onset, m x'' = push - friction(x) is integrated
in small steps, the bristles being parallel ideal springs that each yield at an individual stretch (Iwan, J. Appl.
Mech. 33 (1966) 893), until all have yielded and the mass slips.
"""

from typing import NamedTuple

import numpy as np

from sim.numerics.compilation import SUMS_IN_ANY_ORDER, compiled
from sim.numerics.elasto_plastic import Elements, Springs, displace

KINK_WIDTHS = 3.0
"""Widths of the prefilter beyond which a kink of the motion does not disturb the smoothed velocity."""

MOST_SUBSTEPS = 64
"""Substeps of a sample in which the oscillation on the bristles is integrated, at the most."""

SUBSTEP_PHASE = 0.35
"""Phase of the fastest oscillation in one substep, rad."""


class SlipPhases(NamedTuple):
    """Phases of sliding motion, (k,) each, times in samples: start; end by the position alone (sticking onset,
    reversal, or end of the record); sign of the velocity, 1 or -1; start of the next phase, equal to `end` at a
    reversal without sticking, and the end of the record after the last; sign of the velocity there, 0 after the
    last."""

    start: np.ndarray
    end: np.ndarray
    direction: np.ndarray
    break_away: np.ndarray
    next_direction: np.ndarray

    @property
    def reverses(self) -> np.ndarray:
        """Phases (k,) that end in a reversal without sticking; the end of a record in motion is none."""
        return (self.break_away <= self.end) & (self.next_direction != 0.0)


class Forces(NamedTuple):
    """Forces on a driven mass, N, each (n,): applied force less what is not friction, and the friction level."""

    push: np.ndarray
    level: np.ndarray


class SmoothedMotion(NamedTuple):
    """Velocity and acceleration through the prefilter, and known force over mass, each (n,), per sample (squared); and
    the width of the filter, in samples."""

    velocity: np.ndarray
    acceleration: np.ndarray
    drive: np.ndarray
    width: float


@compiled
def _unfiltered_velocity(motion: SmoothedMotion, i: int) -> float:
    """Velocity at a sample: the filter has added half its width squared times the curvature of the velocity."""
    return motion.velocity[i] - 0.25 * motion.width**2 * (motion.drive[i + 1] - motion.drive[i - 1])


@compiled
def _extrapolate(out: np.ndarray, motion: SmoothedMotion, start: int, limit: int, at: int, direction: float) -> int:
    """Write the velocity from `start` on until it is zero, and return the first sample there, -1 if beyond `limit`;
    backwards, friction too small for a break-away is set to the value that brings the body to rest at `at`."""
    way = 1 if limit > start else -1
    drive = motion.drive
    v = _unfiltered_velocity(motion, start) * direction
    here, own = motion.acceleration[start] * direction, (motion.acceleration[start] - drive[start]) * direction
    i, end = start, -1
    found = np.zeros(abs(limit - start) + 1)
    while i != limit:
        i += way
        there = own + drive[i] * direction
        v += way * 0.5 * (here + there)
        if v <= 0.0:
            end = i
            break
        found[abs(i - start)] = direction * v
        here = there
    if end < 0 and way < 0:
        impulse = 0.0
        for i in range(at, start):
            impulse += 0.5 * (drive[i] + drive[i + 1]) * direction
        v = _unfiltered_velocity(motion, start) * direction
        friction = (impulse - v) / (start - at)
        i = start
        while i - 1 > at:
            i -= 1
            v -= 0.5 * (drive[i] + drive[i + 1]) * direction - friction
            found[start - i] = direction * max(v, 0.0)
        end = at
    if end >= 0:
        j = start + way
        while j != end:
            out[j] = found[abs(j - start)]
            j += way
    return end


def restored_kinks(motion: SmoothedMotion, phases: SlipPhases) -> np.ndarray:
    """Velocity (n,), per sample, with its kinks at sticking onsets and break-aways, which a filter rounds off.

    From some filter widths off a kink the acceleration is continued unchanged, except for the change of the
    drive: friction is taken as constant over so short a distance. Between the two sides the body rests.
    """
    out, clear, n = motion.velocity.copy(), int(np.ceil(KINK_WIDTHS * motion.width)) + 1, motion.velocity.size
    begins, ends = np.floor(phases.end).astype(int), np.ceil(phases.break_away).astype(int)
    until = np.append(phases.end[1:], n - 1.0)
    fits = (begins - clear >= np.maximum(phases.start + clear, 1.0)) & (ends + clear <= until - clear)
    for k in np.flatnonzero(fits & (ends + clear < n - 1)):
        past, before = begins[k] + clear, ends[k] - clear
        stop = _extrapolate(out, motion, begins[k] - clear, past, begins[k], phases.direction[k])
        leave = _extrapolate(out, motion, ends[k] + clear, before, ends[k] - 1, phases.next_direction[k])
        if stop >= 0 and leave >= 0 and past >= before:
            out[stop : leave + 1] = 0.0
            continue
        if stop >= 0:
            out[stop : min(past, ends[k])] = 0.0
        if leave >= 0:
            out[max(before, begins[k]) + 1 : leave + 1] = 0.0
    return out


@compiled
def sticking_onsets(
    phases: SlipPhases, velocity: np.ndarray, forces: Forces, rate: float, width: float, search: float
) -> np.ndarray:
    """Times (k,) at which the slip phases end, in samples; as given where a phase is too short to integrate, and at the
    end of a record in motion, which is not an event.

    Args:
        phases: of sliding motion.
        velocity: smoothed, (n,).
        forces: on the mass.
        rate: step / mass, change of velocity that one N makes in one sample.
        width: of the filter of the velocity, in samples.
        search: largest correction of a time, in samples.
    """
    push, level = forces.push, forces.level
    out, clear = phases.end.copy(), int(np.ceil(KINK_WIDTHS * width)) + 1
    for k in range(phases.end.size):
        i = int(np.floor(phases.end[k])) - clear
        ends_in_motion = phases.next_direction[k] == 0.0 and phases.break_away[k] <= phases.end[k]
        if ends_in_motion or i < phases.start[k] + clear or i < 1:
            continue
        h = phases.direction[k]
        # The filter has added half its width squared times the curvature of the velocity.
        curvature = (push[i + 1] - push[i - 1]) * h - (level[i + 1] - level[i - 1])
        v = velocity[i] * h - 0.25 * width**2 * curvature * rate
        if v <= 0.0:
            continue
        last = min(int(np.ceil(phases.end[k] + search)) + 1, push.size - 1)
        before = (push[i] * h - level[i]) * rate
        found = -1.0
        while i < last:
            after = (push[i + 1] * h - level[i + 1]) * rate
            gained = 0.5 * (before + after)
            if v + gained <= 0.0:
                # Linear between the rows: v + before s + (after - before) s^2 / 2 = 0.
                root = before * before - 2.0 * (after - before) * v
                found = i + 2.0 * v / (-before + np.sqrt(max(root, 0.0)))
                break
            v += gained
            before = after
            i += 1
        if found >= 0.0:
            latest = phases.break_away[k] if phases.break_away[k] > phases.end[k] else np.inf
            out[k] = min(max(found, phases.end[k] - search), phases.end[k] + search, latest)
    return out


@compiled
def break_away_times(phases: SlipPhases, forces: Forces, search: float) -> np.ndarray:
    """Times (k,) from which friction no longer holds the body, in samples.

    A stick phase continues at least until the push reaches the level: the smoothed velocity starts before.
    """
    push, level, given = forces.push, forces.level, phases.break_away
    out = given.copy()
    for k in range(given.size):
        if given[k] <= phases.end[k]:
            continue
        i, h = max(0, int(np.floor(given[k]))), phases.next_direction[k]
        while i < push.size - 1 and i < given[k] + search:
            here, there = push[i] * h - level[i], push[i + 1] * h - level[i + 1]
            if there >= 0.0:
                if here < 0.0:
                    out[k] = max(given[k], i + here / (here - there))
                break
            i += 1
            out[k] = min(float(i), given[k] + search)
    return out


class Onsets(NamedTuple):
    """Sticking onsets: times in samples, ascending, and direction of the motion that each ends, each (k,)."""

    times: np.ndarray
    direction: np.ndarray


class Slip(NamedTuple):
    """Signs that a mass slips: mean sign of the motion over each step, 0 while it sticks, and smoothed position,
    m, each (n,); and the displacement, m, at which the position shows it whatever the balance."""

    direction: np.ndarray
    position: np.ndarray
    displacement: float


def substeps_of(bristles: Elements, scale: float) -> int:
    """Substeps of a sample that the oscillation on the bristles needs; 0 where even the most are too few."""
    phase = float(np.sqrt(np.sum(bristles.stiffness) * scale))
    return 0 if phase > MOST_SUBSTEPS else int(min(MOST_SUBSTEPS, max(3, np.ceil(phase / SUBSTEP_PHASE))))


@compiled(fastmath=SUMS_IN_ANY_ORDER)
def write_presliding_friction(
    out: np.ndarray, onsets: Onsets, slip: Slip, forces: Forces, springs: Springs, scale: float, substeps: int
) -> None:
    """Write the friction between each sticking onset and the next slip into `out` (n,), which has it of rigid contact.

    Args:
        out: friction, N, mean over the step around each sample, (n,).
        onsets: of the stick phases.
        slip: their end.
        forces: on the mass.
        springs: the bristles.
        scale: step^2 / mass.
        substeps: of a sample.
    """
    push, level, n = forces.push, forces.level, out.size
    for k in range(onsets.times.size):
        i = int(np.floor(onsets.times[k] + 0.5))
        if i < 1 or i >= n - 1:
            continue
        springs.force[:] = onsets.direction[k] * level[i] * springs.limit
        force = np.sum(springs.force)
        before = onsets.times[k] - (i - 0.5)
        until = int(np.floor(onsets.times[k + 1] + 0.5)) if k + 1 < onsets.times.size else n - 1
        v, left = 0.0, slip.position[i]
        first = True
        while i < min(until, n - 1):
            share = 1.0 - before if first else 1.0
            pause, total = share / substeps, 0.0
            for j in range(substeps):
                at = (before if first else 0.0) + (j + 0.5) * pause - 0.5
                now = push[i] + at * (push[i + 1] - push[i] if at > 0.0 else push[i] - push[i - 1])
                v += (now - force) * scale * pause
                total += force / substeps
                force = displace(springs, v * pause, level[i])
            out[i] = share * total + (before * onsets.direction[k] * level[i] if first else 0.0)
            first = False
            i += 1
            # Sliding: by the balance and by the position, or by the position alone, clearly.
            if abs(slip.direction[i]) > 0.999:
                slips = v * slip.direction[i] > 0.0
                for b in range(springs.force.size):
                    slips &= abs(springs.force[b]) == level[i - 1] * springs.limit[b]
                if slips or abs(slip.position[i] - left) > slip.displacement:
                    break
