"""Colour of a part by what it is made of, the same in exported models, pictures and the page."""

from __future__ import annotations

Colour = tuple[float, float, float]

BY_MATERIAL: dict[str, Colour] = {
    "aluminium": (0.74, 0.77, 0.80),
    "invar": (0.52, 0.52, 0.55),
    "sus416": (0.58, 0.60, 0.64),
    "sic": (0.20, 0.23, 0.28),
    "ptfe": (0.93, 0.92, 0.86),
    "steel": (0.33, 0.35, 0.38),
    "iron": (0.50, 0.40, 0.34),
    "magnet": (0.62, 0.22, 0.20),
    "pzt": (0.85, 0.68, 0.30),
}
"""Display colours (sRGB, 0 to 1) by the first letters of a material's name in the parameter file."""

OTHER: Colour = (0.60, 0.62, 0.60)


def colour_of(material: str) -> Colour:
    """Colour of `material` (its name in the parameter file): of the longest entry that its name begins with."""
    plain = material.lower().replace("-", "").replace("_", "").replace("aluminum", "aluminium")
    known = sorted((name for name in BY_MATERIAL if plain.startswith(name)), key=len)
    return BY_MATERIAL[known[-1]] if known else OTHER
