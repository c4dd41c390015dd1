"""Sheet plans: the views of a part, their sheets and scales, and the plans of a machine.

A part that states none has the views in which its dimensions are seen, at the largest usual scale. Front view and
picture, and the views that declarations name, else the top view; and a section through the points of each declaration
that asks for one. `VIEWS` in the file of a part, or `sheets.toml`, add others; `front section` is the front view cut
through the origin, `front offset X Y Z X Y Z` one cut through points, also `half`, `aligned`
(`drawings.views.view.section_cut`), `front hidden` one with hidden lines."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

from drawings.dimensions.levels import AXES, along_of
from drawings.sheets.frame import Paper
from drawings.views.view import PROJECTIONS, Cut, auxiliary, dot, projection_of, section_cut
from stagecad.parameters.dimension import Dimension, FaceRequirement, Point
from stagecad.parameters.machine import content, packaged_machine
from stagecad.solids.modelling.verification import DimensionVerifier

if TYPE_CHECKING:
    from drawings.pictures.machine import MachineViews
    from stagecad.solids.artefacts.part import BuiltPart
    from stagecad.solids.assembly.bill_of_materials import Row
    from stagecad.solids.modelling.part import Instance


CALCULATED = "calculated"


@dataclass(frozen=True)
class Figure:
    """A number as printed, and its origin: keys of parameters, or `CALCULATED`."""

    text: str
    origin: str


@dataclass(frozen=True)
class PartUse:
    """A row of the parts list that is put in by a step."""

    item: int  # number in the parts list and of the balloon
    # part, part_number: name, and number in the catalogue or of the drawing
    part: str
    part_number: str
    quantity: int  # number of parts


@dataclass(frozen=True)
class Step:
    """One step."""

    number: int  # from 1, in the order of assembly
    title: str
    sentences: tuple[str, ...]  # instructions
    parts: tuple[PartUse, ...]
    tools: tuple[str, ...]  # and materials that are not in the parts list
    torque: Figure | None  # of the screws of this step
    figures: dict[str, Figure]  # all numbers of the step, by name


@dataclass(frozen=True)
class ViewPlan:
    """Plan of a view."""

    name: str  # as in `drawings.views.view.View`
    projection: str  # name for `drawings.views.view.projection_of`
    aligned_with: str = ""  # name of the view with which it is aligned
    hidden: bool = False  # whether it shows hidden lines
    cut: Cut | None = None  # plane of a section
    face: Cut | None = None  # plane of the slanting face that an auxiliary view shows
    detail: tuple[Point, float] | None = None  # centre, part coordinates, and radius of a detail, mm
    letter: str = ""  # of a detail
    scale: float | None = None  # if it differs from that of the sheet
    symmetry: str = ""  # `u`, `v`: lines of symmetry through the part's origin


@dataclass(frozen=True)
class SheetPlan:
    """Plan of a sheet of a part."""

    name: str  # of its files
    papers: tuple[Paper, ...]  # sizes to try, smallest first
    scale: float  # of the views without a scale
    views: tuple[ViewPlan, ...]  # the main one first
    shows: tuple[str, ...] = ()  # prefixes of the names of its declarations; empty for all that no other sheet shows


def sheet_of(plans: tuple[SheetPlan, ...], declaration: str) -> SheetPlan:
    """The one sheet that shows a declaration."""
    for plan in plans:
        if any(declaration.startswith(beginning) for beginning in plan.shows):
            return plan
    return next(plan for plan in plans if not plan.shows)


def sheet_of_requirement(plans: tuple[SheetPlan, ...], requirement: FaceRequirement) -> SheetPlan:
    """The one sheet that shows a requirement: with the view it is declared for, its face seen as a line.

    Of several sections that through one of its points.
    """
    found: list[tuple[bool, SheetPlan]] = []
    for plan in plans:
        for view in plan.views:
            eye = projection_of(view.projection).towards_eye
            named = view.name == requirement.view or (requirement.view == "section" and view.cut is not None)
            if named and abs(sum(a * b for a, b in zip(eye, requirement.normal, strict=True))) < 1e-6:
                found.append((view.cut is None or any(map(view.cut.holds, requirement.points)), plan))
    return next((plan for through, plan in found if through), found[0][1] if found else plans[0])


@dataclass(frozen=True)
class Sheets:
    """Sheets of a kind of machine."""

    # the sheets of a kind of part in a design; none for one that has the standard sheet
    plans: Callable[[str, Any], tuple[SheetPlan, ...]]
    titles: Mapping[str, str]  # words of the title block for kinds of part, where they are not those of its name
    # how the whole is shown, given the design, its instances and built parts
    views: Callable[[Any, Sequence[Instance], Mapping[str, BuiltPart]], MachineViews]
    # the steps of assembly, given the design, the parts list and the calculated values
    procedure: Callable[[Any, Sequence[Row], Any], tuple[Step, ...]]
    travel: Callable[[Any], float]  # of the parts that move, from end to end, mm
    modules: tuple[str, ...]  # dotted names of the modules that these are made by


def sheets_of(design: Any) -> Sheets:
    """The sheets of a design's machine."""
    return content("drawings", design.machine, "sheets").SHEETS


