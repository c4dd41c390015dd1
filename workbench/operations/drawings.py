"""`drawings`: the drawing sheets of a design, written to files or kept in the cache.

Of solids without declarations, a STEP file or a CadQuery script, there is one sheet for each solid. The proposal is
written beside the sheet as `NAME_proposed.py`, which draws the same sheet again and is edited from there, with the
solid in the position in which it is drawn, `NAME_solid.step`."""

from __future__ import annotations

import json
import re
from collections.abc import Container, Iterator, Sequence
from dataclasses import replace
from itertools import chain, count
from pathlib import Path, PurePosixPath
from types import ModuleType
from typing import Any

from designcalc.checks.check import DesignInputs
from designcalc.checks.run import subjects_of
from drawings.draw_sheets import PICTURES, BuiltSheet, build_all_sheets, build_sheets

# The page asks the operations alone.
from drawings.draw_sheets import chosen_sheets as chosen_sheets
from drawings.draw_sheets import sheet_names as sheet_names
from drawings.sheets.overrides import FILE, read_overrides
from stagecad.consent import give_consent
from stagecad.declared.own_part import REQUIRED, own_definition, run_file
from stagecad.deferred import pd
from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.parameters.design import Design as Values
from stagecad.parameters.errors import InputError, require, require_known
from stagecad.parameters.load import part_design
from stagecad.parameters.machine import packaged_machine
from stagecad.parameters.mass_properties import Masses
from stagecad.solids.artefacts.part import build_part, part_mass
from stagecad.solids.artefacts.store import Artefact, ArtefactStore, write_manifest, write_stored
from stagecad.solids.assembly.built_machine import body_masses
from stagecad.solids.export.step import constant_text
from stagecad.solids.modelling.kernel import cq, load_kernel, occ
from stagecad.solids.modelling.part import part_names
from stagecad.solids.modelling.verification import DimensionVerifier
from workbench.figures import Figure
from workbench.figures import design as design_figures
from workbench.operations.design import STAGE, Design, load_design
from workbench.operations.parts import with_repair
from workbench.operations.result import (
    Line,
    Note,
    ProgressCallback,
    Result,
    counted,
    finite,
    frame,
    plain_table,
    remark,
    silent,
)

MANIFEST = "drawings_manifest.json"
VALUES = "procedure_values.json"
SMALL = "small.png"
WIDTH = 900
"""Width of the small picture of a sheet, pixels."""


def procedure_values(store: ArtefactStore, values: Values) -> dict[str, float | None]:
    """Values of the assembly procedure from the masses of the design's own solids, for `build_all_sheets`."""
    return stored_values(store, values, body_masses(values))


def stored_values(store: ArtefactStore, values: Values, masses: Masses) -> dict[str, float | None]:
    """The values from the store, or computed if they are not there; the field between the teeth takes a second."""
    calculated = subjects_of(values).procedure_values

    def calculate(tracked: Any, folder: Path) -> None:
        (folder / VALUES).write_text(json.dumps(calculated(DesignInputs(tracked, masses))), "utf-8")

    modules = (__name__, calculated.__module__)
    return store.make("procedure values", values, modules, calculate, (repr(masses),)).document(VALUES)


def with_sheet_overrides(design: Design) -> Values:
    """The design with the manual changes of its sheets, from `sheets.toml` beside its parameter file."""
    path = (design.path or STAGE).parent / FILE
    if not path.is_file():
        return design.values
    return replace(design.values, sheets=read_overrides(path, _sheets_of_parts(design.values)))


def _sheets_of_parts(*designs: Values) -> list[str]:
    """Names of the sheets that can be changed by hand."""
    named = [item for design in designs for item in sheet_names(design).items()]
    return [sheet for subject, sheets in named if subject not in PICTURES for sheet in sheets]


def reduced_sheet(store: ArtefactStore, values: Values, path: Path, content: str) -> Artefact:
    """The picture of a sheet as a small one, `SMALL`, for an overview, from the store or made now."""

    def make(tracked: Any, folder: Path) -> None:
        from PIL import Image

        with Image.open(path) as picture:
            small = picture.resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.Resampling.BOX)
        small.quantize(16).save(folder / SMALL)

    return store.make("reduced sheet", values, (__name__,), make, (content,))


