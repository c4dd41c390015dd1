"""Datums proposed for a solid."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from drawings.dimensions.definition import AXES
from drawings.recognition.features import NEAR, Features, along_of, middle_of_face, outward_normal
from drawings.recognition.visible import positive, tidy
from drawings.views.view import PROJECTIONS, dot
from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.verification import DimensionVerifier, moved


@dataclass(frozen=True)
class ProposedDatum:
    """A datum: a plane face, or the axis of the largest shaft; a point of it, its normal or axis, and its view."""

    letter: str
    point: Point
    normal: Point
    view: str
    round: bool = False


def proposed_datums(verifier: DimensionVerifier, features: Features, views: Sequence[str]) -> Iterator[ProposedDatum]:
    """The axis of a turned part and its largest end face; else the largest faces at right angles to each other."""
    used: list[Point] = []
    letters = iter("ABC")
    # The outline of a bore about the same axis would be taken for that of the shaft.
    bored = {face.axis_key for hole in features.holes for face in hole.faces}
    shafts = [one for one in features.shafts if one.face.axis_key not in bored]
    shaft = max(shafts, key=lambda one: one.radius, default=None)
    if shaft is not None and max(abs(dot(shaft.face.origin, unit)) for unit in _across(shaft.face.axis)) < NEAR:
        axis = positive(shaft.face.axis)
        at = moved(
            shaft.face.origin, shaft.face.axis, (shaft.low + shaft.high) / 2 - dot(shaft.face.origin, shaft.face.axis)
        )
        view = next((v for v in views if v in PROJECTIONS and abs(dot(PROJECTIONS[v].towards_eye, axis)) < 1e-6), "")
        if view:
            yield ProposedDatum(next(letters), tidy(at), axis, view, True)
            used = [unit for unit in AXES.values() if abs(dot(unit, axis)) < 1e-6]
    planes = [s for s in verifier.surfaces if s.kind == "PLANE" and along_of(s.axis) is not None]
    for surface in sorted(planes, key=lambda s: -round(s.face.Area(), 3)):
        normal = outward_normal(surface)
        if any(abs(dot(normal, other)) > 0.5 for other in used):
            continue
        shown = (v for v in views if v in PROJECTIONS and abs(dot(PROJECTIONS[v].towards_eye, normal)) < 1e-6)
        view, letter = next(shown, ""), next(letters, "")
        if not view or not letter:
            break
        point = surface.vertices[0] if surface.vertices else middle_of_face(surface)
        yield ProposedDatum(letter, tidy(point), normal, view)
        used.append(normal)


def _across(axis: Point) -> list[Point]:
    return [unit for unit in AXES.values() if abs(dot(unit, axis)) < 1e-6]
