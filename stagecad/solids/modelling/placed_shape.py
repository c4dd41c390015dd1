"""A shape with its name, colour and position, for exports and pictures; the colour follows from the material."""

from __future__ import annotations

from dataclasses import dataclass

from stagecad.solids.modelling.frame import UNMOVED, Frame

Colour = tuple[float, float, float]

BY_MATERIAL: dict[str, Colour] = {
    "al6061": (0.74, 0.77, 0.80),
    "invar": (0.62, 0.62, 0.66),
    "sus416": (0.58, 0.60, 0.64),
    "sic": (0.27, 0.31, 0.37),
    "ptfe": (0.93, 0.92, 0.86),
    "steel": (0.40, 0.42, 0.45),
    "alloysteel": (0.30, 0.31, 0.34),
    "alumina": (0.90, 0.89, 0.85),
    "iron": (0.58, 0.48, 0.42),
    "ndfeb": (0.62, 0.22, 0.20),
    "pzt": (0.85, 0.68, 0.30),
}
"""Display colours (sRGB, 0 to 1) by the first letters of a material's name in the parameter file."""

OTHER: Colour = (0.60, 0.62, 0.60)


def colour_of(material: str) -> Colour:
    """Colour of `material` (its name in the parameter file): of the longest entry that its name begins with."""
    plain = material.lower().replace("-", "").replace("_", "")
    known = sorted((name for name in BY_MATERIAL if plain.startswith(name)), key=len)
    return BY_MATERIAL[known[-1]] if known else OTHER


@dataclass(frozen=True)
class PlacedShape:
    """A shape in an assembly.

    Attributes:
        name: of this instance.
        part: name of the shape; equal to `name` for a single part.
        colour: sRGB, 0 to 1.
        frame: position in the assembly.
    """

    name: str
    part: str
    colour: Colour
    frame: Frame = UNMOVED