class Drawings(Result):
    """The drawing sheets of a design, written to files.

    Attributes:
        design: that is drawn.
        document: that of `stagecad drawings --json`.
        folder: of the files.
    """

    def __init__(self, design: Design, document: dict[str, Any], folder: Path) -> None:
        self.design, self.document, self.folder = design, document, folder

    @property
    def sheets(self) -> dict[str, list[str]]:
        """Files of each sheet, by its name."""
        return {name: list(sheet["files"]) for name, sheet in self.document["sheets"].items()}

    @property
    def hits(self) -> list[tuple[str, str]]:
        """Hits of the lint, each with the name of its sheet."""
        return [(name, hit) for name, sheet in self.document["sheets"].items() for hit in sheet["hits"]]

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each sheet: part, paper, scale, views, hits of the lint."""
        rows = [
            {"sheet": name, **{key: sheet[key] for key in ("part", "paper", "scale", "views", "hits")}}
            for name, sheet in self.document["sheets"].items()
        ]
        return frame(rows, "sheet")

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad drawings --json`."""
        return finite(self.document)

    def plot(self, sheet: str | None = None) -> Figure:
        """A sheet as a picture; the first one when left out.

        Raises:
            InputError: no such sheet.
        """
        name = next(iter(self.sheets)) if sheet is None else sheet
        require_known(name, self.sheets, f"no sheet '{name}'")
        return design_figures.sheet_figure(Path(next(file for file in self.sheets[name] if file.endswith(".png"))))

    def lines(self) -> list[Line]:
        """Paper, scale and views of each sheet; the number of files written."""
        rows = [
            (name, sheet["paper"], sheet["scale"], ", ".join(sheet["views"]))
            for name, sheet in self.document["sheets"].items()
        ]
        written = f"{len(self.document['changed'])} of {self.document['files']} files written to {self.folder}"
        return [plain_table("", "sheet|paper|scale|views", rows, "sheet|paper|views"), written]

    def lint_lines(self) -> list[Line]:
        """The hits of the lint, and their number."""
        hits = [Note(f"{name}: {hit}") for name, hit in self.hits]
        return [*hits, f"lint: {len(hits)} hits on {len(self.sheets)} sheets"]

    def __repr__(self) -> str:
        return f"<Drawings of '{self.design.values.file}': {', '.join(self.sheets)}>"


def drawings(
    design: Design | None = None,
    names: Sequence[str] = (),
    out: str | Path = "build",
    progress: ProgressCallback = silent,
    flat: bool = False,
) -> Drawings:
    """Draw the sheets of a design and write each as DXF, SVG, PDF and PNG, with a list of its dimensions (CSV) and its
    part with tolerances (STEP AP242).

    Args:
        design: the packaged machine when left out.
        names: of parts, or of sheets (`base_2`); all of them when left out.
        out: folder of the files.
        progress: called with the name of a part, the parts drawn, and their number.
        flat: write each DXF flat too, all in model space on paper, for viewers without viewports.

    Raises:
        InputError: no such part or sheet.
    """
    design, folder = design or load_design(), Path(out)
    values = with_sheet_overrides(design)
    store, wanted = ArtefactStore(), chosen_sheets(names, values)

    def draw() -> tuple[list[BuiltSheet], list[str]]:
        made = build_all_sheets(store, wanted, values, counted(progress, "", len(wanted)), calculate=procedure_values)
        sheets = [sheet for part, chosen in wanted.items() for sheet in made[part] if sheet.name in chosen]
        return sheets, write_sheets(sheets, folder)

    sheets, changed = with_repair(store, draw)
    hashes = {str(Path(one.folder, file)): one.artefact.hashes[file] for one in sheets for file in one.written}
    write_manifest(folder / MANIFEST, hashes)
    for sheet in sheets:
        for hit in sheet.hits:
            if hit.startswith(FILE):
                remark(hit)
    for path in undimensioned(values, wanted):
        remark(f"{path}: declares no dimensions; 'stagecad drawings --part {path}' proposes them")
    documents = {str(PurePosixPath(sheet.folder, sheet.name)): sheet_document(sheet, folder) for sheet in sheets}
    for document in documents.values() if flat else ():
        document["files"] += write_flat(document["files"])
    parameters = _write_parameters(design, folder, sheets)
    document = {"sheets": documents, "changed": changed, "files": len(hashes), "parameters": parameters}
    return Drawings(design, document, folder)


