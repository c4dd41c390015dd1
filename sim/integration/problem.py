"""The equations of an axis as named tuples of numbers and arrays, which compiled functions receive.

State y = [position, velocity, (distance travelled, contact age) | internal friction states z_1 .. z_n | position and
velocity of each added oscillator | lagged drive | works of friction state, other forces, drive]. The two in brackets,
the lagged drive and the works are present only where the model or the user needs them.

Importing this module imports numba.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sim.integration import compiled
from sim.integration.compiled.kernel_source import QUANTITIES
from sim.integration.compiled.views import Zeros
from sim.numerics.compilation import INLINED, compile_function

SOURCES = [
    str(path)
    for path in sorted(Path(__file__).parent.glob("*.py")) + sorted(Path(compiled.__file__).parent.glob("*.py"))
]
"""Files that the compiled integrator depends on."""

SLOPES = len(QUANTITIES)
COLUMNS = 1 + SLOPES
"""Numbers that the kernel of an effect writes for each of its laws: the value, then the slopes."""
AXIS_FIELDS = 10
WORKS = 3
"""Integrated works: of the friction state model, of the other forces, of the drive."""

# Not Python's integers: with each of those that a compiled function is called with, numba compiles it once more.
POSITION, VELOCITY = np.int64(0), np.int64(1)
"""Indices of the first states."""
VALUES, WITH_SLOPES = np.int64(0), np.int64(1)
"""Whether the laws are evaluated with their slopes."""


def inlined(function: Callable[..., Any]) -> Any:
    """Decorator: compile a function that becomes part of the compiled function that calls it."""
    return compile_function(function, SOURCES, **INLINED)


class Layout(NamedTuple):
    """Order of the states.

    Args:
        head: 2, or 4 where a law depends on the distance travelled or on the contact age.
        elements: internal states of all friction elements.
        state_elements: those of the friction state model, which come first.
        oscillators: added oscillators.
        lag: index of the lagged drive, or -1.
        works: index of the first work, or -1.
        size: number of states.
    """

    head: int
    elements: int
    state_elements: int
    oscillators: int
    lag: int
    works: int
    size: int


class Body(NamedTuple):
    """Constants of the axis, SI.

    Args:
        inverse_mass: of what moves with the axis itself, 1/kg; 1 where the motion is imposed.
        feedback: 1, or 0 where the motion is imposed and the forces do not act on it.
        spring: stiffness between drive and axis, N/m.
        memory_length: of the contact age, m.
        half_gap: half the backlash times the spring stiffness, N.
        drive_lag: time constant of the drive, s; zero without.
        friction_delay: delay of the speed that the friction level depends on, s.
    """

    inverse_mass: float
    feedback: float
    spring: float
    memory_length: float
    half_gap: float
    drive_lag: float
    friction_delay: float


class Input(NamedTuple):
    """The drive, linear from knot to knot, plus amplitude cos(frequency t + phase)."""

    knots: np.ndarray  # s, (m,)
    values: np.ndarray  # N, (m,)
    rates: np.ndarray  # N/s, (m,)
    amplitude: float
    frequency: float
    phase: float


class Laws(NamedTuple):
    """The laws of a model.

    Args:
        effects: address of the kernel, address of its parameters, terms taken (`FRICTION` + `FORCE`), and whether the
            laws depend on the delayed speed; (effects, 4).
        groups: address of the kernel, address of its parameters, first element and number of elements; the first row is
            the friction state model, the others are elements parallel to it; (groups, 4).
        base: level, factor and force of all that stays constant, (3,).
        surroundings: normal load (N) and temperature (degC), (m, 2); linear between instants that begin at `begin` (s)
            and are `step` (s) apart, or constant for m = 1.
        oscillators: w^2, 2 damping w, and mass of each added oscillator; (oscillators, 3).
    """

    effects: np.ndarray
    groups: np.ndarray
    base: np.ndarray
    surroundings: np.ndarray
    begin: float
    step: float
    oscillators: np.ndarray


FRICTION, FORCE = 1, 2
"""Terms taken from an effect: summand and factor of the friction level, force, or both."""


class Problem(NamedTuple):
    layout: Layout
    body: Body
    drive: Input
    laws: Laws


class Tolerance(NamedTuple):
    """Accuracy and limits of an integration.

    Args:
        relative: of the error of one step.
        absolute: of each state, (size,); infinite for a state whose error does not count.
        counted: number of states whose error counts.
        longest_step: s.
        most_steps: attempts, accepted or not.
    """

    relative: float
    absolute: np.ndarray
    counted: int
    longest_step: float
    most_steps: int


class Output(NamedTuple):
    """Results of an integration, written in place.

    Args:
        time: instants of the output, s, (n,).
        states: the first rows of the state at these instants, (k, n).
        forces: level, force of the friction state model, other forces, drive at these instants, N, (n or 0, 4).
        report: outcome, time reached, accepted and rejected steps, then the state there, (4 + size,).
    """

    time: np.ndarray
    states: np.ndarray
    forces: np.ndarray
    report: np.ndarray


class Branch(NamedTuple):
    """The smooth branch of the equations that one step follows.

    Args:
        direction: of the motion: 1 or -1.
        engaged: 1 where the backlash transmits force, 0 within the gap.
        edge: force of the spring at which the backlash engages, N.
        segment: of the drive.
    """

    direction: float
    engaged: float
    edge: float
    segment: int


BRANCH = Branch(1.0, 1.0, 0.0, 0)
"""Example of a branch, for its type."""


class Terms(NamedTuple):
    """Values of the laws at one instant, written in place.

    Args:
        axis: arguments of the effects' laws, in the order of `sim.effects.effect.Axis`.
        laws: value and slopes of level, factor and force of one effect, then slopes of the product of the factors.
        elements: rate, force, rate_z, rate_v, rate_g, force_z, force_v, force_g of each element, (elements, 8).
        total: level, force of the friction state model, of the effects, of the parallel elements, (4,).
        slope: of these four by `QUANTITIES`, at constant internal states, (4, 5).
    """

    axis: Zeros
    laws: Zeros
    elements: Zeros
    total: Zeros
    slope: Zeros


class Jacobian(NamedTuple):
    """Entries of the Jacobian that are not zero; `arrowhead.py` has the structure.

    Args:
        velocity_by_head: (4,).
        element_by_self, velocity_by_element: (elements,).
        element_by_head: (elements, 4).
        age: slopes of the contact age's rate by velocity and by itself, (2,).
        work_by_head: (3, 4).
        work_by_element: (elements,).
        time: partial derivatives of the rates by time, (size,).
        inverse: of the eliminated pivots: of each element, then of each oscillator.
        effective: velocity by head once the elements are eliminated, (4,).
    """

    velocity_by_head: Zeros
    element_by_self: Zeros
    velocity_by_element: Zeros
    element_by_head: Zeros
    age: Zeros
    work_by_head: Zeros
    work_by_element: Zeros
    time: Zeros
    inverse: Zeros
    effective: Zeros


class Workspace(NamedTuple):
    """Arrays of an integration, written in place.

    Args:
        y, fresh: state before and after a step, (size,).
        rates: at the start of the step, (size,).
        point: state at which a stage evaluates the rates, (size,).
        coupling: sum of the earlier stages' increments in a stage's right-hand side, (size,).
        increments: of the stages, (stages, size).
        dense: coefficients of the dense output, (size, 3).
        history: of the velocity over the friction delay, one step a row (`dense_output.py`); its ends in `ring`, (2,).
        initial_speed: m/s.
    """

    y: np.ndarray
    fresh: Zeros
    rates: Zeros
    point: Zeros
    coupling: Zeros
    increments: Zeros
    dense: Zeros
    history: Zeros
    ring: Zeros
    initial_speed: float
    terms: Terms
    jacobian: Jacobian
