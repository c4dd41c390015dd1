"""A model laid out for the integrator: kernels by address, what never changes as numbers, the order of the states."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sim.effects.model import Model
from sim.integration import kernels
from sim.integration.drive import Drive, delayed
from sim.integration.input_compression import merged
from sim.integration.model_kernel import FEWEST, Law, model_kernel
from sim.library.effect import Axis, Effect
from sim.library.time_domain import AddedOscillator, Backlash, DelayedSpeed, FirstOrderLag, TransportDelay
from stagecad.parameters.errors import InputError

FRICTION, FORCE = 1, 2
SCALE = 1e-3
"""Of position and velocity: an error is held below tolerance times (scale + value), m and m/s."""


@dataclass(frozen=True)
class Plan:
    """What `sim.integration.integrator.integrate` takes of a model; keep it while its addresses are in use.

    Args:
        drive: after delays.
        effects: of each effect that changes in time: kernel, parameters (addresses), what is taken of it, whether it
            sees the lagged speed; shape (effects, 4).
        groups: of the core, then of each element beside it: kernel, parameters, first state, states; shape (groups, 4).
        at_once: one kernel for all of them, and its parameters (addresses); zeros where there is none.
        elements: states of all groups.
        modes: w^2, 2 damping w, and mass of each rider; shape (riders, 3).
        base: [level, factor, force] of all that never changes, load, temperature.
        head: states before the elements: 2, or 4 where a law depends on the distance travelled or the contact age.
        rigid: mass that moves with the axis itself, kg.
        scales: of each element's state.
        gap, lag, delay: half the play times the spring, N; time constant of the drive, s; lag of the friction, s.
        memory_length: of the contact age, m.
        carried: quantities that the laws depend on.
        kernels, tables: kept alive, since the rest holds their addresses.
        row_of, group_of: row of `effects` and of `groups` that each effect of the model has.
    """

    drive: Drive
    effects: np.ndarray
    groups: np.ndarray
    at_once: np.ndarray
    elements: int
    modes: np.ndarray
    base: np.ndarray
    head: int
    rigid: float
    scales: np.ndarray
    gap: float
    lag: float
    delay: float
    memory_length: float
    carried: frozenset[str]
    kernels: list[kernels.Kernel]
    tables: list[np.ndarray]
    row_of: dict[int, int]
    group_of: dict[int, int]

    def body(self, memory_length: float) -> tuple[float, ...]:
        """1 / mass, spring, feedback, memory length, half the play in N, lag of the drive, lag of the friction."""
        feedback = 0.0 if self.drive.prescribes else 1.0
        per_mass = 1.0 if self.drive.prescribes else 1.0 / self.rigid
        return (per_mass, float(self.drive.stiffness), feedback, float(memory_length), self.gap, self.lag, self.delay)

    def shape(self, size: int) -> tuple[int, int] | None:
        """States of the head and of the elements; None for the plain axis, one bristle and no more, whose code is
        compiled for it."""
        plain = (
            size == 3 and self.elements == self.groups[0, 3] == 1 and self.head == 2 and self.gap == self.delay == 0.0
        )
        return None if plain else (self.head, self.elements)

    def merged(self, begin: float, end: float, tolerance: float) -> Plan:
        """The plan with pieces of its drive joined that the tolerance cannot tell apart; not with a play, which is
        opened and closed by the force itself."""
        if self.gap > 0.0:
            return self
        drive = merged(self.drive, begin, end, self.rigid, tolerance, SCALE)
        return self if drive is self.drive else replace(self, drive=drive)

    def start(
        self, position: float, velocity: float, bristle: Any, tolerance: float, energy: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """Initial state and absolute tolerance of every state, in the integrator's order; a rider starts in step."""
        lagged = self.lag > 0.0
        size = self.head + self.elements + 2 * self.modes.shape[0] + int(lagged) + (3 if energy else 0)
        start, absolute = np.zeros(size), np.full(size, tolerance * SCALE)
        start[0], start[1] = position, velocity
        if self.head > 2:
            absolute[2] = tolerance * SCALE if "travelled" in self.carried else math.inf
            absolute[3] = tolerance if "contact_age" in self.carried else math.inf
        at = self.head + self.elements
        if bristle is not None:
            given = np.atleast_1d(np.asarray(bristle, dtype=float))
            start[self.head : self.head + given.size] = given
        absolute[self.head : at] = tolerance * self.scales
        for square, damping, _ in self.modes:
            start[at], start[at + 1] = position - damping / square * velocity, velocity
            at += 2
        if lagged:
            amplitude, _, phase = self.drive.wave
            start[at] = self.drive.values[0] + amplitude * math.cos(phase)
            absolute[at] = tolerance * max(float(np.abs(self.drive.values).max()), amplitude, 1e-3)
        return start, absolute