def undimensioned(values: Values, names: Container[str]) -> list[Path]:
    """Files of the parts `names` of the user's own that are made, but have no function `dimensions`."""
    machine = values.machine.declaration
    made = [part for part in machine.parts if part.file and not part.purchased] if machine else []
    files = [machine.folder / part.file for part in made if part.key in names] if machine else []
    return [path for path in dict.fromkeys(files) if "dimensions" not in path.read_text("utf-8", "replace")]


def write_flat(files: Sequence[str]) -> list[str]:
    """Write the DXF files among some files flat, for viewers without viewports; their names."""
    from drawings.export.dxf import flat_file

    written = []
    for path in (Path(file) for file in files if file.endswith(".dxf")):
        target = path.with_name(f"{path.stem}_flat.dxf")
        atomic_write_bytes(target, flat_file(path))
        written.append(str(target))
    return written


def sheet_document(sheet: BuiltSheet, out: Path) -> dict[str, Any]:
    """A sheet with the paths of its files below a folder."""
    return {
        "part": sheet.subject,
        "paper": sheet.paper,
        "scale": sheet.scale,
        "views": list(sheet.views),
        "files": [str(out / sheet.folder / file) for file in sheet.written],
        "hits": list(sheet.hits),
    }


def write_sheets(sheets: Sequence[BuiltSheet], out: Path) -> list[str]:
    """Write the files of sheets that differ, those of a part with a folder of its own there; their names."""
    changed: list[str] = []
    for folder in dict.fromkeys(sheet.folder for sheet in sheets):
        files = {file: sheet.artefact for sheet in sheets if sheet.folder == folder for file in sheet.written}
        changed += [str(Path(folder, name)) for name in write_stored(out / folder, files)]
    return changed


def _write_parameters(design: Design, folder: Path, sheets: Sequence[BuiltSheet]) -> list[str]:
    """Write the parameters below the sheets, under the names that their title blocks give: `holder_c7088e19.toml`."""
    text = design.to_toml()
    paths = dict.fromkeys(
        folder / sheet.folder / "parameters" / f"{sheet.part}_{sheet.digest}.toml" for sheet in sheets
    )
    for path in paths:
        if not path.is_file() or path.read_text("utf-8") != text:
            atomic_write_text(path, text)
    return [str(path) for path in paths]


def sheets(design: Design, names: Sequence[str]) -> list[dict[str, Any]]:
    """Drawing sheets of parts or sheets by name, from the cache or drawn now: documents, keys for `cached_file`."""
    wanted = chosen_sheets(names, design.values)
    made = build_all_sheets(ArtefactStore(), wanted, design.values, calculate=procedure_values)
    keys = ("files", "part", "paper", "scale", "views", "hits")
    shown = (sheet for part, chosen in wanted.items() for sheet in made[part] if sheet.name in chosen)
    return finite([{"name": one.name, "key": one.artefact.key, **{k: getattr(one, k) for k in keys}} for one in shown])


def cached_file(key: str, name: str) -> Path:
    """A file of the cache of solids and drawings, by the key of its entry."""
    path = ArtefactStore().folder / "entries" / key / name
    if not re.fullmatch(r"[0-9a-f]{64}", key) or not re.fullmatch(r"[a-z0-9_]+\.[a-z]{3,4}", name):
        raise InputError(f"{key}/{name}: no file of the cache")
    require(path.is_file(), f"{name}: no such file in the cache; make the solids again")
    return path


