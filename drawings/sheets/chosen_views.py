"""Sheet plan of a part that states none: the views in which its dimensions are seen, at the largest usual scale.

Top, front and right view and a picture, more views where a declaration names them, and a section through the points of
each declaration that asks for one. `VIEWS` in the file of a part, or `sheets.toml`, add others.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from drawings.sheets.plans import SheetPlan, ViewPlan
from drawings.views.view import PROJECTIONS, Cut, dot
from stagecad.parameters.dimension import Dimension, FaceRequirement, Point
from stagecad.solids.modelling.verification import DimensionVerifier

ALIGNED = {"front": "", "top": "front", "bottom": "front", "right": "front", "left": "front", "back": "right"}
"""Third-angle projection: the view beside which each view is placed."""
SCALES = (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
ROOM = (230.0, 160.0)
"""Space of the views on the smallest sheet, with gaps and dimensions, mm."""
LETTERS = "ABCDEFGH"
BASE = ("top", "front", "right")
"""Views of every part that is not turned."""


def chosen_plan(
    name: str,
    dimensions: Sequence[Dimension],
    requirements: Sequence[FaceRequirement],
    verifier: DimensionVerifier,
    stated: Sequence[str] = (),
) -> SheetPlan:
    """The one sheet of a part, with every view that its declarations name."""
    asked: list[str] = [one.view for one in (*dimensions, *requirements) if one.view in PROJECTIONS]
    wanted = [view for view in ALIGNED if view in stated or (view in BASE and not stated) or view in asked]
    if "front" not in wanted and len(wanted) > 1:
        wanted = ["front", *wanted]
    views = [
        ViewPlan(view, view, _beside(view, wanted), hidden=view == "front" and not stated)
        for view in wanted
        if view != "iso"
    ]
    for letter, (normal, point) in zip(LETTERS, _cuts([*dimensions, *requirements]), strict=False):
        projection = next(p for p in PROJECTIONS if dot(PROJECTIONS[p].towards_eye, normal) > 1 - 1e-9)
        views.append(ViewPlan(f"section {letter}-{letter}", projection, "front", cut=Cut(point, normal, letter)))
    views.append(ViewPlan("iso", "iso"))
    low = [min(surface.low[n] for surface in verifier.surfaces) for n in range(3)]
    high = [max(surface.high[n] for surface in verifier.surfaces) for n in range(3)]
    scale = usual_scale([b - a for a, b in zip(low, high, strict=True)], [view.projection for view in views])
    return SheetPlan(name, ("A3", "A2", "A1", "A0"), scale, tuple(views))


def _beside(view: str, wanted: Sequence[str]) -> str:
    """The view with which a view is aligned; that of a back view is the front view if there is no right view."""
    parent = ALIGNED[view]
    return parent if parent in wanted else "" if view == "front" or "front" not in wanted else "front"


def _cuts(declared: Iterable[Dimension | FaceRequirement]) -> list[tuple[Point, Point]]:
    """Normals and points of the planes in which all points of the declarations for a section lie."""
    found: list[tuple[Point, Point]] = []
    for one in declared:
        if one.view != "section" or not one.points:
            continue
        across = getattr(one, "direction", None) or getattr(one, "normal", None)
        normals: list[Point] = [(0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
        planes = [
            (normal, one.points[0])
            for normal in normals
            if (across is None or abs(dot(normal, across)) < 1e-6)
            and all(abs(dot(normal, point) - dot(normal, one.points[0])) < 1e-6 for point in one.points)
        ]
        known = [plane for plane in planes if any(_same(plane, other) for other in found)]
        if planes and not known:
            found.append(planes[0])
    return found


def _same(one: tuple[Point, Point], other: tuple[Point, Point]) -> bool:
    (normal, point), (direction, through) = one, other
    return normal == direction and abs(dot(normal, point) - dot(normal, through)) < 1e-6


def usual_scale(size: Sequence[float], projections: Sequence[str] = BASE) -> float:
    """The largest usual scale with which the aligned views of a part of a size fit on an A3 sheet."""
    x, y, z = size
    sides = sum(view in projections for view in ("right", "left"))
    rows = sum(view in projections for view in ("top", "bottom"))
    for scale in SCALES:
        if scale * (x + sides * y) <= ROOM[0] and scale * (z + rows * y) <= ROOM[1]:
            return scale
    return SCALES[-1]
