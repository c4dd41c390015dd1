"""Sheet plans: the views of a part, their sheets and scales, and the plans of a machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from drawings.sheets.frame import Paper
from drawings.views.view import Cut, projection_of
from stagecad.parameters.dimension import FaceRequirement, Point
from stagecad.parameters.machine import content, packaged_machine

if TYPE_CHECKING:
    from drawings.pictures.machine import MachineViews
    from drawings.sheets.procedure import Procedure
    from stagecad.solids.artefacts.part import BuiltPart
    from stagecad.solids.assembly.bill_of_materials import Row
    from stagecad.solids.modelling.part import Instance


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
    procedure: Callable[[Any, Sequence[Row], Any], Procedure]
    travel: Callable[[Any], float]  # of the parts that move, from end to end, mm
    modules: tuple[str, ...]  # dotted names of the modules that these are made by


def sheets_of(design: Any) -> Sheets:
    """The sheets of a design's machine."""
    return content("drawings", design.machine, "sheets").SHEETS


def packaged_sheets() -> Sheets:
    """The sheets of the packaged machine, whose parts any machine may have."""
    return content("drawings", packaged_machine(), "sheets").SHEETS
