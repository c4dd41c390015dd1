"""What a machine states of its sheets: plans of the parts, views of the whole, procedure. Found by its name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from drawings.sheets.plans import SheetPlan
from stagecad.parameters.machine import content, packaged_machine

if TYPE_CHECKING:
    from drawings.pictures.machine import MachineViews
    from drawings.sheets.procedure import Procedure
    from stagecad.solids.artefacts.part import BuiltPart
    from stagecad.solids.assembly.bill_of_materials import Row
    from stagecad.solids.modelling.instance import Instance


@dataclass(frozen=True)
class Sheets:
    """Sheets of a kind of machine.

    Args:
        plans: the sheets of a kind of part in a design; none for one that has the standard sheet.
        titles: words of the title block for kinds of part, where they are not those of its name.
        views: how the whole is shown, given the design, its instances and built parts.
        procedure: the steps of assembly, given the design, the parts list and the calculated values.
        travel: of the parts that move, from end to end, mm.
        modules: dotted names of the modules that these are made by.
    """

    plans: Callable[[str, Any], tuple[SheetPlan, ...]]
    titles: Mapping[str, str]
    views: Callable[[Any, Sequence[Instance], Mapping[str, BuiltPart]], MachineViews]
    procedure: Callable[[Any, Sequence[Row], Any], Procedure]
    travel: Callable[[Any], float]
    modules: tuple[str, ...]


def sheets_of(design: Any) -> Sheets:
    """The sheets of a design's machine."""
    return content("drawings", design.machine, "sheets").SHEETS


def packaged_sheets() -> Sheets:
    """The sheets of the packaged machine, whose parts any machine may have."""
    return content("drawings", packaged_machine(), "sheets").SHEETS
