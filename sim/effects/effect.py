"""The declaration of a physical effect, used in simulation, fitting, diagnosis and documentation.

Effects do not call each other. They are coupled by the quantities of the axis (`Axis`) and by one friction level:

    level    = (sum of every effect's `level`) * (product of every effect's `factor`)        [N]
    friction = state model(level) + sum of every effect's `force`                                   [N]
    mass * acceleration = drive force - friction

so every force has the sign of friction: positive where it opposes positive motion. The friction state model
(`sim/effects/friction_state/`) turns the level into a force. Effects on the drive or a sensor act on a signal
(`signal`).

A law is written once, with numpy functions, in arguments that are floats (one instant) or arrays of one shape (a whole
record), so the same lines are compiled for the integrators and evaluated along a measured motion.
"""

from __future__ import annotations

import re
from collections import namedtuple
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

from stagecad.parameters.errors import InputError, nearest


@dataclass(frozen=True)
class AddedOscillator:
    """A part of the moving mass on a spring and damper: x2'' = w^2 (x - x2) - 2 damping w x2', w = 2 pi frequency.

    Its reaction on the axis is mass_ratio * mass * x2''; the axis itself keeps (1 - mass_ratio) * mass. So a slow
    motion has the total mass, and a steady one no drag.
    """

    frequency: float  # Hz
    damping: float  # ratio
    mass_ratio: float


@dataclass(frozen=True)
class Backlash:
    """Lost motion of full width `gap` (m) in the spring that drives the axis: no force within +-gap/2 of stretch."""

    gap: float


@dataclass(frozen=True)
class DelayedSpeed:
    """The friction level depends on the speed `delay` (s) ago, in the present direction."""

    delay: float


@dataclass(frozen=True)
class FirstOrderLag:
    """The drive's force, or the driven end of its spring, follows its command: y' = (u - y)/time_constant (s)."""

    time_constant: float


@dataclass(frozen=True)
class TransportDelay:
    """The drive follows its command after `delay` (s)."""

    delay: float


TimeDomain = AddedOscillator | Backlash | DelayedSpeed | FirstOrderLag | TransportDelay


Coordinate = Literal[
    "time",
    "frequency",
    "position",
    "velocity",
    "direction",
    "acceleration",
    "distance_since_reversal",
    "distance_travelled",
    "contact_age",
    "normal_load",
    "temperature",
    "input",
]


class Axis(NamedTuple):
    """The named quantities of the axis: floats at one instant, or arrays of shape (n,) along a record. SI units.

    A rotary axis has rad for m, N*m for N, and so on throughout.
    """

    time: Any  # s, from the first row of the record
    position: Any  # m
    velocity: Any  # m/s
    acceleration: Any  # m/s^2
    load: Any  # N, normal load, compression positive
    temperature: Any  # degC
    contact_age: Any  # s, how long the present contact has existed (zero in free sliding)
    reversal_distance: Any  # m, distance since the last change of direction
    travelled: Any  # m, distance since the first row of the record
    direction: Any = 1.0  # sign of the velocity; at rest, that of the last motion


