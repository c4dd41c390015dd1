"""What a parameter file leaves open: values that carry a deviation, and dimensions that carry a tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from stagecad.parameters.design import Design


@dataclass(frozen=True)
class Open:
    """One parameter that is drawn: normally about its value with `std`, or evenly within `reach` either way."""

    key: str
    value: float
    unit: str
    std: float | None
    reach: float

    def drawn(self, random: np.random.Generator, count: int) -> np.ndarray:
        """Values in `unit`, shape (count,)."""
        if self.std is not None:
            return random.normal(self.value, self.std, count)
        return random.uniform(self.value - self.reach, self.value + self.reach, count)

    @property
    def words(self) -> str:
        """How it is drawn, for a person."""
        if self.std is not None:
            return f"{self.key} = {self.value:g} +- {self.std:g} {self.unit}".rstrip()
        return f"{self.key} = {self.value:g} {self.unit} within {self.reach:g} {self.unit}"


def reads(experiment: str, key: str) -> bool:
    """Whether an experiment may depend on a parameter: the friction ones on their table, the stage on all."""
    if experiment == "tip":
        return key in ("actuator.piezo_spacing", "actuator.tip_height")
    return experiment == "stage" or key.startswith("friction.")


def open_parameters(design: Design, experiments: Sequence[str], own_mass: bool) -> tuple[Open, ...]:
    """What is drawn for the experiments: values with a `+-`, and toleranced dimensions.

    Args:
        design: as it stands.
        experiments: names.
        own_mass: whether the moving mass is the design's `friction.mass`.
    """
    found = []
    for entry in design.entries:
        if isinstance(entry.value, bool | str | int) or not any(reads(name, entry.key) for name in experiments):
            continue
        if entry.key == "friction.mass" and not own_mass:
            continue
        # A class in millimetres says nothing of an angle.
        reach = design.plus_minus(entry.key) if entry.unit == "mm" else 0.0
        if entry.std or reach > 0.0:
            found.append(Open(entry.key, float(entry.value), entry.unit, entry.std or None, reach))
    return tuple(found)
