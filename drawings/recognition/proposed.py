"""Proposed dimensions as data."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

from drawings.recognition.visible import ProposedDatum
from stagecad.parameters.dimension import Dimension
from stagecad.solids.modelling.dimensioning import DimensionDeclarations


@dataclass(frozen=True)
class Proposed:
    """One declaration: method, name, key and value of its parameter, and the arguments that follow the key.

    Args:
        order: of several that say the same, the one of the highest order is left out.
    """

    method: str
    name: str
    key: str
    value: float
    arguments: tuple[Any, ...]
    fields: dict[str, Any] = field(default_factory=dict)
    order: int = 0


@dataclass(frozen=True)
class Proposal:
    """Proposed dimensions of a solid.

    Args:
        dimensions: in the order of the sheet.
        questions: what only the designer knows, a line each.
        open: what the dimensions leave open, a line each.
        views: in which they are.
        datums: a datum system.
    """

    dimensions: tuple[Proposed, ...]
    questions: tuple[str, ...]
    open: tuple[str, ...]
    views: tuple[str, ...]
    datums: tuple[ProposedDatum, ...] = ()


def as_dimension(one: Proposed) -> Dimension:
    """A proposal as a dimension without a design, in the general class."""
    design = SimpleNamespace(part=SimpleNamespace(**{one.key: one.value}), tolerance=lambda key: "X.X")
    declarations = DimensionDeclarations(design, "part")
    getattr(declarations, one.method)(one.name, one.key, *one.arguments, **one.fields)
    return next(iter(declarations))
