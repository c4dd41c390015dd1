"""Drawn machines as a JSON document and as a table."""

from __future__ import annotations

from typing import Any

import numpy as np

from stagecad.parameters.units import to_si
from workbench.simulation.monte_carlo import Study
from workbench.simulation.uncertain_parameters import Open


def study_document(study: Study, count: int, seed: int) -> dict[str, Any]:
    """The draws as a JSON document: what was drawn, and each feature's band, nested as `simulate` gives features."""

    def si(one: Open, value: float) -> dict[str, Any]:
        unit = {"mm": "m", "deg": "rad"}.get(one.unit, one.unit) or "1"
        return {"value": to_si(value, one.unit), "unit": unit}

    nested: dict[str, Any] = {}
    for name, spread in study.spreads.items():
        *way, last = name
        inner = nested
        for step in way:
            inner = inner.setdefault(step, {})
        inner[last] = spread.as_json()
    return {
        "draws": count,
        "seed": seed,
        "drawn": {
            one.key: {**si(one, one.value), "std": si(one, one.std)["value"]}
            if one.std is not None
            else {**si(one, one.value), "plus_minus": si(one, one.reach)["value"]}
            for one in study.opened
        },
        "refused": [{"draw": k, "reason": reason} for k, reason in study.refused],
        "features": nested,
    }


def study_columns(study: Study) -> dict[str, np.ndarray]:
    """A row for each draw: what was drawn, in SI, and every feature."""
    columns = {}
    for one, column in zip(study.opened, study.values.T):
        unit = {"mm": "m", "deg": "rad"}.get(one.unit, one.unit) or "1"
        columns[f"{one.key} [{unit}]"] = np.array([to_si(value, one.unit) for value in column])
    for name, spread in study.spreads.items():
        columns[f"{'.'.join(name)} [{spread.unit}]"] = spread.values
    return columns
