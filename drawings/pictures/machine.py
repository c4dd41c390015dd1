"""The pictures of the whole machine: from above, cut along and across the travel, exploded, and from below."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drawings.pictures.picture import (
    DEFLECTION,
    EXPLODED,
    FROM_BELOW,
    SCALE,
    TOP,
    MeshedShape,
    Picture,
    Piece,
    Scene,
    meshed,
    picture,
    visible_stretches,
)
from drawings.views.section import cut_faces, cut_shape, different_hatches, hatch, in_plane
from drawings.views.view import PROJECTIONS, Cut, Projection
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.frame import UNMOVED, Box, add, subtract
from stagecad.solids.modelling.kernel import moved
from stagecad.solids.modelling.part import Instance

EYE_BELOW = Projection(
    FROM_BELOW, (1 / math.sqrt(2), 1 / math.sqrt(2), 0.0), (1 / math.sqrt(6), -1 / math.sqrt(6), 2 / math.sqrt(6))
)
"""The isometric direction from below, for the parts under the stage."""


@dataclass(frozen=True)
class MachineViews:
    """How a machine is shown."""

    # planes of the sections, by their name, with the projection in which they are seen
    cuts: Mapping[str, tuple[Cut, str]]
    # parts that a section shows whole: fasteners, pins and springs (ISO 128-3), units bought complete
    whole: tuple[str, ...]
    moving: tuple[str, ...] = ()  # parts that move; the first carries the others
    carried: tuple[str, ...] = ()  # parts that move with it
    scale: float = SCALE  # of the views
    # of the assembly sheet, a line each
    notes: tuple[str, ...] = ("- Order, torques and settings: see the procedure.",)


def machine_picture(
    name: str, instances: Sequence[Instance], scene: Scene, views: MachineViews, *, exact: bool = True
) -> Picture | None:
    """One picture of the machine; None for the picture from below where nothing moves with another part."""
    match name:
        case "top":
            pieces = [Piece(i.part, scene[i.shape], i.frame) for i in instances]
            return picture(TOP, PROJECTIONS["top"], pieces, views.scale, exact=exact)
        case "section A-A" | "section B-B":
            return _section(name, views, instances, scene, exact=exact)
        case "exploded":
            return _exploded(EXPLODED, PROJECTIONS["iso"], instances, scene, views, exact=exact)
        case "from below":
            moving = [i for i in instances if i.part in views.moving]
            return _exploded(FROM_BELOW, EYE_BELOW, moving, scene, views, exact=exact) if len(moving) > 1 else None
        case _:
            raise ValueError(f"there is no picture '{name}' of the machine")


BESIDE = (0.0, 0.02, -0.02, 0.1, -0.1)
"""Displacements of a cutting plane that the kernel is tried with, mm: it fails where the plane contains a seam."""


def _cut(shape: Any, cut: Cut) -> tuple[Any, list[Any]]:
    """A shape behind a cutting plane, with its faces in the plane; whole and without any where the kernel fails."""
    for shift in BESIDE:
        x, y, z = (p + shift * n for p, n in zip(cut.point, cut.normal, strict=True))
        beside = replace(cut, point=(x, y, z))
        try:
            left = cut_shape(shape, beside)
        except ValueError:
            continue
        return left, list(cut_faces(left, beside))
    return shape, []


def _section(name: str, views: MachineViews, instances: Sequence[Instance], scene: Scene, *, exact: bool) -> Picture:
    """The machine cut by a plane."""
    cut, seen = views.cuts[name]
    projection = PROJECTIONS[seen]
    pieces: list[Piece] = []
    cut_pieces: list[tuple[Box, list[Any]]] = []
    covers: list[np.ndarray] = []
    for instance in instances:
        shape, frame = scene[instance.shape], instance.frame
        vertices = shape.placed_vertices(frame)
        towards_eye = (vertices - np.array(cut.point)) @ np.array(cut.normal)
        if towards_eye.min() > -DEFLECTION:
            continue
        if towards_eye.max() < DEFLECTION or instance.part in views.whole:
            if towards_eye.max() > 0.0:
                covers.append(in_plane(vertices, shape.triangles, cut, projection))
            pieces.append(Piece(instance.part, shape, frame))
            continue
        left, faces = _cut(moved(shape.shape, frame), cut)
        cut_pieces.append(((tuple(vertices.min(axis=0)), tuple(vertices.max(axis=0))), faces))
        pieces.append(Piece(instance.part, meshed(left), UNMOVED))
    hatches = different_hatches([box for box, _ in cut_pieces], DEFLECTION)
    hatched = [
        line
        for (_, faces), (falling, pitch) in zip(cut_pieces, hatches, strict=True)
        for line in hatch(faces, projection, views.scale, falling=falling, pitch=pitch, covers=covers)
    ]
    shown = picture(name, projection, pieces, views.scale, exact=exact)
    curves = {**shown.view.curves, "HATCH": tuple(hatched)}
    return replace(shown, view=replace(shown.view, curves=curves, label=f"{cut.letter}-{cut.letter}", cut=cut))


def _exploded(
    name: str, projection: Projection, instances: Sequence[Instance], scene: Scene, views: MachineViews, *, exact: bool
) -> Picture:
    """Parts taken apart, with a trail line from each to its place where nothing hides it."""
    pieces = [Piece(i.part, scene[i.shape], i.exploded) for i in instances]
    shown = picture(name, projection, pieces, views.scale, exact=exact)
    found = [_trail(i, instances, scene[i.shape], views) for i in instances]
    trails = [ends for ends in found if math.dist(*ends) > DEFLECTION]
    lines = visible_stretches([(piece.shape, piece.frame) for piece in pieces], projection, trails)
    return replace(shown, view=replace(shown.view, curves={**shown.view.curves, "CENTRE": tuple(lines)}))


def _trail(
    instance: Instance, instances: Sequence[Instance], shape: MeshedShape, views: MachineViews
) -> tuple[Point, Point]:
    """The middle of a part taken apart, and its place: on the part that carries it, where that is taken apart too."""
    x, y, z = (0.5 * (shape.vertices.min(axis=0) + shape.vertices.max(axis=0))).tolist()
    start, end = instance.exploded.point((x, y, z)), instance.frame.point((x, y, z))
    alone = all(other.part in views.moving for other in instances)
    carrier = next((other for other in instances if other.name == instance.carrier), None)
    if instance.part in views.carried and (alone or instance.part != views.moving[0]):
        carrier = next(other for other in instances if other.part == views.moving[0])
    if carrier is not None:
        end = add(end, subtract(carrier.exploded.shift, carrier.frame.shift))
    return start, end
