"""What a driven stage really does, and its motion in steps of 1 us."""

from typing import NamedTuple

import numpy as np
from numba import njit

STEP = 1e-6
SPACING, HEIGHT, BIAS = 0.046, 0.02, 75.0
LOOPS = 40
LOOP_SUM = float(np.sum(np.exp(-(np.arange(LOOPS) + 0.5) / 10.0)))


class Truth(NamedTuple):
    """SI units, voltages in V; zero switches a law off.

    `slip` is what the contact holds at rest and at the bias, N, zero for a contact that never slips; it goes with the
    load to `load_exponent`. `press` is how far the tip is pressed in at the bias. Parts (`hysteresis`, `loop`, `creep`,
    `mismatch`, `contact_asymmetry`, `wave`, `asymmetry`, `ring_share`, `run_in`, `pads_unloaded`) are of one.
    `memory` is how late (s) the pads' Stribeck level knows of the speed; `dwell` (N) grows as a rest goes on, in times
    of `dwell_time`, and is gone after `dwell_distance`; `warmth` is by what the pads lose per kelvin.
    """

    mass: float = 3.0
    gain: float = 1.1e-7
    stiffness: float = 8e6
    damping: float = 400.0
    press: float = 4e-6
    pads: float = 1.5
    slip: float = 0.0
    load_exponent: float = 0.0
    contact_stribeck: float = 0.0
    contact_stribeck_velocity: float = 2e-4
    contact_viscous: float = 0.0
    contact_asymmetry: float = 0.0
    contact_presliding: float = 0.0
    viscous: float = 0.0
    stribeck: float = 0.0
    stribeck_velocity: float = 1e-4
    presliding: float = 0.0
    asymmetry: float = 0.0
    cogging: float = 0.0
    cogging_pitch: float = 2e-6
    cogging_phase: float = 0.0
    wave: float = 0.0
    wave_pitch: float = 2e-6
    wave_phase: float = 0.0
    spring: float = 0.0
    bias_force: float = 0.0
    pads_unloaded: float = 0.0
    bristle_damping: float = 0.0
    memory: float = 0.0
    dwell: float = 0.0
    dwell_time: float = 0.02
    dwell_distance: float = 2e-7
    run_in: float = 0.0
    run_in_distance: float = 2e-5
    quadratic: float = 0.0
    warmth: float = 0.0
    drive_lag: float = 0.0
    drive_delay: float = 0.0
    slew: float = 0.0
    hysteresis: float = 0.0
    hysteresis_width: float = 15.0
    loop: float = 0.0
    loop_width: float = 15.0
    creep: float = 0.0
    creep_time: float = 0.3
    mismatch: float = 0.0
    ring_share: float = 0.0
    ring_frequency: float = 180.0
    ring_damping: float = 0.03