def packaged_sheets() -> Sheets:
    """The sheets of the packaged machine, whose parts any machine may have."""
    return content("drawings", packaged_machine(), "sheets").SHEETS


ALIGNED = {"front": "", "top": "front", "bottom": "front", "right": "front", "left": "front", "back": "right"}
"""Third-angle projection: the view beside which each view is placed."""
SCALES = (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
ROOM = (230.0, 160.0)
"""Space of the views on the smallest sheet, with gaps and dimensions, mm."""
PICTURE = 90.0
"""Greatest size of the picture on the sheet, mm."""
CUTS = ("section", "offset", "half", "aligned")
"""Words after the name of a view that a part states as a section."""
LETTERS, DETAILS = "ABCDEFGH", "XYZUVW"
LEGIBLE = 1.2
"""Size on the paper from which on a feature is legible, mm: two lines of 0.5 mm with a space of 0.7 mm (ISO 128-20)."""
LARGEST_DETAIL = 60.0
"""Diameter of a detail on the paper, mm."""
BASE = ("top", "front", "right")
"""The usual views; those that no declaration names are left out, but for the front view and one more."""


def chosen_plan(
    name: str,
    dimensions: Sequence[Dimension],
    requirements: Sequence[FaceRequirement],
    verifier: DimensionVerifier,
    stated: Sequence[str] = (),
    symmetric: str = "",
) -> SheetPlan:
    """The one sheet of a part, with every view that it states and that its declarations name; `symmetric` are the axes
    whose middle plane the sheet says to be one of symmetry, shown by lines."""
    slanting = slanting_faces([*dimensions, *requirements], verifier)
    how = {view.partition(" ")[0]: view.partition(" ")[2] for view in stated}
    asked: list[str] = [one.view for one in (*dimensions, *requirements) if one.view in PROJECTIONS]
    # The direction of an auxiliary view is shown where its face is seen as a line.
    edgewise = ([v for v in ALIGNED if abs(dot(PROJECTIONS[v].towards_eye, face.normal)) < 1e-6] for face in slanting)
    asked += [views[0] for views in edgewise if views and not {*views} & {"front", *asked, *how}]
    stated = tuple(how)
    base = () if stated else ("front",) if set(asked) - {"front"} else BASE[:2]
    wanted = [view for view in ALIGNED if view in (*stated, *base, *asked)]
    if "front" not in wanted and len(wanted) > 1:
        wanted = ["front", *wanted]
    letters = iter(LETTERS)
    stated_cuts = [view for view in wanted if how.get(view, "").partition(" ")[0] in CUTS]
    sections = {view: _stated_cut(view, how[view], letters) for view in stated_cuts}
    names = {v: f"section {cut.letter}-{cut.letter}" if cut.letter else f"half {v}" for v, cut in sections.items()}
    views: list[ViewPlan] = []
    for view in wanted:
        # A back view is aligned with the front view if there is no right view.
        beside, projection = ALIGNED[view], PROJECTIONS[view]
        if beside not in wanted:
            beside = "front" if view != "front" and "front" in wanted else ""
        lines = "".join(
            line
            for line, along in (("v", projection.right), ("u", projection.up))
            if any(abs(dot(along, AXES[axis])) > 0.5 for axis in symmetric)
        )
        hidden = how.get(view) == "hidden" or (view == "front" and not stated)
        views.append(
            ViewPlan(names.get(view, view), view, names.get(beside, beside), hidden, sections.get(view), symmetry=lines)
        )
    others = [
        (normal, point)
        for normal, point in _cuts([*dimensions, *requirements], verifier)
        if not any(cut.normal == normal and cut.holds(point) for cut in sections.values())
    ]
    for letter, (normal, point) in zip(letters, others, strict=False):
        view = next(p for p in PROJECTIONS if dot(PROJECTIONS[p].towards_eye, normal) > 1 - 1e-9)
        cut, beside = Cut(point, normal, letter), names.get("front", "front")
        views.append(ViewPlan(f"section {letter}-{letter}", view, beside, cut=cut))
    for face in slanting:
        views.append(ViewPlan(f"auxiliary {len(views)}", auxiliary(face.normal), face=face))
    x, y, z = (b - a for a, b in zip(*verifier.box, strict=True))
    scale = usual_scale((x, y, z), [view.projection for view in views])
    wide, tall = 0.87 * (x + y), 0.5 * (x + y) + z
    picture = next((one for one in SCALES if one <= scale and max(one * wide, one * tall) <= PICTURE), SCALES[-1])
    views.append(ViewPlan("iso", "iso", scale=picture))
    return SheetPlan(name, ("A3", "A2", "A1", "A0"), scale, tuple(views))


def _stated_cut(view: str, words: str, letters: Iterator[str]) -> Cut:
    """The section that a part states for a view: `section` through the origin, or a kind with coordinates of points.

    The plane of a half section of a symmetric part is obvious, and has no letter (ISO 128-3).
    """
    kind, *numbers = words.split()
    values = iter(map(float, numbers))
    points = list(zip(values, values, values, strict=False)) or [(0.0, 0.0, 0.0)]
    letter = "" if kind == "half" else next(letters, "")
    return section_cut(view, points, letter, "offset" if kind == "section" else kind)


def slanting_faces(declared: Iterable[Dimension | FaceRequirement], verifier: DimensionVerifier) -> list[Cut]:
    """Planes of the slanting faces that declarations for an auxiliary view are on, one of each normal."""
    planes = [s for s in verifier.surfaces if s.kind == "PLANE" and along_of(s.axis) is None]
    cuts = [Cut(plane.origin, plane.normal, "") for plane in planes]
    found: dict[Point, Cut] = {}
    for one in (one for one in declared if one.view == "auxiliary" and cuts):
        along = getattr(one, "direction", None) or (0.0, 0.0, 0.0)
        # A corner may be on several.
        ranks = [(abs(dot(along, cut.normal)) > 1 - 1e-6, sum(map(cut.holds, one.points))) for cut in cuts]
        if any(best := max(ranks)):
            cut = cuts[ranks.index(best)]
            found.setdefault(cut.normal, cut)
    return list(found.values())


def _cuts(declared: Iterable[Dimension | FaceRequirement], verifier: DimensionVerifier) -> list[tuple[Point, Point]]:
    """Normals and points of the planes of declarations for a section; across a long shaft rather than along it."""
    found: list[tuple[Point, Point]] = []
    shaft = max((s for s in verifier.surfaces if s.kind == "CYLINDER"), key=lambda s: s.radius, default=None)
    along = shaft is not None and shaft.outward and abs(shaft.axis[0]) > 1 - 1e-9
    for one in declared:
        if one.view != "section" or not one.points:
            continue
        across = getattr(one, "direction", None) or getattr(one, "normal", None)
        normals: list[Point] = [(0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
        normals = [normals[1], normals[0], normals[2]] if along else normals
        planes = [
            (normal, one.points[0])
            for normal in normals
            if (across is None or abs(abs(dot(normal, across)) - (getattr(one, "kind", "") == "radius")) < 1e-6)
            and all(abs(dot(normal, point) - dot(normal, one.points[0])) < 1e-6 for point in one.points)
        ]
        known = (
            normal == direction and abs(dot(normal, point) - dot(normal, through)) < 1e-6
            for normal, point in planes
            for direction, through in found
        )
        if planes and not any(known):
            found.append(planes[0])
    return found


def usual_scale(size: Sequence[float], projections: Sequence[str] = BASE) -> float:
    """The largest usual scale with which the aligned views of a part of a size fit on an A3 sheet."""
    x, y, z = size
    sides = sum(view in projections for view in ("right", "left"))
    rows = sum(view in projections for view in ("top", "bottom"))
    for scale in SCALES:
        if scale * (x + sides * y) <= ROOM[0] and scale * (z + rows * y) <= ROOM[1]:
            return scale
    return SCALES[-1]


def at_scale(plan: SheetPlan, scale: float) -> SheetPlan:
    """A plan at another scale, with a picture that is not larger."""
    views = tuple(replace(view, scale=min(view.scale, scale)) if view.scale else view for view in plan.views)
    return replace(plan, scale=scale, views=views)


def with_details(plan: SheetPlan, dimensions: Sequence[Dimension], size: Point) -> SheetPlan:
    """A plan with a detail for each place in a view where features are not legible at its scale; of a part of a size,
    a view no larger than a detail that has such features far apart is itself at a larger scale."""
    for view in plan.views[1:]:
        places = [(at, reach) for one, at, reach in _illegible(plan, dimensions) if one is view]
        projection = projection_of(view.projection)
        wide = max(sum(abs(a * b) for a, b in zip(size, way, strict=True)) for way in (projection.right, projection.up))
        far = max((_apart(view, a, b) + r + s for (a, r), (b, s) in combinations(places, 2)), default=0.0)
        scale = next(one for one in SCALES if wide * one <= LARGEST_DETAIL or one == SCALES[-1])
        if far > wide / 2 and not view.cut and scale >= 2 * plan.scale:
            plan = replace(plan, views=tuple(replace(one, scale=scale) if one is view else one for one in plan.views))
    found = _illegible(plan, dimensions)
    views = list(plan.views)
    while found and len(views) < len(plan.views) + len(DETAILS):
        view, at, reach = found.pop()
        near = next((one for one in found if one[0] is view and _apart(view, at, one[1]) < reach + one[2]), None)
        if near:
            # One circle around both.
            found.remove(near)
            _, other, far = near
            apart = _apart(view, at, other)
            around = max(reach, far, (apart + reach + far) / 2)
            part = (around - reach) / apart if apart else 0.0
            at: Point = tuple(a + part * (b - a) for a, b in zip(at, other, strict=True))  # type: ignore[assignment]
            found.append((view, at, around))
            continue
        scale = next((one for one in SCALES if 2 * reach * one <= LARGEST_DETAIL), SCALES[-1])
        if scale >= 2 * (view.scale or plan.scale):
            letter = DETAILS[len(views) - len(plan.views)]
            detail = replace(view, name=f"detail {letter}", aligned_with="", symmetry="", scale=scale)
            views.append(replace(detail, detail=(at, reach), letter=letter))
    return replace(plan, views=tuple(views))


def _illegible(plan: SheetPlan, dimensions: Sequence[Dimension]) -> list[tuple[ViewPlan, Point, float]]:
    """Views with the middles of features that are not legible there, and how far around these a detail reaches, mm."""
    found: list[tuple[ViewPlan, Point, float]] = []
    for d in dimensions:
        size, on_axis = d.major or d.value, d.kind in ("diameter", "tap_drill")
        drawn = on_axis or d.kind in ("linear", "pitch") or (d.kind == "depth" and not d.feature)
        shows = [v for v in plan.views if v.cut and all(map(v.cut.holds, d.points))] if d.view == "section" else []
        shows += [v for v in plan.views if d.view == v.projection]
        if drawn and shows and size * (shows[0].scale or plan.scale) < LEGIBLE:
            ends = d.points[:1] if on_axis else d.points
            middle: Point = tuple(sum(end[n] for end in ends) / len(ends) for n in range(3))  # type: ignore[assignment]
            wide = size if d.kind == "pitch" else 2 * size
            found.append((shows[0], middle, wide + max(_apart(shows[0], middle, end) for end in ends)))
    return found


def _apart(view: ViewPlan, one: Point, other: Point) -> float:
    """Distance of two points in a view."""
    return math.dist(*(projection_of(view.projection).to_view(point) for point in (one, other)))
