"""The sheets as they were made: their files, and what lint has to say, from the cache when it has them.

What one part leaves in the cache: ``SHEET.dxf``, ``.svg``, ``.pdf``, ``.png`` for each of its sheets,
``PART_ap242.step``, and ``sheets.json``. Reading them needs neither the CAD kernel nor the DXF library.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from drawings.workers import run_tasks
from stagecad import __version__
from stagecad.solids.cache import Entry, Store
from stagecad.solids.machine import Machine, find_machine, make_machine, part_mass
from stagecad.solids.made_assembly import MadeAssembly
from stagecad.solids.made_part import MadePart, find_part, make_part
from stagecad.solids.registry import ASSEMBLY, module_of

FORMATS = ("dxf", "svg", "pdf", "png")
SHEETS = "sheets.json"

SLOWEST_FIRST = ("base", "stage", "holder", "tip", "tooth_bar", "bearing_way")
"""Order in which parts are begun, so that no long one is left for the end; the assembly needs them all."""


@dataclass(frozen=True)
class MadeSheet:
    """One sheet of one design, made.

    Attributes:
        name: of its files.
        part: what it shows.
        paper, scale: as printed.
        views: names.
        hits: what lint found, a line each.
    """

    name: str
    part: str
    paper: str
    scale: str
    views: tuple[str, ...]
    hits: tuple[str, ...]
    entry: Entry

    @property
    def files(self) -> tuple[str, ...]:
        return tuple(f"{self.name}.{kind}" for kind in FORMATS)


def _modules(part: str) -> tuple[str, ...]:
    from stagecad.solids.registry import module_name

    return (__name__, "drawings.part_sheets", "drawings.document", "drawings.export", module_name(part))


_OF_ASSEMBLY = (__name__, "drawings.assembly_sheet", "drawings.document", "drawings.export")


def _depends(made: MadePart | MadeAssembly) -> tuple[str, ...]:
    return (made.entry.key, *(f"{name} {version(name)}" for name in ("ezdxf", "matplotlib", "fonttools")))


def find_sheets(store: Store, part: str, design: Any) -> tuple[MadeSheet, ...] | None:
    """The sheets of a part, or of the assembly, from the cache, or None where they have to be made."""
    if part == ASSEMBLY:
        machine = find_machine(design, store)
        entry = machine and store.find(f"drawing of {part}", design, _OF_ASSEMBLY, _depends(machine.assembly))
        return _sheets(entry) if entry else None
    made = find_part(store, part, design)
    if made is None:
        return None
    entry = store.find(f"drawing of {part}", design, _modules(part), _depends(made))
    return _sheets(entry) if entry is not None else None


def _sheets(entry: Entry) -> tuple[MadeSheet, ...]:
    return tuple(
        MadeSheet(
            document["name"],
            document["part"],
            document["paper"],
            document["scale"],
            tuple(document["views"]),
            tuple(document["hits"]),
            entry,
        )
        for document in entry.document(SHEETS)
    )


def make_sheets(
    store: Store,
    parts: Iterable[str],
    design: Any,
    advance: Callable[[str], None] = lambda name: None,
    workers: int | None = None,
) -> dict[str, tuple[MadeSheet, ...]]:
    """The sheets of some parts, those that the cache lacks drawn side by side in processes of their own.

    Args:
        store: the cache.
        parts: names.
        design: it must pickle.
        advance: called with each part as it is done.
        workers: processes; the number of processors when left out.
    """
    wanted = tuple(parts)
    found: dict[str, tuple[MadeSheet, ...]] = {}
    for part in wanted:
        sheets = find_sheets(store, part, design)
        if sheets is not None:
            found[part] = sheets
            advance(part)
    missing = sorted((part for part in wanted if part not in found), key=_slowness)
    if missing:
        run_tasks(missing, partial(_draw_elsewhere, store.folder, design), advance, workers=workers)
    for part in missing:
        sheets = find_sheets(store, part, design)
        if sheets is None:
            raise OSError(f"the cache in {store.folder} lost the sheets of '{part}' just drawn")
        found[part] = sheets
    return {part: found[part] for part in wanted}


def _slowness(part: str) -> int:
    if part == ASSEMBLY:
        return len(SLOWEST_FIRST) + 1
    return SLOWEST_FIRST.index(part) if part in SLOWEST_FIRST else len(SLOWEST_FIRST)


def _draw_elsewhere(folder: Path, design: Any, part: str, late: bool) -> None:
    if part == ASSEMBLY:
        draw_assembly(Store(folder), design)
    else:
        draw_part(Store(folder), part, design, exact=not late)


def draw_assembly(store: Store, design: Any) -> tuple[MadeSheet, ...]:
    """The assembly's sheet from the cache, drawn now when it lacks it."""
    machine = make_machine(design, store)

    def make(reading: Any, folder: Path) -> None:
        from drawings.assembly_sheet import Assembled, assembly_sheet
        from stagecad.solids.made_assembly import shapes_of

        read = Machine(reading, machine.parts, machine.assembly)
        instances = machine.assembly.instances
        shapes = shapes_of(instances, machine.parts, reading)
        reads = sorted({name for part in machine.parts.values() for name in part.entry.reads})
        assembled = Assembled(
            instances,
            {name: shape.wrapped for name, shape in shapes.items()},
            read.bill_of_materials,
            _shown_mass(read.whole.mass),
            digest(reading, reads),
            __version__,
        )
        documents = [write_sheet(assembly_sheet(assembled, reading), folder)]
        (folder / SHEETS).write_text(json.dumps(documents, indent=1), "utf-8")

    entry = store.make(f"drawing of {ASSEMBLY}", design, _OF_ASSEMBLY, make, _depends(machine.assembly))
    return _sheets(entry)


