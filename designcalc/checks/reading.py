"""What a check reads of the design, noted as it is read, so that every check can show its inputs with their origins."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from designcalc.checks.check import Check, Input
from stagecad.parameters.quantities import format_quantity

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import MassProperties


_SI = {"mm": "m", "deg": "rad"}
"""SI of the units that geometry is kept in; every other unit of a design is SI already."""


def show(value: float, unit: str = "") -> str:
    """A number for a formula with numbers put in."""
    return format_quantity(float(value), unit, 4)


class Reading:
    """Reads SI numbers of one design for one check, and makes the check with them as its inputs.

    Args:
        design: the design.
        body: mass properties of the moving body from the solids; without them mass and centre are estimated from the
            stage's plain plate, and the inputs say so.
        subject: what the checks are about.
    """

    def __init__(self, design: Design, body: MassProperties | None, subject: str) -> None:
        self.design = design
        self.body = body
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

    def given(self, name: str, value: float, unit: str, origin: str) -> float:
        """Note a number that is no parameter: from the solids, or worked out elsewhere."""
        self.inputs[name] = Input(float(value), unit, origin)
        return float(value)

    def mass(self) -> float:
        """Mass of the moving body, kg."""
        if self.body is not None:
            return self.given("moving body mass", self.body.mass, "kg", "measured from the solids")
        plate = self("stage.length") * self("stage.width") * self("stage.thickness")
        return self.given(
            "moving body mass",
            plate * self.material("stage", "density"),
            "kg",
            "estimated: the stage as a plain plate, since no solids were built",
        )

    def centre(self) -> tuple[float, float]:
        """Centre of mass of the moving body in the plane of motion, from the middle of the stage, m."""
        if self.body is None:
            return 0.0, 0.0
        x, y = float(self.body.centre_of_mass[0]), float(self.body.centre_of_mass[1])
        self.given("centre of mass along", x, "m", "measured from the solids")
        self.given("centre of mass across", y, "m", "measured from the solids")
        return x, y

    def check(
        self,
        name: str,
        value: float | None,
        limit: float | None,
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
