"""Sheets as build artefacts: their files and the result of lint, from the artefact store or drawn now.

The artefact of a part holds ``SHEET.dxf``, ``.svg``, ``.pdf``, ``.png`` of each of its sheets, ``PART_ap242.step`` and
``sheets.json``. Reading it needs neither the CAD kernel nor the libraries that write the files. A picture of the
whole machine is drawn once for all sheets that show it; it depends on the solids that it shows and on their positions.
"""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drawings.dimensions.levels import AXES
from drawings.sheets.plans import chosen_plan, sheets_of
from stagecad.parameters.errors import InputError, LostProcessError, PartError, nearest
from stagecad.parameters.mass_properties import combined
from stagecad.processes import TimeLimit, parallel_map
from stagecad.solids.artefacts.key import versions
from stagecad.solids.artefacts.part import CRASHED, BuiltPart, Contents, build_part, find_part, part_mass
from stagecad.solids.artefacts.store import Artefact, ArtefactStore
from stagecad.solids.assembly.bill_of_materials import bill_of_materials
from stagecad.solids.assembly.built_machine import assemble, shapes_of
from stagecad.solids.modelling.kernel import load_kernel
from stagecad.solids.modelling.mass import placed
from stagecad.solids.modelling.part import (
    ASSEMBLY,
    Instance,
    PartSource,
    construction,
    notes_of,
    part_names,
    part_source,
    treatment_of,
)
from stagecad.solids.modelling.verification import DimensionVerifier

if TYPE_CHECKING:
    from drawings.dimensions.definition import Notes
    from drawings.pictures.picture import Picture
    from drawings.sheets.assembly import AssemblyDescription, Size
    from drawings.sheets.part import PartDescription
    from drawings.sheets.sheet import Sheet

FROM_BELOW = "from below"
"""Shows the moving parts alone."""


def stored_picture(
    store: ArtefactStore,
    name: str,
    instances: Sequence[Instance],
    parts: Mapping[str, BuiltPart],
    design: Any,
    *,
    exact: bool = True,
) -> Picture | None:
    """One picture of the machine from the store, or drawn now; None as of `machine_picture`."""
    views = sheets_of(design).views(design, instances, parts)
    moving = views.moving if name == FROM_BELOW else tuple(parts)
    shown = [instance for instance in instances if instance.part in moving]

    def draw(tracked: Any) -> Picture | None:
        from drawings.pictures.machine import machine_picture
        from drawings.pictures.picture import scene_of

        shapes = {shape: solid.wrapped for shape, solid in shapes_of(shown, parts, tracked).items()}
        scene = scene_of(shapes, {part.name: part.mesh for part in parts.values() if part.name in shapes})
        return machine_picture(name, shown, scene, views, exact=exact)

    kinds = dict.fromkeys(instance.part for instance in shown)
    depends = [repr(tuple(shown)), repr(views), *(f"{kind} {parts[kind].entry.content}" for kind in kinds)]
    return store.computed(f"{name} of the machine", design, ("drawings.pictures.machine",), draw, depends)


FORMATS = ("dxf", "svg", "pdf", "png")
SHEETS = "sheets.json"
PROCEDURE = "procedure"
"""The sheet of the assembly procedure."""
PICTURES = {
    ASSEMBLY: ("top", "section A-A", "section B-B", "exploded", "from below"),
    PROCEDURE: ("exploded", "from below"),
}
"""Sheets of the whole machine, which need every part, and the pictures on them (`drawings.pictures.machine`)."""
CalculateValues = Callable[[ArtefactStore, Any], Any]
"""Calculates what the procedure of a design needs from its parts in the store; pickled for other processes."""

_LIBRARIES = ("ezdxf", "matplotlib", "fonttools", "reportlab", "pypdfium2")
_MODULES = {
    ASSEMBLY: ("drawings.sheets.assembly", "drawings.pictures.machine"),
    PROCEDURE: ("drawings.sheets.assembly", "drawings.pictures.machine", "drawings.sheets.procedure"),
}


@dataclass(frozen=True)
class BuiltSheet:
    """A sheet in the artefact store."""

    name: str  # of its files
    part: str  # kind of part that it shows, or `assembly`, `procedure`
    # paper, scale: as printed
    paper: str
    scale: str
    views: tuple[str, ...]  # names
    digest: str  # hash of the parameters, as in the title block
    hits: tuple[str, ...]  # violations found by lint, a line each
    artefact: Artefact  # that holds its files
    subject: str  # name of the part in the machine

    @property
    def folder(self) -> str:
        """Folder of its files: one of its own for a part that has not the name of its kind, else none."""
        return "" if self.subject == self.part else self.subject

    @property
    def files(self) -> tuple[str, ...]:
        return tuple(f"{self.name}.{kind}" for kind in FORMATS)

    @property
    def written(self) -> tuple[str, ...]:
        """Files that a user receives: the sheet in its formats, and those of its part: the model with the tolerances as
        data (STEP AP242), and the table of what defines its faces."""
        own = (f"{self.part}_ap242.step", f"{self.part}_definition.csv")
        return (*self.files, *(name for name in own if name in self.artefact.hashes))


