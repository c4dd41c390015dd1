"""Sheets of solids without declarations: a STEP file, or a CadQuery script; one sheet for each solid.

The proposal is written beside the sheet as `NAME_proposed.py`, which draws the same sheet again and is edited from
there, with the solid in the position in which it is drawn, `NAME_solid.step`.
"""

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

from stagecad.declared.own_part import REQUIRED, run_file
from stagecad.parameters.errors import InputError, require
from stagecad.parameters.machine import packaged_machine
from workbench.operations.design import Design
from workbench.operations.drawings import sheet_document, write_flat, write_sheets
from workbench.operations.lines import Line, Note


def draw_part(path: Path, out: Path, design: Design, trust: bool = False) -> dict[str, Any]:
    """Write sheet, definition, STEP AP242 and mass properties of a part from its Python file (`sheets.toml` beside it
    changes the sheet); their document. `design` gives materials and title block; without the consent of `trust`, or an
    earlier one, the file is refused."""
    from drawings.artefacts import build_sheets, sheet_names
    from drawings.sheets.overrides import FILE, read_overrides
    from stagecad.consent import give_consent
    from stagecad.parameters.atomic import atomic_write_text
    from stagecad.parameters.load import part_design
    from stagecad.solids.artefacts.part import build_part, part_mass
    from stagecad.solids.artefacts.store import ArtefactStore
    from stagecad.solids.modelling.part import part_names

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


STEP = (".step", ".stp")
MOST_SOLIDS = 200
"""Most solids of one file that are drawn, one sheet each."""


class PartSheets(list[dict[str, Any]]):
    """Documents of the parts of a file, whose sheets are written."""

    @property
    def hits(self) -> list[tuple[str, str]]:
        """Hits of the lint, each with the name of its part."""
        return [(one["part"], hit) for one in self for sheet in one["sheets"] for hit in sheet["hits"]]

    def lines(self, lint: bool) -> Iterator[Line]:
        """Files, open questions, hits of the lint and mass of each part."""
        for document in self:
            hits = [hit for sheet in document["sheets"] for hit in sheet["hits"]]
            yield from document["files"]
            yield from (f"question: {question}" for question in document.get("questions", ()))
            yield from (Note(f"{document['part']}: {hit}") for hit in hits if lint)
            yield f"mass {document['mass']['value']:.4g} kg; lint: {len(hits)} hits"

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad drawings --part --json`."""
        return self[0] if len(self) == 1 else {"parts": list(self)}


def draw_file(path: Path, design: Design, trust: bool, folder: Path, flat: bool = False) -> PartSheets:
    """Draw the parts of a part file, a script or a STEP file; `flat` as for `drawings`."""
    documents = _draw_file(path, design, trust, folder)
    for document in documents if flat else ():
        document["files"] += write_flat(document["files"])
    return PartSheets(documents)


def _draw_file(path: Path, design: Design, trust: bool, folder: Path) -> list[dict[str, Any]]:
    if path.suffix.lower() in STEP:
        return [propose_sheet(name, solid, path.name, design, folder) for name, solid in _step_solids(path)]
    module: Any = run_file(path, trust, "this part")
    if hasattr(module, "build") or hasattr(module, "dimensions") or hasattr(module, "NAME"):
        return [draw_part(path, folder, design)]
    solids = _shown_solids(module, path)
    if not solids:
        raise InputError(
            f"{path}: shows no solid; write show_object(result), or the words of a part: {', '.join(REQUIRED)}"
        )
    return [propose_sheet(name, solid, path.name, design, folder) for name, solid in solids]


def _step_solids(path: Path) -> list[tuple[str, Any]]:
    import cadquery as cq

    require(path.is_file(), f"{path}: cannot be read: No such file or directory")
    try:
        shape = cq.importers.importStep(str(path))
    except Exception as error:
        raise InputError(f"{path}: is no STEP file that can be read: {error}") from None
    solids: list[Any] = shape.solids().vals()
    if not solids:
        raise InputError(f"{path}: has no solid")
    return _named(_word(path.stem), solids, path)


def _shown_solids(module: ModuleType, path: Path) -> list[tuple[str, Any]]:
    """Solids that a script shows, else those of its last workplane, shape or assembly."""
    shown: list[tuple[str, Any]] = []
    marked: list[tuple[Any, Any, dict[str, Any]]] = getattr(module, "SHOWN", [])
    for number, (value, _, options) in enumerate(marked):
        name = options.get("name") or (path.stem if number == 0 else f"{path.stem}_{number + 1}")
        shown += _named(_word(str(name)), _solids(value), path)
    if not shown:
        values = [value for key, value in vars(module).items() if not key.startswith("_") and _solids(value)]
        shown = _named(_word(path.stem), _solids(values[-1]), path) if values else []
    names = [name for name, _ in shown]
    return [
        (name if names.count(name) == 1 else f"{name}_{number}", one) for number, (name, one) in enumerate(shown, 1)
    ]


def _solids(value: Any) -> list[Any]:
    """Solids of a workplane, a shape, or an assembly."""
    if hasattr(value, "toCompound"):
        return list(value.toCompound().Solids())
    if hasattr(value, "vals") and hasattr(value, "solids"):
        return [solid for one in value.vals() if hasattr(one, "Solids") for solid in one.Solids()]
    return list(value.Solids()) if hasattr(value, "Solids") and hasattr(value, "ShapeType") else []


def _named(name: str, solids: list[Any], path: Path) -> list[tuple[str, Any]]:
    if len(solids) > MOST_SOLIDS:
        raise InputError(f"{path}: has {len(solids)} solids; at most {MOST_SOLIDS} are drawn")
    return [(name if len(solids) == 1 else f"{name}_{number}", one) for number, one in enumerate(solids, start=1)]


def _word(text: str) -> str:
    word = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
    return word if word[:1].isalpha() else f"part_{word}".rstrip("_")


def propose_sheet(name: str, solid: Any, source: str, design: Design, folder: Path) -> dict[str, Any]:
    """Propose dimensions of a valid solid of the file `source`, write them as Python, and draw them; the document of
    the sheet."""
    import cadquery as cq

    from drawings.recognition.part_file import in_position, part_text
    from drawings.recognition.proposal import propose
    from stagecad.parameters.atomic import atomic_write_text
    from stagecad.solids.modelling.verification import DimensionVerifier

    if not solid.isValid() or solid.Volume() <= 0:
        raise InputError(f"{source}: the solid {name} is not valid and closed")
    name = f"{name}_part" if name in packaged_machine().table_names else name
    folder.mkdir(parents=True, exist_ok=True)
    file, model = folder / f"{name}_proposed.py", folder / f"{name}_solid.step"
    in_position(solid).exportStep(str(model))
    # The proposal is for the solid as it is read again.
    solid = cq.importers.importStep(str(model)).solids().val()
    proposal = propose(DimensionVerifier(solid))
    text = part_text(name, source, proposal)
    atomic_write_text(file, text)
    document = draw_part(file, folder, design, trust=True)
    return {
        **document,
        "files": [*document["files"], str(file), str(model)],
        "proposed": True,
        "questions": list(proposal.questions),
    }