def _shown_mass(kilograms: float) -> str:
    return f"{kilograms:.2f} kg" if kilograms >= 1.0 else f"{1000 * kilograms:.3g} g"


def draw_part(store: Store, part: str, design: Any, *, exact: bool = True) -> tuple[MadeSheet, ...]:
    """The sheets of one part from the cache, drawn now when it lacks them.

    Args:
        exact: how lines are hidden (`drawings.projection.project`).
    """
    made = make_part(store, part, design)

    def make(reading: Any, folder: Path) -> None:
        from drawings.part_sheets import sheets_of

        described = describe(made, reading)
        documents = [write_sheet(sheet, folder) for sheet in sheets_of(described, reading, exact=exact)]
        (folder / SHEETS).write_text(json.dumps(documents, indent=1), "utf-8")

    return _sheets(store.make(f"drawing of {part}", design, _modules(part), make, _depends(made)))


def describe(made: MadePart, design: Any) -> Any:
    """A made part as its sheets need it."""
    from drawings.part_sheets import Described

    module: Any = module_of(made.name)
    return Described(
        name=made.name,
        solid=made.solid,
        dimensions=module.dimensions(design),
        requirements=module.requirements(design) if hasattr(module, "requirements") else (),
        notes=getattr(module, "NOTES", ()),
        material=design.materials[made.material].description,
        mass=_shown_mass(part_mass(made, design).mass),
        digest=digest(design, made.entry.reads),
        revision=__version__,
    )


def digest(design: Any, reads: Sequence[str]) -> str:
    """Short hash of the parameters a part was made from: their names and values, and nothing else."""
    values: list[tuple[str, str]] = []
    for name in reads:
        value = design
        for step in name.split("."):
            value = getattr(value, step, None)
        if value is not None:
            values.append((name, repr(value)))
    return hashlib.sha256(json.dumps(values).encode()).hexdigest()[:8]


def write_sheet(sheet: Any, folder: Path) -> dict[str, Any]:
    """Write the four files of a sheet, and tell what it is."""
    from drawings.document import document_of, dxf_bytes
    from drawings.export import render
    from drawings.sheet import scale_text

    document = document_of(sheet)
    (folder / f"{sheet.name}.dxf").write_bytes(dxf_bytes(document))
    renderings = render(document, sheet.paper)
    for kind in ("svg", "pdf", "png"):
        (folder / f"{sheet.name}.{kind}").write_bytes(getattr(renderings, kind))
    return {
        "name": sheet.name,
        "part": sheet.part,
        "paper": sheet.paper,
        "scale": scale_text(sheet.scale),
        "views": [view.name for view in sheet.views],
        "hits": [],
    }
