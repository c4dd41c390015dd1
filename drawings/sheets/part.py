"""The sheets of a part: projection of the views, placement of the dimensions, title block."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from drawings.annotations.annotation import Note
from drawings.annotations.primitives import LINE_PITCH, TEXT_HEIGHT, Primitive, Stroke, Text, rectangle
from drawings.annotations.symbols import symbol_text_primitives, symbol_text_width
from drawings.dimensions.dimensioning import HoleGroup, HoleTable, SheetDimensions, sheet_dimensions
from drawings.dimensions.levels import AXES, corners_of
from drawings.dimensions.text import general_tolerance, number
from drawings.pictures.picture import faces_of_views
from drawings.placement.views import Arrangement, annotated_views, arrange, detached
from drawings.sheets.frame import PAPERS, Paper, TitleBlock, title_area
from drawings.sheets.overrides import changed_plan, listed_notes, moved, overrides_of, placed_notes
from drawings.sheets.plans import SCALES, SheetPlan, ViewPlan, at_scale, sheet_of, sheet_of_requirement, with_details
from drawings.sheets.sheet import Sheet, scale_text, sheet_area, wrapped
from drawings.views.centre_lines import Mark, axes_of, centre_lines
from drawings.views.detail import clipped
from drawings.views.projection import project, with_simple_curves
from drawings.views.section import cut_faces, cut_shape, edge_points, hatch, outline, ribs, without_changes
from drawings.views.thread_lines import ThreadedHole, thread_lines, without_mouths
from drawings.views.view import Arc, Box2, Curve, Layer, Point2, Polyline, View, dot, projection_of
from stagecad.parameters.dimension import Dimension, FaceRequirement, Point, feature_of
from stagecad.solids.export.mesh import Mesh
from stagecad.solids.modelling.frame import add, cross, scaled, subtract
from stagecad.solids.modelling.kernel import KernelShape, cq
from stagecad.solids.modelling.verification import DimensionVerifier

COLUMNS = (13.0, 20.0, 20.0)
"""Widths of name, X and Y of a hole, mm."""
ACROSS = 2
"""Number of holes in a row."""
ROW = 6.5
WIDTH = ACROSS * sum(COLUMNS)


def hole_table_box(table: HoleTable, at: Point2) -> Box2:
    """Bounding box of the table, its upper left corner at a point, mm."""
    return (at[0], at[1] - ROW * sum(1 for _ in _rows(table)), at[0] + WIDTH, at[1])


def hole_table_primitives(table: HoleTable, at: Point2) -> Iterator[Primitive]:
    """Lines and texts of the table, its upper left corner at a point."""
    x, y = at
    yield rectangle(hole_table_box(table, at))
    for row in _rows(table):
        y -= ROW
        yield Stroke(((x, y), (x + WIDTH, y)))
        base = y + (ROW - TEXT_HEIGHT) / 2
        if isinstance(row, str):
            yield from symbol_text_primitives(row, (x + 1.5, base))
            continue
        left = x
        for cell, text in enumerate(row):
            width = COLUMNS[cell % len(COLUMNS)]
            if cell:
                yield Stroke(((left, y), (left, y + ROW)))
            yield Text(text, (left + width / 2, base), TEXT_HEIGHT, "middle")
            left += width


def _rows(table: HoleTable) -> Iterator[str | tuple[str, ...]]:
    """Rows from the top down: a callout as one text, or the cells of holes."""
    yield ("hole", "X", "Y") * ACROSS
    for group in table.groups:
        yield from _callout(group)
        height = math.ceil(len(group.rows) / ACROSS)
        cells = [(row.text, *map(_coordinate, row.at)) for row in group.rows]
        cells += [("", "", "")] * (ACROSS * height - len(group.rows))
        for index in range(height):
            yield tuple(cell for column in range(ACROSS) for cell in cells[index + column * height])


def _coordinate(value: float) -> str:
    return number(round(value, 6) + 0.0, "X.X", 0.0).partition(" ")[0]


def _callout(group: HoleGroup) -> Iterator[str]:
    """Lines of a callout joined as far as they fit; control frames on lines of their own."""
    words = ", ".join(line for line in group.lines if not line.startswith("{frame:"))
    yield from wrapped(f"{group.rows[0].text[0]}: {words}", WIDTH - 3.0)
    yield from (line for line in group.lines if line.startswith("{frame:"))


WIDEST_MOUTH = 1.4
"""Greatest diameter of the chamfer at the mouth of a thread, in major diameters."""

MARK = 1.0
"""Radius around the centre of an arc that its centre mark covers, mm."""
MOST_REVISIONS = 8
"""Most rows of the revision table."""

DETACHABLE = ("bottom", "back", "left")
"""Views that may be detached from their row, with a label, where the paper is too small."""


def threaded_holes(dimensions: Sequence[Dimension], verifier: DimensionVerifier) -> tuple[ThreadedHole, ...]:
    """The tapped holes of a part, by their declarations and the solid."""
    found: list[ThreadedHole] = []
    for drill in dimensions:
        if drill.kind != "tap_drill" or drill.direction is None:
            continue
        depth = next((d.value for d in dimensions if d.kind == "thread_depth" and d.feature == drill.feature), None)
        axis = drill.direction
        start = dot(drill.points[0], axis)
        for surface in verifier.holes(drill):
            low, high = surface.extent(axis)
            # Holes in opposite faces are mirror images of the declared one.
            sign = 1.0 if low - 1e-3 <= start <= high + 1e-3 else -1.0
            mouth = low if sign > 0 else high
            step = mouth - dot(surface.origin, axis)
            x, y, z = (o + step * a for o, a in zip(surface.origin, axis, strict=True))
            into = (sign * axis[0], sign * axis[1], sign * axis[2])
            length = min(depth or math.inf, high - low)
            rim = _rim((x, y, z), into, drill.major, verifier)
            found.append(ThreadedHole((x, y, z), into, length, drill.value, drill.major, depth is not None, rim))
    return tuple(found)


def _slanting_mouths(dimensions: Sequence[Dimension], verifier: DimensionVerifier) -> list[Mark]:
    """Points at which the axes of holes at a declared angle meet a face, its normal, and the radius of the hole."""
    found: list[Mark] = []
    for d in (d for d in dimensions if d.kind == "angle" and d.direction and d.count == 1):
        for s in verifier.surfaces:
            along = dot(s.axis, d.direction or s.axis)
            if s.kind == "CYLINDER" and abs(along) > 1e-6 and max(map(s.off_axis, d.points)) < 1e-3:
                x, y, z = (a - along * b for a, b in zip(s.axis, d.direction or s.axis, strict=True))
                size = math.hypot(x, y, z)
                found.append(Mark(d.points[0], (x / size, y / size, z / size), s.radius))
    return found


def _centres(dimensions: Sequence[Dimension], verifier: DimensionVerifier) -> Iterator[Mark]:
    """Marks of arcs of less than half a turn at whose centres distances end, of circles of holes, and of slots and
    other prisms that distances span or at whose middle they end."""
    rounds = [s for s in verifier.surfaces if s.kind == "CYLINDER"]
    circles = [(d.points[0], d.direction) for d in dimensions if d.kind == "pitch_circle" and d.direction]
    yield from (Mark(at, axis, MARK) for at, axis in circles if all(s.off_axis(at) > 1e-3 for s in rounds))
    distances = [(d.points, d.direction) for d in dimensions if d.kind in ("linear", "pitch") and d.direction]
    ends = [(point, along) for points, along in distances for point in points]
    slanting = [points for points, along in distances if max(map(abs, along)) < 1 - 1e-6]
    met = [(pair, [s for s in rounds if min(map(s.off_axis, pair)) < 1e-3]) for pair in slanting]
    radial = [(pair, next(s.axis for s in on if s.off_axis(pair[0]) < 1e-3)) for pair, on in met if on[1:]]
    angles = [d.points for d in dimensions if d.kind == "angle" and d.count == 1]
    radial += [(pair, axis) for pair in angles for at, axis in circles if math.dist(pair[0], at) < 1e-3]
    for (one, other), axis in radial:
        yield Mark(scaled(add(one, other), 0.5), axis, halves=(scaled(subtract(other, one), 0.5),))
    flanks = [s for s in verifier.surfaces if s.kind == "PLANE" and max(map(abs, s.axis)) < 1 - 1e-6]
    for vertex, far in angles:
        # The flanks of a groove are drawn to the line in which they would meet.
        met = [s for s in flanks if s.is_level(vertex) and not s.holds(vertex)]
        for s in met if any(one.holds(far) for one in met) else ():
            near = min(s.corners, key=lambda at: math.dist(at, vertex))
            edge = cross(met[0].axis, met[-1].axis)
            half = scaled(subtract(near, vertex), 0.5)
            yield Mark(add(vertex, half), scaled(edge, 1 / math.hypot(*edge)), halves=(half,), layer="THREAD")
    drawn = [(sharp, real, s) for s in flanks for sharp, real in corners_of(s, verifier).items() if sharp != real]
    for sharp, real, s in drawn:
        if any(math.dist(sharp, point) < 1e-3 for point, _ in ends):
            half = scaled(subtract(sharp, real), 0.5)
            edge = next(unit for unit in AXES.values() if abs(dot(unit, s.axis)) < 1e-6)
            yield Mark(add(real, half), edge, halves=(half,), layer="THREAD")
    for point, along in ends:
        for s in (s for s in verifier.surfaces if s.kind in ("CYLINDER", "TORUS") and s.span < math.pi - 1e-6):
            if s.off_axis(point) < 1e-3 and abs(dot(s.axis, along)) < 1e-6 and not s.holds(point):
                yield Mark(point, s.axis, min(s.radius, MARK))
    for one in verifier.prisms:
        if any(one.is_axis(*end) for end in ends) or any(one.spans(*distance) for distance in distances):
            bare = [end.origin for end in one.ends if all(end.off_axis(point) > 1e-3 for point, _ in ends)]
            halves = () if one.regular else tuple(scaled(way, size / 2) for way, size in one.widths)
            yield Mark(one.centre, one.axis, one.widths[0][1] / 2, halves, tuple(bare))


def _rim(mouth: Point, into: Point, major: float, verifier: DimensionVerifier) -> float:
    """Radius of the conical chamfer of a tapped hole; 0 without one. A larger cone is that of something else."""
    level, found = dot(mouth, into), 0.0
    for surface in verifier.surfaces:
        if surface.kind == "CONE" and abs(abs(dot(surface.axis, into)) - 1) < 1e-6 and surface.off_axis(mouth) < 1e-4:
            low, high = surface.extent(into)
            radius = max(map(surface.off_axis, surface.vertices))
            if abs(high - level) < 1e-3 and low < level - 1e-3 and radius < WIDEST_MOUTH * major / 2:
                found = max(found, radius)
    return found


def part_views(
    shape: KernelShape,
    plans: Sequence[SheetPlan],
    holes: Sequence[ThreadedHole] = (),
    mesh: Mesh | None = None,
    circles: Sequence[tuple[Point, Point | None, float]] = (),
    marks: Sequence[Mark] = (),
    *,
    exact: bool = True,
    kept: Callable[[Hashable, Callable[[], Any]], Any] = lambda key, make: make(),
) -> tuple[tuple[View, ...], ...]:
    """The views of each sheet of a part, not yet placed; `kept` keeps projections for other scales."""
    axes = axes_of(shape)
    drawn = with_simple_curves(shape) if exact else shape
    outside = {(plan.projection, plan.hidden) for sheet in plans for plan in sheet.views if not plan.cut}
    seen_from = faces_of_views(drawn, mesh) if exact else lambda projection: drawn

    def projected_of(name: str, hidden: bool) -> dict[Layer, tuple[Curve, ...]]:
        faces = drawn if hidden else seen_from(projection_of(name))
        return project(faces, projection_of(name), hidden=hidden, exact=exact, simple=True)

    projected = {view: kept(("projected", *view, exact), partial(projected_of, *view)) for view in outside}

    def view(plan: ViewPlan, sheet_scale: float) -> View:
        scale, projection, label, clip = plan.scale or sheet_scale, projection_of(plan.projection), "", None
        curves: dict[Layer, tuple[Curve, ...]]
        if plan.cut:
            left = cut_shape(shape, plan.cut)
            curves = project(left, projection, hidden=False, exact=exact)
            curves["VISIBLE"] = without_changes(curves["VISIBLE"], plan.cut, projection)
            webs = [*ribs(shape, plan.cut)] if plan.cut.kind == "offset" and not plan.cut.more else []
            covers = [outline(face.wrapped, projection) for face, _ in webs]
            curves["HATCH"] = hatch(cut_faces(left, plan.cut), projection, scale, covers=covers)
            edges = (edge.wrapped for _, own in webs for edge in own)
            curves["VISIBLE"] = (*curves["VISIBLE"], *(Polyline(tuple(edge_points(e, projection))) for e in edges))
            label = f"{plan.cut.letter}-{plan.cut.letter}" if plan.cut.letter else ""
        else:
            curves = dict(projected[plan.projection, plan.hidden])
        if plan.projection != "iso":
            threads = thread_lines(curves, holes, projection, plan.cut, scale)
            curves["THREAD"] = threads["THREAD"]
            curves["VISIBLE"] = (*without_mouths(curves["VISIBLE"], holes, projection), *threads["VISIBLE"])
            eye = projection.towards_eye
            spaced = [Arc(projection.to_view(at), r) for at, axis, r in circles if axis and abs(dot(axis, eye)) > 0.999]
            curves["THREAD"] = (*curves["THREAD"], *(line for one in marks for line in one.thin(projection)))
            curves["CENTRE"] = (*centre_lines(curves, axes, projection, scale, plan.symmetry, marks), *spaced)
        if plan.detail:
            clip = (projection.to_view(plan.detail[0]), plan.detail[1])
            curves = {layer: clipped(lines, *clip) for layer, lines in curves.items()}
            curves["HATCH"] = (*curves.get("HATCH", ()), Arc(*clip))
            label = plan.letter
        if scale != sheet_scale:
            label = f"{label} ({scale_text(scale)})".strip()
        return View(
            plan.name,
            projection,
            curves,
            scale,
            label=label,
            clip=clip,
            cut=plan.cut,
            face=plan.face,
            aligned_with=plan.aligned_with,
        )

    return tuple(tuple(view(plan, sheet.scale) for plan in sheet.views) for sheet in plans)


@dataclass(frozen=True)
class PartDescription:
    """The data of a part for its sheets."""

    name: str
    title: str  # words of the title block
    plans: tuple[SheetPlan, ...]  # of its sheets, in order
    solid: cq.Solid  # in part coordinates
    # dimensions, requirements: the declarations of the part
    dimensions: tuple[Dimension, ...]
    requirements: tuple[FaceRequirement, ...]
    notes: tuple[str, ...]  # of the part
    material: str  # as ordered
    mass: str  # with its unit
    digest: str  # hash of the parameters of the part
    reads: tuple[str, ...] = ()  # names of the parameters of the part
    treatment: str = "-"  # of the material
    brittle: bool = False  # whether the material is, so that edges are not broken by hand
    mesh: Mesh | None = None  # of the solid, if there is one already
    # whether the plans follow from the declarations: then a dimension in another view than declared is reported
    chosen: bool = False
    proposed: bool = False  # whether the program has proposed the dimensions, which the title block then says


def part_sheets(
    part: PartDescription, design: Any, verifier: DimensionVerifier | None = None, *, exact: bool = True
) -> tuple[Sheet, ...]:
    """The sheets of a part; with a chosen plan, at a smaller scale if only this fits on the smallest paper."""
    verifier = verifier or DimensionVerifier(part.solid)
    if part.chosen:
        low, high = verifier.box
        detailed = partial(with_details, dimensions=part.dimensions, size=subtract(high, low))
        first, part = part, replace(part, plans=tuple(map(detailed, part.plans)))
        for scale in (one for one in SCALES if 1.0 <= one <= part.plans[0].scale):
            part = replace(part, plans=tuple(detailed(at_scale(plan, scale)) for plan in first.plans))
            sheets = _sheets(part, design, verifier, exact=exact)
            if all(sheet.paper == plan.papers[0] for sheet, plan in zip(sheets, part.plans, strict=True)):
                return sheets
    return _sheets(part, design, verifier, exact=exact)


def _sheets(part: PartDescription, design: Any, verifier: DimensionVerifier, *, exact: bool) -> tuple[Sheet, ...]:
    overrides = [overrides_of(design, plan.name) for plan in part.plans]
    changed = [changed_plan(plan, own) for plan, own in zip(part.plans, overrides, strict=True)]
    plans = tuple(plan for plan, _ in changed)
    holes = threaded_holes(part.dimensions, verifier)
    circles = [(d.points[0], d.direction, d.value / 2) for d in part.dimensions if d.kind == "pitch_circle"]
    marks = [*_slanting_mouths(part.dimensions, verifier), *_centres(part.dimensions, verifier)]
    views = part_views(part.solid.wrapped, plans, holes, part.mesh, circles, marks, exact=exact, kept=verifier.kept)

    def sheet(number: int, plan: SheetPlan, own: Any, problems: Sequence[str], views: tuple[View, ...]) -> Sheet:
        dimensions = [d for d in part.dimensions if sheet_of(plans, d.name) is plan]
        features = {d.feature for d in dimensions if d.feature}
        requirements = [
            r
            for r in part.requirements
            if (feature_of(r) in features if feature_of(r) else sheet_of_requirement(plans, r) is plan)
        ]
        shown = sheet_dimensions(dimensions, requirements, design, verifier, views, stated=part.chosen)
        if shown.missing:
            raise ValueError(f"sheet '{plan.name}': no view shows {', '.join(shown.missing)}")
        title = _title(part, design, plan, number, len(plans))
        lines = (
            "NOTES",
            "- Tolerances by the decimals of a dimension: see the table.",
            *(f"- {text}" for text in part.notes),
            *(f"[{index}] {text}" for index, text in enumerate(shown.notes, start=1)),
            *listed_notes(own),
        )
        paper, arranged, note, corner = _arranged(plan, views, shown, lines, title)
        annotations, unapplied = moved(arranged.annotations, own, plan.name)
        notes = (note, *placed_notes(own))
        table = tuple(hole_table_primitives(shown.table, corner)) if shown.table else ()
        groups = shown.table.groups if shown.table else ()
        tabulated = (*(shown.table.names if shown.table else ()), *(name for group in groups for name in group.names))
        unapplied = (*problems, *unapplied, *(shown.elsewhere if part.chosen else ()))
        return Sheet(
            plan.name,
            part.name,
            paper,
            plan.scale,
            title,
            arranged.views,
            annotations,
            notes,
            table,
            tabulated,
            unapplied,
        )

    numbered = enumerate(zip(changed, overrides, views, strict=True), start=1)
    return tuple(sheet(number, plan, own, problems, seen) for number, ((plan, problems), own, seen) in numbered)


def _arranged(
    plan: SheetPlan, views: tuple[View, ...], shown: SheetDimensions, texts: tuple[str, ...], title: TitleBlock
) -> tuple[Paper, Arrangement, Note, Point2]:
    """Views, annotations, notes and upper left corner of the hole table on the smallest paper on which they fit."""
    every = annotated_views(views, shown.specs)
    for plan_of_view in plan.views:
        larger = plan_of_view.scale and plan_of_view.aligned_with and not plan_of_view.cut
        if plan_of_view.face or larger or _is_opposite(plan_of_view, plan):
            # Third-angle projection has no place for it next to another view.
            every = detached(every, plan_of_view.name)
    loose = [v.name for v in plan.views if v.name in DETACHABLE and v.aligned_with and not _is_opposite(v, plan)]
    variants = {"": every}
    sizes = list(PAPERS)
    for paper in (*plan.papers, *sizes[sizes.index(plan.papers[-1]) + 1 :]):
        for name in ("", *loose):
            if name not in variants:
                variants[name] = detached(every, name)
            area = title_area(title, paper)
            for note, box in _notes(paper, texts, area):
                for corner in _table_corners(paper, shown.table):
                    taken = (box, area, *((hole_table_box(shown.table, corner),) if shown.table else ()))
                    arranged = arrange(variants[name], sheet_area(paper, taken))
                    if arranged.fits:
                        return paper, arranged, note, corner
    note, box = _notes(plan.papers[-1], texts, title_area(title, plan.papers[-1]))[0]
    return plan.papers[-1], arrange(every, sheet_area(plan.papers[-1], (box,))), note, (0.0, 0.0)


def _is_opposite(view: ViewPlan, plan: SheetPlan) -> bool:
    """Whether a view is from the side opposite to that of the view with which it is aligned."""
    parent = next((other for other in plan.views if other.name == view.aligned_with), None)
    if parent is None:
        return False
    eyes = (projection_of(one.projection).towards_eye for one in (view, parent))
    return dot(*eyes) < -0.5


def _table_corners(paper: Paper, table: HoleTable | None) -> list[Point2]:
    """Two positions of the upper left corner of the hole table, at the right and at the left edge of the sheet."""
    if table is None:
        return [(0.0, 0.0)]
    x0, _, x1, y1 = sheet_area(paper).space
    return [(x1 - hole_table_box(table, (0.0, 0.0))[2], y1), (x0, y1)]


def _notes(paper: Paper, texts: tuple[str, ...], title: Box2) -> list[tuple[Note, Box2]]:
    """Two positions of the notes, in the lower left corner and above the title block, with their bounding boxes."""
    x0, y0, _, _ = sheet_area(paper).space
    found = []
    for left, low, width in (
        # The centring mark is in the middle of the edge.
        (x0, y0, min(title[0] - 2 * TEXT_HEIGHT, PAPERS[paper][0] / 2 - TEXT_HEIGHT) - x0),
        (title[0], title[3] + 2 * TEXT_HEIGHT, title[2] - title[0]),
    ):
        lines = [line for text in texts for line in wrapped(text, width, indent="  ")]
        box = (
            left,
            low,
            left + max(map(symbol_text_width, lines)) + TEXT_HEIGHT,
            low + (len(lines) + 1) * LINE_PITCH * TEXT_HEIGHT,
        )
        found.append((Note((left, low), tuple(lines)), box))
    return found


def _title(part: PartDescription, design: Any, plan: SheetPlan, number: int, count: int) -> TitleBlock:
    drawing = design.drawing
    words = part.title
    general = general_tolerance(design, part.requirements)
    edges = "no sharp edges; chamfers as drawn" if part.brittle else drawing.edges
    return TitleBlock(
        title=f"{words} {number}/{count}" if count > 1 else words,
        supplement="-" if part.proposed else supplement_of(design, part.reads),
        number=getattr(drawing, f"file_{part.name}", part.name),
        material=part.material,
        mass=part.mass,
        scale=scale_text(plan.scale),
        sheet=number,
        sheets=count,
        revision=drawing.revision,
        parameters=part.digest,
        kind="Proposal, to be checked" if part.proposed else "Part drawing",
        finish=f"Ra {1e6 * drawing.roughness:g}",
        tolerances=tolerances_of(design),
        geometry=f"ISO 22081 profile {general.value:g} {' '.join(general.datums)}".strip(),
        edges=edges,
        treatment=part.treatment,
        **issue_of(design),
        revisions=revisions_of(design, part.reads),
    )


def issue_of(design: Any) -> dict[str, str]:
    """Fields of the title block about the issue."""
    drawing = design.drawing
    return {
        "date": drawing.date,
        "creator": drawing.drawn,
        "checker": drawing.checked,
        "approver": drawing.approved,
        "company": drawing.company,
    }


def supplement_of(design: Any, reads: Sequence[str]) -> str:
    """The product a sheet belongs to; where `--set` changed what the sheet shows, with the changes."""
    changed = [f"{key} = {design.entry(key).text}" for key in reads if design.is_overridden(key)]
    more = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
    return f"{design.drawing.title}, changed: {changed[0]}{more}" if changed else design.drawing.title


def revisions_of(design: Any, reads: Sequence[str]) -> tuple[str, ...]:
    """What a sheet shows that differs from the earlier issue: `stage.thickness: 12 mm, now 14 mm`."""
    before = {key: design.earlier_text(key) for key in reads}
    lines = [f"{key}: {text}, now {design.entry(key).text}" for key, text in before.items() if text is not None]
    if len(lines) > MOST_REVISIONS:
        lines = [*lines[:MOST_REVISIONS], f"and {len(lines) - MOST_REVISIONS} more; see stagecad params --diff"]
    return tuple(lines)


def tolerances_of(design: Any) -> tuple[tuple[str, str], ...]:
    """Tolerance classes and their tolerances for the title block."""
    drawing = design.drawing
    return (
        ("X.", f"±{drawing.tolerance_x:g}"),
        ("X.X", f"±{drawing.tolerance_x_x:g}"),
        ("X.XX", f"±{drawing.tolerance_x_xx:g}"),
        ("ANGLE", f"±{drawing.tolerance_angle:g}°"),
    )
