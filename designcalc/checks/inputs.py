"""What a check reads of the design, noted as it is read, so that every check can show its inputs with their origins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, SupportsFloat

from designcalc.checks.check import Check, Input
from stagecad.parameters.units import format_quantity

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import MassProperties


_SI = {"mm": "m", "deg": "rad"}
"""SI of the units that geometry is kept in; every other unit of a design is SI already."""


def show(value: SupportsFloat, unit: str = "") -> str:
    """A number for a formula with numbers put in."""
    return format_quantity(float(value), unit, 4)


def over(value: SupportsFloat, divisor: SupportsFloat) -> float:
    """`value/divisor` of a proposal, infinite where nothing is in the way."""
    return float(value) / float(divisor) if float(divisor) != 0 else math.inf


@dataclass(frozen=True)
class Weighed:
    """What the solids of a design weigh, as far as checks want to know."""

    moving: MassProperties
    """stage and all that rides on it, in the assembly's coordinates at mid-travel"""
    tip: MassProperties
    """one tip, in its own coordinates"""


class Reading:
    """Reads SI numbers of one design for one check, and makes the check with them as its inputs.

    Args:
        design: the design.
        weighed: what the solids weigh; without it masses are estimated from the stage's plain plate and the tip's
            limit, and the inputs say so.
        subject: what the checks are about.
    """

    def __init__(self, design: Design, weighed: Weighed | None, subject: str) -> None:
        self.design = design
        self.weighed = weighed
        self.subject = subject
        self.inputs: dict[str, Input] = {}

    def __call__(self, key: str) -> float:
        """SI value of a parameter."""
        entry = self.design.entry(key)
        value = self.design.si(key)
        self.inputs[key] = Input(value, _SI.get(entry.unit, entry.unit), entry.origin)
        return value

    def material(self, part: str, quantity: str) -> float:
        """SI value of a property of the material that a part is made of."""
        return self(f"materials.{self.design.value(f'{part}.material')}.{quantity}")

    def given(self, name: str, value: SupportsFloat, unit: str, origin: str) -> float:
        """Note a number that is no parameter: from the solids, or worked out elsewhere."""
        self.inputs[name] = Input(float(value), unit, origin)
        return float(value)

    def mass(self) -> float:
        """Mass of the moving body, kg."""
        if self.weighed is not None:
            return self.given("moving body mass", self.weighed.moving.mass, "kg", "measured from the solids")
        plate = self("stage.length") * self("stage.width") * self("stage.thickness")
        return self.given(
            "moving body mass",
            plate * self.material("stage", "density"),
            "kg",
            "estimated: the stage as a plain plate, since no solids were built",
        )

    def tip_mass(self) -> float:
        """Mass of one tip, kg."""
        if self.weighed is not None:
            return self.given("tip mass", self.weighed.tip.mass, "kg", "measured from the solids")
        return self("tip.mass_limit")

    def centre(self) -> tuple[float, float]:
        """Centre of mass of the moving body in the plane of motion, from the middle of the stage, m."""
        if self.weighed is None:
            return 0.0, 0.0
        x, y = self.weighed.moving.centre_of_mass[:2]
        self.given("centre of mass along", x, "m", "measured from the solids")
        self.given("centre of mass across", y, "m", "measured from the solids")
        return x, y

    def centre_height(self) -> float:
        """Height of the centre of mass of stage and payload over the sea, m."""
        thickness, carried, above = self("stage.thickness"), self("payload.mass"), self("payload.height")
        mass = self.mass()
        if self.weighed is None:
            own = thickness / 2
        else:
            sea = self("bearing_way.height") + self("pads.height")
            own = self.given(
                "centre of mass above the sea", self.weighed.moving.centre_of_mass[2] - sea, "m", "measured"
            )
        return (mass * own + carried * (thickness + above)) / (mass + carried)

    def turning_inertia(self) -> tuple[float, float]:
        """Moments of inertia of stage and payload about the axes along and across, through their centre, kg m^2."""
        mass, carried = self.mass(), self("payload.mass")
        length, width, thickness = self("stage.length"), self("stage.width"), self("stage.thickness")
        if self.weighed is None:
            own = mass * (width**2 + thickness**2) / 12, mass * (length**2 + thickness**2) / 12
        else:
            inertia = self.weighed.moving.inertia
            own = float(inertia[0][0]), float(inertia[1][1])
        apart = thickness / 2 + self("payload.height")
        steiner = mass * carried / (mass + carried) * apart**2 if mass + carried > 0 else 0.0
        along = self.given("inertia about the axis along", own[0] + steiner, "kg*m^2", "stage and a payload at a point")
        across = self.given(
            "inertia about the axis across", own[1] + steiner, "kg*m^2", "stage and a payload at a point"
        )
        return along, across

    def check(
        self,
        name: str,
        value: SupportsFloat | None,
        limit: SupportsFloat | None,
        unit: str,
        sense: Literal["at most", "at least"],
        source: str,
        formula: str,
        substituted: str = "",
        proposal: str = "",
        thesis: str = "",
        requirement: str = "",
        note: str = "",
        trouble: Literal["", "out_of_range", "undecidable"] = "",
    ) -> Check:
        """The check, with all that has been read so far as its inputs; what is read next belongs to the next check.

        A proposal is kept only where the check does not pass.
        """
        inputs, self.inputs = self.inputs, {}
        made = Check(
            name=name,
            subject=self.subject,
            value=None if value is None else float(value),
            limit=None if limit is None else float(limit),
            unit=unit,
            at_most=sense == "at most",
            source=source,
            formula=formula,
            substituted=substituted,
            inputs=inputs,
            thesis=thesis,
            requirement=requirement,
            note=note,
            trouble=trouble,
            proposal=proposal,
        )
        if made.verdict != "passes" or not proposal:
            return made
        return Check(**{**made.__dict__, "proposal": ""})
