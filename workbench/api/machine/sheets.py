"""The drawing sheets of a design in the cache, to be looked at; `drawings` writes them to a folder."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stagecad.parameters.errors import InputError
from workbench.operations.design import Design, load_design


@dataclass(frozen=True)
class Sheet:
    """A drawing sheet in the cache.

    Args:
        name: of the sheet.
        key: of its entry in the cache, for `cached_file`.
        files: names in the entry.
        document: what `stagecad drawings --json` states of it, without files.
    """

    name: str
    key: str
    files: tuple[str, ...]
    document: dict[str, Any]


def sheet_names(design: Design) -> dict[str, list[str]]:
    """Names of the sheets by part, for the assembly and the procedure too."""
    from drawings.artefacts.names import sheet_names as names_of

    return {part: list(names) for part, names in names_of(design.values).items()}


def chosen_sheets(design: Design, names: Sequence[str]) -> dict[str, list[str]]:
    """Sheets by part, of names of parts or sheets.

    Raises:
        InputError: no such part or sheet.
    """
    from drawings.artefacts.names import chosen_sheets as chosen

    return {part: list(sheets) for part, sheets in chosen(tuple(names), design.values).items()}


def sheets(design: Design | None = None, names: Sequence[str] = ()) -> list[Sheet]:
    """The drawing sheets, from the cache or drawn now; `drawings` writes them to files.

    Args:
        design: the packaged machine when left out.
        names: of parts or sheets; all of them when left out.

    Raises:
        InputError: no such part or sheet.
    """
    from drawings.artefacts.tasks import build_all_sheets
    from stagecad.solids.artefacts.store import ArtefactStore
    from workbench.machine.artefacts import procedure_values

    design = design or load_design()
    wanted = chosen_sheets(design, names)
    made = build_all_sheets(ArtefactStore(), wanted, design.values, calculate=procedure_values)
    return [
        Sheet(
            sheet.name,
            sheet.artefact.key,
            tuple(sheet.files),
            {
                "part": sheet.part,
                "paper": sheet.paper,
                "scale": sheet.scale,
                "views": list(sheet.views),
                "hits": list(sheet.hits),
            },
        )
        for part, chosen in wanted.items()
        for sheet in made[part]
        if sheet.name in chosen
    ]


def cached_file(key: str, name: str) -> Path:
    """A file of the cache of solids and drawings, by the key of its entry.

    Raises:
        InputError: no such file.
    """
    from stagecad.solids.artefacts.store import ArtefactStore

    path = ArtefactStore().folder / "entries" / key / name
    if not re.fullmatch(r"[0-9a-f]{64}", key) or not re.fullmatch(r"[a-z0-9_]+\.[a-z]{3}", name):
        raise InputError(f"{key}/{name}: no file of the cache")
    if not path.is_file():
        raise InputError(f"{name}: no such file in the cache; make the solids again")
    return path