def find_sheets(
    store: ArtefactStore, subject: str, design: Any, calculate: CalculateValues | None = None
) -> tuple[BuiltSheet, ...] | None:
    """The sheets of a subject from the store, or None where they have to be drawn."""
    parts: dict[str, BuiltPart] = {}
    for name in _required_parts(subject, design):
        found = find_part(store, name, design)
        if found is None:
            return None
        parts[name] = found
    artefact = store.find(*_stored_as(subject, parts, design, _values(store, subject, design, calculate)))
    return _sheets(artefact, subject) if artefact else None


def build_sheets(
    store: ArtefactStore,
    subject: str,
    design: Any,
    calculate: CalculateValues | None = None,
    *,
    exact: bool = True,
    contents: Contents = "files",
) -> tuple[BuiltSheet, ...]:
    """The sheets of a subject from the store, drawn now where it lacks them; `contents` that its parts get then."""
    parts = {name: build_part(store, name, design, contents) for name in _required_parts(subject, design)}
    values = _values(store, subject, design, calculate)
    name, read, modules, depends = _stored_as(subject, parts, design, values)

    def make(tracked: Any, folder: Path) -> None:
        problems: list[str] = []
        if subject in PICTURES:
            sheets: Sequence[Sheet] = [_machine_sheet(store, subject, parts, tracked, values, exact)]
        else:
            source = part_source(subject, design)
            sheets, problems = _part_sheets(parts[subject], source, tracked, read, folder, exact=exact)
        documents = [write_sheet(sheet, folder) for sheet in sheets]
        documents[0]["hits"] += problems
        (folder / SHEETS).write_text(json.dumps(documents, indent=1), "utf-8")

    return _sheets(store.make(name, read, modules, make, depends), subject)


def _required_parts(subject: str, design: Any) -> Sequence[str]:
    return part_names(design) if subject in PICTURES else (subject,)


def _values(store: ArtefactStore, subject: str, design: Any, calculate: CalculateValues | None) -> Any:
    return calculate(store, design) if subject == PROCEDURE and calculate is not None else None


def _stored_as(
    subject: str, parts: Mapping[str, BuiltPart], design: Any, values: Any
) -> tuple[str, Any, tuple[str, ...], tuple[str, ...]]:
    """Name of the artefact of a subject's sheets, the design as the subject reads it, the modules that make them, and
    what they depend on: keys of artefacts, versions of libraries, calculated values."""
    libraries = (f"{name} {number}" for name, number in versions(_LIBRARIES).items())
    calculated = () if values is None else (repr(values),)
    if subject in PICTURES:
        source: Any = construction(design)
        read = design
        own = source.depends(design)
        modules = _MODULES[subject]
    else:
        source = part_source(subject, design)
        read = source.design_of(design)
        own = source.depends
        modules = ("drawings.sheets.part", "drawings.pmi.ap242")
    depends = (*(part.entry.key for part in parts.values()), *libraries, *calculated, *own)
    return f"drawing of {subject}", read, (__name__, *modules, *source.modules, *sheets_of(design).modules), depends


def _sheets(artefact: Artefact, subject: str) -> tuple[BuiltSheet, ...]:
    return tuple(
        BuiltSheet(
            **{**document, "views": tuple(document["views"]), "hits": tuple(document["hits"])},
            artefact=artefact,
            subject=subject,
        )
        for document in artefact.document(SHEETS)
    )


def _part_sheets(
    part: BuiltPart, source: PartSource, design: Any, plain: Any, folder: Path, *, exact: bool
) -> tuple[Sequence[Sheet], list[str]]:
    """The sheets of a part, and what is not defined; its STEP AP242 file and the table are written into the folder."""
    from drawings.dimensions.consistency import mistakes, unsuited
    from drawings.pmi.ap242 import ap242_bytes
    from drawings.sheets.part import part_sheets

    module: Any = source.definition()
    verifier = DimensionVerifier(part.solid)
    described, notes = describe(part, source, design, plain, verifier)
    texts = (getattr(module, "TREATMENT", ""), *module.notes(design)) if described.chosen else ()
    for mistake in (
        *mistakes(described.dimensions, described.requirements, verifier, alike=described.chosen),
        *unsuited(design.materials[part.material], described.dimensions, texts),
    ):
        raise InputError(f"{getattr(module, 'path', source.kind)}: {mistake}")
    kind = source.kind
    (folder / f"{kind}_ap242.step").write_bytes(ap242_bytes(kind, module, design, described.solid, verifier))
    sheets = part_sheets(described, design, verifier, exact=exact)
    from drawings.dimensions.definition import HEADINGS, definition

    views = [view for sheet in sheets for view in sheet.views if view.projection.name != "iso"]
    roughness = 1e6 * design.drawing.roughness
    found = definition(verifier, described.dimensions, described.requirements, notes, views, roughness)
    with (folder / f"{described.name}_definition.csv").open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([HEADINGS, *(face.row for face in found.faces)])
    return sheets, list(found.problems)


