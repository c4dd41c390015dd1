"""`drawings`: the drawing sheets of a design, written to files or kept in the cache."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from designcalc.checks.check import DesignInputs
from designcalc.checks.run import subjects_of
from drawings.artefacts import build_all_sheets
from drawings.artefacts import chosen_sheets as chosen_by_part
from drawings.artefacts import sheet_names as names_by_part
from drawings.sheets.overrides import FILE, read_overrides
from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.parameters.errors import InputError, nearest, require
from stagecad.solids.artefacts.outputs import write_manifest, write_stored
from stagecad.solids.artefacts.store import Artefact, ArtefactStore
from stagecad.solids.assembly.built_machine import body_masses
from workbench.operations.design import STAGE, Design, load_design
from workbench.operations.lines import Line, ProgressCallback, counted, plain_table, remark, silent
from workbench.operations.parts import with_repair
from workbench.operations.result import Result, finite, frame

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from drawings.artefacts import BuiltSheet
    from stagecad.parameters.design import Design as Values
    from stagecad.parameters.mass_properties import Masses

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
    known = [sheet for sheets in names_by_part(design.values).values() for sheet in sheets]
    return replace(design.values, sheets=read_overrides(path, known))


def reduced_sheet(store: ArtefactStore, values: Values, path: Path, content: str) -> Artefact:
    """The picture of a sheet as a small one, `SMALL`, for an overview, from the store or made now."""

    def make(tracked: Any, folder: Path) -> None:
        from PIL import Image

        with Image.open(path) as picture:
            height = round(picture.height * WIDTH / picture.width)
            small = picture.resize((WIDTH, height), Image.Resampling.BOX)
        small.quantize(16).save(folder / SMALL)

    return store.make("reduced sheet", values, (__name__,), make, (content,))


class Drawings(Result):
    """The drawing sheets of a design, written to files.

    Attributes:
        design: that is drawn.
        document: that of `stagecad drawings --json`.
    """

    def __init__(self, design: Design, document: dict[str, Any]) -> None:
        self.design, self.document = design, document

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
        from workbench.figures.design import sheet_figure

        name = next(iter(self.sheets)) if sheet is None else sheet
        if name not in self.sheets:
            raise InputError(f"no sheet '{name}'{nearest(name, self.sheets)}")
        return sheet_figure(Path(next(file for file in self.sheets[name] if file.endswith(".png"))))

    def lines(self) -> list[Line]:
        """Paper, scale and views of each sheet."""
        rows = [
            (name, sheet["paper"], sheet["scale"], ", ".join(sheet["views"]))
            for name, sheet in self.document["sheets"].items()
        ]
        return [plain_table("", "sheet|paper|scale|views", rows, "sheet|paper|views")]

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
    store, wanted = ArtefactStore(), chosen_by_part(tuple(names), values)

    def draw() -> tuple[list[BuiltSheet], list[str]]:
        advance = counted(progress, "", len(wanted))
        made = build_all_sheets(store, wanted, values, advance, calculate=procedure_values)
        sheets = [sheet for part, chosen in wanted.items() for sheet in made[part] if sheet.name in chosen]
        return sheets, write_sheets(sheets, folder)

    sheets, changed = with_repair(store, draw)
    hashes = {str(Path(one.folder, file)): one.artefact.hashes[file] for one in sheets for file in sheet_files(one)}
    write_manifest(folder / MANIFEST, hashes)
    for sheet in sheets:
        for hit in sheet.hits:
            if hit.startswith(FILE):
                remark(hit)
    documents = {str(PurePosixPath(sheet.folder, sheet.name)): sheet_document(sheet, folder) for sheet in sheets}
    for document in documents.values() if flat else ():
        document["files"] += write_flat(document["files"])
    parameters = _write_parameters(design, folder, sheets)
    return Drawings(design, {"sheets": documents, "changed": changed, "files": len(hashes), "parameters": parameters})


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
        "files": [str(out / sheet.folder / file) for file in sheet_files(sheet)],
        "hits": list(sheet.hits),
    }


def write_sheets(sheets: Sequence[BuiltSheet], out: Path) -> list[str]:
    """Write the files of sheets that differ, those of a part with a folder of its own there; their names."""
    changed: list[str] = []
    for folder in dict.fromkeys(sheet.folder for sheet in sheets):
        files = {file: sheet.artefact for sheet in sheets if sheet.folder == folder for file in sheet_files(sheet)}
        changed += [str(Path(folder, name)) for name in write_stored(out / folder, files)]
    return changed


def sheet_files(sheet: BuiltSheet) -> tuple[str, ...]:
    """The sheet in its formats, its part's model with tolerances, and the table of what defines its faces."""
    return (*sheet.files, *(file for file in (sheet.model, sheet.definition) if file))


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


def sheet_names(design: Design) -> dict[str, list[str]]:
    """Names of the sheets by part, for the assembly and the procedure too."""
    return {part: list(names) for part, names in names_by_part(design.values).items()}


def chosen_sheets(design: Design, names: Sequence[str]) -> dict[str, list[str]]:
    """Sheets by part, of names of parts or sheets."""
    return {part: list(sheets) for part, sheets in chosen_by_part(tuple(names), design.values).items()}


def sheets(design: Design, names: Sequence[str]) -> list[dict[str, Any]]:
    """Drawing sheets of parts or sheets by name, from the cache or drawn now: documents, keys for `cached_file`."""
    wanted = chosen_sheets(design, names)
    made = build_all_sheets(ArtefactStore(), wanted, design.values, calculate=procedure_values)

    def stated(sheet: BuiltSheet) -> dict[str, Any]:
        document = {"name": sheet.name, "key": sheet.artefact.key, "files": list(sheet.files), "part": sheet.part}
        document |= {"paper": sheet.paper, "scale": sheet.scale}
        return document | {"views": list(sheet.views), "hits": list(sheet.hits)}

    return [stated(sheet) for part, chosen in wanted.items() for sheet in made[part] if sheet.name in chosen]


def cached_file(key: str, name: str) -> Path:
    """A file of the cache of solids and drawings, by the key of its entry."""
    path = ArtefactStore().folder / "entries" / key / name
    if not re.fullmatch(r"[0-9a-f]{64}", key) or not re.fullmatch(r"[a-z0-9_]+\.[a-z]{3,4}", name):
        raise InputError(f"{key}/{name}: no file of the cache")
    require(path.is_file(), f"{name}: no such file in the cache; make the solids again")
    return path