@njit(cache=True)
def _stack(volts, sample, per, p, second):
    """Stretch (m) of one stack at every step, from its voltage over bias at the samples."""
    n = (volts.size - 1) * per + 1
    out = np.empty(n)
    lagging, loop, slewing = volts[0], 0.0, volts[0]
    before = volts[0]
    slow = np.full(3, volts[0])
    yielding = np.zeros(LOOPS)
    late = round(p.drive_delay / sample * per)
    h = sample / per
    gain = p.gain * (1.0 + p.mismatch) if second else p.gain
    ring, ring_rate = volts[0], 0.0
    w = 2.0 * np.pi * p.ring_frequency
    for i in range(n):
        j = max(i - late, 0)
        row = min(j // per, volts.size - 2)
        u = volts[row] + (volts[row + 1] - volts[row]) * (j - row * per) / per
        if p.slew > 0.0:
            most = p.slew * h
            slewing += min(max(u - slewing, -most), most)
            u = slewing
        if p.drive_lag > 0.0:
            lagging += (u - lagging) * (1.0 - np.exp(-h / p.drive_lag))
            u = lagging
        du = u - before
        before = u
        # Duhem: the loop grows with the voltage, and forgets by the path.
        loop += du - abs(du) * loop / p.hysteresis_width
        stretch = u - p.hysteresis * loop
        if p.loop > 0.0:
            # Elements of dry friction, each with a place of its own at which it yields: the same way back as forth.
            for k in range(yielding.size):
                most = p.loop_width * (k + 0.5) / 10.0
                yielding[k] = min(max(yielding[k] + du, -most), most)
                stretch -= p.loop * np.exp(-(k + 0.5) / 10.0) / LOOP_SUM * yielding[k]
        for k in range(3):
            slow[k] += (u - slow[k]) * h / (p.creep_time * (0.2, 1.0, 6.0)[k])
            stretch += p.creep * (0.4, 0.35, 0.25)[k] * slow[k]
        if p.ring_share > 0.0:
            ring_rate += h * (w * w * (stretch - ring) - 2.0 * p.ring_damping * w * ring_rate)
            ring += h * ring_rate
            stretch += p.ring_share * (ring - stretch)
        out[i] = gain * stretch
    return out


@njit(cache=True)
def _move(one, two, per, h, p, push, load_of_pads, warm, out):
    x, v, v_before = 0.0, 0.0, 0.0
    lever = HEIGHT / SPACING
    tip_before = -lever * (two[0] - one[0])
    elements = 6
    widths = np.empty(elements)
    pads = np.zeros(elements)
    wound = np.zeros(elements)
    for k in range(elements):
        widths[k] = 0.15 * 1.6**k
    held = 0.0
    remembered, rested, aged, path = 0.0, 0.0, 0.0, 0.0
    for i in range(one.size):
        tip = -lever * (two[i] - one[i])
        load = max(1.0 + 0.5 * (one[i] + two[i]) / p.press, 0.0)
        # Speeds stand halfway between the steps, forces go by the speed at them: it is read half a step on.
        if i % per == 0:
            out[i // per] = x
        now = v + 0.5 * (v - v_before)
        now = now if now * v > 0.0 else 0.0
        v_before = v
        sliding = (tip - tip_before) / h - v
        slipping = (tip - tip_before) / h - now
        tip_before = tip
        if load <= 0.0:
            force = 0.0
            held = 0.0
            wound[:] = 0.0
        elif p.slip <= 0.0:
            held += p.stiffness * sliding * h
            force = held + p.damping * slipping
        else:
            speed = slipping / p.contact_stribeck_velocity
            most = (p.slip + p.contact_stribeck / (1.0 + speed * speed)) * load**p.load_exponent
            side = 1.0 if held > 0.0 else -1.0
            most *= 1.0 + p.contact_asymmetry * side
            if p.contact_presliding > 0.0:
                # Each element is a spring and a dashpot, up to what it holds.
                force = 0.0
                for k in range(elements):
                    reach, part = widths[k] * p.contact_presliding, most / elements
                    wound[k] += sliding * h
                    pull = part * wound[k] / reach + p.damping / elements * slipping
                    force += min(max(pull, -part), part)
                    wound[k] = min(max(wound[k], -reach), reach)
                held = force
            else:
                # Radial return: spring and dashpot up to what the contact holds.
                trial = held + p.stiffness * sliding * h
                force = min(max(trial + p.damping * slipping, -most), most)
                held = min(max(trial, -most), most)
            force += p.contact_viscous * slipping
        known = now
        if p.memory > 0.0:
            remembered += (v - remembered) * (1.0 - np.exp(-h / p.memory))
            known = remembered
        level = p.pads + p.stribeck / (1.0 + (known / p.stribeck_velocity) ** 2)
        if p.dwell > 0.0:
            if v == 0.0:
                rested += h
                aged = max(aged, p.dwell * rested / (rested + p.dwell_time))
            else:
                rested = 0.0
                aged *= max(1.0 - 2.0 * abs(v) * h / p.dwell_distance, 0.0)
            level += aged
        if p.run_in > 0.0:
            path += abs(v) * h
            level *= 1.0 + p.run_in / (1.0 + path / p.run_in_distance) ** 2
        level *= np.exp(-p.warmth * warm[i // per])
        way = v if v != 0.0 else force - p.spring * x - p.bias_force - push[i // per]
        level *= 1.0 + p.asymmetry * (1.0 if way > 0.0 else -1.0)
        level *= 1.0 + p.wave * np.sin(2.0 * np.pi * x / p.wave_pitch + p.wave_phase)
        if p.pads_unloaded > 0.0:
            level *= max(load_of_pads[i // per], 0.0) ** p.pads_unloaded
        other = p.viscous * now + p.quadratic * now * abs(now)
        other += p.cogging * np.sin(2.0 * np.pi * x / p.cogging_pitch + p.cogging_phase)
        other += p.spring * x + p.bias_force + push[i // per]
        if p.presliding > 0.0:
            friction = 0.0
            for k in range(elements):
                reach = widths[k] * p.presliding
                friction += level * pads[k] / reach / elements
                if p.bristle_damping > 0.0 and abs(pads[k]) < reach:
                    friction += p.bristle_damping / elements * now
            v += h * (force - other - friction) / p.mass
            for k in range(elements):
                reach = widths[k] * p.presliding
                pads[k] = min(max(pads[k] + v * h, -reach), reach)
        else:
            # Rigid: it takes away what speed it can, and no more.
            trend = v + h * (force - other) / p.mass
            lost = h * level / p.mass
            v = trend - lost if trend > lost else (trend + lost if trend < -lost else 0.0)
        x += v * h


def motion(
    truth: Truth,
    sample: float,
    first: np.ndarray,
    second: np.ndarray,
    push: np.ndarray,
    load: np.ndarray,
    warm: np.ndarray,
) -> np.ndarray:
    """Position (n,) of the stage, m, under two voltages (V) linear between samples, a push (N) against it, the pads'
    load over its mean, and how much warmer (K) they are than at first."""
    per = max(1, round(sample / STEP))
    one = _stack(first - BIAS, sample, per, truth, False)
    two = _stack(second - BIAS, sample, per, truth, True)
    out = np.zeros(first.size)
    _move(one, two, per, sample / per, truth, push, load, warm, out)
    return out
