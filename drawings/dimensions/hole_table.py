"""Hole tables: coordinates of many holes of a face, in place of their dimensions and callouts."""

from collections.abc import Sequence
from dataclasses import dataclass

from drawings.dimensions.text import number
from drawings.views.view import Point2, View
from stagecad.parameters.dimension import Dimension
from stagecad.solids.modelling.verification import DimensionVerifier


@dataclass(frozen=True)
class HoleRow:
    """One hole: name, coordinates in the view, mm, and its radius."""

    tag: str
    at: Point2
    radius: float

    @property
    def cells(self) -> tuple[str, str, str]:
        """The row as printed."""
        x, y = (number(round(value, 6) + 0.0, "X.X", 0.0).partition(" ")[0] for value in self.at)
        return (self.tag, x, y)


@dataclass(frozen=True)
class HoleGroup:
    """Equal holes."""

    lines: tuple[str, ...]  # callout
    rows: tuple[HoleRow, ...]  # the holes, from the left column up
    names: tuple[str, ...]  # declarations of the callout


@dataclass(frozen=True)
class HoleTable:
    """The table of a view."""

    view: str  # name of the view, whose origin is that of the coordinates
    groups: tuple[HoleGroup, ...]  # of equal holes
    names: tuple[str, ...]  # declarations of distances between the holes, which follow from the coordinates


def hole_group(
    letter: str, lines: tuple[str, ...], group: Sequence[Dimension], view: View, gauge: DimensionVerifier
) -> HoleGroup:
    """The rows of equal holes, with the coordinates of the solid."""
    drill = next(d for d in group if d.kind in ("diameter", "tap_drill"))
    faces = gauge.holes(drill)
    places = sorted(view.projection.to_view(face.origin) for face in faces)
    rows = (
        HoleRow(f"{letter}{index}", place, max(d.value for d in group if d.kind in ("diameter", "tap_drill")) / 2)
        for index, place in enumerate(places, start=1)
    )
    return HoleGroup(lines, tuple(rows), tuple(d.name for d in group))
