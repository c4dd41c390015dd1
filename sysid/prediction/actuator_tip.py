"""An actuator-tip record: voltages in, tip motion out, through piezos, a rigid tip and sensors.

    d_i = gain * (voltage_i - bias_voltage)
    two piezos:    tip_x = -h (d2 - d1)/D,  tip_y = (d1 + d2)/2
    three piezos:  tip_y = (d1 + d2 + d3)/3,  tip_z = -h [d3 - (d1 + d2)/2] / (D sqrt(3)/2)

with one offset per channel. The prediction is of the measured output itself, so this form is `output`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Protocol

import numpy as np

from sim.effects.effect import Effect
from sysid.experiment.experiment import Rig
from sysid.experiment.known import Known
from sysid.experiment.record import Record
from sysid.noise.estimate import Noise
from sysid.prediction.effect_terms import Values, kept_term, values_of
from sysid.prediction.model import Scales
from sysid.prediction.prepared_record import PredictsChannels, PreparedRecord
from sysid.prediction.resampling import uniform
from sysid.prediction.rig_model import Channels, Effects, Noises, RigModel, RigParameters, Start
from sysid.prediction.sensors import sensed
from sysid.signals import filled

VOLTAGES = ("voltage_1", "voltage_2", "voltage_3")
TIP_CHANNELS = ("tip_x", "tip_y", "tip_z")
LENGTHS = {"piezo_spacing": "46 mm", "tip_height": "20 mm"}
"""Known quantities that relate the voltages to the motion of a tip, each with an example."""


class DrivenPiezos(Protocol):
    """A prepared record with the voltages of one actuator from their bias, V, each (n,)."""

    drives: list[np.ndarray]
    step: float


@dataclass(eq=False, kw_only=True)
class TipRecord(PreparedRecord):
    """One actuator-tip record, with the voltages of its piezos from their bias, V, each (n,)."""

    drives: list[np.ndarray]
    piezo_spacing: float
    tip_height: float

    @property
    def size(self) -> int:
        return self.drives[0].size

    @property
    def settled_from(self) -> int:
        """First row after the first reversal of every voltage."""
        return max((_first_reversal(drive) for drive in self.drives), default=0)

    def scales(self) -> dict[str, float]:
        return {
            "time": float(self.time[-1]),
            "sample": self.step,
            "input": max(float(np.ptp(u)) for u in self.drives),
            "channel": max(float(np.ptp(y)) for y in self.measured.values()),
        }

    def driven_by(self, name: str, step: float, drives: list[np.ndarray]) -> TipRecord:
        """The record as if the rig had been driven by other voltages, V, each (n,)."""
        n = drives[0].size
        measured, valid = dict.fromkeys(self.measured, np.zeros(n)), dict.fromkeys(self.measured, np.arange(n) >= 1)
        return replace(self, name=name, step=step, drives=drives, measured=measured, valid=valid)


def _first_reversal(drive: np.ndarray) -> int:
    """First row at which a signal (n,) changes its direction; its size where it does not."""
    changes = np.flatnonzero(np.diff(drive))
    signs = np.sign(np.diff(drive)[changes])
    turns = np.flatnonzero(signs[1:] != signs[:-1])
    return int(changes[turns[0] + 1]) if turns.size else (0 if changes.size == 0 else drive.size)


def piezo_signals(
    channels: Mapping[str, np.ndarray], missing: np.ndarray, known: Mapping[str, Known], names: Sequence[str]
) -> tuple[list[np.ndarray], dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Voltage of each piezo from its bias, V, the measured channels of these `names`, and the rows of each that count,
    (n,), gaps bridged: not the first row, nor `missing` ones, nor those with a gap there or in a voltage."""
    bias = known["bias_voltage"].value if "bias_voltage" in known else 0.0
    drives, measured, valid = [], {}, {}
    for name in VOLTAGES:
        if name in channels:
            voltage, gap = filled(channels[name])
            missing = missing | gap
            drives.append(voltage - bias)
    for name in names:
        if name in channels:
            measured[name], gap = filled(channels[name])
            valid[name] = ~(gap | missing)
            valid[name][0] = False
    return drives, measured, valid


