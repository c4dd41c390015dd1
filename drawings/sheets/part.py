"""The sheets of a part: projection of the views, placement of the dimensions, title block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from drawings.annotations.annotation import Note
from drawings.annotations.font import LINE_PITCH, TEXT_HEIGHT
from drawings.annotations.symbols import symbol_text_width
from drawings.dimensions.dimensioning import sheet_dimensions
from drawings.dimensions.specification import DimensionSpec
from drawings.placement.views import Arrangement, annotated_views, arrange, detached
from drawings.sheets.frame import PAPERS, Paper
from drawings.sheets.plans import SheetPlan, ViewPlan, sheet_of, sheet_of_requirement, sheet_plans
from drawings.sheets.sheet import Sheet, scale_text, sheet_area, wrapped
from drawings.sheets.title_block import TitleBlock, title_box
from drawings.views.centre_lines import axes_of, centre_lines
from drawings.views.detail import clipped
from drawings.views.projection import project, with_simple_curves
from drawings.views.section import cut_faces, cut_shape, hatch
from drawings.views.view import PROJECTIONS, Arc, Box2, Curve, Layer, View
from stagecad.parameters.dimension import Dimension, FaceRequirement
from stagecad.solids.modelling.verification import DimensionVerifier

if TYPE_CHECKING:
    import cadquery as cq
    from OCP.TopoDS import TopoDS_Shape  # pyright: ignore[reportAttributeAccessIssue]


TITLES = {"tip": "actuator tip", "holder": "piezo holder"}
"""Titles of the thesis where they differ from the names of the parts."""


DETACHABLE = ("bottom", "back", "left")
"""Views that may be detached from their row, with a label, where the paper is too small."""


def part_views(shape: TopoDS_Shape, plans: Sequence[SheetPlan], *, exact: bool = True) -> tuple[tuple[View, ...], ...]:
    """The views of each sheet of a part, not yet placed; a projection that several sheets show is computed once.

    Args:
        shape: the solid.
        exact: method of hidden-line removal (`drawings.views.projection.project`).
    """
    axes = axes_of(shape)
    drawn = with_simple_curves(shape) if exact else shape
    outside = {(plan.projection, plan.hidden) for sheet in plans for plan in sheet.views if not plan.cut}
    projected = {
        (name, hidden): project(drawn, PROJECTIONS[name], hidden=hidden, exact=exact, simple=True)
        for name, hidden in outside
    }

    def view(plan: ViewPlan, sheet_scale: float) -> View:
        scale, projection, label, clip = plan.scale or sheet_scale, PROJECTIONS[plan.projection], "", None
        curves: dict[Layer, tuple[Curve, ...]]
        if plan.cut:
            left = cut_shape(shape, plan.cut)
            curves = project(left, projection, hidden=False, exact=exact)
            curves["HATCH"] = hatch(cut_faces(left, plan.cut), projection, scale)
            label = f"{plan.cut.letter}-{plan.cut.letter}"
        else:
            curves = dict(projected[plan.projection, plan.hidden])
        if plan.projection != "iso":
            curves["CENTRE"] = centre_lines(curves, axes, projection, scale, plan.symmetry)
        if plan.detail:
            clip = (projection.to_view(plan.detail[0]), plan.detail[1])
            curves = {layer: clipped(lines, *clip) for layer, lines in curves.items()}
            curves["HATCH"] = (*curves.get("HATCH", ()), Arc(*clip))
            label = plan.letter
        if label and scale != sheet_scale:
            label = f"{label} ({scale_text(scale)})"
        return View(
            plan.name, projection, curves, scale, label=label, clip=clip, cut=plan.cut, aligned_with=plan.aligned_with
        )

    return tuple(tuple(view(plan, sheet.scale) for plan in sheet.views) for sheet in plans)


@dataclass(frozen=True)
class PartDescription:
    """The data of a part for its sheets.

    Args:
        solid: in part coordinates.
        dimensions, requirements: the declarations of the part.
        notes: of the part.
        material: as ordered.
        mass: with its unit.
        digest: hash of the parameters of the part.
        revision: of the program.
    """

    name: str
    solid: cq.Solid
    dimensions: tuple[Dimension, ...]
    requirements: tuple[FaceRequirement, ...]
    notes: tuple[str, ...]
    material: str
    mass: str
    digest: str
    revision: str


def part_sheets(
    part: PartDescription, design: Any, verifier: DimensionVerifier | None = None, *, exact: bool = True
) -> tuple[Sheet, ...]:
    """The sheets of a part.

    Args:
        design: for scales, tolerances and the title.
        verifier: of the solid, if there is one already.
        exact: method of hidden-line removal (`drawings.views.projection.project`).
    """
    plans = sheet_plans(part.name, design)
    views = part_views(part.solid.wrapped, plans, exact=exact)
    verifier = verifier or DimensionVerifier(part.solid)
    return tuple(
        _sheet(part, design, plans, number, views[number - 1], verifier) for number in range(1, len(plans) + 1)
    )


def _sheet(
    part: PartDescription,
    design: Any,
    plans: tuple[SheetPlan, ...],
    number: int,
    views: tuple[View, ...],
    verifier: DimensionVerifier,
) -> Sheet:
    plan = plans[number - 1]
    dimensions = [d for d in part.dimensions if sheet_of(plans, d.name) is plan]
    requirements = [r for r in part.requirements if sheet_of_requirement(plans, r) is plan]
    shown = sheet_dimensions(dimensions, requirements, design, verifier, views)
    if shown.missing:
        raise ValueError(f"sheet '{plan.name}': no view shows {', '.join(shown.missing)}")
    paper, arranged, note = _arranged(plan, views, shown.specs, _note_lines(part, shown.notes))
    title = _title(part, design, plan, number, len(plans))
    return Sheet(plan.name, part.name, paper, plan.scale, title, arranged.views, arranged.annotations, (note,))


def _arranged(
    plan: SheetPlan, views: tuple[View, ...], specs: Sequence[DimensionSpec], texts: tuple[str, ...]
) -> tuple[Paper, Arrangement, Note]:
    """Views, annotations and notes on the smallest paper on which they fit."""
    every = annotated_views(views, specs)
    loose = [view.name for view in plan.views if view.name in DETACHABLE and view.aligned_with]
    variants = {"": every}
    sizes = list(PAPERS)
    for paper in (*plan.papers, *sizes[sizes.index(plan.papers[-1]) + 1 :]):
        for name in ("", *loose):
            if name not in variants:
                variants[name] = detached(every, name)
            for note, box in _notes(paper, texts):
                arranged = arrange(variants[name], sheet_area(paper, (box,)))
                if arranged.fits:
                    return paper, arranged, note
    note, box = _notes(plan.papers[-1], texts)[0]
    return plan.papers[-1], arrange(every, sheet_area(plan.papers[-1], (box,))), note


def _notes(paper: Paper, texts: tuple[str, ...]) -> list[tuple[Note, Box2]]:
    """Two positions of the notes, in the lower left corner and above the title block, with their bounding boxes."""
    x0, y0, _, _ = sheet_area(paper).space
    title = title_box(paper)
    found = []
    for left, low, width in (
        (x0, y0, title[0] - x0 - 2 * TEXT_HEIGHT),
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


def _note_lines(part: PartDescription, numbered: Sequence[str]) -> tuple[str, ...]:
    """Notes of the sheet: general, of the part, and those that dimensions refer to by number."""
    lines = [
        "NOTES",
        "- Tolerances by the decimals of a dimension: see the table.",
        *(f"- {text}" for text in part.notes),
    ]
    lines += [f"[{index}] {text}" for index, text in enumerate(numbered, start=1)]
    return tuple(lines)


def _title(part: PartDescription, design: Any, plan: SheetPlan, number: int, count: int) -> TitleBlock:
    drawing = design.drawing
    words = TITLES.get(part.name, part.name.replace("_", " "))
    return TitleBlock(
        title=f"{words} {number}/{count}" if count > 1 else words,
        supplement=drawing.title,
        number=getattr(drawing, f"file_{part.name}"),
        material=part.material,
        mass=part.mass,
        scale=scale_text(plan.scale),
        sheet=number,
        sheets=count,
        revision=part.revision,
        parameters=part.digest,
        kind="Part drawing",
        finish=f"Ra {1e6 * drawing.roughness:g}, edges deburred",
        tolerances=tolerances_of(design),
    )


def tolerances_of(design: Any) -> tuple[tuple[str, str], ...]:
    """Tolerance classes and their tolerances for the title block."""
    drawing = design.drawing
    return (
        ("X.", f"±{drawing.tolerance_x:g}"),
        ("X.X", f"±{drawing.tolerance_x_x:g}"),
        ("X.XX", f"±{drawing.tolerance_x_xx:g}"),
        ("ANGLE", f"±{drawing.tolerance_angle:g}°"),
    )
