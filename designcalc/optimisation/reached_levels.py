"""Levels of the requirements of Table 1 that designs reach: the result of `requirement_levels`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Together:
    """Levels that one design meets together.

    Args:
        kept: the requirement that was kept at the level it reaches by itself; empty for none.
        levels: in the unit of their keys, by name; empty where no design was found.
    """

    kept: str
    levels: Mapping[str, float]


@dataclass(frozen=True)
class Price:
    """A check that fails with the required value of one requirement, and not with the level that was reached.

    Args:
        requirement: name in Table 1.
        check: name.
        value, limit: of the check, SI.
        unit: of both.
    """

    requirement: str
    check: str
    value: float | None
    limit: float | None
    unit: str


@dataclass
class Levels:
    """Result of the study; levels are in the units of their keys.

    Args:
        required: values of the file.
        units: of the levels.
        never: checks that pass at no level, whatever the free parameters, by requirement.
        alone: what each requirement reaches by itself, the others as required but not met.
        together: designs that meet all other checks of Table 1; nothing is kept in the first one.
        prices: what the required values of speed, acceleration and smoothness make fail.
        fronts: levels (n, 2) of two requirements by their names, the other ones left aside.
        evaluations: number of evaluated designs.
    """

    required: dict[str, float]
    units: dict[str, str]
    never: dict[str, list[str]] = field(default_factory=dict)
    alone: dict[str, float] = field(default_factory=dict)
    together: list[Together] = field(default_factory=list)
    prices: list[Price] = field(default_factory=list)
    fronts: dict[tuple[str, str], list[tuple[float, float]]] = field(default_factory=dict)
    evaluations: int = 0