@dataclass(frozen=True)
class Scan:
    """Range over which a shape parameter is searched, as multiples of a scale of the record.

    The scale is the record's largest value (or range) of `of`; "time" is its duration, "sample" its sampling time,
    "rest" its longest rest.
    `reciprocal` spacing is even in 1/value: a pitch is found by its number of waves along the travel.
    A bounded range excludes values that cannot be distinguished: a cogging pitch longer than the travel is a slope.
    It extends at least to `reach`, SI, whatever the scale. Pitches of a periodic effect are searched down to `shortest`
    by a periodogram, and up to `high` times the travel of any record, held-out ones included.
    """

    of: Literal[
        "position", "velocity", "time", "sample", "travelled", "rest", "force", "load", "temperature", "input", "one"
    ]
    low: float
    high: float
    points: int = 9
    spacing: Literal["geometric", "linear", "reciprocal"] = "geometric"
    reach: float = 0.0
    shortest: float = 0.0


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    Args:
        name: the user writes `effect.name`.
        unit: SI unit on a linear axis (a rotary axis: `rotary_unit`).
        default: physical default.
        low, high: bounds of a fit, from physics (drag is not negative).
        meaning: one line.
        source: of default and bounds.
        role: `amplitude` (zero means the effect is absent, and the force is linear in it), `shape` (searched over
            `scan`, since it has no gradient where the effect is absent), `phase` (an angle of an amplitude: tried at 0
            and pi/2, which span every phase), `level` (base size such as a Coulomb force), or `reference`
            (held at a value, a mean of the record: never fitted). Of a user's own effect, an amplitude in which the
            laws are not linear, or which may not be zero, is taken for a shape.
        scan: the range searched for a `shape` parameter.
        fixed: not fitted unless the experiment frees it.
        natural: ends of the range of a fit at which the effect is still an explanation: a limit of the law itself, or
            of what the records resolve. At another end the effect stands for something else. Zero is natural always.
        reported: shown in tables; otherwise a nuisance that only the fit needs.
    """

    name: str
    unit: str
    default: float
    low: float
    high: float
    meaning: str
    source: str
    role: Literal["amplitude", "shape", "phase", "level", "reference"] = "amplitude"
    scan: Scan | None = None
    fixed: bool = False
    natural: Literal["", "low", "high", "both"] = ""
    reported: bool = True

    def shape(
        self, scan: Scan | None = None, *, natural: Literal["", "low", "high", "both"] = "", fixed: bool = False
    ) -> Parameter:
        """This parameter in the role `shape`, searched over `scan`."""
        return replace(self, role="shape", scan=scan, natural=natural, fixed=fixed)


Law = Callable[[Axis, Any], Any]
"""`law(axis, p) -> value`: `p` has the effect's parameters as attributes; the value has the shape of the axis."""

MemoryLaw = Callable[[Axis, Any], Axis]
"""`law(axis, p) -> axis`: the quantities that the friction depends on, along a whole record."""

SignalLaw = Callable[[Any, float, Any], Any]
"""`law(signal, step, p) -> signal`: a causal operator on a uniformly sampled signal of shape (n,), `step` in s."""


