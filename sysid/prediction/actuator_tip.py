"""An actuator-tip record: voltages in, tip motion out, through piezos, a rigid tip and sensors.

    d_i = gain * (voltage_i - bias_voltage)
    two piezos:    tip_x = -h (d2 - d1)/D,  tip_y = (d1 + d2)/2
    three piezos:  tip_y = (d1 + d2 + d3)/3,  tip_z = -h [d3 - (d1 + d2)/2] / (D sqrt(3)/2)

with one offset per channel. The prediction is of the measured output itself, so this form is `output`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np

from sim.library.effect import Effect
from sysid.experiment.record import Record
from sysid.noise.estimate import Noise
from sysid.prediction.effect_terms import TERMS, Values, values_of
from sysid.prediction.sensors import sensed
from sysid.signals.masks import filled
from sysid.signals.resampling import uniform


class DrivenPiezos(Protocol):
    """A prepared record with the voltages of one actuator from their bias, V, each (n,)."""

    drives: list[np.ndarray]
    step: float


@dataclass(eq=False)
class TipRecord:
    """One actuator-tip record, prepared. Arrays have shape (n,), SI units, on a uniform time grid."""

    name: str
    role: str
    kind: str
    step: float
    time: np.ndarray
    drives: list[np.ndarray]
    measured: dict[str, np.ndarray]
    valid: dict[str, np.ndarray]
    noise: dict[str, float]
    piezo_spacing: float
    tip_height: float

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.time.size


def tip_record(record: Record, known: Mapping[str, float], noise: Mapping[str, Noise]) -> TipRecord:
    """A record of the rig kind `actuator-tip`, with the design's or the user's `piezo_spacing` and `tip_height`, m."""
    time, step, channels, hole = uniform(record)
    drives, missing = [], hole.copy()
    for name in ("voltage_1", "voltage_2", "voltage_3"):
        if name in channels:
            voltage, gap = filled(channels[name])
            missing |= gap
            drives.append(voltage - known.get("bias_voltage", 0.0))
    measured, valid, floor = {}, {}, {}
    for name in ("tip_x", "tip_y", "tip_z"):
        if name in channels:
            measured[name], gap = filled(channels[name])
            valid[name] = ~(gap | missing)
            valid[name][0] = False
            floor[name] = noise[name].value
    return TipRecord(
        name=record.name,
        role=record.role,
        kind="actuator-tip",
        step=step,
        time=time,
        drives=drives,
        measured=measured,
        valid=valid,
        noise=floor,
        piezo_spacing=known["piezo_spacing"],
        tip_height=known["tip_height"],
    )


def piezo_stretch(record: DrivenPiezos, effects: Sequence[Effect], values: Values, index: int) -> np.ndarray:
    """Stretch (n,) of one piezo over its gain, V, after every effect on drive and piezo."""
    signal, key = record.drives[index], ("stretch", index)
    for effect in effects:
        if effect.acts_on not in ("drive", "piezo") or effect.signal is None:
            continue
        if effect.name == "gain_mismatch" and index != 1:
            continue
        p = values_of(effect, values)
        key = (*key, effect.name, p)
        signal = TERMS.get(record, key, partial(effect.signal, signal, record.step, p))
    return signal


def predict_tip(record: TipRecord, effects: Sequence[Effect], values: Values) -> dict[str, np.ndarray]:
    """Predicted tip channels (n,), m."""
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
        if effect.acts_on == "structure" and effect.signal is not None:
            p: Any = values_of(effect, values)
            part = getattr(p, "mass_ratio", 1.0)
            out = {n: u + part * (effect.signal(u, record.step, p) - u) for n, u in out.items()}
    for name in out:
        out[name] = out[name] + values[f"rig.offset_{name}"]
    return sensed(effects, values, out, record.step)
