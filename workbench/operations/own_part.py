"""The sheet of a part of the user's own."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from workbench.operations.design import Design
from workbench.operations.drawings import sheet_document, write_sheets


def draw_part(path: Path, out: Path, design: Design, trust: bool = False) -> dict[str, Any]:
    """Write sheet, definition, STEP AP242 and mass properties of a part; returns their document.

    Args:
        path: Python file of the part (`stagecad new part`); `sheets.toml` beside it changes the sheet.
        out: folder of the files.
        design: whose materials and entries of the title block it has.
        trust: whether the user consents to run the file as it is now.

    Raises:
        InputError: no consent, an error of the file, or a dimension that is not on the solid.
    """
    from drawings.artefacts.names import sheet_names
    from drawings.artefacts.sheets import build_sheets
    from drawings.sheets.overrides import FILE, read_overrides
    from stagecad.consent import give_consent
    from stagecad.parameters.atomic import atomic_write_text
    from stagecad.parameters.load import part_design
    from stagecad.solids.artefacts.part import build_part, part_mass
    from stagecad.solids.artefacts.store import ArtefactStore
    from stagecad.solids.modelling.registry import part_names

    if trust:
        give_consent((path,))
    values, store = part_design(design.file, design.overrides, path), ArtefactStore()
    (name,) = part_names(values)
    changes = path.parent / FILE
    if changes.is_file():
        known = [sheet for one in (design.values, values) for sheets in sheet_names(one).values() for sheet in sheets]
        values = replace(values, sheets=read_overrides(changes, known))
    sheets = build_sheets(store, name, values)
    mass = part_mass(build_part(store, name, values), values).as_json()
    write_sheets(sheets, out)
    properties = out / f"{name}_mass.json"
    atomic_write_text(properties, json.dumps(mass, indent=1) + "\n")
    documents = [{"name": sheet.name, **sheet_document(sheet, out), "digest": sheet.digest} for sheet in sheets]
    files = [file for document in documents for file in document["files"]]
    return {"part": name, "sheets": documents, "files": [*files, str(properties)], **mass}