def tip_record(
    rig: PredictsChannels, record: Record, known: Mapping[str, Known], noise: Mapping[str, Noise]
) -> TipRecord:
    """A record of an actuator tip, with the design's or the user's `piezo_spacing` and `tip_height`, m."""
    _, step, channels, hole = uniform(record)
    drives, measured, valid = piezo_signals(channels, hole, known, TIP_CHANNELS)
    return TipRecord(
        name=record.name,
        role=record.role,
        rig=rig,
        step=step,
        drives=drives,
        measured=measured,
        valid=valid,
        noise={name: noise[name].value for name in measured},
        piezo_spacing=known["piezo_spacing"].value,
        tip_height=known["tip_height"].value,
    )


def piezo_stretch(record: DrivenPiezos, effects: Effects, values: Values, index: int) -> np.ndarray:
    """Stretch (n,) of one piezo over its gain, V, after every effect on drive and piezo."""
    signal, key = record.drives[index], ("stretch", index)
    for effect in effects:
        if effect.acts_on not in ("drive", "piezo") or effect.signal is None or effect.piezo not in (None, index):
            continue
        p = values_of(effect, values)
        key = (*key, effect.name, p)
        signal = kept_term(record, key, partial(effect.signal, signal, record.step, p))
    return signal


def predict_tip(
    record: TipRecord, effects: Effects, values: Values, at: Mapping[str, np.ndarray] | None = None
) -> Channels:
    """Predicted tip channels, m, (n,), or at the samples `at` of each channel, (k,)."""
    stretches = [piezo_stretch(record, effects, values, k) for k in range(len(record.drives))]
    gain, lever = values["rig.gain"], record.tip_height / record.piezo_spacing
    first, second = stretches[0], stretches[1]
    out: dict[str, np.ndarray] = {"tip_x": -lever * gain * (second - first), "tip_y": 0.5 * gain * (first + second)}
    if len(stretches) == 3:
        third = stretches[2]
        out["tip_y"] = gain * (first + second + third) / 3.0
        depth = record.piezo_spacing * np.sqrt(3.0) / 2.0
        out["tip_z"] = -record.tip_height * gain * (third - 0.5 * (first + second)) / depth
    out = {name: signal for name, signal in out.items() if name in record.measured}
    for effect in effects:
        if effect.is_mode and effect.signal is not None:
            p: Any = values_of(effect, values)
            part = getattr(p, "mass_ratio", 1.0)
            out = {n: u + part * (effect.signal(u, record.step, p) - u) for n, u in out.items()}
    out = {name: u + values[f"rig.offset_{name}"] for name, u in out.items()}
    out = sensed(effects, values, out, record.step)
    return out if at is None else {channel: out[channel][index] for channel, index in at.items()}


class ActuatorTip(RigModel):
    """Voltages in, tip motion out."""

    name = "actuator-tip"
    predict = staticmethod(predict_tip)
    required = LENGTHS

    def parameters(self, rig: Rig, records: Sequence[Record], noise: Noises) -> RigParameters:
        fits = [r for r in records if r.role == "fit"]
        rows = {c: np.concatenate([r.channels[c] for r in fits]) for c in fits[0].channels}
        spread = max(float(np.nanstd(rows[c])) for c in VOLTAGES if c in rows)
        size = max(float(np.nanstd(rows[c])) for c in TIP_CHANNELS if c in rows)
        found, gain = RigParameters(rig), size / max(spread, 1e-300)
        found.put_free("gain", gain, (0.0, np.inf), gain)
        for channel in TIP_CHANNELS:
            if channel in rows:
                found.put_free(f"offset_{channel}", float(np.nanmean(rows[channel])), (-np.inf, np.inf), size)
        return found

    def prepare(self, rig: Rig, records: Sequence[Record], noise: Noises, values: Values) -> list[TipRecord]:
        return [tip_record(self, record, rig.known, noise) for record in records]

    def shows(self, effect: Effect, records: Sequence[Any], channels: set[str]) -> bool:
        return effect.acts_on in ("drive", "piezo", "sensor") or effect.is_mode

    def sensor_places(self, channels: Sequence[str]) -> tuple[str | None, ...]:
        return (None, *channels)

    def without_motion(self, scales: Scales) -> str:
        return "the voltages never change; their effect on the tip is not identifiable" if scales.input == 0.0 else ""

    def simulate(self, rig: Rig, record: Record, effects: Effects, values: Values, start: Start | None) -> Channels:
        logged = {name: 0.0 for name in TIP_CHANNELS if f"rig.offset_{name}" in values}
        return self.predict_along(rig, record, logged, effects, values)
