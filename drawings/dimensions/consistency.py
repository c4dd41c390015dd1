"""What declarations of a part say against its solid or each other: values, counts, names, tolerances, fits, threads."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from drawings.dimensions.levels import NEAR, SQUARE, ends_of_cones, like_edges
from drawings.dimensions.round_sections import sections_of
from drawings.views.view import dot
from stagecad.parameters.dimension import (
    FORM,
    DatumFeature,
    Dimension,
    FaceRequirement,
    GeometricTolerance,
    Point,
    SurfaceTexture,
)
from stagecad.parameters.threads import BOTTOMING_TAP, threads
from stagecad.solids.modelling.frame import cross, subtract
from stagecad.solids.modelling.part import takes
from stagecad.solids.modelling.surface import Surface
from stagecad.solids.modelling.verification import DimensionVerifier

ORIENTATION, LOCATION = ("parallelism", "perpendicularity", "angularity"), ("position", "coaxiality")
"""Characteristics of orientation and of location; `stagecad.parameters.dimension.FORM` are those of form."""
EXACT = 1e-6
"""Greatest difference of the solid from a declared value, before rounding, mm."""


def mistakes(
    dimensions: Sequence[Dimension],
    requirements: Sequence[FaceRequirement],
    verifier: DimensionVerifier,
    *,
    alike: bool = True,
) -> Iterator[str]:
    """What the solid does not have, or is declared twice or for nothing, so that no sheet can be drawn; a line each.
    With `alike` fillets and chamfers are counted, too, and holes of one dimension must be alike."""
    yield from _twice("dimensions have the name", [d.name for d in dimensions])
    for d in dimensions:
        try:
            measured = verifier.measure(d) if d.points else None
        except LookupError as error:
            yield f"dimension '{d.name}': {error.args[0]}"
        else:
            if measured is not None and abs(measured - d.value) > EXACT:
                yield f"dimension '{d.name}': declared {d.value:.9g}, the solid measures {measured:.9g}"
    yield from _miscounted(verifier, dimensions, alike=alike)
    letters = [r.letter for r in requirements if isinstance(r, DatumFeature)]
    yield from _twice("datums have the letter", letters)
    for r in requirements:
        name = f"datum {r.letter}" if isinstance(r, DatumFeature) else f"requirement '{r.name}'"
        for letter in getattr(r, "datums", ()):
            if not set(letter.split("-")) <= set(letters):
                yield f"{name}: no datum {letter} is declared"
        # The second point of an axis is on the face that is meant.
        for one in [r] if getattr(r, "round", False) else [replace(r, points=(point,)) for point in r.points]:
            if not any(is_on(surface, one) for surface in verifier.surfaces):
                yield f"{name}: no face of the solid at {one.points[0]}"


def unsuited(material: Any, dimensions: Sequence[Dimension], texts: Sequence[str]) -> Iterator[str]:
    """Threads in a brittle material, and texts that ask for a coating which a material has not; a line each."""
    for d in dimensions:
        if d.kind == "tap_drill" and material.strength_kind == "fracture":
            yield f"'{d.name}': {material.description} is brittle, and no thread is tapped in it"
    for text in texts:
        if not takes(material, text):
            yield f"'{text}': {material.description} is not anodised (key `coating` of a material)"


def _twice(what: str, names: Sequence[str]) -> Iterator[str]:
    yield from (f"two {what} '{name}'" for name in dict.fromkeys(names) if names.count(name) > 1)


def contradictions(
    verifier: DimensionVerifier,
    dimensions: Sequence[Dimension],
    requirements: Sequence[FaceRequirement],
    roughness: float,
) -> Iterator[str]:
    """Tolerances of form that are not smaller than those of orientation, or these than those of location (ISO 1101),
    fits of the other kind or with a roughness above an eighth of their tolerance, and threads that reach the end of
    their drill; `roughness` is the Ra of faces without a mark, um."""
    for number, surface in enumerate(verifier.surfaces, start=1):
        own = [r for r in requirements if isinstance(r, GeometricTolerance) and is_on(surface, r)]
        for finer, coarser in ((FORM, ORIENTATION), (FORM, LOCATION), (ORIENTATION, LOCATION)):
            for one in (r for r in own if r.characteristic in finer):
                for other in (r for r in own if r.characteristic in coarser and r.value <= one.value):
                    yield (
                        f"the {one.characteristic} {one.value:g} of face {number} is not smaller than its "
                        f"{other.characteristic} {other.value:g}, which includes it"
                    )
    marked = [r for r in requirements if isinstance(r, SurfaceTexture)]
    for d in dimensions:
        if d.kind != "diameter" or d.deviations is None or d.direction is None:
            continue
        low, high = d.deviations
        most = 1e3 * (high - low) / 8
        faces = [s for s in verifier.surfaces if s.is_round(d.value / 2) and s.off_axis(d.points[0]) < NEAR]
        letter = (d.tolerance or "X")[0]
        if letter != "X" and any(s.outward == letter.isupper() for s in faces):
            yield f"'{d.name}': {d.tolerance} is a class of {'holes' if letter.isupper() else 'shafts'} (ISO 286)"
        own = next((r.roughness for r in marked for s in faces if is_on(s, r)), roughness)
        if own > most:
            yield f"Ra {own:g} of '{d.name}' is too rough for its tolerance of {high - low:g} mm: Ra {most:.2g} at most"
    pitches = {thread.designation: thread.pitch for thread in threads().values()}
    drilled = {d.feature: d.value for d in dimensions if d.kind == "depth" and d.major}
    for d in (d for d in dimensions if d.kind == "thread_depth" and d.feature in drilled):
        least = d.value + BOTTOMING_TAP * pitches.get(d.note, 0.0)
        if drilled[d.feature] < least - NEAR:
            yield f"'{d.name}' of {d.value:g} mm needs a drill {least:.3g} mm deep, not {drilled[d.feature]:g} mm"


def _miscounted(verifier: DimensionVerifier, dimensions: Sequence[Dimension], *, alike: bool) -> Iterator[str]:
    """Diameters given for more features than the solid has; with `alike`, also fillets and chamfers, diameters for
    holes of which some go through and some do not, and callouts of holes that are not about one axis."""
    callouts: dict[str, Dimension] = {}
    for d in dimensions:
        if alike and d.feature and d.kind in ("diameter", "tap_drill") and d.direction is not None:
            first = callouts.setdefault(d.feature, d)
            if math.hypot(*cross(subtract(d.points[0], first.points[0]), d.direction)) > NEAR:
                yield f"'{first.name}' and '{d.name}' are in one callout, and not about one axis"
    for d in dimensions:
        if alike and d.kind in ("radius", "chamfer") and d.count > 1:
            edges = len(set(like_edges(verifier, d).values()))
            if edges < d.count:
                yield f"'{d.name}' is given for {d.count} edges, the solid has {edges} of this size"
        if d.kind not in ("diameter", "tap_drill") or d.direction is None:
            continue
        try:
            found = verifier.holes(d)
        except LookupError:
            ends = len(ends_of_cones(verifier.surfaces, d.value / 2))
            if 0 < ends < d.count:
                yield f"'{d.name}' is given for {d.count} ends of cones, the solid has {ends} of this diameter"
            continue
        if len(found) == d.count:
            ends = {verifier.open_ends(surface, d.direction) for surface in found}
            if alike and len({len(end) for end in ends}) > 1:
                yield f"'{d.name}' is one dimension for holes that go through and holes that do not"
            elif alike and d.note.startswith("through") and len(*ends) < 2:
                yield f"'{d.name}' goes through by its note, the hole of the solid does not"
            continue
        like = (s for s in verifier.surfaces if s.is_round(found[0].radius) and s.outward == found[0].outward)
        number = len([*sections_of(like)])
        if number < d.count:
            yield f"'{d.name}' is given for {d.count} features, the solid has {number} of this diameter"


def is_on(surface: Surface, requirement: FaceRequirement) -> bool:
    """Whether a requirement is for a face: one of its points is on it, or on the axis of a round one."""
    if isinstance(requirement, GeometricTolerance | DatumFeature) and requirement.round:
        return surface.kind == "CYLINDER" and any(
            parallel(surface, requirement.normal) and surface.off_axis(point) < NEAR for point in requirement.points
        )
    return any(surface.holds(point) for point in requirement.points)


def parallel(surface: Surface, axis: Point) -> bool:
    return abs(abs(dot(surface.axis, axis)) - 1.0) < SQUARE
