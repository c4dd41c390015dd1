"""Laws of force and friction on one axis, each evaluated at the present state and advanced step by step.

`place` says where a law acts: `level` adds to the friction level (N), `factor` multiplies it, `force` opposes the drive
(N), `bristles` replaces the set-valued friction. The level times the sign of the velocity is the friction force.
"""

from collections.abc import Callable
from math import cosh, exp, expm1, log1p, pi, sin, tanh

import numpy as np


class State:
    """State of the axis as laws read it: `side` is the last direction of motion, `turned` the way since it changed."""

    __slots__ = ("load", "rate", "side", "t", "temperature", "travelled", "turned", "v", "warming", "x")

    def __init__(self) -> None:
        self.t = self.x = self.v = self.rate = self.travelled = self.turned = self.warming = 0.0
        self.side, self.load, self.temperature = 1.0, 1.0, 0.0


class Law:
    """A law without memory: `value` of the state."""

    def __init__(self, place: str, value: Callable[[State], float]) -> None:
        self.place, self.value = place, value

    def advance(self, s: State, h: float) -> None:
        """Advance internal states by `h` seconds along the motion of `s`."""


FORMS: dict[str, Callable[[float], float]] = {
    "power_2": lambda a: exp(-a * a),
    "power_1": lambda a: exp(-a),
    "lorentzian": lambda a: 1.0 / (1.0 + a * a),
    "power_law": lambda a: (1.0 + a) ** -1.5,
    "hyperbolic": lambda a: 1.0 / cosh(min(a, 50.0)),
}


class Curve(Law):
    """Stribeck curve height * form(u / speed), u = |v| after a memory of `delay` seconds or `way` metres.

    du/dt = (|v| - u) / delay, or du/ds = (|v| - u) / way along the distance s.
    """

    def __init__(self, height: float, speed: float, form: str, *, delay: float = 0.0, way: float = 0.0) -> None:
        self.height, self.speed, self.form, self.delay, self.way = height, speed, FORMS[form], delay, way
        self.seen = 0.0
        super().__init__("level", self._value)

    def _value(self, s: State) -> float:
        seen = self.seen if self.delay or self.way else abs(s.v)
        return self.height * self.form(seen / self.speed)

    def advance(self, s: State, h: float) -> None:
        if self.delay or self.way:
            share = h / self.delay if self.delay else abs(s.v) * h / self.way
            self.seen += (abs(s.v) - self.seen) * -expm1(-share)


class Ageing(Law):
    """Rate-and-state friction, ageing law (Ruina 1983): height ln(1 + theta / scale), theta' = 1 - |v| theta / way."""

    def __init__(self, height: float, scale: float, way: float) -> None:
        self.height, self.scale, self.way, self.age = height, scale, way, 0.0
        super().__init__("level", lambda s: self.height * log1p(self.age / self.scale))

    def advance(self, s: State, h: float) -> None:
        decay = abs(s.v) / self.way
        if decay * h < 1e-6:
            self.age += h
        else:
            self.age = 1.0 / decay + (self.age - 1.0 / decay) * exp(-decay * h)


class Bristles(Law):
    """Elasto-plastic elements in parallel, break-away distances of a Weibull distribution, equal shares of the level.

    `damping` (N s/m) acts on the share of the elements that do not slip.
    """

    def __init__(self, stretch: float, *, shape: float = 1.4, elements: int = 24, damping: float = 0.0) -> None:
        order = (np.arange(elements) + 0.5) / elements
        self.limits = stretch * (-np.log1p(-order)) ** (1.0 / shape)
        self.damping, self.stretched = damping, np.zeros(elements)
        self.shares = 1.0 / (self.limits * elements)
        super().__init__("bristles", lambda s: float(self.stretched @ self.shares))

    def drag(self, v: float) -> float:
        """Damping force (N) of the elements that stick."""
        if not self.damping:
            return 0.0
        stuck = np.count_nonzero(np.abs(self.stretched) < self.limits) / self.limits.size
        return self.damping * stuck * v

    def moved(self, dx: float) -> None:
        """Move all elements by `dx`."""
        z = self.stretched
        z += dx
        np.minimum(z, self.limits, out=z)
        np.maximum(z, -self.limits, out=z)


class Resonator(Law):
    """A mass on a spring and damper that rides on the axis and pulls at it."""

    def __init__(self, mass: float, frequency: float, damping: float) -> None:
        self.mass, self.w, self.damping, self.q, self.u = mass, frequency, damping, 0.0, 0.0
        super().__init__("force", self._value)

    def _value(self, s: State) -> float:
        pull = self.w**2 * (s.x - self.q) + 2.0 * self.damping * self.w * (s.v - self.u)
        return self.mass * pull

    def advance(self, s: State, h: float) -> None:
        self.u += h * self._value(s) / self.mass
        self.q += h * self.u


def waves(x0: float, pitch: float, bend: float) -> Callable[[float], float]:
    """A wave between -1 and 1 of `pitch`, bent towards a rounded triangle and leaning by `bend`."""
    k = 2.0 * pi / pitch
    return lambda x: tanh(1.2 * sin(k * x + x0 + bend * sin(k * x))) / tanh(1.2)


def harmonics(rng: np.random.Generator, pitch: float, reach: float) -> Callable[[float], float]:
    """A cogging force of three harmonics whose amplitude varies along the travel; its largest value is about 1."""
    k = 2.0 * pi / pitch
    second, third, first, vary = rng.uniform(0.1, 0.3), rng.uniform(0.05, 0.15), rng.uniform(0, 6), rng.uniform(0, 0.2)
    far = 2.0 * pi / (reach * rng.uniform(0.7, 1.5))

    def value(x: float) -> float:
        a = k * x + first
        return (1 + vary * sin(far * x)) * (sin(a) + second * sin(2 * a + 1) + third * sin(3 * a + 2))

    return value
