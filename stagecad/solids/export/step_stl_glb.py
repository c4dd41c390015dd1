"""STEP, STL and GLB as bytes, reproducible for the same solid.

OCCT writes the time of day into the STEP header, a counter of its exports within the process into one PRODUCT line per
file, and the colours in the order of addresses in memory. All three are made constant here. STL and GLB are written
from the mesh: GLB with a material that is not metallic (viewers show a metallic one black), lengths in metres and y up,
as required by glTF 2.0 section 3.4.
"""

import itertools
import json
import re
import struct
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.solids.export.mesh import Mesh
from stagecad.solids.modelling.frame import UNMOVED, Colour, PlacedShape
from stagecad.solids.modelling.kernel import KernelShape, occ
from stagecad.solids.modelling.topology import transformation


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
ROUGHNESS = 0.7


def stl_bytes(meshes: Sequence[Mesh]) -> bytes:
    """Binary STL in millimetres, of one or several bodies."""
    triangle = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])
    blocks = []
    for mesh in meshes:
        corners = mesh.vertices[mesh.triangles].astype("<f4")
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        block = np.zeros(len(corners), dtype=triangle)
        block["normal"] = normal / np.where(length > 0.0, length, 1.0)
        block["corners"] = corners
        blocks.append(block)
    count = sum(len(block) for block in blocks)
    header = b"binary STL, millimetres".ljust(80, b" ") + struct.pack("<I", count)
    return header + b"".join(block.tobytes() for block in blocks)


class _Buffer:
    """Binary buffer of a GLB file with its views and accessors (glTF 2.0 section 3.6)."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, data: np.ndarray, kind: str, component: int, target: int, *, limits: bool = False) -> int:
        """Append an array, and return the number of its accessor; `limits` adds its minimum and maximum."""
        raw = data.tobytes()
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(raw), "target": target})
        self.data += raw + b"\0" * (-len(raw) % 4)
        view = len(self.views) - 1
        accessor: dict[str, Any] = {"bufferView": view, "componentType": component, "count": len(data), "type": kind}
        if limits:
            accessor["min"] = [float(value) for value in data.min(axis=0)]
            accessor["max"] = [float(value) for value in data.max(axis=0)]
        self.accessors.append(accessor)
        return view

    def add_mesh(self, mesh: Mesh, material: int) -> dict[str, Any]:
        """Append a mesh, and return it as a primitive of glTF."""
        position = self.add((mesh.vertices / 1000.0).astype("<f4"), "VEC3", 5126, 34962, limits=True)
        units = mesh.normals / np.linalg.norm(mesh.normals, axis=1, keepdims=True)
        normal = self.add(units.astype("<f4"), "VEC3", 5126, 34962)
        indices = self.add(mesh.triangles.astype("<u4").reshape(-1), "SCALAR", 5125, 34963)
        attributes = {"POSITION": position, "NORMAL": normal}
        return {"attributes": attributes, "indices": indices, "material": material}


def glb_bytes(name: str, shapes: Sequence[PlacedShape], meshes: dict[str, Mesh]) -> bytes:
    """glTF 2.0 binary: metres, y up, a root node `name`, one node per shape, one mesh per part, one material per
    colour."""
    buffer = _Buffer()
    colours = sorted({shape.colour for shape in shapes})
    colour_of_part = {shape.part: colours.index(shape.colour) for shape in shapes}
    primitives = {part: buffer.add_mesh(meshes[part], colour_of_part[part]) for part in sorted(colour_of_part)}
    numbers = {part: number for number, part in enumerate(colour_of_part)}
    nodes: list[dict[str, Any]] = []
    for shape in shapes:
        nodes.append({"name": shape.name, "mesh": numbers[shape.part]})
        if shape.frame != UNMOVED:
            columns = [value for column in zip(*shape.frame.rotation, strict=True) for value in (*column, 0.0)]
            nodes[-1]["matrix"] = [*columns, *(value / 1000.0 for value in shape.frame.shift), 1.0]
    # The root turns z up into y up; all nodes below it keep the axes of the machine.
    half = float(np.sqrt(0.5))
    root = {"name": name, "rotation": [-half, 0.0, 0.0, half], "children": list(range(len(nodes)))}
    document = {
        "asset": {"version": "2.0", "generator": "stagecad"},
        "scene": 0,
        "scenes": [{"nodes": [len(nodes)]}],
        "nodes": [*nodes, root],
        "meshes": [{"name": part, "primitives": [primitives[part]]} for part in numbers],
        "materials": [_material(colour) for colour in colours],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.data)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(buffer.data), b"BIN\0") + bytes(buffer.data)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _material(colour: Colour) -> dict[str, Any]:
    # Colours are sRGB here and linear in glTF.
    linear = [value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4 for value in colour]
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*(round(value, 6) for value in linear), 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": ROUGHNESS,
        }
    }


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

    def renumbered(body: str) -> str:
        return re.sub(r"#(\d+)", lambda one: f"#{order.get(one[1], one[1])}", body)

    lines = [f"#{place} = {renumbered(entities[number])};\n" for number, place in order.items()]
    return text[: first.start()] + "".join(lines) + text[end:]
