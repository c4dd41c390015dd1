"""The coordinates that a residual is held against, and the bins that they are cut into."""

from __future__ import annotations

import numpy as np

from sysid.prediction.actuator_tip import TipRecord
from sysid.prediction.model import Prepared


def coordinates_of(record: Prepared) -> dict[str, np.ndarray]:
    """The coordinates (n,) that a record's residual is held against, by the interface's names; `frequency` aside."""
    if isinstance(record, TipRecord):
        rate = np.gradient(np.mean(record.drives, axis=0), record.step)
        out = {"time": record.time, "input": np.mean(record.drives, axis=0), "velocity": rate}
        for name, signal in record.measured.items():
            out[f"position@{name}"] = signal
        out["acceleration"] = np.gradient(rate, record.step)
        return out
    axis = record.axis
    out = {
        "time": axis.time,
        "position": axis.position,
        "velocity": axis.velocity,
        "direction": axis.direction,
        "acceleration": axis.acceleration,
        "distance_since_reversal": axis.reversal_distance,
        "distance_travelled": axis.travelled,
        "contact_age": axis.contact_age,
    }
    if np.ptp(axis.load) > 0:
        out["normal_load"] = axis.load
    if np.ptp(axis.temperature) > 0:
        out["temperature"] = axis.temperature
    return out


_BY_RANK = ("velocity", "acceleration", "distance_since_reversal", "contact_age")


def edges_of(values: np.ndarray, coordinate: str, bins: int) -> np.ndarray:
    """Edges of a coordinate's bins, the outer ones open: even, or by rank where most samples share a few values."""
    if coordinate == "direction":
        return np.array([-np.inf, 0.0, np.inf])
    if coordinate in _BY_RANK:
        inner = np.unique(np.quantile(values, np.linspace(0, 1, bins + 1)[1:-1]))
    else:
        low, high = float(np.min(values)), float(np.max(values))
        inner = np.linspace(low, high, bins + 1)[1:-1]
    return np.concatenate([[-np.inf], inner, [np.inf]])


def cells_of(values: np.ndarray, direction: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Number of each sample's bin (n,), the bins of motion backwards after those forwards."""
    index = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)
    return index + (edges.size - 1) * (direction < 0)


def means_of(cells: np.ndarray, residual: np.ndarray, count: int) -> np.ndarray:
    """Mean residual per cell, drawn towards zero where a cell holds few samples."""
    number = np.bincount(cells, minlength=count)
    return np.bincount(cells, residual, minlength=count) / (number + 3.0)
