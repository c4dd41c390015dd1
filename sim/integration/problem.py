"""The equations of an axis as named tuples of numbers and arrays, which compiled functions receive.

State y = [position, velocity, (distance travelled, contact age) | internal friction states z_1 .. z_n | position and
velocity of each added oscillator | lagged drive | works of friction state, other forces, drive]. The two in brackets,
the lagged drive and the works are present only where the model or the user needs them.

Importing this module imports numba.
"""

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
    """Order of the states."""

    head: int  # 2, or 4 where a law depends on the distance travelled or on the contact age
    elements: int  # internal states of all friction elements
    state_elements: int  # those of the friction state model, which come first
    oscillators: int  # added oscillators
    lag: int  # index of the lagged drive, or -1
    works: int  # index of the first work, or -1
    size: int  # number of states


class Body(NamedTuple):
    """Constants of the axis, SI."""

    inverse_mass: float  # of what moves with the axis itself, 1/kg; 1 where the motion is imposed
    feedback: float  # 1, or 0 where the motion is imposed and the forces do not act on it
    spring: float  # stiffness between drive and axis, N/m
    memory_length: float  # of the contact age, m
    ages_by_slip: float  # 1 where the contacts age by the slip of the first element, 0 by the motion of the axis
    half_gap: float  # half the backlash times the spring stiffness, N
    drive_lag: float  # time constant of the drive, s; zero without
    friction_delay: float  # delay of the speed that the friction level depends on, s


class Input(NamedTuple):
    """The drive, linear from knot to knot, plus amplitude cos(frequency t + phase)."""

    knots: np.ndarray  # s, (m,)
    values: np.ndarray  # N, (m,)
    rates: np.ndarray  # N/s, (m,)
    amplitude: float
    frequency: float
    phase: float


class Laws(NamedTuple):
    """The laws of a model."""

    # address of the kernel, address of its parameters, terms taken (`FRICTION` + `FORCE`), and whether the laws depend
    # on the delayed speed; (effects, 4)
    effects: np.ndarray
    # address of the kernel, address of its parameters, first element and number of elements; the first row is the
    # friction state model, the others are elements parallel to it; (groups, 4)
    groups: np.ndarray
    base: np.ndarray  # level, factor and force of all that stays constant, (3,)
    # normal load (N) and temperature (degC), (m, 2); linear between instants that begin at `begin` (s) and are `step`
    # (s) apart, or constant for m = 1
    surroundings: np.ndarray
    begin: float
    step: float
    oscillators: np.ndarray  # w^2, 2 damping w, and mass of each added oscillator; (oscillators, 3)


FRICTION, FORCE = 1, 2
"""Terms taken from an effect: summand and factor of the friction level, force, or both."""


class Problem(NamedTuple):
    layout: Layout
    body: Body
    drive: Input
    laws: Laws


class Tolerance(NamedTuple):
    """Accuracy and limits of an integration."""

    relative: float  # of the error of one step
    absolute: np.ndarray  # of each state, (size,); infinite for a state whose error does not count
    counted: int  # number of states whose error counts
    longest_step: float  # s
    most_steps: int  # attempts, accepted or not


class Output(NamedTuple):
    """Results of an integration, written in place."""

    time: np.ndarray  # instants of the output, s, (n,)
    states: np.ndarray  # the first rows of the state at these instants, (k, n)
    # level, force of the friction state model, other forces, drive at these instants, N, (n or 0, 4)
    forces: np.ndarray
    report: np.ndarray  # outcome, time reached, accepted and rejected steps, then the state there, (4 + size,)


class Branch(NamedTuple):
    """The smooth branch of the equations that one step follows."""

    direction: float  # of the motion: 1 or -1
    engaged: float  # 1 where the backlash transmits force, 0 within the gap
    edge: float  # force of the spring at which the backlash engages, N
    segment: int  # of the drive


BRANCH = Branch(1.0, 1.0, 0.0, 0)
"""Example of a branch, for its type."""


class Terms(NamedTuple):
    """Values of the laws at one instant, written in place."""

    axis: Zeros  # arguments of the effects' laws, in the order of `sim.effects.effect.Axis`
    laws: Zeros  # value and slopes of level, factor and force of one effect, then slopes of the product of the factors
    elements: Zeros  # rate, force, rate_z, rate_v, rate_g, force_z, force_v, force_g of each element, (elements, 8)
    total: Zeros  # level, force of the friction state model, of the effects, of the parallel elements, (4,)
    slope: Zeros  # of these four by `QUANTITIES`, at constant internal states, (4, 5)


class Jacobian(NamedTuple):
    """Entries of the Jacobian that are not zero; `arrowhead.py` has the structure."""

    velocity_by_head: Zeros  # (4,)
    # element_by_self, velocity_by_element: (elements,)
    element_by_self: Zeros
    velocity_by_element: Zeros
    element_by_head: Zeros  # (elements, 4)
    age: Zeros  # slopes of the contact age's rate by velocity, by itself, and by the rate of the first element, (3,)
    work_by_head: Zeros  # (3, 4)
    work_by_element: Zeros  # (elements,)
    time: Zeros  # partial derivatives of the rates by time, (size,)
    inverse: Zeros  # of the eliminated pivots: of each element, then of each oscillator
    effective: Zeros  # velocity by head once the elements are eliminated, (4,)


class Workspace(NamedTuple):
    """Arrays of an integration, written in place."""

    # y, fresh: state before and after a step, (size,)
    y: np.ndarray
    fresh: Zeros
    rates: Zeros  # at the start of the step, (size,)
    point: Zeros  # state at which a stage evaluates the rates, (size,)
    coupling: Zeros  # sum of the earlier stages' increments in a stage's right-hand side, (size,)
    increments: Zeros  # of the stages, (stages, size)
    dense: Zeros  # coefficients of the dense output, (size, 3)
    # of the velocity over the friction delay, one step a row (`dense_output.py`); its ends in `ring`, (2,)
    history: Zeros
    ring: Zeros
    initial_speed: float  # m/s
    terms: Terms
    jacobian: Jacobian
