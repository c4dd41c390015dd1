"""Sheets of a machine of the user's own: views of the whole by its size, steps of assembly by its mates."""

from collections.abc import Mapping, Sequence
from typing import Any

from drawings.pictures.machine import MachineViews
from drawings.pictures.picture import SCALE
from drawings.sheets.plans import CALCULATED, Figure, PartUse, SheetPlan, Sheets, Step, packaged_sheets
from drawings.views.view import Cut
from stagecad.parameters.machine import MachineDeclaration, Mate
from stagecad.parameters.machine_declaration import placed_values
from stagecad.solids.artefacts.part import BuiltPart
from stagecad.solids.assembly.bill_of_materials import Row
from stagecad.solids.modelling.part import Instance, construction

SCALES = (5.0, 2.0, 1.0, SCALE, 0.2, 0.1, 0.05, 0.02)
ROOM = (560.0, 380.0)
"""Space of the views on the larger paper beside the parts list, with gaps and dimensions, mm: top view and sections one
above the other, and beside them the exploded view."""


def _plans(kind: str, design: Any) -> tuple[SheetPlan, ...]:
    """Those of the packaged machine for its parts."""
    own = {part.part for part in design.machine.declaration.parts if part.file}
    return () if kind in own else packaged_sheets().plans(kind, design)


def _views(design: Any, instances: Sequence[Instance], parts: Mapping[str, BuiltPart]) -> MachineViews:
    """Sections through the middle of the machine, at the largest usual scale with which the views fit."""
    low, high = _box(instances, parts, exploded=False)
    x, y, z = (b - a for a, b in zip(low, high, strict=True))
    # An isometric view of the parts taken apart is about as wide as their box is in both directions.
    apart = [b - a for a, b in zip(*_box(instances, parts, exploded=True), strict=True)]
    wide, tall = max(x, y) + 0.75 * (apart[0] + apart[1]), max(y + 2 * z, apart[2] + 0.41 * (apart[0] + apart[1]))
    scale = next((one for one in SCALES if one * wide <= ROOM[0] and one * tall <= ROOM[1]), SCALES[-1])
    middle = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2)
    cuts = {
        "section A-A": (Cut(middle, (0.0, -1.0, 0.0), "A"), "front"),
        "section B-B": (Cut(middle, (1.0, 0.0, 0.0), "B"), "right"),
    }
    bought = tuple(name for name, source in construction(design).sources(design).items() if source.purchased)
    notes = ("- Order of assembly: see the procedure.", *(("- Purchased parts are not cut.",) if bought else ()))
    return MachineViews(cuts, bought, scale=scale, notes=notes)


def _box(
    instances: Sequence[Instance], parts: Mapping[str, BuiltPart], *, exploded: bool
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Corners of the bounding box of all instances, mm."""
    corners = []
    for one in instances:
        frame = one.exploded if exploded else one.frame
        (x0, y0, z0), (x1, y1, z1) = parts[one.part].geometry.bounding_box
        corners += [frame.point((x, y, z)) for x in (x0, x1) for y in (y0, y1) for z in (z0, z1)]
    axes = list(zip(*corners, strict=True))
    return tuple(map(min, axes)), tuple(map(max, axes))


def procedure(design: Any, rows: Sequence[Row], values: Mapping[str, Any]) -> tuple[Step, ...]:
    """A step for each part, in the order of the mates: where it is put, and how far from there."""
    declaration: MachineDeclaration = design.machine.declaration
    listed = {row.part: row for row in rows}
    kinds: dict[str, list[Mate]] = {}
    for mate in declaration.mates:
        kinds.setdefault(mate.part, []).append(mate)
    steps = []
    for number, (part, mates) in enumerate(kinds.items(), start=1):
        row, words = listed[part], part.replace("_", " ")
        figures: dict[str, Figure] = {}
        sentences = [sentence for mate in mates for sentence in _sentences(design, mate, figures)]
        use = PartUse(row.item, part, row.part_number, row.quantity)
        steps.append(Step(number, words.capitalize(), tuple(sentences), (use,), (), None, figures))
    return tuple(steps)


def _sentences(design: Any, mate: Mate, figures: dict[str, Figure]) -> list[str]:
    """What is done with one mate; the numbers are added to `figures`."""
    name = mate.name.replace("_", " ")
    if not mate.datum:
        return [f"Set up {name}: all other parts are put on it."]
    offset, turn = placed_values(design, mate)
    on, datum = mate.on
    each = "each" if mate.is_pattern else "the"
    found = [f"Put the {mate.datum} of {name} on {each} {datum.replace('*', 'N')} of {on.replace('_', ' ')}."]
    shifts = []
    for axis, length in zip(("x", "y", "its normal"), offset, strict=True):
        if length:
            figures[f"{mate.name}_{axis}"] = Figure(f"{round(length, 3):g} mm", CALCULATED)
            shifts.append(f"{round(length, 3):g} mm along {axis}")
    if turn:
        figures[f"{mate.name}_turn"] = Figure(f"{turn:g}°", CALCULATED)
        shifts.append(f"turned by {turn:g}°")
    return [*found, f"From there: {', '.join(shifts)}."] if shifts else found


SHEETS = Sheets(
    plans=_plans,
    titles={},
    views=_views,
    procedure=procedure,
    travel=lambda design: 0.0,
    modules=(__name__, *packaged_sheets().modules),
)
