"""The triangles that the kernel put on the faces of a shape, as arrays.

Asked for point by point through the kernel's Python bindings they take as long as the mesher itself took to find them.
The kernel writes them in one go in its own binary format (OCCT, ``BinTools_ShapeSet::WriteTriangulation``), every
number at full length, and numpy reads them from there. That format is little-endian on every machine.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import io
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Face

_SECTION = b"\nTriangulations "
_HEAD = struct.Struct("<ii??d")
"""Numbers of nodes and triangles, whether there are surface parameters and normals, deflection."""


@dataclass(frozen=True)
class Triangulation:
    """Triangles of one face, in the coordinates of its own location.

    Attributes:
        places: (n, 3), mm.
        normals: (n, 3) unit, of the surface; empty where none were computed.
        corners: (m, 3) indices into `places`, as the surface turns, whichever way the face is used.
    """

    places: np.ndarray
    normals: np.ndarray
    corners: np.ndarray


def triangulations(faces: Sequence[TopoDS_Face]) -> list[Triangulation]:
    """What the mesher left on each of some faces.

    Args:
        faces: meshed.

    Raises:
        ValueError: a face has no triangles.
    """
    from OCP.BinTools import BinTools, BinTools_FormatVersion
    from OCP.BRep import BRep_Builder, BRep_Tool
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS_Compound, TopoDS_Face

    kernel = [BRep_Tool.Triangulation_s(face, TopLoc_Location()) for face in faces]
    # Faces that are one and the same in several places share their triangles, which are written once.
    numbers: dict[int, int] = {}
    builder, bare = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(bare)
    for triangles in kernel:
        if triangles is None:
            raise ValueError("a face of the solid could not be meshed")
        if id(triangles) in numbers:
            continue
        numbers[id(triangles)] = len(numbers)
        # A face of nothing but triangles: surfaces and edges need not be written.
        holder = TopoDS_Face()
        builder.MakeFace(holder, triangles)
        builder.Add(bare, holder)
    stream = io.BytesIO()
    BinTools.Write_s(bare, stream, True, True, BinTools_FormatVersion.BinTools_FormatVersion_VERSION_4)
    found = list(_read(stream.getvalue()))
    if len(found) != len(numbers):
        raise ValueError(f"the kernel wrote the triangles of {len(found)} of {len(numbers)} faces")
    return [found[numbers[id(triangles)]] for triangles in kernel]


def _read(data: bytes) -> Iterator[Triangulation]:
    at = data.index(_SECTION) + len(_SECTION)
    end = data.index(b"\n", at)
    count, at = int(data[at:end]), end + 1

    def numbers(kind: str, shape: tuple[int, int]) -> np.ndarray:
        nonlocal at
        values = np.frombuffer(data, kind, shape[0] * shape[1], at).reshape(shape)
        at += values.nbytes
        return values

    for _ in range(count):
        nodes, triangles, has_parameters, has_normals, _ = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        places = numbers("<f8", (nodes, 3))
        if has_parameters:
            numbers("<f8", (nodes, 2))
        corners = numbers("<i4", (triangles, 3)).astype(np.int64) - 1
        normals = numbers("<f4", (nodes, 3)).astype(np.float64) if has_normals else np.zeros((0, 3))
        yield Triangulation(places, normals, corners)
