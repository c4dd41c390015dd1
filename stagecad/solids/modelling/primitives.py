"""Blanks and pockets milled from plate: rounded rectangles, edges selected by position. Lengths in millimetres."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    import cadquery as cq


Point = tuple[float, float, float]


def plate(centre: Point, length: float, width: float, height: float, *, corner_radius: float = 0.0) -> cq.Solid:
    """Prism of length (x) by width (y), rising by height (z) from `centre`, the middle of its lower face.

    corner_radius rounds the four upright edges (the cutter's radius in a pocket, a handling radius on a plate);
    it must stay below half the shorter side. A negative height makes it hang below `centre`.
    """
    import cadquery as cq

    x, y, z = centre
    low = min(z, z + height)
    block = cq.Solid.makeBox(length, width, abs(height), cq.Vector(x - length / 2, y - width / 2, low))
    if corner_radius > 0.0:
        block = block.fillet(corner_radius, upright_edges(block))
    return _solid(block)


def upright_edges(shape: cq.Shape) -> list[cq.Edge]:
    """The straight edges of a shape that run along z."""
    return [e for e in shape.Edges() if e.geomType() == "LINE" and abs(e.tangentAt(0.5).z) > 0.999]


def edges_where(shape: cq.Shape, keep: Callable[[cq.Vector], bool]) -> list[cq.Edge]:
    """The edges whose mid-point satisfies `keep`: selection by position."""
    return [e for e in shape.Edges() if keep(e.positionAt(0.5))]


def cut_all(body: cq.Shape, cutters: Iterable[cq.Shape]) -> cq.Solid:
    """The body with every cutter taken away in one boolean; the result must be one solid."""
    return _solid(body.cut(*cutters).clean())


def joined(body: cq.Shape, others: Iterable[cq.Shape]) -> cq.Solid:
    """The body and others as one solid, faces that continue each other merged."""
    return _solid(body.fuse(*others).clean())


def revolved(profile: cq.Workplane) -> cq.Solid:
    """A closed profile drawn in the XZ plane, turned about z."""
    return _solid(cast("cq.Shape", profile.revolve(360, (0, 0), (0, 1)).val()))


def _solid(shape: cq.Shape) -> cq.Solid:
    """The one solid a boolean left. More than one, or none, means that the dimensions cut the part apart."""
    solids = shape.Solids()
    if len(solids) != 1:
        raise ValueError(f"the dimensions leave {len(solids)} separate bodies where one part is meant")
    return solids[0]
