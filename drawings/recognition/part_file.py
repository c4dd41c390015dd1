"""Solids without declarations in the position in which they are drawn, and their proposal: as data, and in Python."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import combinations, starmap
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from drawings.dimensions.levels import AXES, along_of, axis_of_reference, is_mirrored
from drawings.recognition.visible import ProposedDatum
from drawings.views.view import dot
from stagecad.parameters.dimension import Dimension, Point
from stagecad.solids.modelling.dimensioning import DimensionDeclarations
from stagecad.solids.modelling.frame import add, cross, scaled, subtract
from stagecad.solids.modelling.kernel import cq, unlocated
from stagecad.solids.modelling.surface import Surface
from stagecad.solids.modelling.verification import DimensionVerifier

TURNS = {"x": None, "y": ((0, 0, 1), -90.0), "z": ((0, 1, 0), 90.0)}
"""Rotation that brings an axis of the part to x."""
UPRIGHT = {"x": ((0, 1, 0), -90.0), "y": ((1, 0, 0), 90.0), "z": None}
"""Rotation that brings an axis of the part to z."""

MATERIAL = "steel"
"""Of a part whose file does not name any."""
ALIKE = 1e-3
"""Relative difference of area up to which two faces may be mirror images."""

PART = Path(__file__).with_suffix(".py.txt")
"""Template of the file of a part."""


@dataclass(frozen=True)
class Proposed:
    """One declaration: method, name, key and value of its parameter, and the arguments that follow the key."""

    method: str
    name: str
    key: str
    value: float
    arguments: tuple[Any, ...]
    fields: dict[str, Any] = field(default_factory=dict)
    order: int = 0  # of several that say the same, the one of the highest order is left out


@dataclass(frozen=True)
class Proposal:
    """Proposed dimensions of a solid."""

    dimensions: tuple[Proposed, ...]  # in the order of the sheet
    questions: tuple[str, ...]  # what only the designer knows, a line each
    open: tuple[str, ...]  # what the dimensions leave open, a line each
    views: tuple[str, ...]  # in which they are
    datums: tuple[ProposedDatum, ...] = ()  # a datum system
    model: tuple[str, ...] = ()  # what the model gives
    undefined: tuple[str, ...] = ()  # faces that no dimension gives, but the model


def as_dimension(one: Proposed) -> Dimension:
    """A proposal as a dimension without a design, in the general class."""
    design = SimpleNamespace(part=SimpleNamespace(**{one.key: one.value}), tolerance=lambda key: "X.X")
    declarations = DimensionDeclarations(design, "part")
    getattr(declarations, one.method)(one.name, one.key, *one.arguments, **one.fields)
    return next(iter(declarations))


def part_text(name: str, source: str, proposal: Proposal, quantity: int = 1) -> str:
    """The proposal as the file of a part."""
    asked = [*proposal.questions, f"material: is it {MATERIAL}?", *(f"open: {line}" for line in proposal.open)]
    notes = ["PROPOSED by stagecad from the solid: a designer has to check dimensions and tolerances."]
    if quantity > 1:
        notes.append(f"Quantity: {quantity}.")
    model = (*proposal.model, *(["faces without dimensions"] if proposal.undefined else []))
    if model:
        text = " and ".join(model)
        notes.append(f"{text.capitalize()}: by the model {name}_ap242.step, general tolerance of profile (ISO 22081).")
    parameters = {one.key: _value_text(one) for one in proposal.dimensions}
    return PART.read_text("utf-8").format(
        name=name,
        source=source,
        questions="".join(f"\n- {line}" for line in asked) + "\n",
        parameters="".join(f"    {key!r}: {text},\n" for key, text in parameters.items()),
        views=tuple(view for view in proposal.views if view not in ("section", "auxiliary")),
        notes=tuple(notes),
        model=bool(proposal.model),
        faces="".join(f"    {one!r},\n" for one in proposal.undefined),
        material=MATERIAL,
        dimensions="".join(f"    {_call(one)}\n" for one in proposal.dimensions),
        datums="".join(f"    {_datum(one)}\n" for one in proposal.datums),
    )


def _value_text(one: Proposed) -> str:
    """A length as a parameter, in the general class of one decimal, whatever decimals it needs; an angle in degrees."""
    value = one.value
    if one.method == "angle":
        return repr(f"{value:.9g} deg")
    if abs(value - round(value, 1)) < 1e-6:
        return repr(f"{value:.1f} mm")
    return repr({"value": f"{value:.9f}".rstrip("0") + " mm", "tolerance": "X.X"})


def _call(one: Proposed) -> str:
    arguments: list[Any] = [one.name, one.key, *one.arguments]
    words = [*map(repr, arguments), *(f"{key}={value!r}" for key, value in one.fields.items())]
    return f"d.{one.method}({', '.join(words)})"


def _datum(one: ProposedDatum) -> str:
    more = ", round=True" if one.round else ""
    return f"f.datum({one.letter!r}, {one.points!r}, {one.normal!r}, {one.view!r}{more})"


def along_axes(solid: cq.Solid) -> cq.Solid:
    """A solid turned so that most of its faces are square to an axis or, as tapered flanks, mirrored about one; one of
    which faces are square to two axes of its file is in the position in which it was designed."""
    areas: dict[Point, float] = {}
    for surface in DimensionVerifier(solid).surfaces:
        if surface.kind in ("PLANE", "CYLINDER"):
            axis = next((one for one in areas if abs(dot(one, surface.axis)) > 1 - 1e-6), surface.axis)
            areas[axis] = areas.get(axis, 0.0) + surface.face.Area()

    if sum(any(abs(dot(one, unit)) > 1 - 1e-9 for one in areas) for unit in AXES.values()) > 1:
        return solid

    def aligned(frame: tuple[Point, ...]) -> float:
        """Area of the faces that are square to an axis, or of which an axis has a mirror image."""
        found = 0.0
        for one, area in areas.items():
            images = [subtract(one, scaled(axis, 2 * dot(one, axis))) for axis in frame]
            like = [two for two, other in areas.items() if two is not one and math.isclose(area, other, rel_tol=ALIKE)]
            square = any(dot(image, one) < 1e-6 - 1 for image in images)
            found += area * (square or any(abs(dot(image, two)) > 1 - 1e-6 for image in images for two in like))
        return found

    first = max(areas, key=areas.__getitem__, default=(0.0, 0.0, 1.0))
    beside = sorted((one for one in areas if abs(dot(one, first)) < 1e-6), key=areas.__getitem__, reverse=True)
    pairs = (pair for pair in combinations(beside, 2) if math.isclose(*map(areas.__getitem__, pair), rel_tol=ALIKE))
    between = [scaled(half, 1 / math.hypot(*half)) for half in starmap(add, pairs)]
    frame = max(((first, one, cross(first, one)) for one in (*beside, *between)), key=aligned, default=None)
    if frame is None or aligned(frame) < 1.01 * aligned(((1, 0, 0), (0, 1, 0), (0, 0, 1))):
        return solid
    return solid.moved(cq.Location(cq.Plane((0, 0, 0), frame[1], first)).inverse)


def in_position(solid: cq.Solid) -> cq.Solid:
    """A solid as it is drawn: along the axes, a long turned part along x, a disc along z, on its lowest face, symmetric
    parts about the origin, others from their lower left corner."""
    solid = along_axes(solid)
    surfaces = DimensionVerifier(solid).surfaces
    axis = _turning_axis(surfaces)
    if axis is not None:
        name, length, diameter, _ = axis
        turn = (TURNS if length > diameter else UPRIGHT)[name]
        if turn:
            solid = solid.rotate((0, 0, 0), *turn)
        surfaces = DimensionVerifier(solid).surfaces
        axis = _turning_axis(surfaces)
    low, high = _box(surfaces)
    shift = [-round(value, 6) for value in low]  # a box of the kernel is larger than its face by 1e-7
    for number, name in enumerate("xyz"):
        middle = (low[number] + high[number]) / 2
        if axis is not None and name != axis[0]:
            shift[number] = -axis[3][number]
        elif name != "z" and axis is None and is_mirrored(surfaces, number, middle):
            shift[number] = -middle
        elif axis is None and (reference := axis_of_reference(surfaces, AXES[name])):
            shift[number] = -round(reference.origin[number], 9)
    return unlocated(solid.translate((shift[0], shift[1], shift[2])))


def _box(surfaces: list[Surface]) -> tuple[list[float], list[float]]:
    return [min(s.low[n] for s in surfaces) for n in range(3)], [max(s.high[n] for s in surfaces) for n in range(3)]


def _turning_axis(surfaces: list[Surface]) -> tuple[str, float, float, tuple[float, float, float]] | None:
    """Name of the axis of a part whose largest outer faces are a cylinder and balls about it, length, diameter, a
    point."""
    outside = [s for s in surfaces if s.kind == "CYLINDER" and s.outward]
    largest = max(outside, key=lambda s: s.radius, default=None)
    name = along_of(largest.axis) if largest else None
    if largest is None or name is None:
        return None
    low, high = _box(surfaces)
    number = "xyz".index(name)
    balls = [s.radius for s in surfaces if s.kind == "SPHERE" and largest.off_axis(s.origin) < 0.01]
    radius = max(largest.radius, *balls, 0.0)
    # A slit or flat may have removed the outline at one side.
    sides = [abs(side[n] - largest.origin[n]) for side in (low, high) for n in range(3) if n != number]
    if max(sides) > radius + 0.01 or sum(abs(side - radius) < 0.01 for side in sides) < 3:
        return None
    return name, high[number] - low[number], 2 * radius, largest.origin