def draw_part(path: Path, out: Path, design: Design, trust: bool = False) -> dict[str, Any]:
    """Write sheet, definition, STEP AP242 and mass properties of a part from its Python file (`sheets.toml` beside it
    changes the sheet); their document. `design` gives materials and title block; without the consent of `trust`, or an
    earlier one, the file is refused."""
    if trust:
        give_consent((path,))
    values, store = part_design(design.file, design.overrides, path), ArtefactStore()
    (name,) = part_names(values)
    changes = path.parent / FILE
    if changes.is_file():
        values = replace(values, sheets=read_overrides(changes, _sheets_of_parts(design.values, values)))
    sheets = build_sheets(store, name, values, contents="solid")
    mass = part_mass(build_part(store, name, values, "solid"), values).as_json()
    write_sheets(sheets, out)
    properties = out / f"{name}_mass.json"
    atomic_write_text(properties, json.dumps(mass, indent=1) + "\n")
    documents = [{"name": sheet.name, **sheet_document(sheet, out), "digest": sheet.digest} for sheet in sheets]
    files = [file for document in documents for file in document["files"]]
    return {"part": name, "sheets": documents, "files": [*files, str(properties)], **mass}


STEP = (".step", ".stp")
MOST_SOLIDS = 200
"""Most solids of one file that are drawn, one sheet each."""
UNNAMED = re.compile("[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")
"""Names of parts of an assembly that cadquery makes where none is given."""


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
        parts = _step_parts(path)
        require(parts, f"{path}: has no solid")
        shown = [(_word(path.stem), parts if parts[1:] else [("", parts[0][1])])]
    else:
        load_kernel()  # before the file imports all of it
        module: Any = run_file(path, trust, "this part")
        if hasattr(module, "build") or hasattr(module, "dimensions") or hasattr(module, "NAME"):
            part, values = own_definition(path), part_design(design.file, design.overrides, path)
            if part.dimensions(values):
                return [draw_part(path, folder, design)]
            return [propose_sheet(part.NAME, part.build(values), path.name, design, folder)]
        shown = _shown_parts(module, path)
        require(
            any(parts for _, parts in shown),
            f"{path}: shows no solid; write show_object(result), or the words of a part: {', '.join(REQUIRED)}",
        )
    return [
        propose_sheet(name, solid, path.name, design, folder, quantity) for name, solid, quantity in _named(shown, path)
    ]


def _step_parts(path: Path) -> list[tuple[str, Any]]:
    """Solids of a STEP file, each with the name of its product."""
    require(path.is_file(), f"{path}: cannot be read: No such file or directory")
    load_kernel()
    document, reader = occ.TDocStd_Document(occ.TCollection_ExtendedString("XCAF")), occ.STEPCAFControl_Reader()
    try:
        read = reader.ReadFile(str(path)) == occ.IFSelect_RetDone and reader.Transfer(document)
    except Exception as error:
        raise InputError(f"{path}: is no STEP file that can be read: {error}") from None
    require(read, f"{path}: is no STEP file that can be read")
    products = occ.TDF_LabelSequence()
    occ.XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(products)
    return [part for product in products for part in _product_parts(product)]


def _product_parts(product: Any) -> list[tuple[str, Any]]:
    """Solids of a product of a STEP file, with the name of the outermost product that has a single solid."""
    tool, shape = occ.XCAFDoc_ShapeTool, cq.Shape.cast(occ.XCAFDoc_ShapeTool.GetShape_s(product))
    solids, components, name = shape.Solids(), occ.TDF_LabelSequence(), occ.TDataStd_Name()
    if len(solids) > 1 and tool.GetComponents_s(product, components) and components.Length():
        products = [occ.TDF_Label() for _ in components]
        for component, referred in zip(components, products, strict=True):
            tool.GetReferredShape_s(component, referred)
        return [part for referred in products for part in _product_parts(referred)]
    text = name.Get().ToExtString() if product.FindAttribute(occ.TDataStd_Name.GetID_s(), name) else ""
    # Words of the kernel for a product that nobody named.
    words = occ.Interface_Static.CVal_s("write.step.product.name").rpartition(" ")[0], shape.ShapeType().upper()
    return [("" if text.startswith(words) or UNNAMED.match(text) else text, solid) for solid in solids]