def plan_of(model: Model, drive: Drive, mass: float, load: float, temperature: float, whole: bool = False) -> Plan:
    """Lay a model out for the integrator; `whole` keeps the effects that never change among those that do.

    Raises:
        InputError: an effect that cannot be integrated, or not with this drive.
    """
    for effect in model.effects:
        reason = kernels.unsupported(effect)
        if reason:
            raise InputError(f"simulation: effect '{effect.name}' {reason}")
    acting = list(zip(model.effects, model.values))
    tables = [np.array(p if len(p) else (0.0,), dtype=float) for _, p in acting]
    kept: list[kernels.Kernel] = []
    rows: list[tuple[int, int, int, int]] = []
    row_of: dict[int, int] = {}
    group_of: dict[int, int] = {}
    groups: list[tuple[int, int, int, int]] = [(0, 0, 0, 0)]
    scales: list[float] = []
    modes: list[tuple[float, float, float]] = []
    carried: set[str] = set()
    base = np.array([0.0, 1.0, 0.0, load, temperature])
    gap, lag, delay, ridden = 0.0, 0.0, 0.0, 0.0
    for effect, p in acting:
        part = effect.time_domain(p) if effect.time_domain is not None else None
        if isinstance(part, (Backlash, FirstOrderLag, TransportDelay)) and drive.prescribes:
            raise InputError(
                f"simulation: effect '{effect.name}' acts on a drive, and here the motion itself is imposed"
            )
        if isinstance(part, Backlash):
            if not drive.stiffness > 0.0:
                raise InputError(f"simulation: effect '{effect.name}' needs a drive that pulls a spring")
            gap += 0.5 * part.gap * drive.stiffness
        elif isinstance(part, FirstOrderLag):
            if lag > 0.0:
                raise InputError("simulation: one lag of the drive at most")
            lag = part.time_constant
        elif isinstance(part, TransportDelay):
            drive = delayed(drive, part.delay)
        elif isinstance(part, DelayedSpeed):
            delay += part.delay
        elif isinstance(part, AddedOscillator):
            w = 2.0 * math.pi * part.frequency
            modes.append((w * w, 2.0 * part.damping * w, part.mass_ratio * mass))
            ridden += part.mass_ratio
    if ridden >= 1.0:
        raise InputError(f"simulation: {ridden:g} of the mass rides on modes; must be below 1")
    count = 0
    for i, ((effect, p), table) in enumerate(zip(acting, tables)):
        if effect.friction_state is not None or effect.parallel_element is not None:
            declared = effect.friction_state or effect.parallel_element
            kernel = kernels.core_kernel(effect)
            kept.append(kernel)
            n = int(declared.elements(p))
            if effect.friction_state is not None and groups[0][3] == 0:
                if count:
                    groups = [groups[0], *[(a, q, first + n, m) for a, q, first, m in groups[1:]]]
                groups[0] = (kernel.address, table.ctypes.data, 0, n)
                group_of[i] = 0
                scales = [float(declared.scale(p))] * n + scales
            else:
                group_of[i] = len(groups)
                groups.append((kernel.address, table.ctypes.data, count, n))
                scales += [float(declared.scale(p))] * n
            count += n
        friction, force = kernels.takes(effect)
        if not (friction or force):
            continue
        if kernels.is_constant(effect) and not whole:
            _fold(effect, p, base)
            continue
        carried |= kernels.carried(effect)
        row_of[i] = len(rows)
        kernel = kernels.effect_kernel(effect, p)
        kept.append(kernel)
        row = (kernel.address, table.ctypes.data)
        sees_lag = _sees_lag(effect, delay)
        if sees_lag and force:
            rows += [(*row, FRICTION, 1), (*row, FORCE, 0)]
        else:
            rows.append((*row, FRICTION * friction + FORCE * force, int(sees_lag)))
    head = 4 if carried & {"travelled", "contact_age"} else 2
    at_once = np.zeros(2, dtype=np.int64)
    if len(row_of) + len(group_of) >= FEWEST and all(kernel.compiled for kernel in kept):
        # The core's elements stand first.
        order = sorted({*row_of, *group_of}, key=lambda i: group_of.get(i) != 0)
        kernel = model_kernel(tuple(_law(*acting[i], i in row_of, group_of.get(i, -1), delay) for i in order), head)
        if kernel is not None:
            kept.append(kernel)
            tables.append(np.concatenate([tables[i][: len(model.values[i])] for i in order] + [np.zeros(1)]))
            at_once[:] = kernel.address, tables[-1].ctypes.data
    return Plan(
        drive=drive,
        effects=np.array(rows, dtype=np.int64).reshape(-1, 4),
        groups=np.array(groups, dtype=np.int64),
        at_once=at_once,
        elements=count,
        modes=np.array(modes, dtype=float).reshape(-1, 3),
        base=base,
        head=head,
        rigid=mass * (1.0 - ridden),
        scales=np.array(scales),
        gap=gap,
        lag=lag,
        delay=delay,
        memory_length=next((p.memory_length for _, p in acting if hasattr(p, "memory_length")), math.inf),
        carried=frozenset(carried),
        kernels=kept,
        tables=tables,
        row_of=row_of,
        group_of=group_of,
    )


def _sees_lag(effect: Effect, delay: float) -> bool:
    return delay > 0.0 and any(kernels.depends_on(effect, law, "velocity") for law in ("level", "factor"))


def _law(effect: Effect, p: Any, taken: bool, group: int, delay: float) -> Law:
    """What the kernel of the whole model takes of an effect."""
    friction, force = kernels.takes(effect) if taken else (False, False)
    wanted = {"level": friction, "factor": friction, "force": force}
    declared = effect.friction_state or effect.parallel_element
    return Law(
        effect.name,
        kernels.is_held(effect, p),
        tuple(law for law, is_wanted in wanted.items() if is_wanted and getattr(effect, law) is not None),
        _sees_lag(effect, delay),
        int(declared.elements(p)) if group >= 0 else 0,
        group > 0,
    )


def _fold(effect: Effect, p: Any, base: np.ndarray) -> None:
    """Add an effect that never changes to the numbers that never change."""
    axis = Axis(0.0, 0.0, 0.0, math.nan, base[3], base[4], 0.0, math.nan, 0.0, 1.0)
    if effect.level is not None:
        base[0] += effect.level(axis, p)
    if effect.factor is not None:
        base[1] *= effect.factor(axis, p)
    if effect.force is not None:
        base[2] += effect.force(axis, p)
