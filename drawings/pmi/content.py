"""What a part's STEP file says beside its shape: plain data, read off the declarations that its sheet is drawn from.

What the schema has a place for becomes a dimension, a datum or a tolerance; what it has none for goes along as text,
on the dimension it belongs to where there is one, else as a named text of the product. Nothing is left out.
Millimetres and degrees.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from drawings.dimensions.text import number
from stagecad.parameters.dimension import (
    DatumFeature,
    Dimension,
    FaceRequirement,
    GeometricTolerance,
    Kind,
    SurfaceTexture,
)

TEXT_ONLY: tuple[Kind, ...] = ("count", "callout", "thread_depth")
"""Kinds of declaration that the solid does not show as a distance, an angle or a size: they go along as text."""


@dataclass(frozen=True)
class ToleratedDimension:
    """One dimension as data.

    Args:
        declaration: the declaration it says.
        plus_minus: limits about the value, mm; none where its class has none, and for angles.
        decimals: as printed on the sheet; none where no class says.
        notes: count, designation and whatever else stands beside it.
    """

    declaration: Dimension
    plus_minus: float | None
    decimals: int | None
    notes: tuple[str, ...]


@dataclass(frozen=True)
class ManufacturingInformation:
    """All that is said of one part.

    Args:
        texts: by name; what belongs to no dimension.
    """

    dimensions: tuple[ToleratedDimension, ...]
    datums: tuple[DatumFeature, ...]
    tolerances: tuple[GeometricTolerance, ...]
    texts: dict[str, str]


def manufacturing_information(
    design: Any,
    dimensions: Iterable[Dimension],
    requirements: Iterable[FaceRequirement] = (),
    notes: Iterable[str] = (),
) -> ManufacturingInformation:
    """What a part's declarations come to in a STEP file.

    Args:
        design: for the general tolerances of its classes.
        dimensions, requirements, notes: of the part.
    """
    tolerated: list[ToleratedDimension] = []
    texts: dict[str, str] = {}
    dimensions, requirements = tuple(dimensions), tuple(requirements)
    for dimension in dimensions:
        if dimension.kind not in TEXT_ONLY:
            tolerated.append(_tolerated(design, dimension))
    for dimension in dimensions:
        if dimension.kind in TEXT_ONLY:
            place = next(
                (
                    index
                    for index, other in enumerate(tolerated)
                    if dimension.feature and other.declaration.feature == dimension.feature
                ),
                None,
            )
            if place is None:
                texts[dimension.name] = _as_text(design, dimension)
            else:
                text = f"{dimension.name} {_as_text(design, dimension)}"
                tolerated[place] = replace(tolerated[place], notes=(*tolerated[place].notes, text))
    for requirement in requirements:
        if isinstance(requirement, SurfaceTexture):
            process = f"{requirement.process}, " if requirement.process else ""
            texts[f"surface texture of {requirement.name}"] = f"{process}Ra {requirement.roughness:g} um"
    for index, note in enumerate(notes, start=1):
        texts[f"note {index}"] = note
    return ManufacturingInformation(
        tuple(tolerated),
        tuple(r for r in requirements if isinstance(r, DatumFeature)),
        tuple(r for r in requirements if isinstance(r, GeometricTolerance)),
        texts,
    )


def _tolerated(design: Any, dimension: Dimension) -> ToleratedDimension:
    notes = [f"{dimension.count}x"] if dimension.count > 1 else []
    if dimension.kind == "slope":
        notes.append(f"slope {dimension.value:g}")
    if dimension.kind == "chamfer":
        notes.append("45 deg")
    if dimension.note:
        notes.append(dimension.note)
    plus_minus = _plus_minus(design, dimension)
    printed = number(dimension.value, dimension.tolerance, plus_minus or 0.0).partition(" ")[0]
    decimals = len(printed.partition(".")[2]) if dimension.tolerance else None
    return ToleratedDimension(dimension, plus_minus, decimals, tuple(notes))


def _plus_minus(design: Any, dimension: Dimension) -> float | None:
    # The block's classes are lengths; they say nothing of an angle.
    if dimension.tolerance is None or dimension.kind in ("angle", "slope"):
        return None
    return design.plus_minus(dimension.parameter or dimension.derived_from[0])


def _as_text(design: Any, dimension: Dimension) -> str:
    plus_minus = _plus_minus(design, dimension)
    text = number(dimension.value, dimension.tolerance, plus_minus or 0.0).partition(" ")[0]
    if plus_minus:
        text += f" +-{plus_minus:g}"
    return f"{text}, {dimension.note}" if dimension.note else text
