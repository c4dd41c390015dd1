"""The sheets as they were made: their files, and what lint has to say, from the cache when it has them.

What one part leaves in the cache: ``SHEET.dxf``, ``.svg``, ``.pdf``, ``.png`` for each of its sheets,
``PART_ap242.step``, and ``sheets.json``. Reading them needs neither the CAD kernel nor the DXF library.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drawings.artefacts.pictures import PICTURES, PROCEDURE, make_picture
from stagecad import __version__
from stagecad.parameters.mass_properties import combined
from stagecad.solids.artefacts.part import BuiltPart, build_part, find_part
from stagecad.solids.artefacts.source_digest import versions
from stagecad.solids.artefacts.store import Artefact, ArtefactStore
from stagecad.solids.assembly.assemble import assemble
from stagecad.solids.assembly.machine import part_mass
from stagecad.solids.modelling.mass import placed
from stagecad.solids.modelling.registry import ASSEMBLY, module_name, part_definition, part_names

if TYPE_CHECKING:
    from drawings.pictures.picture import Picture
    from drawings.procedure.figures import ProcedureValues
    from drawings.sheets.assembly import Assembled
    from drawings.sheets.assembly_dimensions import Extent
    from drawings.sheets.sheet import Sheet
    from stagecad.solids.assembly.assemble import Instance

FORMATS = ("dxf", "svg", "pdf", "png")
SHEETS = "sheets.json"
WHOLE = (ASSEMBLY, PROCEDURE)
"""Sheets that need every part."""
Calculate = Callable[[ArtefactStore, Any], "ProcedureValues"]
"""Gives what the procedure of a design has to calculate, once its parts are in the store; it must pickle."""


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
    entry: Artefact

    @property
    def files(self) -> tuple[str, ...]:
        return tuple(f"{self.name}.{kind}" for kind in FORMATS)

    @property
    def model(self) -> str | None:
        """File of the part with the sheet's tolerances as data (STEP AP242); none for what is no single part."""
        name = f"{self.part}_ap242.step"
        return name if name in self.entry.hashes else None


_OF_ALL = (
    __name__,
    "drawings.export.dxf",
    "drawings.export.svg",
    "drawings.export.pdf",
    "drawings.export.lint",
)
_OF_ASSEMBLY = (*_OF_ALL, "drawings.artefacts.pictures", "drawings.sheets.assembly")
_OF_PROCEDURE = (*_OF_ASSEMBLY, "drawings.procedure.procedure", "drawings.procedure.sheet")


def _modules(part: str) -> tuple[str, ...]:
    return (*_OF_ALL, "drawings.sheets.part", "drawings.pmi.ap242", module_name(part))


def _depends(made: BuiltPart) -> tuple[str, ...]:
    return (made.entry.key, *_libraries())


_LIBRARIES = ("ezdxf", "matplotlib", "fonttools", "reportlab", "pypdfium2")


def _libraries() -> tuple[str, ...]:
    return tuple(f"{name} {number}" for name, number in versions(_LIBRARIES).items())


def find_sheets(
    store: ArtefactStore, part: str, design: Any, calculate: Calculate | None = None
) -> tuple[MadeSheet, ...] | None:
    """The sheets of a part, of the assembly, or of its procedure, from the cache, or None where they have to be made.

    Args:
        calculate: for the procedure.
    """
    if part in WHOLE:
        parts = {name: find_part(store, name, design) for name in part_names(design)}
        if None in parts.values():
            return None
        keys = [found.entry.key for found in parts.values() if found]
        modules, depends = _whole(keys, part, _values(store, part, design, calculate))
        entry = store.find(f"drawing of {part}", design, modules, depends)
        return _sheets(entry) if entry else None
    made = find_part(store, part, design)
    if made is None:
        return None
    entry = store.find(f"drawing of {part}", design, _modules(part), _depends(made))
    return _sheets(entry) if entry is not None else None


def _values(store: ArtefactStore, part: str, design: Any, calculate: Calculate | None) -> ProcedureValues | None:
    return calculate(store, design) if part == PROCEDURE and calculate is not None else None


def _whole(keys: Sequence[str], part: str, values: ProcedureValues | None) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Modules and results that a sheet of the whole machine is made from; the assembly's own files are not needed."""
    if part == ASSEMBLY:
        return _OF_ASSEMBLY, (*keys, *_libraries())
    return _OF_PROCEDURE, (*keys, *_libraries(), repr(values))


def _sheets(entry: Artefact) -> tuple[MadeSheet, ...]:
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


def draw_whole(
    store: ArtefactStore, part: str, design: Any, calculate: Calculate | None = None, *, exact: bool = True
) -> tuple[MadeSheet, ...]:
    """A sheet of the whole machine from the cache, drawn now when it lacks it.

    Args:
        part: `assembly` or `procedure`.
        calculate: for the procedure.
        exact: how lines are hidden (`drawings.views.projection.project`).
    """
    # A process that draws may start no others: what the cache still lacks is made here, one by one.
    parts = all_parts(store, design)
    values = _values(store, part, design, calculate)
    modules, depends = _whole([made.entry.key for made in parts.values()], part, values)

    def make(reading: Any, folder: Path) -> None:
        from drawings.sheets.assembly import assembly_sheet

        made = {name: make_picture(store, name, parts, design, exact=exact) for name in PICTURES[part]}
        pictures = {name: picture for name, picture in made.items() if picture is not None}
        assembled = _assembled(parts, reading)
        if part == ASSEMBLY:
            sheet = assembly_sheet(assembled, reading, pictures)
        else:
            sheet = _procedure_sheet(assembled, reading, values, tuple(pictures.values()))
        (folder / SHEETS).write_text(json.dumps([write_sheet(sheet, folder)], indent=1), "utf-8")

    return _sheets(store.make(f"drawing of {part}", design, modules, make, depends))


