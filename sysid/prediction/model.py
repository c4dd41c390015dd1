"""The model of an experiment: its effects, the values it starts from, and what a fit may move."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from sim.effects.effect import Effect, Parameter
from sysid.experiment.known import Unknown
from sysid.prediction.effect_terms import split_channel
from sysid.prediction.friction_drive.friction import CONTACT
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.sensors import scaled


def predict(
    record: PreparedRecord,
    effects: Sequence[Effect],
    values: Mapping[str, float],
    at: Mapping[str, np.ndarray] | None = None,
) -> dict[str, np.ndarray]:
    """Predicted channels of a prepared record of any rig, (n,), or at the samples `at` of each channel, (k,)."""
    return scaled(record.rig.predict(record, effects, values, at), values)


@dataclass(frozen=True)
class Scales:
    """Scales of a set of records, in which initial values, search ranges and steps of parameters are expressed. SI
    units.

    `rest` is the longest rest, or a hundredth of the time where there is none. `sliding` is the speed
    between the tip and the stage of a friction drive; zero where there is none. `travel` is the largest range of
    positions of any record, held-out ones included: a wave is known by its repetition there.
    """

    force: float
    position: float
    velocity: float
    time: float
    sample: float
    travelled: float
    load: float
    temperature: float
    input: float
    channel: float
    load_mean: float
    temperature_mean: float
    sliding: float = 0.0
    rest: float = 1.0
    travel: float = 0.0

    def of(self, name: str) -> float:
        """The scale called `name` in a `Scan`; 1 for `one`."""
        return 1.0 if name == "one" else float(getattr(self, name))


LEAST_REST = 10.0
"""Samples of the shortest stick phase that sets the scale of time at rest."""

_DEFAULT = {"temperature_mean": 0.0, "sliding": 0.0, "rest": 0.0, "travel": 0.0}
"""Scales of records without such a quantity; all others are one."""


def scales_of(records: Sequence[PreparedRecord]) -> Scales:
    """Scales of a set of records: the largest over them, but the least sampling time, and the means of the last."""
    found = [record.scales() for record in records]

    def over(name: str) -> float:
        sizes, default = [one[name] for one in found if name in one], _DEFAULT.get(name, 1.0)
        if not sizes or name.endswith("_mean"):
            return sizes[-1] if sizes else default
        return min(sizes) if name == "sample" else max(sizes)

    scales = Scales(**{part.name: over(part.name) for part in fields(Scales)})
    return scales if scales.rest > LEAST_REST * scales.sample else replace(scales, rest=0.01 * scales.time)


def _scales_for(effect: Effect, scales: Scales) -> Scales:
    """The scales of an effect: between tip and stage the velocity is that of sliding."""
    return replace(scales, velocity=scales.sliding) if in_contact(effect) and scales.sliding > 0.0 else scales


_BY_UNIT = {
    "N": lambda s: s.force,
    "m": lambda s: s.position,
    "m/s": lambda s: s.velocity,
    "s": lambda s: 0.01 * s.time,
    "N*s/m": lambda s: s.force / s.velocity,
    "N*s^2/m^2": lambda s: s.force / s.velocity**2,
    "N/m": lambda s: s.force / s.position,
    "1/m": lambda s: 1.0 / s.position,
    "1/K": lambda s: 1.0 / max(s.temperature, 1e-9),
    "channel": lambda s: s.channel,
    "V": lambda s: s.input,
    "rad": lambda s: 1.0,
    "1": lambda s: 1.0,
    "Hz": lambda s: 0.1 / s.sample,
    "kg": lambda s: s.force / max(s.velocity, 1e-12),
}


def size_of(parameter: Parameter, scales: Scales) -> float:
    """Typical size of a parameter on these records: the unit of its steps."""
    if parameter.scan is not None:
        low, high = _scan_range(parameter, scales)
        return low or 0.1 * high
    size = _BY_UNIT.get(parameter.unit)
    return 0.1 * float(size(scales)) if size is not None else max(abs(parameter.default), 1e-12)


def _scan_range(parameter: Parameter, scales: Scales) -> tuple[float, float]:
    """Ends of the range in which a shape parameter is searched on these records."""
    assert parameter.scan is not None
    scale = _scan_scale(parameter, scales)
    longest = max(scale, scales.travel) if parameter.scan.shortest > 0.0 else scale
    return parameter.scan.low * scale, max(parameter.scan.high * longest, parameter.scan.reach)


def _scan_scale(parameter: Parameter, scales: Scales) -> float:
    assert parameter.scan is not None
    scale = scales.of(parameter.scan.of)
    # A frequency is searched as a part of the sampling frequency.
    return 1.0 / scale if parameter.unit == "Hz" else scale


def scan_values(parameter: Parameter, scales: Scales) -> np.ndarray:
    """The grid (k,) on which a shape parameter is searched on these records."""
    scan = parameter.scan
    if scan is None:
        return np.array([parameter.default])
    first, last = _scan_range(parameter, scales)
    low, high = max(first, parameter.low), min(last, parameter.high)
    if not high > low or (low <= 0.0 and scan.spacing != "linear"):
        return np.array([min(max(first, parameter.low), parameter.high)])
    if scan.spacing == "geometric":
        return np.geomspace(low, high, scan.points)
    if scan.spacing == "reciprocal":
        return 1.0 / np.linspace(1.0 / high, 1.0 / low, scan.points)
    return np.linspace(low, high, scan.points)


def bounds_of(parameter: Parameter, scales: Scales) -> tuple[float, float]:
    """Bounds of a fit: the declared ones, narrowed to what these records can show of a shape parameter."""
    low, high = parameter.low, parameter.high
    if parameter.unit == "m" and parameter.scan is None and not np.isfinite(high):
        # A position far outside the travel (of the rest of a cable, say) acts as a constant.
        low, high = max(low, -scales.position), min(high, scales.position)
    if parameter.scan is not None:
        first, last = _scan_range(parameter, scales)
        low = max(low, 0.3 * (parameter.scan.shortest * _scan_scale(parameter, scales) or first))
        high = min(high, (1.0 if parameter.scan.spacing == "reciprocal" else 1.5) * last)
        if low > high:
            low, high = parameter.low, parameter.high
    return low, high


def start_of(parameter: Parameter, effect: Effect, scales: Scales) -> float:
    """Initial value of a parameter; that of a reference is a mean or range of the records, or its default."""
    if parameter.role == "reference" or parameter.fixed:
        if parameter.name == "reference":
            return scales.load_mean if "load" in effect.needs else scales.temperature_mean
        if parameter.name == "full_scale":
            return scales.channel
        ranged = parameter.role == "reference" and parameter.scan is not None
        return _scan_range(parameter, scales)[0] if ranged else parameter.default
    if parameter.role == "level":
        return scales.force
    if parameter.role == "shape":
        grid = scan_values(parameter, scales)
        return float(grid[grid.size // 2])
    if parameter.role == "phase":
        return 0.0
    size = size_of(parameter, scales)
    return min(max(size, parameter.low), parameter.high) if parameter.low >= 0.0 else 0.0


@dataclass(frozen=True)
class Model:
    """Effects with their parameter values, and the parameters that a fit adjusts.

    `values` holds every parameter by key, `rig.` numbers included; `unknowns` those that are moved.
    """

    effects: tuple[Effect, ...]
    values: dict[str, float]
    unknowns: tuple[Unknown, ...]

    def __repr__(self) -> str:
        names = ", ".join(effect.name for effect in self.effects) or "no effects"
        return f"<Model {names}: {len(self.unknowns)} of {len(self.values)} values are fitted>"

    @property
    def nuisances(self) -> frozenset[str]:
        """Keys of the parameters that tables do not show."""
        return frozenset(f"{e.name}.{p.name}" for e in self.effects for p in e.parameters if not p.reported)

    def at(self, values: Mapping[str, float]) -> Model:
        """This model with other values, which are also the start of its next fit."""
        merged = {**self.values, **values}
        return replace(self, values=merged, unknowns=tuple(replace(u, start=merged[u.key]) for u in self.unknowns))

    def bounded(self, values: Mapping[str, float]) -> dict[str, float]:
        """Values of unknowns within their bounds."""
        return {u.key: min(max(values[u.key], u.low), u.high) for u in self.unknowns if u.key in values}


CONTACT_OVER_PADS = 1.03
"""Friction limit of a contact over the pads' friction: initial value."""