def describe(
    part: BuiltPart, source: PartSource, design: Any, plain: Any, verifier: DimensionVerifier
) -> tuple[PartDescription, Notes]:
    """A part as its sheets need it, and what its notes define.

    A part without a plan gets one by its declarations; what it does not state is symmetric only if the solid is.
    """
    from drawings.dimensions.definition import centred_axes, notes_on_shape
    from drawings.sheets.part import PartDescription

    module: Any = source.definition()
    sheets, material, name = sheets_of(plain), design.materials[part.material], source.kind
    dimensions = module.dimensions(design)
    requirements = module.requirements(design) if hasattr(module, "requirements") else ()
    shape, lines = notes_on_shape(module, design), notes_of(module, design)
    plans, stated = sheets.plans(name, design), getattr(module, "VIEWS", ())
    if not plans:
        symmetric = "".join(axis for axis in AXES if axis in shape.symmetric + centred_axes(verifier))
        shape = replace(shape, symmetric=symmetric, packaged=False)
        if symmetric:
            lines = (*lines, "Symmetric about the centre lines unless dimensioned.")
    described = PartDescription(
        name=name,
        title=sheets.titles.get(name, name.replace("_", " ")),
        plans=plans or (chosen_plan(name, dimensions, requirements, verifier, stated, shape.symmetric),),
        solid=part.solid,
        dimensions=dimensions,
        requirements=requirements,
        notes=lines,
        material=material.description,
        mass=_mass_text(part_mass(part, design).mass),
        digest=digest(design, part.entry.reads),
        reads=parameters_of(part.entry.reads, plain),
        treatment=treatment_of(module, design, part.material),
        brittle=material.strength_kind == "fracture",
        mesh=part.mesh,
        chosen=not plans,
        proposed=bool(getattr(module, "PROPOSED", False)),
    )
    return described, shape


def parameters_of(reads: Iterable[str], design: Any) -> tuple[str, ...]:
    """Those of the names read that are keys of the parameter file, without materials."""
    return tuple(sorted(name for name in reads if design.has(name) and not name.startswith("materials.")))


def _machine_sheet(
    store: ArtefactStore, subject: str, parts: dict[str, BuiltPart], design: Any, values: Any, exact: bool
) -> Sheet:
    """The sheet of the assembly or of its procedure, with its pictures that show something."""
    from drawings.sheets.assembly import assembly_sheet, title_of
    from drawings.sheets.procedure import procedure_sheet

    instances = assemble(parts, design)
    machine = _assembled(instances, parts, design)
    drawn = {name: stored_picture(store, name, instances, parts, design, exact=exact) for name in PICTURES[subject]}
    pictures = {name: picture for name, picture in drawn.items() if picture is not None}
    if subject == ASSEMBLY:
        return assembly_sheet(machine, design, pictures)
    steps = sheets_of(design).procedure(design, machine.rows, values)
    return procedure_sheet(steps, title_of(machine, design, PROCEDURE), tuple(pictures.values()), machine.rows)


def _assembled(instances: Sequence[Instance], parts: dict[str, BuiltPart], design: Any) -> AssemblyDescription:
    """The machine as its sheets need it."""
    from drawings.sheets.assembly import AssemblyDescription

    masses = {name: part_mass(part, design) for name, part in parts.items()}
    views = sheets_of(design).views(design, instances, parts)
    reads = sorted({name for part in parts.values() for name in part.entry.reads})
    return AssemblyDescription(
        bill_of_materials(instances, parts, masses, design),
        machine_size(instances, parts, design),
        _mass_text(combined(placed(masses[i.part], i.frame) for i in instances).mass),
        digest(design, reads),
        parameters_of(reads, design),
        construction(design).accessories(design),
        construction(design).carried,
        views.scale,
        views.notes,
    )


def machine_size(instances: Sequence[Instance], parts: Mapping[str, BuiltPart], design: Any) -> Size:
    """Bounding box of all parts at the middle of travel, from the corners of each part's own box; and the travel."""
    corners = []
    for instance in instances:
        (x0, y0, z0), (x1, y1, z1) = parts[instance.part].geometry.bounding_box
        corners += [instance.frame.point((x, y, z)) for x in (x0, x1) for y in (y0, y1) for z in (z0, z1)]
    axes = tuple(zip(*corners, strict=True))
    low, high = ((pick(axes[0]), pick(axes[1]), pick(axes[2])) for pick in (min, max))
    return low, high, sheets_of(design).travel(design)


