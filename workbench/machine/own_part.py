"""A part of the user's own, from a Python file: its solid, its sheet, and its STEP AP242 file.

The file follows the interface of a part (`stagecad.solids.modelling.part`). Its parameters are declared in the file
itself, as in a parameter file: ``PARAMETERS = {"length": "60 mm", "hole": "6.6 mm"}``; tolerance classes follow from
the decimals. It may read those of the machine too. The file is Python code: it runs after `--trust`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError
from stagecad.parameters.file import Entry, FileEntry, read_entry
from stagecad.parameters.schema import Declaration

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

REQUIRED = ("NAME", "PARAMETERS", "build", "material", "dimensions")
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_FIT = re.compile(r"(\d+(?:\.\d+)?)(?: mm)? ([A-Za-z]{1,2}\d{1,2})")


@dataclass(frozen=True)
class OwnPart:
    """A part from a file, and the design with its parameters."""

    path: Path
    module: Any
    design: Design

    @property
    def name(self) -> str:
        """Name of the part, of its files, and of the table with its parameters."""
        return self.module.NAME


def load_part(path: Path, design: Design, trust: bool) -> OwnPart:
    """Run a part's file and read its parameters.

    Args:
        path: of the file.
        design: of the machine.
        trust: whether the user consents to run the file as it is now.

    Raises:
        InputError: no consent, an error of the file, or something missing in it.
    """
    return stated_part(run_file(path, trust, "this part"), path, design)


def stated_part(module: Any, path: Path, design: Design) -> OwnPart:
    """The part that a module states.

    Raises:
        InputError: something is missing in it.
    """
    for word in REQUIRED:
        if not hasattr(module, word):
            raise InputError(f"{path}: has no {word}; `stagecad new part NAME` writes a file that has all")
    name = module.NAME
    if not isinstance(name, str) or not _NAME.fullmatch(name) or hasattr(design, name):
        raise InputError(
            f"{path}: NAME = {name!r}; write small letters, digits and _, and no name of the machine's own"
        )
    return OwnPart(path, module, own_design(design, name, module.PARAMETERS, path))


def run_file(path: Path, trust: bool, what: str) -> ModuleType:
    """Run a Python file of the user's, with consent, and return it as a module.

    Raises:
        InputError: the file cannot be read, no consent, or an error in it.
    """
    from sysid.experiment.consent import give_consent, require_consent

    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if trust:
        give_consent((path,))
    try:
        require_consent(path, data)
    except InputError as error:
        raise InputError(str(error).replace("this experiment", what)) from None
    module = ModuleType(path.stem)
    module.__file__ = str(path)
    module.SHOWN = []  # type: ignore[attr-defined]
    # A script of cadquery's editor shows its result by a function of the editor.
    module.show_object = lambda shown, *more, **options: module.SHOWN.append((shown, more, options))  # type: ignore[attr-defined]
    module.debug = lambda *shown, **options: None  # type: ignore[attr-defined]
    try:
        exec(compile(data, str(path), "exec"), vars(module))
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{path}: {_where(error, path)}{type(error).__name__}: {error}") from None
    return module


def _where(error: Exception, path: Path) -> str:
    """Line of the file in which an error occurred."""
    if isinstance(error, SyntaxError):
        return f"line {error.lineno}: "
    trace, line = error.__traceback__, None
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == str(path):
            line = trace.tb_lineno
        trace = trace.tb_next
    return f"line {line}: " if line else ""


def _entry(key: str, given: Any, place: str, before: Sequence[Entry]) -> Entry:
    """One parameter of a part: a length, with a fit (`25 k6`) or as a table with a tolerance class, an angle, a count,
    or a formula of the ones before it, in millimetres (`= 2 * width + 5`)."""
    table = dict(given) if isinstance(given, Mapping) else {"value": given}
    value, tolerance = table.pop("value", None), table.pop("tolerance", None)
    if table or value is None or isinstance(value, bool):
        raise InputError(f"{place}: write a length like '40.0 mm', or a table with value and tolerance")
    if isinstance(value, int):
        return read_entry(key, FileEntry(value, place), Declaration("count", f"of {key}", low=0.0), ())
    if not isinstance(value, str):
        raise InputError(f"{place}: write the value with its unit, like '{value} mm'")
    if value.startswith("="):
        value, tolerance = f"{_evaluated(value, key.partition('.')[0], place, before)} mm", tolerance or "X.X"
    fit = _FIT.fullmatch(value)
    if fit:
        value, tolerance = f"{fit[1]} mm", fit[2]
    unit = "deg" if value.strip().endswith(("deg", "rad")) else "mm"
    declaration = Declaration("number", f"of {key}", unit, low=0.0, closed=False)
    return read_entry(key, FileEntry(value, place, tolerance), declaration, ())


def _evaluated(formula: str, table: str, place: str, before: Sequence[Entry]) -> float:
    """Value of a formula of the parameters before it, mm."""
    from stagecad.parameters.formula import Value, parse_formula
    from stagecad.parameters.units import to_si, unit_dimension

    known = {entry.key.partition(".")[2]: entry for entry in before}
    named = re.sub(r"(?<![\w.])([a-z]\w*)(?![\w.(])", lambda m: f"{table}.{m[1]}" if m[1] in known else m[1], formula)

    def value_of(key: str) -> Value:
        entry = known.get(key.partition(".")[2])
        if entry is None:
            raise InputError(f"{place}: '{key}' is no parameter before this one")
        return Value(to_si(float(entry.value), entry.unit), unit_dimension(entry.unit))

    return round(1e3 * parse_formula(named).value(value_of, "m", place), 9)


def own_design(design: Design, name: str, parameters: Mapping[str, str], path: Path) -> Design:
    """The design with one more table, in millimetres: the parameters of the part.

    Raises:
        InputError: a parameter that is not a length.
    """
    entries: list[Entry] = []
    for key, given in parameters.items():
        place = f"{path}: PARAMETERS[{key!r}]"
        if not _NAME.fullmatch(str(key)):
            raise InputError(f"{place}: write a name of small letters, digits and _, like 'width'")
        entries.append(_entry(f"{name}.{key}", given, place, entries))
    extended = replace(design, entries=(*design.entries, *entries))
    table = SimpleNamespace(**{entry.key.split(".")[1]: entry.value for entry in entries})
    object.__setattr__(extended, name, table)
    return extended


def draw_part(part: OwnPart, folder: Path) -> dict[str, Any]:
    """Write sheet, STEP AP242, STEP and mass properties of a part; returns their document.

    Raises:
        InputError: the file's functions fail, the result is not a valid solid, or a dimension is not on the solid.
    """
    try:
        return _drawn(part, folder)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{part.path}: {_where(error, part.path)}{type(error).__name__}: {error}") from None


def _drawn(part: OwnPart, folder: Path) -> dict[str, Any]:
    from drawings.artefacts.sheets import write_definition, write_sheet
    from drawings.dimensions.definition import AXES, Notes, centred_axes
    from drawings.pmi.ap242 import ap242_bytes
    from drawings.sheets.chosen_views import chosen_plan
    from drawings.sheets.part import PartDescription, part_sheets
    from stagecad.parameters.atomic import atomic_write_bytes
    from stagecad.solids.modelling.mass import density_of, geometry_of, mass_properties
    from stagecad.solids.modelling.part import treatment_of
    from stagecad.solids.modelling.verification import DimensionVerifier

    module = part.module
    design = with_sheet_changes(part)
    solid, material = built_solid(part)
    mass = mass_properties(geometry_of(solid), density_of(design, material))
    verifier = DimensionVerifier(solid)
    dimensions = tuple(module.dimensions(design))
    requirements = tuple(module.requirements(design)) if hasattr(module, "requirements") else ()
    for dimension in dimensions:
        try:
            verifier.measure(dimension)
        except LookupError as error:
            raise InputError(f"{part.path}: dimension '{dimension.name}': {error.args[0]}") from None
    symmetric = "".join(name for name in AXES if name in getattr(module, "SYMMETRIC", "") + centred_axes(verifier))
    defines = getattr(module, "defined_by_note", None)
    notes = Notes(
        symmetric,
        getattr(module, "TURNED", 1),
        False,
        (lambda point: defines(design, point)) if defines else lambda point: "",
    )
    lines = tuple(getattr(module, "NOTES", ()))
    if symmetric:
        lines = (*lines, f"Symmetric about the middle {' and '.join(symmetric)} unless dimensioned.")
    description = PartDescription(
        name=part.name,
        solid=solid,
        dimensions=dimensions,
        requirements=requirements,
        notes=lines,
        material=design.materials[material].description,
        mass=f"{mass.mass:.3f} kg" if mass.mass >= 1 else f"{1e3 * mass.mass:.1f} g",
        digest=design.digest[:8],
        treatment=treatment_of(module, design, material),
        brittle=design.materials[material].strength_kind == "fracture",
        proposed=bool(getattr(module, "PROPOSED", False)),
        plan=(chosen_plan(part.name, dimensions, requirements, verifier, getattr(module, "VIEWS", ())),),
    )
    folder.mkdir(parents=True, exist_ok=True)
    drawn = part_sheets(description, design, verifier)
    sheets = [write_sheet(sheet, folder) for sheet in drawn]
    sheets[0]["hits"] += write_definition(description, notes, design, verifier, drawn, folder)
    model = folder / f"{part.name}_ap242.step"
    atomic_write_bytes(model, ap242_bytes(part.name, module, design, solid, verifier))
    files = [str(folder / f"{sheet['name']}.{kind}") for sheet in sheets for kind in ("dxf", "svg", "pdf", "png")]
    properties = folder / f"{part.name}_mass.json"
    properties.write_text(json.dumps(mass.as_json(), indent=1) + "\n", "utf-8")
    files += [str(model), str(folder / f"{part.name}_definition.csv"), str(properties)]
    return {"part": part.name, "sheets": sheets, "files": files, **mass.as_json()}


def with_sheet_changes(part: OwnPart) -> Design:
    """The design of a part with the manual changes of its sheet, from `sheets.toml` beside its file."""
    from drawings.artefacts.names import sheet_names
    from drawings.sheets.overrides import FILE, read_overrides

    path = part.path.parent / FILE
    if not path.is_file():
        return part.design
    known = [sheet for sheets in sheet_names(part.design).values() for sheet in sheets]
    changed = replace(part.design, sheets=read_overrides(path, [*known, part.name]))
    object.__setattr__(changed, part.name, getattr(part.design, part.name))
    return changed


def called(part: OwnPart, function: str) -> Any:
    """Result of a function of the part's file.

    Raises:
        InputError: the function fails, with the line.
    """
    try:
        return getattr(part.module, function)(part.design)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{part.path}: {_where(error, part.path)}{type(error).__name__}: {error}") from None


def built_solid(part: OwnPart) -> tuple[Any, str]:
    """The solid of a part, mm, and the name of its material.

    Raises:
        InputError: the file's functions fail, the result is not a valid solid, or the material is unknown.
    """
    found, material = called(part, "build"), called(part, "material")
    if material not in part.design.materials:
        raise InputError(f"{part.path}: material '{material}' is not in [materials]")
    return _solid(part, found), material


def _solid(part: OwnPart, found: Any) -> Any:
    """The one solid that the file has built, also from a workplane."""
    shape = found.val() if hasattr(found, "val") else found
    if hasattr(shape, "Solids") and len(shape.Solids()) == 1:
        shape = shape.Solids()[0]
    if getattr(shape, "ShapeType", lambda: "")() != "Solid" or not shape.isValid() or shape.Volume() <= 0:
        raise InputError(f"{part.path}: build(design) must return one valid closed solid")
    return shape
