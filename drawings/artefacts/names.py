"""Names of the sheets of a design, without drawing any or loading the CAD kernel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from drawings.artefacts.sheets import PROCEDURE
from drawings.sheets.plans import sheet_plans
from stagecad.parameters.errors import InputError, nearest
from stagecad.solids.modelling.registry import ASSEMBLY, MADE, OF_TEETH, PURCHASED, part_names


def sheet_names(design: Any) -> dict[str, tuple[str, ...]]:
    """Names of the sheets of each subject: the parts that are made, the assembly, the procedure."""
    made = [name for name in part_names(design) if name in MADE]
    sheets = {part: tuple(plan.name for plan in sheet_plans(part, design)) for part in made}
    return {**sheets, ASSEMBLY: (ASSEMBLY,), PROCEDURE: (PROCEDURE,)}


def chosen_sheets(names: Sequence[str], design: Any) -> dict[str, tuple[str, ...]]:
    """The sheets that are named, by subject or one by one; all when none is named.

    Raises:
        InputError: a name that is neither, with the nearest that is.
    """
    known = sheet_names(design)
    if not names:
        return known
    chosen: set[str] = set()
    for name in names:
        subject = next((subject for subject, sheets in known.items() if name == subject or name in sheets), None)
        if subject is None:
            raise InputError(_unknown(name, known))
        chosen.update(known[subject] if name == subject else (name,))
    found = {subject: tuple(sheet for sheet in sheets if sheet in chosen) for subject, sheets in known.items()}
    return {subject: sheets for subject, sheets in found.items() if sheets}


def _unknown(name: str, known: dict[str, tuple[str, ...]]) -> str:
    if name in PURCHASED:
        return f"part '{name}' is bought; it has no drawing"
    if name in OF_TEETH:
        return f"part '{name}': this design has no magnetic teeth; set teeth.fitted = true"
    everything = [*known, *(sheet for sheets in known.values() for sheet in sheets if sheet not in known)]
    return f"no drawing '{name}'{nearest(name, everything)}"