def all_parts(store: ArtefactStore, design: Any) -> dict[str, BuiltPart]:
    """Every part of the machine from the cache, made now where it lacks one."""
    return {name: build_part(store, name, design) for name in part_names(design)}


def _assembled(parts: dict[str, BuiltPart], design: Any) -> Assembled:
    """The machine as its sheets need it."""
    from drawings.sheets.assembly import Assembled
    from stagecad.solids.assembly.bill_of_materials import bill_of_materials

    instances = assemble(parts, design)
    masses = {name: part_mass(made, design) for name, made in parts.items()}
    reads = sorted({name for made in parts.values() for name in made.entry.reads})
    return Assembled(
        bill_of_materials(instances, parts, masses, design),
        extent_of(instances, parts, design),
        _shown_mass(combined(placed(masses[i.part], i.frame) for i in instances).mass),
        digest(design, reads),
        __version__,
    )


def extent_of(instances: Sequence[Instance], parts: dict[str, BuiltPart], design: Any) -> Extent:
    """The box of all parts at the middle of travel, each part's own box taken to where it stands; and the travel."""
    from drawings.sheets.assembly_dimensions import Extent

    corners = []
    for piece in instances:
        (x0, y0, z0), (x1, y1, z1) = parts[piece.part].geometry.bounding_box
        corners += [piece.frame.point((x, y, z)) for x in (x0, x1) for y in (y0, y1) for z in (z0, z1)]
    axes = tuple(zip(*corners, strict=True))
    low, high = ((pick(axes[0]), pick(axes[1]), pick(axes[2])) for pick in (min, max))
    return Extent(low, high, design.stage.travel)


def _procedure_sheet(
    assembled: Assembled, design: Any, values: ProcedureValues | None, pictures: Sequence[Picture]
) -> Sheet:
    from drawings.procedure.procedure import procedure
    from drawings.procedure.sheet import procedure_sheet
    from drawings.sheets.assembly import title_of

    if values is None:
        raise ValueError("the procedure needs its calculated values")
    steps = procedure(design, assembled.rows, values)
    title = title_of(assembled, design, PROCEDURE)
    return procedure_sheet(steps, title, pictures, assembled.rows)


def _shown_mass(kilograms: float) -> str:
    return f"{kilograms:.2f} kg" if kilograms >= 1.0 else f"{1000 * kilograms:.3g} g"


def draw_part(store: ArtefactStore, part: str, design: Any, *, exact: bool = True) -> tuple[MadeSheet, ...]:
    """The sheets of one part from the cache, drawn now when it lacks them.

    Args:
        exact: how lines are hidden (`drawings.views.projection.project`).
    """
    made = build_part(store, part, design)

    def make(reading: Any, folder: Path) -> None:
        from drawings.pmi.ap242 import write_ap242
        from drawings.sheets.part import sheets_of
        from stagecad.solids.modelling.verification import DimensionVerifier

        described = describe(made, reading)
        gauge = DimensionVerifier(described.solid)
        write_ap242(part, reading, described.solid, folder / f"{part}_ap242.step", gauge)
        documents = [write_sheet(sheet, folder) for sheet in sheets_of(described, reading, gauge, exact=exact)]
        (folder / SHEETS).write_text(json.dumps(documents, indent=1), "utf-8")

    return _sheets(store.make(f"drawing of {part}", design, _modules(part), make, _depends(made)))


def describe(made: BuiltPart, design: Any) -> Any:
    """A made part as its sheets need it."""
    from drawings.sheets.part import Described

    module: Any = part_definition(made.name)
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
    """Write the four files of a sheet; returns its description."""
    from drawings.export.drawing_model import drawing_model
    from drawings.export.dxf import dxf_bytes, dxf_document
    from drawings.export.lint import lint
    from drawings.export.pdf import pdf_bytes, png_bytes
    from drawings.export.svg import svg_bytes
    from drawings.sheets.sheet import scale_text

    drawing = drawing_model(sheet)
    document = dxf_document(drawing)
    pdf = pdf_bytes(drawing)
    contents = {
        "dxf": dxf_bytes(document),
        "svg": svg_bytes(drawing),
        "pdf": pdf,
        "png": png_bytes(pdf, sheet.paper),
    }
    for kind, data in contents.items():
        (folder / f"{sheet.name}.{kind}").write_bytes(data)
    return {
        "name": sheet.name,
        "part": sheet.part,
        "paper": sheet.paper,
        "scale": scale_text(sheet.scale),
        "views": [view.name for view in sheet.views],
        "hits": [str(hit) for hit in lint(document)],
    }
