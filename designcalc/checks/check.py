"""One design check: a value held against a limit, with everything needed to believe it or to argue with it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

from stagecad.parameters.units import as_json, format_quantity

Verdict = Literal["passes", "fails", "out_of_range", "undecidable"]


@dataclass(frozen=True)
class Input:
    """A number that went into a check."""

    value: float
    """SI"""
    unit: str
    origin: str
    """origin in the parameter file, or where else the number comes from"""

    def text(self) -> str:
        """For people, with a sensible prefix."""
        return format_quantity(self.value, self.unit)


@dataclass(frozen=True)
class Check:
    """A value, its limit, and the verdict.

    `margin` is the part of the limit that is left: ``(limit - value)/|limit|`` where the value must stay below, with
    the sign turned where it must reach the limit; negative when the check fails. With a limit of zero it is the
    distance itself, in the unit of the value.
    """

    name: str
    subject: str
    value: float | None
    limit: float | None
    unit: str
    at_most: bool
    """True: the value must not exceed the limit; False: it must reach it"""
    source: str
    formula: str
    substituted: str = ""
    inputs: dict[str, Input] = field(default_factory=dict)
    proposal: str = ""
    """the change that would pass; empty when the check passes with room"""
    thesis: str = ""
    """what the thesis says, where that is wrong or differs"""
    requirement: str = ""
    """entry of the thesis's Tables 1 and 2 that this check bears on"""
    note: str = ""
    trouble: Literal["", "out_of_range", "undecidable"] = ""
    """why there is no verdict: outside the formula's range, or a number is missing"""

    @property
    def margin(self) -> float | None:
        """Part of the limit left, negative when the check fails; none without a value."""
        if self.value is None or self.limit is None or math.isnan(self.value) or math.isinf(self.limit):
            return None
        room = self.limit - self.value if self.at_most else self.value - self.limit
        return room / abs(self.limit) if self.limit != 0 else room

    @property
    def verdict(self) -> Verdict:
        """Passes on the limit itself; a hair of rounding (1e-9 of it) does not fail a design."""
        if self.trouble:
            return self.trouble
        margin = self.margin
        if margin is None:
            return "undecidable"
        return "passes" if margin >= -1e-9 else "fails"

    def as_json(self) -> dict[str, Any]:
        """The check as it stands in a JSON document."""
        return {
            "name": self.name,
            "subject": self.subject,
            "value": None if self.value is None else as_json(self.value, self.unit),
            "limit": None if self.limit is None else as_json(self.limit, self.unit),
            "sense": "at most" if self.at_most else "at least",
            "margin": self.margin,
            "verdict": self.verdict,
            "source": self.source,
            "formula": self.formula,
            "substituted": self.substituted,
            "inputs": {
                name: {**as_json(item.value, item.unit), "origin": item.origin} for name, item in self.inputs.items()
            },
            "proposal": self.proposal,
            "thesis": self.thesis,
            "requirement": self.requirement,
            "note": self.note,
        }
