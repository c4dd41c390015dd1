"""Interface of a kind of rig: preparation, prediction, simulation; `sysid/prediction/simulation.py` has the kinds."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np

from sim.effects.effect import Effect
from sysid.experiment.experiment import Rig
from sysid.experiment.known import Prior, Unknown
from sysid.experiment.record import Record
from sysid.noise.estimate import Noise
from sysid.prediction.effect_terms import Values
from sysid.prediction.model import Model, Scales

Channels = dict[str, np.ndarray]
Effects = Sequence[Effect]
Noises = Mapping[str, Noise]


@dataclass(frozen=True)
class RigParameters:
    """Parameters of a rig by key, SI: known ones are fixed, unknown or uncertain ones are fitted."""

    rig: Rig
    values: dict[str, float] = field(default_factory=dict)
    unknowns: list[Unknown] = field(default_factory=list)

    def put(
        self,
        name: str,
        guess: Callable[[], float] | float,
        bounds: tuple[float, float] | None = None,
        free: bool = True,
    ) -> float:
        """Enter a parameter, and return its value."""
        key, given = f"rig.{name}", self.rig.known.get(self.rig.declaration.key_of(name) or name)
        value = given.value if given is not None else guess() if callable(guess) else guess
        self.values[key] = value
        if given is None and free:
            low, high = bounds or (1e-3 * abs(value), 1e3 * abs(value))
            self.unknowns.append(Unknown(key, value, low, high, abs(value)))
        elif given is not None and given.std:
            reach = 3.0 * given.std
            self.unknowns.append(Unknown(key, value, value - reach, value + reach, given.std, Prior(value, given.std)))
        return value

    def put_free(self, name: str, start: float, bounds: tuple[float, float], size: float) -> None:
        """Enter a parameter that is fitted in any case, with the typical size of its steps."""
        self.values[f"rig.{name}"] = start
        self.unknowns.append(Unknown(f"rig.{name}", start, *bounds, size))


@dataclass(frozen=True)
class Start:
    """State of a driven mass at the first row: position (m), velocity (m/s), states of the friction state model (zero
    where none), distance travelled (m) and contact age (s)."""

    position: float
    velocity: float = 0.0
    bristle: np.ndarray | None = None
    travelled: float = 0.0
    contact_age: float = 0.0


class RigModel(ABC):
    """A kind of rig.

    Args:
        name: in `[rig] kind`.
        form: of the residual: of a measured channel, or of a force balance.
        required: known quantities that it needs, each with an example.
        restarts: whether its prediction can begin at a measured position.
        along_motion: whether its prediction uses the measured motion, with its noise.
        predict: `predict(record, effects, values, at)`: predicted channels of a prepared record, (n,), or at the
            samples `at` of each channel, (k,).
    """

    name: ClassVar[str]
    form: ClassVar[Literal["output", "force_balance"]] = "output"
    required: ClassVar[Mapping[str, str]] = {}
    restarts: ClassVar[bool] = False
    along_motion: ClassVar[bool] = False
    predict: ClassVar[Callable[..., Channels]]

    def parameters(self, rig: Rig, records: Sequence[Record], noise: Noises) -> RigParameters:
        """The rig's own parameters; their starts are estimated from the records."""
        return RigParameters(rig)

    @abstractmethod
    def prepare(self, rig: Rig, records: Sequence[Record], noise: Noises, values: Values) -> list[Any]:
        """The prepared records, with the rig's own `values`."""

    def prepare_again(
        self, prepared: Sequence[Any], rig: Rig, records: Sequence[Record], noise: Noises, values: Values
    ) -> list[Any]:
        """Copies of prepared records with other noise, from the logs (`records`) with it, filtered as they are."""
        return self.prepare(rig, records, noise, values)

    def with_input_noise(self, records: Sequence[Any], noise: Noises) -> Noises:
        """The noise by channel, that of a logged input without the part on which prepared records show it to act."""
        return noise

    @abstractmethod
    def shows(self, effect: Effect, records: Sequence[Any], channels: set[str]) -> bool:
        """Whether an effect is observable in prepared records, of which these `channels` were logged."""

    def sensor_places(self, channels: Sequence[str]) -> tuple[str | None, ...]:
        """Measured channels on which a sensor effect is tried; none: on all of them alike."""
        return tuple(channels)

    def further_candidates(self, records: Sequence[Any], present: Sequence[str]) -> list[Effect]:
        """Effects of this rig alone to try on top of a model whose effects are named `present`."""
        return []

    def with_nuisances(self, model: Model, records: Sequence[Any]) -> Model:
        """A stated model with its values free that no table shows, but that a fit to these records needs."""
        return model

    def without_motion(self, scales: Scales) -> str:
        """Error of records in which nothing moves; empty if something moves."""
        return "nothing moves; give a record of motion" if scales.position == 0.0 or scales.velocity == 0.0 else ""

    def simulate(self, rig: Rig, record: Record, effects: Effects, values: Values, start: Start | None) -> Channels:
        """Measured channels (n,) of a record that has the inputs alone, at a uniform step and without gaps; the
        prediction itself where that is a simulation."""
        return self.predict_along(rig, record, dict.fromkeys(rig.declaration.measured_channels, 0.0), effects, values)

    def predict_along(
        self, rig: Rig, record: Record, channels: Mapping[str, Any], effects: Effects, values: Values
    ) -> Channels:
        """Predicted channels (n,) of a record without noise, with further channels: constants or (n,)."""
        added = {name: np.broadcast_to(signal, record.time.shape).astype(float) for name, signal in channels.items()}
        record = replace(record, channels={**record.channels, **added})
        exact = {name: Noise(1e-300, "", "given") for name in record.channels}
        return self.predict(*self.prepare(rig, [record], exact, values), effects, values)