def _shown_parts(module: ModuleType, path: Path) -> list[tuple[str, list[tuple[str, Any]]]]:
    """Solids that a script shows with the names of their parts, by the name of what is shown, else those of its last
    workplane, shape or assembly."""
    marked: list[tuple[Any, Any, dict[str, Any]]] = getattr(module, "SHOWN", [])
    shown = [
        (str(options.get("name") or (path.stem if number == 0 else f"{path.stem}_{number + 1}")), _parts(value))
        for number, (value, _, options) in enumerate(marked)
    ]
    if not any(parts for _, parts in shown):
        values = [parts for key, value in vars(module).items() if key[0] != "_" and (parts := _parts(value))]
        return [(path.stem, values[-1] if values else [])]
    return shown


def _parts(value: Any) -> list[tuple[str, Any]]:
    """Solids of a workplane or a shape; of an assembly with the names of its parts that were given."""
    if hasattr(value, "traverse"):
        rows = [("" if UNNAMED.fullmatch(name) else name, one.obj) for name, one in value.traverse()]
        return [(name, solid) for name, shape in rows for _, solid in _parts(shape)]
    if hasattr(value, "vals") and hasattr(value, "solids"):
        return [part for one in value.vals() for part in _parts(one)]
    return [("", one) for one in value.Solids()] if hasattr(value, "Solids") and hasattr(value, "ShapeType") else []


def _named(shown: list[tuple[str, list[tuple[str, Any]]]], path: Path) -> list[tuple[str, Any, int]]:
    """Solids under different names and how many there are of each: of equal ones, placed several times, the first."""
    rows = [
        (_word(own or (f"{name}_{number}" if parts[1:] else name)), solid)
        for name, parts in shown
        for number, (own, solid) in enumerate(parts, start=1)
    ]
    require(len(rows) <= MOST_SOLIDS, f"{path}: has {len(rows)} solids; at most {MOST_SOLIDS} are drawn")
    alike = [[solid.wrapped.IsPartner(other.wrapped) for _, other in rows] for _, solid in rows]
    found: dict[str, tuple[Any, int]] = {}
    for number, (name, solid) in enumerate(rows):
        if alike[number].index(True) == number:
            free = (f"{name}_{again}" for again in count(2))
            found[next(one for one in chain((name,), free) if one not in found)] = (solid, sum(alike[number]))
    return [(name, *row) for name, row in found.items()]


def _word(text: str) -> str:
    word = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
    return word if word[:1].isalpha() else f"part_{word}".rstrip("_")


NAMED = re.compile("(?:the dimension )?'([^']+)'")
"""The beginning of a hit of the lint that names a dimension."""


def propose_sheet(
    name: str, solid: Any, source: str, design: Design, folder: Path, quantity: int = 1
) -> dict[str, Any]:
    """Propose dimensions of a valid solid of the file `source`, which has `quantity` of it, write them as Python, and
    draw them; the document of the sheet."""
    from drawings.recognition.part_file import in_position, part_text
    from drawings.recognition.proposal import propose

    if not solid.isValid() or solid.Volume() <= 0:
        raise InputError(f"{source}: the solid {name} is not valid and closed")
    name = f"{name}_part" if name in packaged_machine().table_names else name
    folder.mkdir(parents=True, exist_ok=True)
    file, model = folder / f"{name}_proposed.py", folder / f"{name}_solid.step"
    in_position(solid).exportStep(str(model))
    # The same file each time, so that a second drawing of the part is taken from the store.
    atomic_write_text(model, constant_text(model.read_text("utf-8"), name))
    # The proposal is for the solid as it is read again.
    solid = cq.importers.importStep(str(model)).solids().val()
    verifier = DimensionVerifier(solid)
    proposal = propose(verifier)

    def draw() -> dict[str, Any]:
        atomic_write_text(file, part_text(name, source, proposal, quantity))
        return draw_part(file, folder, design, trust=True)

    document = draw()
    hits = (NAMED.match(hit) for sheet in document["sheets"] for hit in sheet["hits"])
    if hidden := {hit[1] for hit in hits if hit} & {one.name for one in proposal.dimensions}:
        # The sheet does not show them: the model gives their faces.
        proposal = propose(verifier, hidden)
        document = draw()
    return {
        **document,
        "files": [*document["files"], str(file), str(model)],
        "proposed": True,
        "questions": list(proposal.questions),
    }
