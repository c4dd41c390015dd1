"""One axis in time: semi-implicit steps of set-valued friction (Moreau 1988), prescribed, on a spring, or driven.

Each step takes forces at the middle of the free motion and solves m (w - v) / h + c (v + w) / 2 + level Sign(w) = push
for the new velocity w: w = 0 where the level exceeds what is left of push and momentum, otherwise it opposes w exactly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from .friction_laws import Bristles, Law, State
from .machines import FINEST, Machine


@dataclass
class Chain:
    """What lies between command and axis: lag and delay (s) of the drive, gap and its softness (m) of the pull."""

    lag: float = 0.0
    delay: float = 0.0
    gap: float = 0.0
    soft: float = 1e-3


@dataclass(frozen=True)
class Motion:
    """Reference motion and channels of one record, each (rows,); `command` (N) in place of a controller where given."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    load: np.ndarray
    temperature: np.ndarray
    command: np.ndarray | None = None


@dataclass(frozen=True)
class Run:
    """What came out at every row: `force` is friction force, spring force or logged command; `side` is 0 at rest."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    force: np.ndarray
    side: np.ndarray


class _Sum:
    """Level, opposing force and bristles of a set of laws."""

    def __init__(self, coulomb: float, laws: Sequence[Law]) -> None:
        self.coulomb, self.laws = coulomb, laws
        self.levels = [law.value for law in laws if law.place == "level"]
        self.factors = [law.value for law in laws if law.place == "factor"]
        self.forces = [law.value for law in laws if law.place == "force"]
        self.bristles = next((law for law in laws if isinstance(law, Bristles)), None)

    def level(self, s: State) -> float:
        value = self.coulomb
        for law in self.levels:
            value += law(s)
        for law in self.factors:
            value *= law(s)
        return max(float(value), 0.0)

    def force(self, s: State) -> float:
        value = 0.0
        for law in self.forces:
            value += law(s)
        return float(value)

    def advance(self, s: State, v: float, dx: float, h: float) -> None:
        s.v = v
        s.travelled += abs(dx)
        s.t += h
        if v * s.side < 0.0:
            s.side, s.turned = -s.side, 0.0
        s.turned += abs(dx)
        if self.bristles:
            self.bristles.moved(dx)
        for law in self.laws:
            law.advance(s, h)


def _lists(motion: Motion, dt: float) -> list[list[float]]:
    """Position, velocity, acceleration, load, temperature and its rate as lists of floats, for speed."""
    rows = (motion.position, motion.velocity, motion.acceleration, motion.load, motion.temperature)
    return [y.tolist() for y in (*rows, np.gradient(motion.temperature, dt))]


def run_prescribed(m: Machine, motion: Motion, laws: Sequence[Law]) -> Run:
    """Friction force along a prescribed motion; at rest the force keeps its last value below the level."""
    n, h = m.rows, m.step
    total, s = _Sum(m.coulomb, laws), State()
    moving = motion.velocity[motion.velocity != 0.0]
    s.side = 1.0 if moving.size and moving[0] > 0.0 else -1.0
    held = s.side * np.inf
    force, side = np.zeros(n), np.zeros(n)
    place, speed, rate, load, warmth, warming = _lists(motion, h)
    for k in range(n):
        v, s.x, s.v, s.rate = speed[k], place[k], speed[k], rate[k]
        s.load, s.temperature, s.warming = load[k], warmth[k], warming[k]
        if v * s.side < 0.0:
            s.side, s.turned = -s.side, 0.0
        level = total.level(s)
        if total.bristles:
            friction = level * total.bristles.value(s) + total.bristles.drag(v)
        else:
            held = level * s.side if v != 0.0 else min(max(held, -level), level)
            friction = held
        force[k] = friction + m.viscous * v + total.force(s)
        side[k] = (v > 0.0) - (v < 0.0)
        total.advance(s, v, place[min(k + 1, n - 1)] - place[k], h)
    return Run(motion.position, motion.velocity, motion.acceleration, force, side)


def transmitted(stretch: float, stiffness: float, chain: Chain) -> float:
    """Force of a spring with a gap whose edges are rounded over `soft`."""
    if not chain.gap:
        return stiffness * stretch
    beyond = (abs(stretch) - 0.5 * chain.gap) / chain.soft
    rounded = chain.soft * (beyond if beyond > 30.0 else float(np.log1p(np.exp(beyond))))
    return stiffness * rounded * (1.0 if stretch > 0.0 else -1.0)


def run_driven(m: Machine, motion: Motion, laws: Sequence[Law], chain: Chain) -> Run:
    """The axis pulled by a spring (`spring-pull`), or by a force that a sampled controller or a table commands."""
    n, dt = m.rows, m.step
    steps = max(1, ceil(dt / FINEST))
    h = dt / steps
    total, s = _Sum(m.coulomb, laws), State()
    out, mass = np.zeros((5, n)), m.mass - sum(getattr(law, "mass", 0.0) for law in laws)
    kp, kd, ki = m.mass * m.bandwidth**2, 1.6 * m.mass * m.bandwidth, 0.1 * m.mass * m.bandwidth**3
    place, speed, rate, load, warmth, warming = _lists(motion, dt)
    command = [0.0] * n if motion.command is None else motion.command.tolist()
    drive, before, integral, late, follow = 0.0, 0.0, 0.0, round(chain.delay / h), 1.0
    if chain.lag:
        follow = float(-np.expm1(-h / chain.lag))
    pulled, x, v, bristles = m.rig == "spring-pull", 0.0, 0.0, total.bristles
    for k in range(n):
        nxt = min(k + 1, n - 1)
        s.load, s.temperature, s.warming = load[k], warmth[k], warming[k]
        target, ahead = place[k], place[nxt]
        if pulled:
            command[k] = transmitted(target - x, m.stiffness, chain)
        elif motion.command is None:
            error = target - x
            integral = (integral + ki * error * dt) * (1.0 - dt / 2.0)
            command[k] = kp * error + kd * (speed[k] - v) + integral + m.mass * rate[k]
        out[0, k], out[1, k] = x, v
        for j in range(steps):
            middle = x + 0.5 * h * v
            if pulled:
                part = (j + 0.5) / steps
                drive = transmitted(target + part * (ahead - target) - middle, m.stiffness, chain)
            else:
                wanted = command[max(k * steps + j - late, 0) // steps]
                before = drive
                drive += (wanted - drive) * follow
            # The velocity in the middle of the step as the last step's acceleration has it, but for a reversal.
            ahead_v = v + 0.5 * h * s.rate
            s.x, s.v = middle, ahead_v if ahead_v * v > 0.0 else v
            level = total.level(s)
            push = (0.5 * (before + drive) if chain.lag else drive) - total.force(s)
            if bristles:
                push -= level * bristles.value(s) + bristles.drag(v)
                level = 0.0
            free = (mass / h - 0.5 * m.viscous) * v + push
            if free > level:
                w = (free - level) / (mass / h + 0.5 * m.viscous)
            elif free < -level:
                w = (free + level) / (mass / h + 0.5 * m.viscous)
            else:
                w = 0.0
            s.rate = (w - v) / h
            if j == 0:
                out[2, k] = s.rate
                out[4, k] = (w > 0.0) - (w < 0.0)
            dx = 0.5 * h * (v + w)
            x, v = x + dx, w
            total.advance(s, w, dx, h)
    out[3] = command
    return Run(out[0], out[1], out[2], out[3], out[4])


def run_axis(m: Machine, motion: Motion, laws: Sequence[Law], chain: Chain) -> Run:
    """One record of a machine's axis."""
    if m.rig == "velocity-drive":
        return run_prescribed(m, motion, laws)
    return run_driven(m, motion, laws, chain)
