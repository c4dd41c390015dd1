"""Product and manufacturing information (PMI) of a part as plain data, from the declarations of its drawing.

Declarations that AP242 can represent become dimensions, datums and tolerances; all others become texts, of the
dimension of the same feature or of the product. Millimetres and degrees.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from drawings.dimensions.text import dimension_text, number
from stagecad.parameters.dimension import (
    DatumFeature,
    Dimension,
    FaceRequirement,
    GeometricTolerance,
    Kind,
    SurfaceTexture,
)

TEXT_ONLY: tuple[Kind, ...] = ("count", "callout", "thread_depth", "sag", "pitch_circle")
"""Kinds of declaration that are no distance, angle or size of the solid: they become texts."""


@dataclass(frozen=True)
class TolerancedDimension:
    """One dimension."""

    declaration: Dimension
    limits: tuple[float, float] | None  # lower and upper limit deviation, mm; None without a class, and for angles
    decimals: int | None  # as printed on the sheet; None without a class
    notes: tuple[str, ...]  # count, designation and note


@dataclass(frozen=True)
class PartPmi:
    """The information of one part."""

    dimensions: tuple[TolerancedDimension, ...]
    datums: tuple[DatumFeature, ...]
    tolerances: tuple[GeometricTolerance, ...]
    texts: dict[str, str]  # of the product, by name


def pmi_of_declarations(
    design: Any,
    dimensions: Iterable[Dimension],
    requirements: Iterable[FaceRequirement] = (),
    notes: Iterable[str] = (),
) -> PartPmi:
    """The information in the declarations of a part."""
    tolerated: list[TolerancedDimension] = []
    texts: dict[str, str] = {}
    dimensions, requirements = tuple(dimensions), tuple(requirements)
    for dimension in dimensions:
        if dimension.kind not in TEXT_ONLY:
            tolerated.append(_tolerated(design, dimension))
    for dimension in dimensions:
        if dimension.kind in TEXT_ONLY:
            same = (n for n, other in enumerate(tolerated) if other.declaration.feature == dimension.feature)
            place = next(same, None) if dimension.feature else None
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
    return PartPmi(
        tuple(tolerated),
        tuple(r for r in requirements if isinstance(r, DatumFeature)),
        tuple(r for r in requirements if isinstance(r, GeometricTolerance)),
        texts,
    )


def _tolerated(design: Any, dimension: Dimension) -> TolerancedDimension:
    notes = [f"{dimension.count}x"] if dimension.count > 1 else []
    if dimension.kind == "slope":
        notes.append(f"slope {dimension.value:g}")
    if dimension.kind == "chamfer":
        notes.append("45 deg")
    if dimension.exact:
        notes.append("theoretically exact")
    if dimension.note:
        notes.append(dimension.note)
    if dimension.kind == "pitch":
        # The file has the distance of the first and last feature.
        notes = [dimension_text(dimension, _plus_minus(design, dimension) or 0.0), *notes[1:]]
        dimension = replace(dimension, kind="linear", value=dimension.value * dimension.count, count=1)
    plus_minus = _plus_minus(design, dimension)
    printed = number(dimension.value, dimension.tolerance, plus_minus or 0.0).partition(" ")[0]
    decimals = len(printed.partition(".")[2]) if dimension.tolerance and not dimension.exact else None
    limits = dimension.deviations or (None if plus_minus is None else (-plus_minus, plus_minus))
    return TolerancedDimension(dimension, limits, decimals, tuple(notes))


def _plus_minus(design: Any, dimension: Dimension) -> float | None:
    # The tolerance classes apply to lengths only.
    if dimension.tolerance is None or dimension.reference or dimension.exact or dimension.kind in ("angle", "slope"):
        return None
    if dimension.deviations is not None:
        low, high = dimension.deviations
        return (high - low) / 2
    names = {"X": "tolerance_x", "X.X": "tolerance_x_x", "X.XX": "tolerance_x_xx"}
    return getattr(design.drawing, names[dimension.tolerance])


def _as_text(design: Any, dimension: Dimension) -> str:
    if dimension.kind in ("callout", "sag", "pitch_circle"):
        return dimension_text(dimension, 0.0).replace("±", "+-")
    plus_minus = _plus_minus(design, dimension)
    text = number(dimension.value, dimension.tolerance, plus_minus or 0.0).partition(" ")[0]
    if plus_minus:
        text += f" +-{plus_minus:g}"
    return f"{text}, {dimension.note}" if dimension.note else text
