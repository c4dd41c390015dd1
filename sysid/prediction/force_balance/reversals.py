"""Times of velocity reversals and sticking onsets from a noisy position, and event-resolved friction.

Where friction jumps, the acceleration does, and smoothing the position over that kink shifts the zero of the velocity
by up to half the filter's width. At ten reversals a second that shift, times twice the Coulomb force, would be the
largest error of a force balance. Here each event is fitted by two pieces that meet at rest. With the known drive
acceleration u(t) integrated twice from t0, U(t; t0), and a friction that is constant on each side,

    x = x0 + U + a1 (t - t0)^2 / 2  before t0,   x0 + U + a2 (t - t0)^2 / 2  after,   or x0 after: it sticks,

so that t0 is free of that bias, to a few hundredths of a sampling step.

Sticking onsets and break-away of a driven mass follow from its own momentum and friction. The smoothed velocity is
disturbed within some filter widths of a kink of the motion. From outside that range the balance m v' = applied -
friction is integrated to v = 0. The error of that time is an error of momentum, no larger than the velocity's noise and
the model's own misfit over the distance: the filtered balance across a sticking onset is then as accurate as away from
it, for any force.

After the onset a presliding contact lets the mass oscillate on its bristles. The position's noise hides their stretch;
the force does not need it: with all bristles stretched one way at the onset, m x'' = push - friction(x) is integrated
in small steps, the bristles being parallel ideal springs that each yield at an individual stretch (Iwan, J. Appl.
Mech. 33 (1966) 893), until all have yielded and the mass slips.
"""

from typing import NamedTuple

import numpy as np

from sim.numerics.compilation import SUMS_IN_ANY_ORDER, compiled
from sim.numerics.elasto_plastic import Elements, Springs, displace
from sysid.signals import runs

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
    end = -1
    found = np.zeros(abs(limit - start) + 1)
    for i in range(start + way, limit + way, way):
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
        for i in range(start - 1, at, -1):
            v -= 0.5 * (drive[i] + drive[i + 1]) * direction - friction
            found[start - i] = direction * max(v, 0.0)
        end = at
    for j in range(start + way, end if end >= 0 else start + way, way):
        out[j] = found[abs(j - start)]
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

    The `velocity` (n,) was smoothed over a `width` of samples; one N changes it by `rate`, step / mass, in a sample. A
    time is corrected by at most `search` samples.
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
    out: np.ndarray,
    onsets: np.ndarray,
    sides: np.ndarray,
    slip: Slip,
    forces: Forces,
    springs: Springs,
    scale: float,
    substeps: int,
) -> None:
    """Write the friction, N, mean over the step around each sample, between each sticking onset and the next slip into
    `out` (n,), which has it of rigid contact.

    The `onsets` (k,) are in samples, ascending, and `sides` the directions of the motion before them; `springs` are the
    bristles, `scale` is step^2 / mass, and each sample is integrated in `substeps`.
    """
    push, level, n = forces.push, forces.level, out.size
    for k in range(onsets.size):
        i = int(np.floor(onsets[k] + 0.5))
        if i < 1 or i >= n - 1:
            continue
        springs.force[:] = sides[k] * level[i] * springs.limit
        force = np.sum(springs.force)
        before = onsets[k] - (i - 0.5)
        until = int(np.floor(onsets[k + 1] + 0.5)) if k + 1 < onsets.size else n - 1
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
            out[i] = share * total + (before * sides[k] * level[i] if first else 0.0)
            first = False
            i += 1
            # Sliding: by the balance and by the position, or by the position alone, clearly.
            if abs(slip.direction[i]) > 0.999:
                slips = v * slip.direction[i] > 0.0
                for b in range(springs.force.size):
                    slips &= abs(springs.force[b]) == level[i - 1] * springs.limit[b]
                if slips or abs(slip.position[i] - left) > slip.displacement:
                    break


@compiled
def _squared_error(window: np.ndarray, once: np.ndarray, twice: np.ndarray, t0: float) -> float:
    """Least sum of squares of two pieces that meet at rest at t0, in samples, in a window of the position (m,), by the
    first and second integral of the drive over it, (m,); infinite where it is not determined."""
    n, k = window.size, int(t0)
    f = t0 - k
    rate = once[k] + f * (once[min(k + 1, n - 1)] - once[k])
    base = twice[k] + f * once[k] + 0.5 * f * (rate - once[k])
    s_b, s_bb, s_a, s_aa, y_b, y_a = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    y_1, yy, r_1, rr, p_1, pp = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
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
            p_1 += y
            pp += y * y
            s_a += q
            s_aa += q * q
            y_a += q * y
            r_1 += window[i]
            rr += window[i] ** 2
    if s_bb <= 0.0 or s_aa <= 0.0:
        return np.inf
    # Reversal: two curvatures that do not overlap are eliminated, then x0 is solved for.
    determinant = n - s_b * s_b / s_bb - s_a * s_a / s_aa
    moving = np.inf
    if determinant > 1e-9:
        x0 = (y_1 + p_1 - s_b * y_b / s_bb - s_a * y_a / s_aa) / determinant
        moving = yy + pp - x0 * (y_1 + p_1) - (y_b - s_b * x0) / s_bb * y_b - (y_a - s_a * x0) / s_aa * y_a
    # Sticking: one curvature before, none after.
    determinant = n - s_b * s_b / s_bb
    staying = np.inf
    if determinant > 1e-9:
        x0 = (y_1 + r_1 - s_b * y_b / s_bb) / determinant
        staying = yy + rr - x0 * (y_1 + r_1) - (y_b - s_b * x0) / s_bb * y_b
    # One more curvature explains a little noise by itself.
    return min(moving, staying * (1.0 - 1.0 / n))


