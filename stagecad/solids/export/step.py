"""STEP as bytes, reproducible for the same solid.

OCCT writes the time of day into the STEP header, a counter of its exports within the process into one PRODUCT line per
file, and the colours in the order of addresses in memory. All three are made constant here.
"""

import itertools
import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stagecad.solids.modelling.frame import Colour, PlacedShape
from stagecad.solids.modelling.kernel import KernelShape, occ, transformation


def new_document() -> Any:
    """An empty document; messages of the kernel below failures are not printed."""
    for printer in occ.Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(occ.Message_Gravity.Message_Fail)
    document = occ.TDocStd_Document(occ.TCollection_ExtendedString("XmlXCAF"))
    occ.XCAFApp_Application.GetApplication_s().InitDocument(document)
    return document


def set_name(label: Any, name: str) -> None:
    """Name a label of a document."""
    occ.TDataStd_Name.Set_s(label, occ.TCollection_ExtendedString(name))


def step_text(document: Any, name: str, schema: str, contents: Sequence[str]) -> str:
    """A document as STEP with names, as OCCT writes it."""
    writer = occ.STEPCAFControl_Writer()
    # The setting exists only after a writer has been created.
    occ.Interface_Static.SetCVal_s("write.step.schema", schema)
    occ.Interface_Static.SetIVal_s("write.surfacecurve.mode", 0)
    for content in ("Name", *contents):
        getattr(writer, f"Set{content}Mode")(True)
    if not writer.Transfer(document, occ.STEPControl_StepModelType.STEPControl_AsIs):
        raise ValueError(f"'{name}' could not be translated to STEP")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "part.step"
        if writer.Write(str(path)) != occ.IFSelect_RetDone:
            raise ValueError(f"'{name}' could not be written as STEP")
        return path.read_text("utf-8")


PRESENTATION = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION"
TIME_STAMP = "2000-01-01T00:00:00"


def step_bytes(name: str, placed: Sequence[PlacedShape], solids: dict[str, KernelShape]) -> bytes:
    """STEP (AP214) with names and colours, millimetres."""
    document = new_document()
    tool = occ.XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colour_tool = occ.XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    alone = len(placed) == 1 and placed[0].name == name
    whole = None
    if not alone:
        whole = tool.NewShape()
        set_name(whole, name)
    labels: dict[tuple[str, Colour], Any] = {}
    for shape in placed:
        kind = (shape.part, shape.colour)
        if kind not in labels:
            label = tool.AddShape(solids[shape.part], False)
            set_name(label, shape.part)
            colour_tool.SetColor(label, occ.Quantity_Color(*shape.colour, occ.Quantity_TOC_sRGB), occ.XCAFDoc_ColorGen)
            labels[kind] = label
        if whole is not None:
            component = tool.AddComponent(whole, labels[kind], occ.TopLoc_Location(transformation(shape.frame)))
            set_name(component, shape.name)
    tool.UpdateAssemblies()
    text = step_text(document, name, "AP214IS", ("Color",))
    return ordered_styles(constant_text(text, name)).encode()


def constant_text(text: str, name: str) -> str:
    """A STEP text with constant time stamp and file name, and OCCT's counters restarted."""
    text = re.sub(
        r"FILE_NAME\(.*?\);",
        f"FILE_NAME('{name}','{TIME_STAMP}',('stagecad'),(''),'Open CASCADE','stagecad','');",
        text,
        count=1,
        flags=re.DOTALL,
    )
    text = re.sub(r"'Open CASCADE STEP translator ([\d.]+) [\d.]+'", r"'Open CASCADE STEP translator \1'", text)
    number = itertools.count(1)
    return re.sub(
        r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('\d+'", lambda _: f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{next(number)}'", text
    )


def ordered_styles(text: str) -> str:
    """A STEP text with its presentations in the order of the shapes that they colour.

    They are the last entities of the file: MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION (ISO 10303-46), each
    followed by the styles that only it refers to, and by a colour where that is the first to use it. They are written
    again from each presentation down, with new numbers.
    """
    first = re.search(rf"^#\d+ = {PRESENTATION}", text, re.MULTILINE)
    if first is None:
        return text
    end = text.index("ENDSEC;", first.start())
    found = re.findall(r"#(\d+) = (.*?);\n", text[first.start() : end], re.DOTALL)
    entities = {number: re.sub(r"\n\s*", "", body) for number, body in found}
    roots = [number for number, body in entities.items() if body.startswith(PRESENTATION)]
    roots.sort(key=lambda number: int(re.findall(r"#(\d+)", entities[number])[-1]))
    order: dict[str, int] = {}
    lowest = min(int(number) for number in entities)
    pending = roots[::-1]
    while pending:
        number = pending.pop()
        if number in entities and number not in order:
            order[number] = lowest + len(order)
            pending += reversed(re.findall(r"#(\d+)", entities[number]))
    lines = "".join(f"#{place} = {entities[number]};\n" for number, place in order.items())
    renumbered = re.sub(r"#(\d+)\b(?! = )", lambda one: f"#{order.get(one[1], one[1])}", lines)
    return text[: first.start()] + renumbered + text[end:]