def in_contact(effect: Effect) -> bool:
    """Whether an effect acts between tip and stage, and not on the axis."""
    return effect.name.startswith(CONTACT)


def with_effect(
    model: Model, effect: Effect, scales: Scales, start: Mapping[str, float] | None = None, as_listed: bool = False
) -> Model:
    """The model with one more effect; a friction state model replaces the one before it, and starts from its
    friction level.

    A sensor effect comes before the drift of its zero, which is added after any nonlinearity; `as_listed`
    puts it last.
    """
    effects, values, unknowns = list(model.effects), dict(model.values), list(model.unknowns)
    if effect.friction_state is not None:
        for old in [e for e in effects if e.friction_state is not None and in_contact(e) == in_contact(effect)]:
            effects.remove(old)
            unknowns = [u for u in unknowns if not u.key.startswith(f"{old.name}.")]
            carried = {k.partition(".")[2]: v for k, v in values.items() if k.startswith(f"{old.name}.")}
            values = {k: v for k, v in values.items() if not k.startswith(f"{old.name}.")}
            # A level of zero has no gradient in the values of the bristles.
            if carried.get("force"):
                start = {f"{effect.name}.force": carried["force"], **(start or {})}
        core = next((e for e in effects if e.friction_state is not None), None)
        if in_contact(effect) and core is not None and f"{effect.name}.force" not in (start or {}):
            # A contact with a lower limit than the pads moves nothing, one with a far higher limit never slips: either
            # way the limit is not identifiable.
            start = {f"{effect.name}.force": CONTACT_OVER_PADS * values[f"{core.name}.force"], **(start or {})}
        effects.insert(0, effect)
    else:
        drifts = [k for k, e in enumerate(effects) if e.added_to_output]
        before = drifts[0] if drifts and effect.acts_on == "sensor" and not as_listed else len(effects)
        effects.insert(before, effect)
    own = _scales_for(effect, scales)
    for parameter in effect.parameters:
        key = f"{effect.name}.{parameter.name}"
        values[key] = start_of(parameter, effect, own)
        if parameter.role != "reference" and not parameter.fixed:
            size = max(abs(size_of(parameter, own)), 1e-300)
            unknowns.append(Unknown(key, values[key], *bounds_of(parameter, own), size))
    values.update(start or {})
    return Model(tuple(effects), values, tuple(replace(u, start=values[u.key]) for u in unknowns))


def shape_grid(effect: Effect, scales: Scales, most: int = 130) -> list[dict[str, float]]:
    """Every combination of the effect's shape parameters on their grids, thinned to at most `most`."""
    shapes = [p for p in effect.parameters if p.role == "shape" and not p.fixed]
    axes = [scan_values(p, _scales_for(effect, scales)) for p in shapes]
    combinations = list(itertools.product(*axes))
    if len(combinations) > most:
        combinations = combinations[:: int(np.ceil(len(combinations) / most))]
    return [
        {f"{effect.name}.{p.name}": float(v) for p, v in zip(shapes, combination, strict=True)}
        for combination in combinations
    ]


def public_name(effect: str) -> str:
    """Public name of an effect: without its variant, number of the copy and channel."""
    return split_channel(effect)[0].partition("#")[0].partition(":")[0]


def variant_group(effect: str) -> str:
    """Name of the group in which one variant replaces another: without its variant, with its copy and channel."""
    plain, channel = split_channel(effect)
    law, copied, copy = plain.partition("#")
    return law.partition(":")[0] + copied + copy + (f"@{channel}" if channel else "")
