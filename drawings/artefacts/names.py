"""Names of the sheets of a design, without drawing any or loading the CAD kernel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from drawings.artefacts.sheets import PROCEDURE
from drawings.sheets.machine_sheets import sheets_of
from stagecad.parameters.errors import InputError, nearest
from stagecad.solids.modelling.registry import ASSEMBLY, construction, part_names


def sheet_names(design: Any) -> dict[str, tuple[str, ...]]:
    """Names of the sheets of each subject: the parts that are made, the assembly, the procedure."""
    sheets: dict[str, tuple[str, ...]] = {}
    for name, source in construction(design).sources(design).items():
        if not source.purchased:
            plans = sheets_of(design).plans(source.kind, source.design_of(design))
            sheets[name] = tuple(plan.name for plan in plans) or (source.kind,)
    return {**sheets, ASSEMBLY: (ASSEMBLY,), PROCEDURE: (PROCEDURE,)}


def chosen_sheets(names: Sequence[str], design: Any) -> dict[str, tuple[str, ...]]:
    """The sheets that are named, by subject or one by one; all when none is named."""
    known = sheet_names(design)
    if not names:
        return known
    chosen: set[str] = set()
    for name in names:
        subject = next((subject for subject, sheets in known.items() if name == subject or name in sheets), None)
        if subject is None:
            raise InputError(_unknown(name, known, design))
        chosen.update(known[subject] if name == subject else (name,))
    found = {subject: tuple(sheet for sheet in sheets if sheet in chosen) for subject, sheets in known.items()}
    return {subject: sheets for subject, sheets in found.items() if sheets}


def _unknown(name: str, known: dict[str, tuple[str, ...]], design: Any) -> str:
    if name in part_names(design):
        return f"part '{name}' is bought; it has no drawing"
    reason = construction(design).refusal(name, design)
    if reason:
        return f"part '{name}': {reason}"
    everything = [*known, *(sheet for sheets in known.values() for sheet in sheets if sheet not in known)]
    return f"no drawing '{name}'{nearest(name, everything)}"