@dataclass(frozen=True)
class Effect:
    """One physical effect, declared once.

    Args:
        name: public name.
        meaning: one line.
        equation: the law as text, in the names of the parameters.
        shows: signature in a measurement, in words.
        dissipation: whether it can return energy over a closed cycle of position, speed, load and temperature.
        source: literature.
        parameters: its numbers.
        coordinates: on which the residual depends where the effect is missing, strongest first.
        level: adds to the friction level, N.
        factor: multiplies the friction level.
        force: adds to the force that opposes the motion, N.
        slopes: exact partial derivatives for implicit integration: `{"force.velocity": law, "level.velocity": law,
            "force.position": law, ...}`; one left out is zero.
        signal: forward operator on the drive (`acts_on="drive"`) or on a measured channel (`acts_on="sensor"`).
        inverse: of `signal`, for one that delays: the input of a smooth output.
        memory: changes the quantities that level and friction state depend on along a record (a lag in the friction,
            backlash in the drive, the age of the contacts).
        friction_state: the `FrictionStateModel` (static map, Dahl, LuGre, Maxwell-slip) that turns the level into a
            force.
        parallel_element: for an effect with internal states: the `FrictionStateModel` of those states in a
            simulation, in place of `force`.
        time_domain: for an effect of drive, structure or memory: its time-domain realisation, a function of its values.
        acts_on: place of action.
        needs: what the records must have for the effect to be observable.
        between_rows: a law for the course of a command between its rows.
        rounds: a sensor effect that rounds a channel: it adds to its noise, and changes no prediction.
        added_to_output: a sensor effect that adds to the output of the sensor, after its other effects.
        piezo: index of the one piezo that it acts on; every one where left out.
        refinement: tried only once another law of its name is in the model, or by name.
        variants: other laws under the same name (`stribeck:free_exponent`).
        origin: of an effect of the user's own once it is checked: gives it by its name in another process.
    """

    name: str
    meaning: str
    equation: str = ""
    shows: str = ""
    dissipation: str = ""
    source: str = ""
    parameters: tuple[Parameter, ...] = ()
    coordinates: tuple[Coordinate, ...] = ()
    level: Law | None = None
    factor: Law | None = None
    force: Law | None = None
    slopes: Mapping[str, Law] = field(default_factory=dict)
    signal: SignalLaw | None = None
    inverse: SignalLaw | None = None
    memory: MemoryLaw | None = None
    friction_state: Any = None
    parallel_element: Any = None
    time_domain: Callable[[Any], TimeDomain] | None = None
    acts_on: Literal["friction", "axis", "drive", "piezo", "sensor", "memory", "structure"] = "axis"
    needs: tuple[Literal["load", "temperature", "rotary", "imposed_motion"], ...] = ()
    between_rows: bool = False
    rounds: bool = False
    added_to_output: bool = False
    piezo: int | None = None
    refinement: bool = False
    variants: tuple[Effect, ...] = ()
    origin: Callable[[str], Effect] | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if isinstance(self.parameters, list):
            object.__setattr__(self, "parameters", tuple(self.parameters))

    @property
    def energy(self) -> str:
        """Whether the effect can return energy over a closed cycle; empty where that is not stated."""
        level_alone = self.force is None and self.friction_state is None and self.parallel_element is None
        if self.dissipation or not level_alone or self.acts_on not in ("friction", "axis", "memory"):
            return self.dissipation
        return "Changes the friction level alone: whether energy is returned depends on the state model."

    @property
    def is_mode(self) -> bool:
        """Whether it is a structural mode: a part of the moving mass, or of a motion, follows through a resonance."""
        return self.acts_on == "structure" and self.signal is not None

    @property
    def opens_gap(self) -> bool:
        """Whether it is lost motion between the drive and the body."""
        return self.acts_on == "structure" and self.memory is not None

    @property
    def is_periodic(self) -> bool:
        """Whether it is periodic in the position, so that a model may have several of it, one for each pitch."""
        return any(p.scan is not None and p.scan.shortest > 0.0 for p in self.parameters)

    @property
    def has_presliding(self) -> bool:
        """Whether it is a friction state model whose presliding displacement a record resolves."""
        return self.friction_state is not None and not self.friction_state.rigid

    def parameter(self, name: str) -> Parameter:
        """The parameter called `name`.

        Raises:
            InputError: naming the nearest parameter this effect has.
        """
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        known = nearest(name, [p.name for p in self.parameters])
        raise InputError(f"effect '{self.name}' has no parameter '{name}'{known}")

    @cached_property
    def values_type(self) -> Any:
        """The named tuple of this effect's parameter values, argument of its laws."""
        return namedtuple(re.sub(r"\W", "_", f"{self.name}_values"), [p.name for p in self.parameters])

    def values(self, **given: float) -> Any:
        """Parameter values for the laws: the defaults, with those `given` in their place."""
        for name in given:
            self.parameter(name)
        return self.values_type(*[float(given.get(p.name, p.default)) for p in self.parameters])


_ROTARY = {
    "N": "N*m",
    "m": "rad",
    "N/m": "N*m/rad",
    "N*s/m": "N*m*s/rad",
    "N*s^2/m^2": "N*m*s^2/rad^2",
    "m/s": "rad/s",
    "kg": "kg*m^2",
    "1/m": "1/rad",
}


def rotary_unit(unit: str) -> str:
    """The unit on a rotary axis that corresponds to `unit` on a linear one (`N*s/m` -> `N*m*s/rad`)."""
    return _ROTARY.get(unit, unit)
