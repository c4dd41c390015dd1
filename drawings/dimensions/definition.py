"""Completeness of definition: whether size and place of every face of a part follow from its declarations.

Computed on the solid. Sizes: every radius is that of a declared diameter, radius or tap drill, or half a declared
width. Places: along each axis a face or the axis of a round face is at a level that dimensions connect to the reference
(`drawings.dimensions.levels`); a chamfer or fillet is placed by the faces it joins, a hole by the hole table. The
module of a part says what its notes say: `SYMMETRIC`, axes whose middle plane is a plane of symmetry; `TURNED`, number
of equal sectors about z; `defined_by_note(design, point)`, faces that a note or a detail defines; `BY_MODEL`, whether
the model gives the shape of free-form faces and of outlines of marks (`drawings.dimensions.contours`);
`FACES_BY_MODEL`, other faces that it gives, in the words in which a problem names them.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from drawings.dimensions.consistency import contradictions, is_on
from drawings.dimensions.levels import AXES, NEAR
from drawings.dimensions.places import Notes, Part, middle_of_box
from drawings.dimensions.stated_part import StatedPart
from drawings.views.segment_index import SegmentIndex, lines_of
from drawings.views.view import View
from stagecad.parameters.dimension import Dimension, FaceRequirement, GeometricTolerance, Point, SurfaceTexture
from stagecad.solids.modelling.surface import Surface
from stagecad.solids.modelling.verification import DimensionVerifier

HEADINGS = ("face", "kind", "x", "y", "z", "size", "place", "form", "finish")
IN_VIEW = 0.1
"""Half side of the box about a point of an edge in which a line of a view must lie, mm."""


@dataclass(frozen=True)
class FaceDefinition:
    """One face and what defines it."""

    number: int  # in the solid's order, from 1
    kind: str  # plane, cylinder, cone, sphere, torus, or other
    middle: Point  # of its box, part coordinates, mm
    # size, place, form, finish: declarations or notes that give them; empty where nothing does
    size: str
    place: str
    form: str
    finish: str
    shown: bool = True  # whether a view shows an edge of it

    @property
    def words(self) -> str:
        """Kind and middle."""
        return f"{self.kind} at {', '.join(f'{round(value, 3) + 0.0:g}' for value in self.middle)}"

    @property
    def problems(self) -> Iterator[str]:
        """What is not defined, one text for each of size and place."""
        for what in ("size", "place"):
            if not getattr(self, what):
                yield f"the {what} of face {self.number} ({self.words}) is not defined"
        if not self.shown:
            yield f"face {self.number} ({self.words}) is in no view"

    @property
    def row(self) -> tuple[str, ...]:
        """Cells below `HEADINGS`."""
        middle = (f"{round(value, 3) + 0.0:g}" for value in self.middle)
        return (str(self.number), self.kind, *middle, self.size, self.place, self.form, self.finish)


@dataclass(frozen=True)
class Definition:
    """Definition of a part."""

    faces: tuple[FaceDefinition, ...]  # of the solid
    superfluous: tuple[str, ...]  # dimensions that follow from others
    contradictory: tuple[str, ...] = ()  # tolerances, fits and threads

    @property
    def problems(self) -> tuple[str, ...]:
        """Everything that is missing or given twice, a line each."""
        missing = [problem for face in self.faces for problem in face.problems]
        return (
            *missing,
            *self.contradictory,
            *(f"the dimension '{name}' follows from others" for name in self.superfluous),
        )


def notes_on_shape(module: Any, design: Any) -> Notes:
    """Symmetry and faces defined by notes, as the module of a part declares them."""
    by_note = getattr(module, "defined_by_note", None)
    words = [one.partition(" at ")[2].split(", ") for one in getattr(module, "FACES_BY_MODEL", ())]
    middles = [tuple(map(float, numbers)) for numbers in words]

    def defines(point: Point) -> str:
        given = any(math.dist(point, middle) < IN_VIEW for middle in middles)
        return "by the model" if given else by_note(design, point) if by_note else ""

    return Notes(
        getattr(module, "SYMMETRIC", ""),
        getattr(module, "TURNED", 1),
        True,
        bool(getattr(module, "BY_MODEL", False)),
        defines,
    )


def definition(
    verifier: DimensionVerifier,
    dimensions: Sequence[Dimension],
    requirements: Sequence[FaceRequirement],
    notes: Notes,
    views: Sequence[View] = (),
    roughness: float = 3.2,
) -> Definition:
    """Definition of a part by its declarations."""
    part = Part(verifier, dimensions, notes) if notes.packaged else StatedPart(verifier, dimensions, notes)
    drawn = [(view, lines_of(view.on("VISIBLE", "HIDDEN"))) for view in views if not view.clip]
    faces = []
    for number, surface in enumerate(verifier.surfaces, start=1):
        tolerances = [r for r in requirements if is_on(surface, r)]
        faces.append(
            FaceDefinition(
                number,
                surface.kind.lower(),
                middle_of_box(surface),
                part.size_of(surface),
                part.place_of(surface),
                ", ".join(r.characteristic for r in tolerances if isinstance(r, GeometricTolerance)) or "general",
                next((f"Ra {r.roughness:g}" for r in tolerances if isinstance(r, SurfaceTexture)), f"Ra {roughness:g}"),
                not drawn
                or bool(notes.defines(middle_of_box(surface)))
                or any(_is_shown(surface, view, lines) for view, lines in drawn),
            )
        )
    superfluous = tuple(name for one in part.levels.values() for name in one.superfluous)
    return Definition(tuple(faces), superfluous, tuple(contradictions(verifier, dimensions, requirements, roughness)))


def centred_axes(verifier: DimensionVerifier) -> str:
    """Names of the axes along which a solid reaches equally far to both sides of the origin: what is not dimensioned
    from a side is symmetric about this middle, and the sheet says so."""
    return "".join(name for name, low, high in zip(AXES, *verifier.box, strict=True) if abs(low + high) < NEAR)


def _is_shown(surface: Surface, view: View, lines: SegmentIndex) -> bool:
    """Whether the middle of an edge of a face is drawn in a view, or a point of it in the plane of a section."""
    for edge in surface.face.Edges():
        points = [edge.positionAt(part).toTuple() for part in (0.37, 0.0, 0.25, 0.5, 0.75)]  # pyright: ignore[reportAttributeAccessIssue]
        cut = [point for point in points[1:] if view.cut and view.cut.holds(point, NEAR)]
        for u, v in map(view.projection.to_view, (points[0], *cut)):
            if lines.count_in((u - IN_VIEW, v - IN_VIEW, u + IN_VIEW, v + IN_VIEW)):
                return True
    return False
