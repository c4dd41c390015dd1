"""Texts of geometrical tolerances, and the tolerances whose control frames are below the callout of holes."""

from __future__ import annotations

from collections.abc import Sequence

from drawings.dimensions.text import DIAMETER
from stagecad.parameters.dimension import FaceRequirement, GeometricTolerance

AXIAL = ("perpendicularity", "parallelism", "angularity", "position", "coaxiality", "straightness")
"""Characteristics that hold for the axis of a round feature, within a cylinder."""


def tolerance_text(tolerance: GeometricTolerance) -> str:
    """The second compartment of a control frame: `⌀0.2 CZ`."""
    cylindrical = tolerance.round and tolerance.characteristic in AXIAL
    return f"{DIAMETER if cylindrical else ''}{tolerance.value:g}{' CZ' if tolerance.combined else ''}"


def frames_of_features(requirements: Sequence[FaceRequirement]) -> dict[str, list[GeometricTolerance]]:
    """Tolerances by the name of the holes whose callout has their control frames."""
    found: dict[str, list[GeometricTolerance]] = {}
    for requirement in requirements:
        if isinstance(requirement, GeometricTolerance) and requirement.feature:
            found.setdefault(requirement.feature, []).append(requirement)
    return found
