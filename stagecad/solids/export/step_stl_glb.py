"""STEP, STL and GLB as bytes: the same bytes for the same solid, in whatever process and how often.

OCCT writes the time of day into the STEP header and counts its exports within the process into one PRODUCT line per
file; both are made constant here. STL and GLB are written from the mesh directly: GLB so that the material is not
metallic (a viewer would paint it black), lengths are metres and y is up, as glTF 2.0 section 3.4 wants.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import itertools
import json
import re
import struct
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stagecad.solids.export.mesh import Mesh
from stagecad.solids.modelling.frame import UNMOVED, Frame
from stagecad.solids.modelling.placed_shape import Colour, PlacedShape

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

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


def glb_bytes(name: str, pieces: Sequence[PlacedShape], meshes: dict[str, Mesh]) -> bytes:
    """glTF 2.0 binary: metres, y up, one node per piece, one mesh per part, one material per colour.

    Args:
        name: of the scene's root node.
        pieces: what stands where.
        meshes: mesh of each part, mm, by `PlacedShape.part`.
    """
    chunks: list[bytes] = []
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []

    def add(data: np.ndarray, kind: str, component: int, target: int | None, limits: bool = False) -> int:
        start = sum(len(chunk) for chunk in chunks)
        raw = data.tobytes()
        chunks.append(raw + b"\0" * (-len(raw) % 4))
        view: dict[str, Any] = {"buffer": 0, "byteOffset": start, "byteLength": len(raw)}
        if target is not None:
            view["target"] = target
        views.append(view)
        accessor: dict[str, Any] = {
            "bufferView": len(views) - 1,
            "componentType": component,
            "count": len(data),
            "type": kind,
        }
        if limits:
            accessor["min"] = [float(value) for value in data.min(axis=0)]
            accessor["max"] = [float(value) for value in data.max(axis=0)]
        accessors.append(accessor)
        return len(accessors) - 1

    colours = sorted({piece.colour for piece in pieces})
    geometry: dict[str, tuple[int, int, int]] = {}
    for part in sorted({piece.part for piece in pieces}):
        mesh = meshes[part]
        geometry[part] = (
            add((mesh.vertices / 1000.0).astype("<f4"), "VEC3", 5126, 34962, limits=True),
            add(_unit_float(mesh.normals), "VEC3", 5126, 34962),
            add(mesh.triangles.astype("<u4").reshape(-1), "SCALAR", 5125, 34963),
        )
    shapes: list[dict[str, Any]] = []
    places: dict[tuple[str, Colour], int] = {}
    nodes: list[dict[str, Any]] = []
    for piece in pieces:
        if (piece.part, piece.colour) not in places:
            position, normal, indices = geometry[piece.part]
            places[piece.part, piece.colour] = len(shapes)
            primitive = {
                "attributes": {"POSITION": position, "NORMAL": normal},
                "indices": indices,
                "material": colours.index(piece.colour),
            }
            shapes.append({"name": piece.part, "primitives": [primitive]})
        node: dict[str, Any] = {"name": piece.name, "mesh": places[piece.part, piece.colour]}
        if piece.frame != UNMOVED:
            node["matrix"] = _column_major(piece.frame)
        nodes.append(node)
    # The root turns z up into y up; everything below it keeps the machine's own axes.
    half = float(np.sqrt(0.5))
    root = {"name": name, "rotation": [-half, 0.0, 0.0, half], "children": list(range(len(nodes)))}
    document = {
        "asset": {"version": "2.0", "generator": "stagecad"},
        "scene": 0,
        "scenes": [{"nodes": [len(nodes)]}],
        "nodes": [*nodes, root],
        "meshes": shapes,
        "materials": [_material(colour) for colour in colours],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": sum(len(chunk) for chunk in chunks)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(chunks)
    return (
        struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(binary))
        + struct.pack("<I4s", len(text), b"JSON")
        + text
        + struct.pack("<I4s", len(binary), b"BIN\0")
        + binary
    )


def _material(colour: Colour) -> dict[str, Any]:
    # glTF wants linear colour; ours are sRGB.
    linear = [value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4 for value in colour]
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*(round(value, 6) for value in linear), 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": ROUGHNESS,
        }
    }


def _column_major(frame: Frame) -> list[float]:
    columns = [[frame.rotation[row][column] for row in range(3)] + [0.0] for column in range(3)]
    return [*(value for column in columns for value in column), *(value / 1000.0 for value in frame.shift), 1.0]


def _unit_float(normals: np.ndarray) -> np.ndarray:
    return (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype("<f4")


def step_bytes(name: str, pieces: Sequence[PlacedShape], shapes: dict[str, TopoDS_Shape]) -> bytes:
    """STEP (AP214) with names and colours, millimetres.

    Args:
        name: of the product; of the whole when there are several pieces.
        pieces: what stands where; a single piece that is named like the product is written as that part alone.
        shapes: solid of each part by `PlacedShape.part`.

    Raises:
        ValueError: OCCT could not write the solid.
    """
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.Interface import Interface_Static
    from OCP.Message import Message, Message_Gravity
    from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.STEPControl import STEPControl_StepModelType
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_ColorGen, XCAFDoc_DocumentTool

    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Gravity.Message_Fail)
    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colour_tool = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    alone = len(pieces) == 1 and pieces[0].name == name
    whole = None
    if not alone:
        whole = tool.NewShape()
        TDataStd_Name.Set_s(whole, TCollection_ExtendedString(name))
    labels: dict[tuple[str, Colour], Any] = {}
    for piece in pieces:
        kind = (piece.part, piece.colour)
        if kind not in labels:
            label = tool.AddShape(shapes[piece.part], False)
            TDataStd_Name.Set_s(label, TCollection_ExtendedString(piece.part))
            colour_tool.SetColor(label, Quantity_Color(*piece.colour, Quantity_TOC_sRGB), XCAFDoc_ColorGen)
            labels[kind] = label
        if whole is not None:
            component = tool.AddComponent(whole, labels[kind], TopLoc_Location(transformation(piece.frame)))
            TDataStd_Name.Set_s(component, TCollection_ExtendedString(piece.name))
    tool.UpdateAssemblies()
    writer = STEPCAFControl_Writer()
    Interface_Static.SetCVal_s("write.step.schema", "AP214IS")
    Interface_Static.SetIVal_s("write.surfacecurve.mode", 0)
    writer.SetColorMode(True)
    writer.SetNameMode(True)
    if not writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs):
        raise ValueError(f"'{name}' could not be translated to STEP")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "part.step"
        if writer.Write(str(path)) != IFSelect_RetDone:
            raise ValueError(f"'{name}' could not be written as STEP")
        text = path.read_text("utf-8")
    return constant_text(text, name).encode()


def constant_text(text: str, name: str) -> str:
    """A STEP text with the time stamp and the file's own name fixed, and OCCT's running counters restarted."""
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


def transformation(frame: Frame) -> Any:
    """The move as the kernel's own ``gp_Trsf``."""
    from OCP.gp import gp_Trsf

    move = gp_Trsf()
    rows = [value for row, shift in zip(frame.rotation, frame.shift, strict=True) for value in (*row, shift)]
    move.SetValues(*rows)
    return move
