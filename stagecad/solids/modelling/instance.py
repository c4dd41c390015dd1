"""One instance of a part in an assembly."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from stagecad.solids.modelling.frame import Frame


@dataclass(frozen=True)
class Instance:
    """One instance of a part in the assembly.

    Attributes:
        name: unique: the part's, with a number or side if there are several.
        part: name of the part.
        frame: position in the assembly.
        exploded: position in the exploded view.
        compression: of a spring, relative to its installed length at mid-adjustment, mm.
    """

    name: str
    part: str
    frame: Frame
    exploded: Frame
    compression: float = 0.0

    @property
    def shape(self) -> str:
        """Name of its shape: that of the part; for a compressed spring with the compression."""
        return self.part if abs(self.compression) < 1e-6 else f"{self.part}@{self.compression:.6f}"


def count(instances: Iterable[Instance]) -> dict[str, int]:
    """Number of each part, in the order of their first appearance."""
    counts: dict[str, int] = {}
    for instance in instances:
        counts[instance.part] = counts.get(instance.part, 0) + 1
    return counts
