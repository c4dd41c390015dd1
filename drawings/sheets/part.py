"""The sheets of a part: its views projected, its declarations asked for and arranged, its title block filled in."""

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
from drawings.views.centre_lines import Axis, axes_of, centre_lines
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
"""Titles that say more than the part's name, as the thesis has them."""


DETACHABLE = ("bottom", "back", "left")
"""Views that may stand by themselves where a sheet is too small for them in line; they are named then."""


class Views:
    """Makes the views of one part; what several views need is worked out once.

    Args:
        shape: the solid.
        exact: hidden lines by the exact algorithm (`drawings.views.projection.project`).
    """

    def __init__(self, shape: TopoDS_Shape, *, exact: bool = True) -> None:
        self._shape = shape
        self._exact = exact
        self._drawn = with_simple_curves(shape) if exact else shape
        self._axes: tuple[Axis, ...] = axes_of(shape)
        self._projected: dict[tuple[str, bool], dict[Layer, tuple[Curve, ...]]] = {}

    def of(self, plan: SheetPlan) -> tuple[View, ...]:
        """The views of a sheet, without places."""
        return tuple(self._view(view, plan.scale) for view in plan.views)

    def _view(self, plan: ViewPlan, sheet_scale: float) -> View:
        scale, projection = plan.scale or sheet_scale, PROJECTIONS[plan.projection]
        label = ""
        curves: dict[Layer, tuple[Curve, ...]]
        if plan.cut:
            left = cut_shape(self._shape, plan.cut)
            curves = dict(project(left, projection, hidden=False, exact=self._exact))
            curves["HATCH"] = hatch(cut_faces(left, plan.cut), projection, scale)
            label = f"{plan.cut.letter}-{plan.cut.letter}"
        else:
            curves = dict(self._outside(plan))
        if plan.projection != "iso":
            curves["CENTRE"] = centre_lines(curves, self._axes, projection, scale, plan.symmetry)
        clip = None
        if plan.detail:
            clip = (projection.to_view(plan.detail[0]), plan.detail[1])
            curves = {layer: clipped(lines, *clip) for layer, lines in curves.items()}
            curves["HATCH"] = (*curves.get("HATCH", ()), Arc(*clip))
            label = plan.letter
        if label and scale != sheet_scale:
            label = f"{label} ({scale_text(scale)})"
        return View(plan.name, projection, curves, scale, label=label, clip=clip, cut=plan.cut, beside=plan.beside)

    def _outside(self, plan: ViewPlan) -> dict[Layer, tuple[Curve, ...]]:
        key = (plan.projection, plan.hidden)
        if key not in self._projected:
            projection = PROJECTIONS[plan.projection]
            self._projected[key] = project(self._drawn, projection, hidden=plan.hidden, exact=self._exact, simple=True)
        return self._projected[key]


@dataclass(frozen=True)
class Described:
    """A part as its sheets need it.

    Args:
        name: of the part.
        solid: in part coordinates.
        dimensions, requirements: what is declared beside its features.
        notes: of the part's module.
        material: as it is ordered.
        mass: with its unit.
        digest: hash of the parameters its sheets depend on.
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


def sheets_of(
    part: Described, design: Any, gauge: DimensionVerifier | None = None, *, exact: bool = True
) -> tuple[Sheet, ...]:
    """The sheets of a part.

    Args:
        part: what is drawn.
        design: for scales that depend on it, tolerances and the title.
        gauge: of the solid, where it has been read before.
        exact: how lines are hidden (`drawings.views.projection.project`).
    """
    plans = sheet_plans(part.name, design)
    views = Views(part.solid.wrapped, exact=exact)
    gauge = gauge or DimensionVerifier(part.solid)
    return tuple(
        _sheet(part, design, plans, number, views.of(plan), gauge) for number, plan in enumerate(plans, start=1)
    )


def _sheet(
    part: Described,
    design: Any,
    plans: tuple[SheetPlan, ...],
    number: int,
    views: tuple[View, ...],
    gauge: DimensionVerifier,
) -> Sheet:
    plan = plans[number - 1]
    dimensions = [d for d in part.dimensions if sheet_of(plans, d.name) is plan]
    requirements = [r for r in part.requirements if sheet_of_requirement(plans, r) is plan]
    shown = sheet_dimensions(dimensions, requirements, design, gauge, views)
    if shown.missing:
        raise ValueError(f"sheet '{plan.name}': no view shows {', '.join(shown.missing)}")
    lines = _note_lines(part, shown.notes)
    paper, arranged, note = _arranged(plan, views, shown.specs, lines)
    title = _title(part, design, plan, number, len(plans))
    return Sheet(plan.name, part.name, paper, plan.scale, title, arranged.views, arranged.annotations, (note,))


def _arranged(
    plan: SheetPlan, views: tuple[View, ...], asked: Sequence[DimensionSpec], texts: tuple[str, ...]
) -> tuple[Paper, Arrangement, Note]:
    """Views, annotations and notes on the smallest paper on which they fit."""
    every = annotated_views(views, asked)
    loose = [view.name for view in plan.views if view.name in DETACHABLE and view.beside]
    ways = {"": every}
    sizes = list(PAPERS)
    for paper in (*plan.papers, *sizes[sizes.index(plan.papers[-1]) + 1 :]):
        for name in ("", *loose):
            if name not in ways:
                ways[name] = detached(every, name)
            for note, room in _notes(paper, texts):
                arranged = arrange(ways[name], sheet_area(paper, (room,)))
                if arranged.fits:
                    return paper, arranged, note
    note, room = _notes(plan.papers[-1], texts)[0]
    return plan.papers[-1], arrange(every, sheet_area(plan.papers[-1], (room,))), note


def _notes(paper: Paper, texts: tuple[str, ...]) -> list[tuple[Note, Box2]]:
    """The notes beside the title block, in the lower left corner, or above it, and the room they take."""
    x0, y0, _, _ = sheet_area(paper).space
    title = title_box(paper)
    found = []
    for left, low, width in (
        (x0, y0, title[0] - x0 - 2 * TEXT_HEIGHT),
        (title[0], title[3] + 2 * TEXT_HEIGHT, title[2] - title[0]),
    ):
        lines = [line for text in texts for line in wrapped(text, width, indent="  ")]
        room = (
            left,
            low,
            left + max(map(symbol_text_width, lines)) + TEXT_HEIGHT,
            low + (len(lines) + 1) * LINE_PITCH * TEXT_HEIGHT,
        )
        found.append((Note((left, low), tuple(lines)), room))
    return found


def _note_lines(part: Described, numbered: Sequence[str]) -> tuple[str, ...]:
    """Notes of the sheet: general ones, the part's own, and those that dimensions refer to by number."""
    lines = [
        "NOTES",
        "- Tolerances by the decimals of a dimension: see the table.",
        *(f"- {text}" for text in part.notes),
    ]
    lines += [f"[{index}] {text}" for index, text in enumerate(numbered, start=1)]
    return tuple(lines)


def _title(part: Described, design: Any, plan: SheetPlan, number: int, count: int) -> TitleBlock:
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
    """What the decimals of a dimension allow, and what an angle is allowed, as the title block says it."""
    drawing = design.drawing
    return (
        ("X.", f"±{drawing.tolerance_x:g}"),
        ("X.X", f"±{drawing.tolerance_x_x:g}"),
        ("X.XX", f"±{drawing.tolerance_x_xx:g}"),
        ("ANGLE", f"±{drawing.tolerance_angle:g}°"),
    )
