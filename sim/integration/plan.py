"""A model laid out for the integrator: kernels by address, constant terms as numbers, the order of the states."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from sim.effects.catalogue import Model
from sim.effects.effect import AddedOscillator, Axis, Backlash, DelayedSpeed, Effect, FirstOrderLag, TransportDelay
from sim.integration.compiled import kernels
from sim.integration.drive import Drive, compressed, delayed
from sim.integration.problem import FORCE, FRICTION, WORKS, Body, Input, Laws, Layout, Problem, Tolerance
from stagecad.parameters.errors import InputError, require

SCALE = 1e-3
"""Scale of position and velocity, m and m/s: an error is kept below tolerance times (scale + value)."""


@dataclass(frozen=True)
class Plan:
    """A model with its drive, laid out for the integrator; keep it while its addresses are in use."""

    drive: Drive  # after delays
    laws: Laws  # kernels and constants
    # states before the friction elements: 2, or 4 where a law depends on the distance travelled or the contact age
    head: int
    scales: np.ndarray  # typical size of each element's state, (elements,)
    axis: _Mechanics  # realisation of the effects of drive, structure and memory
    memory_length: float  # of the contact age, m
    ages_by_slip: bool  # of the friction state model's first element
    required: frozenset[str]  # quantities of the axis that the laws depend on
    # kernels, tables: owners of the memory that `laws` has the addresses of
    kernels: list[kernels.Kernel]
    tables: list[np.ndarray]

    @property
    def elements(self) -> int:
        return self.scales.size

    def compressed(self, begin: float, end: float, tolerance: float) -> Plan:
        """The plan with segments of its drive joined where the tolerance allows it; not with a backlash, whose gap the
        force itself opens and closes."""
        if self.axis.half_gap > 0.0:
            return self
        drive = compressed(self.drive, begin, end, self.axis.mass, tolerance * SCALE)
        return self if drive is self.drive else replace(self, drive=drive)

    def problem(self, memory_length: float, energy: bool) -> Problem:
        """The equations for the compiled integrator; with `energy` the works are states too."""
        drive, axis = self.drive, self.axis
        oscillators = self.laws.oscillators.shape[0]
        size = self.head + self.elements + 2 * oscillators
        lag = size if axis.lag > 0.0 else -1
        size += int(axis.lag > 0.0)
        layout = Layout(
            head=self.head,
            elements=self.elements,
            state_elements=int(self.laws.groups[0, 3]),
            oscillators=oscillators,
            lag=lag,
            works=size if energy else -1,
            size=size + (WORKS if energy else 0),
        )
        body = Body(
            inverse_mass=1.0 if drive.prescribes else 1.0 / axis.mass,
            feedback=0.0 if drive.prescribes else 1.0,
            spring=float(drive.stiffness),
            memory_length=float(memory_length),
            ages_by_slip=float(self.ages_by_slip),
            half_gap=axis.half_gap,
            drive_lag=axis.lag,
            friction_delay=axis.friction_delay,
        )
        segments = Input(drive.knots, drive.values, drive.rates, *map(float, drive.wave))
        return Problem(layout, body, segments, self.laws)

    def start(self, layout: Layout, position: float, velocity: float, bristle: Any) -> np.ndarray:
        """Initial state, (size,); an added oscillator starts in step with the axis."""
        start = np.zeros(layout.size)
        start[0], start[1] = position, velocity
        at = self.head + self.elements
        if bristle is not None:
            given = np.atleast_1d(np.asarray(bristle, dtype=float))
            start[self.head : self.head + given.size] = given
        for square, damping, _ in self.laws.oscillators:
            start[at], start[at + 1] = position - damping / square * velocity, velocity
            at += 2
        if layout.lag >= 0:
            amplitude, _, phase = self.drive.wave
            start[layout.lag] = self.drive.values[0] + amplitude * math.cos(phase)
        return start

    def tolerance(self, layout: Layout, relative: float, longest_step: float, most_steps: int) -> Tolerance:
        """Accuracy of every state."""
        absolute = np.full(layout.size, relative * SCALE)
        if self.head > 2:
            absolute[2] = relative * SCALE if "travelled" in self.required else math.inf
            absolute[3] = relative if "contact_age" in self.required else math.inf
        absolute[self.head : self.head + self.elements] = relative * self.scales
        if layout.lag >= 0:
            absolute[layout.lag] = relative * max(float(np.abs(self.drive.values).max()), self.drive.wave[0], 1e-3)
        return Tolerance(relative, absolute, int(np.isfinite(absolute).sum()), float(longest_step), int(most_steps))


@dataclass(frozen=True)
class _Mechanics:
    """Time-domain realisation of the effects of drive, structure and memory."""

    mass: float  # that moves with the axis itself, kg
    half_gap: float = 0.0  # half the backlash times the spring stiffness, N
    lag: float = 0.0  # time constant of the drive, s
    friction_delay: float = 0.0  # of the speed that the friction level depends on, s


class Surroundings(NamedTuple):
    """Normal load (N) and temperature (degC), (m, 2), at instants that begin at `begin` (s), `step` (s) apart."""

    values: np.ndarray
    begin: float = 0.0
    step: float = 1.0


def plan_of(model: Model, drive: Drive, mass: float, surroundings: Surroundings) -> Plan:
    """Lay a model out for the integrator.

    Raises:
        InputError: an effect that cannot be integrated, or not with this drive.
    """
    for effect in model.effects:
        reason = kernels.unsupported(effect)
        if reason:
            raise InputError(f"simulation: effect '{effect.name}' {reason}")
    tables = [np.array(p if len(p) else (0.0,), dtype=float) for p in model.values]
    drive, axis, oscillators = _mechanics(model, drive, mass)
    groups, scales, kept = _groups(model, tables)
    base = np.array([0.0, 1.0, 0.0])
    varying = surroundings.values.shape[0] > 1
    rows: list[tuple[int, int, int, int]] = []
    required: set[str] = set()
    for effect, p, table in zip(model.effects, model.values, tables):
        if not any(kernels.instantaneous_terms(effect)):
            continue
        if kernels.is_constant(effect) and not (varying and effect.needs):
            _add_constant(effect, p, base, surroundings)
            continue
        required |= kernels.required_quantities(effect)
        kernel = kernels.effect_kernel(effect)
        kept.append(kernel)
        rows += _effect_rows(effect, kernel, table, axis.friction_delay)
    return Plan(
        drive=drive,
        laws=Laws(np.array(rows, dtype=np.int64).reshape(-1, 4), groups, base, *surroundings, oscillators),
        head=4 if required & {"travelled", "contact_age"} else 2,
        scales=scales,
        axis=axis,
        memory_length=next((p.memory_length for p in model.values if hasattr(p, "memory_length")), math.inf),
        ages_by_slip=model.state_effect is not None and model.state_effect.friction_state.ages,
        required=frozenset(required),
        kernels=kept,
        tables=tables,
    )


def _mechanics(model: Model, drive: Drive, mass: float) -> tuple[Drive, _Mechanics, np.ndarray]:
    """Drive after delays, mechanics of the axis, and the rows of `Laws.oscillators`."""
    oscillators: list[tuple[float, float, float]] = []
    half_gap, lag, friction_delay, carried = 0.0, 0.0, 0.0, 0.0
    for effect, p in zip(model.effects, model.values):
        part = effect.time_domain(p) if effect.time_domain is not None else None
        if isinstance(part, Backlash | FirstOrderLag | TransportDelay) and drive.prescribes:
            raise InputError(
                f"simulation: effect '{effect.name}' acts on a drive, and here the motion itself is imposed"
            )
        if isinstance(part, Backlash):
            require(drive.stiffness > 0.0, f"simulation: effect '{effect.name}' needs a drive that pulls a spring")
            half_gap += 0.5 * part.gap * drive.stiffness
        elif isinstance(part, FirstOrderLag):
            if lag > 0.0:
                raise InputError("simulation: one lag of the drive at most")
            lag = part.time_constant
        elif isinstance(part, TransportDelay):
            drive = delayed(drive, part.delay)
        elif isinstance(part, DelayedSpeed):
            friction_delay += part.delay
        elif isinstance(part, AddedOscillator):
            w = 2.0 * math.pi * part.frequency
            oscillators.append((w * w, 2.0 * part.damping * w, part.mass_ratio * mass))
            carried += part.mass_ratio
    if carried >= 1.0:
        raise InputError(f"simulation: {carried:g} of the mass belongs to added oscillators; must be below 1")
    axis = _Mechanics(mass * (1.0 - carried), half_gap, lag, friction_delay)
    return drive, axis, np.array(oscillators, dtype=float).reshape(-1, 3)


def _groups(model: Model, tables: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, list[kernels.Kernel]]:
    """Rows of `Laws.groups`, scales of their elements, and their kernels; the friction state model comes first.

    Tables of elements are appended to `tables`, which own the memory.
    """
    first_row = [(0, 0, 0, 0)] if model.state_effect is None else []
    having = [i for i, e in enumerate(model.effects) if e.friction_state is not None or e.parallel_element is not None]
    rows, scales, kept = first_row, [], []
    for i in sorted(having, key=lambda i: model.effects[i].friction_state is None):
        effect, p = model.effects[i], model.values[i]
        declared = effect.friction_state or effect.parallel_element
        kernel, count = kernels.state_kernel(effect), int(declared.elements(p))
        kept.append(kernel)
        table = tables[i]
        if declared.table is not None:
            tables.append(table := np.ascontiguousarray(declared.table(p)))
        rows.append((kernel.address, table.ctypes.data, len(scales), count))
        scales += [float(declared.scale(p))] * count
    return np.array(rows, dtype=np.int64), np.array(scales), kept


def _effect_rows(
    effect: Effect, kernel: kernels.Kernel, table: np.ndarray, friction_delay: float
) -> list[tuple[int, int, int, int]]:
    """Rows of `Laws.effects`; two where the friction level depends on the delayed speed, and the force does not."""
    friction, force = kernels.instantaneous_terms(effect)
    row = (kernel.address, table.ctypes.data)
    is_delayed = friction_delay > 0.0 and "velocity" in kernels.dependence(effect, "level", "factor")
    if is_delayed and force:
        return [(*row, FRICTION, 1), (*row, FORCE, 0)]
    return [(*row, FRICTION * friction + FORCE * force, int(is_delayed))]


def _add_constant(effect: Effect, p: Any, base: np.ndarray, surroundings: Surroundings) -> None:
    """Add an effect that stays constant to the constant terms."""
    load, temperature = surroundings.values[0]
    axis = Axis(0.0, 0.0, 0.0, math.nan, load, temperature, 0.0, math.nan, 0.0, 1.0)
    if effect.level is not None:
        base[0] += effect.level(axis, p)
    if effect.factor is not None:
        base[1] *= effect.factor(axis, p)
    if effect.force is not None:
        base[2] += effect.force(axis, p)