def _mass_text(kilograms: float) -> str:
    return f"{kilograms:.2f} kg" if kilograms >= 1.0 else f"{1000 * kilograms:.3g} g"


def digest(design: Any, reads: Sequence[str]) -> str:
    """Short hash of the names and values of the parameters that a part was made from."""
    values: list[tuple[str, str]] = []
    for name in reads:
        value = design
        for step in name.split("."):
            value = getattr(value, step, None)
        if value is not None:
            values.append((name, repr(value)))
    return hashlib.sha256(json.dumps(values).encode()).hexdigest()[:8]


def write_sheet(sheet: Sheet, folder: Path) -> dict[str, Any]:
    """Write the four files of a sheet; returns the fields of its `BuiltSheet`."""
    from drawings.export.drawing_model import drawing_model
    from drawings.export.dxf import dxf_bytes, dxf_document
    from drawings.export.pdf import pdf_bytes, png_bytes, svg_bytes
    from drawings.lint import lint
    from drawings.sheets.sheet import scale_text

    drawing = drawing_model(sheet)
    document, pdf = dxf_document(drawing), pdf_bytes(drawing)
    contents = (dxf_bytes(document), svg_bytes(drawing), pdf, png_bytes(pdf, sheet.paper))
    for kind, data in zip(FORMATS, contents, strict=True):
        (folder / f"{sheet.name}.{kind}").write_bytes(data)
    return {
        "name": sheet.name,
        "part": sheet.part,
        "paper": sheet.paper,
        "scale": scale_text(sheet.scale),
        "views": [view.name for view in sheet.views],
        "digest": sheet.title.parameters,
        "hits": [*sheet.unapplied, *(str(hit) for hit in lint(sheet))],
    }


BUILD = "build "
"""Begins the name of a task that builds a part; the other tasks draw the sheets of their name."""

TIME_LIMIT = 120.0
"""Processor time after which a task is repeated without exact hidden-line removal, which can hang, s; the longest takes
some ten."""

SLOWEST_FIRST = ("base", "spring", ASSEMBLY, PROCEDURE, "stage", "holder", "tip", "tooth_bar", "bearing_way")
"""Order in which parts are built and sheets drawn, so that no long task is left for the end."""


def build_all_sheets(
    store: ArtefactStore,
    subjects: Iterable[str],
    design: Any,
    advance: Callable[[str], None] = lambda name: None,
    calculate: CalculateValues | None = None,
) -> dict[str, tuple[BuiltSheet, ...]]:
    """The sheets of parts and of the machine; those that the store lacks are drawn in several processes."""
    wanted = tuple(subjects)
    found: dict[str, tuple[BuiltSheet, ...]] = {}
    for subject in wanted:
        sheets = find_sheets(store, subject, design, calculate)
        if sheets is not None:
            found[subject] = sheets
            advance(subject)
    missing = slowest_first(subject for subject in wanted if subject not in found)
    if missing:
        before: tuple[str, ...] = ()
        if any(subject in PICTURES for subject in missing):
            parts = slowest_first(name for name in part_names(design) if find_part(store, name, design) is None)
            before = tuple(f"{BUILD}{name}" for name in parts)

        def report(task: str) -> None:
            if task in missing:
                advance(task)

        requires = {
            subject: [task for task in before if subject in PICTURES or task == f"{BUILD}{subject}"]
            for subject in missing
        }
        tasks = (*before, *missing)
        run = partial(_run, store.folder, design, calculate)
        limit = TimeLimit(TIME_LIMIT, fallback=partial(run, exact=False))
        try:
            built = parallel_map(run, tasks, progress=report, limit=limit, requires=requires)
        except LostProcessError as error:
            if str(error.item).startswith(BUILD):
                raise PartError(str(error.item).removeprefix(BUILD), design, CRASHED) from None
            raise
        found |= dict(zip(missing, built[len(before) :]))
    return {subject: found[subject] for subject in wanted}


def slowest_first(names: Iterable[str]) -> Sequence[str]:
    return sorted(names, key=lambda name: SLOWEST_FIRST.index(name) if name in SLOWEST_FIRST else len(SLOWEST_FIRST))


def _run(
    folder: Path, design: Any, calculate: CalculateValues | None, task: str, exact: bool = True
) -> tuple[BuiltSheet, ...]:
    """Run a task in a worker process, with or without exact hidden-line removal."""
    load_kernel()
    store = ArtefactStore(folder)
    if task.startswith(BUILD):
        build_part(store, task.removeprefix(BUILD), design)
        return ()
    return build_sheets(store, task, design, calculate, exact=exact)


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
