"""The data of the figures of fitted models, as plain numbers: curves over the records, residual maps, free values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from sysid.diagnosis.residual_maps import ResidualMap
    from sysid.prediction.model import Model
    from sysid.prediction.problem import Problem

LEAST_SHARE = 0.005
"""Share of the residual's variance from which a map is shown."""
MOST_SAMPLES = 3_000_000
"""Samples of all records up to which models are predicted on every record; above it, on the first of each role."""
USUAL_SHARE = 0.97
"""Share of the samples that the scale of the residual shows: a few next to reversals would hide all others."""


@dataclass(frozen=True)
class Curves:
    """A channel of a record with what models predict for it.

    Args:
        record, role, channel, unit: of the measured signal.
        series: arrays (n,) by name: `time`, `measured`, each model, `residual:MODEL`, `motion:NAME`; gaps are NaN.
        motion: unit by name of the logged motion.
        noise: standard deviation of the noise.
    """

    record: str
    role: str
    channel: str
    unit: str
    series: dict[str, np.ndarray]
    motion: dict[str, str]
    noise: float

    @property
    def largest(self) -> float:
        """The largest measured value, without sign."""
        return _quantile(self.series["measured"], 1.0)

    @property
    def usual(self) -> float:
        """Size of the residual of the first model that most samples stay below."""
        first = next(values for name, values in self.series.items() if name.startswith("residual:"))
        return _quantile(first, USUAL_SHARE)


def curves(problem: Problem, models: Mapping[str, Model], only: tuple[str, str] | None = None) -> Iterator[Curves]:
    """Measured and predicted signal of each channel of each record; held-out records first.

    Args:
        problem: with the prepared records.
        models: by name.
        only: the record and the channel wanted; all of them when left out.
    """
    from sysid.report import channel_unit
    from workbench.report.figures import curve_of

    samples = sum(record.size for record in problem.records) * len(models)
    for role, records in (("validate", problem.validate_records), ("fit", problem.fit_records)):
        for record in records if only or samples <= MOST_SAMPLES else records[:1]:
            for channel in record.measured:
                if only not in (None, (record.name, channel)):
                    continue
                found = curve_of(record, channel, channel_unit(problem, channel), models)
                series = {"time": found.time, "measured": found.measured, **found.predicted}
                series |= {f"residual:{m}": found.measured - values for m, values in found.predicted.items()}
                series |= {f"motion:{name}": values for name, (values, _) in found.motion.items()}
                motion = {name: unit for name, (_, unit) in found.motion.items()}
                yield Curves(found.record, role, channel, found.unit, series, motion, found.noise)


def _quantile(values: np.ndarray, share: float) -> float:
    """Quantile of the absolute values; 0 without any number."""
    sizes = np.abs(values[np.isfinite(values)])
    return float(np.quantile(sizes, share)) if sizes.size else 0.0


def residual_maps(problem: Problem, maps: Sequence[ResidualMap]) -> list[dict[str, Any]]:
    """Residual over each coordinate, in standard deviations of the noise; empty cells as None."""
    from workbench.report.map_figures import coordinate_unit

    drawable = [m for m in maps if m.centres.size > 1 and np.ptp(m.centres) > 0.0]
    chosen = [m for m in drawable if m.share > LEAST_SHARE][:9] or drawable[:3]
    rotary, tip = problem.experiment.rig.rotary, problem.kind == "actuator-tip"
    return [
        {
            "coordinate": m.coordinate,
            "unit": coordinate_unit(m.coordinate, rotary, tip),
            "share": m.share,
            "p_value": m.p_value,
            "centres": m.centres.tolist(),
            "forward": _filled(m.forward),
            "backward": _filled(m.backward),
            "forward_error": m.forward_error.tolist(),
            "backward_error": m.backward_error.tolist(),
        }
        for m in chosen
    ]


def _filled(values: np.ndarray) -> list[float | None]:
    """A cell that no sample fell into holds an exact zero."""
    return [None if value == 0.0 else float(value) for value in values]


def free_values(problem: Problem, model: Model) -> list[dict[str, Any]]:
    """Fitted values, SI, with a range around each: half to one and a half times the value, within its bounds."""
    from sysid.estimation.identifiability import public_key
    from sysid.report import parameter_unit

    found = []
    for one in model.unknowns:
        if one.key in model.nuisances:
            continue
        value = model.values[one.key]
        reach = 0.5 * abs(value) or one.size
        low, high = max(value - reach, one.low), min(value + reach, one.high)
        if high > low:
            unit = parameter_unit(problem, one.key)
            found.append(
                {"key": one.key, "name": public_key(one.key), "value": value, "low": low, "high": high, "unit": unit}
            )
    return found


def stated(problem: Problem) -> dict[str, Any]:
    """Stated model, text of the file, rig, noise and records of an experiment."""
    from workbench.identification.statements import noise_text

    rig = problem.experiment.rig
    return {
        "stated": list(problem.experiment.effects),
        "text": problem.experiment.text,
        "rig": {"kind": rig.kind, "rotary": rig.rotary},
        "noise": noise_text(problem),
        "records": [
            {
                "name": record.name,
                "role": record.role,
                "rows": record.size,
                "seconds": float(record.time[-1] - record.time[0]),
                "channels": list(record.channels),
                "notes": list(record.notes),
            }
            for record in problem.records
        ],
    }