@compiled
def event_times(position: np.ndarray, drive: np.ndarray, events: np.ndarray, reach: int, search: float) -> np.ndarray:
    """Times (k,), in samples, at which the velocity around each event is zero.

    Args:
        position: measured, unfiltered, (n,).
        drive: known force over mass, in position units per sample squared, (n,); zeros where not known.
        events: first guesses, in samples, (k,); the result where the window would leave the record.
        reach: samples on each side that are fitted.
        search: largest distance from the guess, in samples: on a grid of a quarter, then of a 1/32 sample.
    """
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
                error = _squared_error(window, once, twice, t0)
                if error < best:
                    best = error
                    out[k] = low + t0
            middle, width, spacing = out[k] - low, spacing, 0.03125
    return out


class ResolvedMotion(NamedTuple):
    """Direction of a motion with its changes at the times of the events."""

    # sign of the velocity, averaged over the step around each sample, (n,), in [-1, 1]; 0 while sticking
    direction: np.ndarray
    stick_fraction: np.ndarray  # part of the step around each sample spent sticking, (n,), in [0, 1]
    reversals: np.ndarray  # times of the reversals without sticking, in samples, (k,)
    reversed_to: np.ndarray  # direction after each, 1 or -1, (k,)


def resolve_events(
    position: np.ndarray,
    velocity: np.ndarray,
    drive: np.ndarray,
    resting: np.ndarray,
    reach: int,
    search: float,
    shortest: int,
) -> tuple[ResolvedMotion, SlipPhases]:
    """Direction of motion with its changes where they happened, and the phases of sliding motion; `reach` and `search`
    as of `event_times`, and a motion below `shortest` samples is noise."""
    n = velocity.size
    sign = np.where(resting, 0.0, np.sign(velocity))
    # Noise at rest is detected as motion for a sample or two.
    for start, stop in runs(sign != 0.0):
        if stop - start < shortest:
            sign[start:stop] = 0.0
    moving = np.flatnonzero(sign)
    direction, stick_fraction = np.zeros(n), np.zeros(n)
    if moving.size == 0:
        none = np.empty(0)
        return ResolvedMotion(direction, np.ones(n), none, none), SlipPhases(none, none, none, none, none)
    # One slip phase ends at sample i, and the next begins at sample j.
    last, first = moving[:-1], moving[1:]
    ends = np.flatnonzero((first - last > 1) | (sign[first] != sign[last]))
    i, j = last[ends], first[ends]
    through = j - i == 1
    fall = np.where(through, velocity[i] / np.where(through, velocity[i] - velocity[j], 1.0), 0.5)
    position, drive = np.ascontiguousarray(position), np.ascontiguousarray(drive)
    times = event_times(position, drive, (i + fall).astype(float), reach, search)
    starts = np.where(through, times, np.maximum(j - 0.5, times))
    start = -0.5
    if moving[0] > 0:
        _add(stick_fraction, start, moving[0] - 0.5, 1.0)
        start = moving[0] - 0.5
    for stop, following, side in zip(times.tolist(), starts.tolist(), sign[i].tolist(), strict=True):
        _add(direction, start, stop, side)
        _add(stick_fraction, stop, following, 1.0)
        start = max(following, stop)
    end = float(moving[-1]) + 0.5
    _add(direction, start, end, float(sign[moving[-1]]))
    _add(stick_fraction, end, n - 0.5, 1.0)
    reversals, reversed_to = times[through], sign[j[through]]
    # A slow motion that is lost in the noise for a while does not end; the last phase does, with nothing after it.
    ended = np.append((starts > times) | (sign[i] != sign[j]), True)
    times, starts = np.append(times, end)[ended], np.append(np.maximum(starts, times), n - 0.5)[ended]
    began = np.concatenate([moving[:1] - 0.5, starts[:-1]])
    sides, following = np.append(sign[i], sign[moving[-1]])[ended], np.append(sign[j], 0.0)[ended]
    phases = SlipPhases(began, times, sides, starts, following)
    return ResolvedMotion(direction, stick_fraction, reversals, reversed_to), phases


