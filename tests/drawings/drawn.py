"""Sheets of parts for the tests, each drawn once in a run."""

from functools import cache
from typing import Any

from ezdxf.document import Drawing

from drawings.annotations.annotation import AngularDimension, Annotation, Callout, LinearDimension, RadialDimension
from drawings.export.drawing_model import drawing_model
from drawings.export.dxf import dxf_document
from drawings.sheets.part import PartDescription, part_sheets
from drawings.sheets.plans import sheets_of
from drawings.sheets.sheet import Sheet
from stagecad.friction_stage.construction import part_definition
from stagecad.solids.modelling.part import notes_of
from tests.thesis_parts import thesis


def described(name: str, design: Any) -> PartDescription:
    """A part as its sheets need it; mass and hash are others' business."""
    module, known = part_definition(name), sheets_of(design)
    title = known.titles.get(name, name.replace("_", " "))
    shape = known.plans(name, design), module.build(design), module.dimensions(design)
    required = getattr(module, "requirements", lambda _: ())(design)
    material = module.material(design)
    return PartDescription(name, title, *shape, required, notes_of(module, design), material, "1 g", "0123")


@cache
def sheets(name: str) -> tuple[Sheet, ...]:
    return part_sheets(described(name, thesis()), thesis())


def words(annotation: Annotation) -> str:
    match annotation:
        case LinearDimension() | RadialDimension() | AngularDimension():
            return annotation.text
        case Callout():
            return " ".join(annotation.lines)
        case _:
            return ""


def document_of(sheet: Sheet) -> Drawing:
    return dxf_document(drawing_model(sheet))


def framed(line: str) -> tuple[str, str, tuple[str, ...]]:
    """Characteristic, tolerance and datums of a control frame in a callout."""
    characteristic, tolerance, *datums = line.removeprefix("{frame:").removesuffix("}").split("|")
    return characteristic, tolerance, tuple(datums)