def shifted_events(
    direction: np.ndarray, stick_fraction: np.ndarray, phases: SlipPhases, onsets: np.ndarray, break_aways: np.ndarray
) -> ResolvedMotion:
    """The motion, of a direction (n,) and stick fraction (n,), with its events at other times."""
    direction, stick_fraction = direction.copy(), stick_fraction.copy()
    through, next_direction = phases.reverses, phases.next_direction
    _shift(direction, stick_fraction, phases.end, onsets, phases.direction, np.where(through, next_direction, 0.0))
    sticks = ~through
    before = np.zeros(sticks.sum())
    old, new = phases.break_away[sticks], break_aways[sticks]
    _shift(direction, stick_fraction, old, new, before, next_direction[sticks])
    return ResolvedMotion(direction, stick_fraction, onsets[through], next_direction[through])


@compiled
def _shift(
    direction: np.ndarray,
    stick_fraction: np.ndarray,
    old: np.ndarray,
    new: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
) -> None:
    """Correct the steps between old and new times of events (k,), by the direction before and after; 0 for sticking."""
    for k in range(old.size):
        way = 1.0 if new[k] > old[k] else -1.0
        still = (1.0 if before[k] == 0.0 else 0.0) - (1.0 if after[k] == 0.0 else 0.0)
        low, high = min(old[k], new[k]), max(old[k], new[k])
        _add(direction, low, high, way * (before[k] - after[k]))
        _add(stick_fraction, low, high, way * still)


@compiled
def event_resolved_friction(motion: ResolvedMotion, forces: Forces, stretch: float, scale: float) -> np.ndarray:
    """Coulomb friction (n,) of a driven mass, N, before any filter.

    While the mass moves, the level against the motion; while it sticks, the push, up to the level. After a reversal the
    bristle that was stretched one way is integrated to the other, from rest, in sixteenths of a sample: it passes its
    2 `stretch` in a fraction of a sample where the drive is strong, and holds the mass where it is weak, for a time too
    short for the position to show, but not for the balance. It slips at a displacement of `stretch`, m; `scale` is
    step^2 / mass.
    """
    direction, stick_fraction, level, applied = motion.direction, motion.stick_fraction, forces.level, forces.push
    n = direction.size
    out = np.empty(n)
    for i in range(n):
        out[i] = stick_fraction[i] * min(level[i], max(-level[i], applied[i])) + direction[i] * level[i]
    parts = 16
    for k in range(motion.reversals.size):
        t0, side = motion.reversals[k], motion.reversed_to[k]
        i = int(np.floor(t0 + 0.5))
        if i < 0 or i >= n:
            continue
        gone, speed = 0.0, 0.0
        before = t0 - (i - 0.5)
        slipped = False
        first = True
        while i < n and not slipped:
            share = 1.0 - before if first else 1.0
            if not first and direction[i] * side < 0.999:
                break
            g, u = level[i], applied[i] * side
            if g <= 0.0:
                break
            total = 0.0
            pause = share / parts
            for _ in range(parts):
                force = g * min(1.0, gone / stretch - 1.0)
                push = u - force
                if u < g:
                    # Sticking: the bristle, well damped, rests where it balances the push.
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
            out[i] = side * (share * total - (before * g if first else 0.0))
            first = False
            i += 1
    return out


@compiled
def write_sharp_steps(
    friction: np.ndarray, forces: Forces, times: np.ndarray, before: np.ndarray, after: np.ndarray
) -> None:
    """Correct `friction` (n,) beside events at `times` (k,), between directions `before` and `after`, 0 while sticking.

    With means over the steps a change at t0 = i + d between two smooth signals has the right moment 0, as a sum over
    the samples. With three samples

        w(i - 1) = 1 + c,  w(i) = d + 1/2 - d^3/3,  w(i + 1) = d^3/6 + d^2/4 - 1/24,  c = d^3/6 - d^2/4 + 1/24

    of the signal before the change it has the right moments 0 to 2 (Euler-Maclaurin), so that a filter blurs it no
    more than the acceleration.
    """
    for k in range(times.size):
        i = int(np.floor(times[k] + 0.5))
        if i < 1 or i > friction.size - 2:
            continue
        d = times[k] - i
        cube, square = d**3 / 6.0, d**2 / 4.0 - 1.0 / 24.0
        for j, weight in ((i - 1, cube - square), (i, -2.0 * cube), (i + 1, cube + square)):
            held = min(forces.level[j], max(-forces.level[j], forces.push[j]))
            was = before[k] * forces.level[j] if before[k] != 0.0 else held
            becomes = after[k] * forces.level[j] if after[k] != 0.0 else held
            friction[j] += weight * (was - becomes)


@compiled
def _add(cells: np.ndarray, start: float, stop: float, value: float) -> None:
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
