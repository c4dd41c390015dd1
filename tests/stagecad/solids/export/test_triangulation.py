"""Triangles read in one go are those that the kernel gives one by one."""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import cadquery as cq
import numpy as np
import pytest
from OCP.BRep import BRep_Tool
from OCP.BRepLib import BRepLib_ToolTriangulatedShape
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.TopLoc import TopLoc_Location

from stagecad.solids.export.triangulation import triangulations


def meshed() -> list[cq.Face]:
    """Faces of a moved block with a bore, a ball's hollow and a round corner: planes, cylinders and a sphere."""
    block = cq.Workplane().box(30, 20, 10).edges("|Z").fillet(3).faces(">Z").hole(5)
    block = block.cut(cq.Workplane().sphere(4).translate((10, 0, 5)))
    shape = block.solids().val().moved(cq.Location((1, 2, 3), (0, 0, 1), 30))
    BRepMesh_IncrementalMesh(shape.wrapped, 0.05, False, 0.2, False)
    return shape.Faces()


@pytest.mark.parametrize("with_normals", [False, True])
def test_nodes_triangles_and_normals_are_the_kernel_s_own(with_normals: bool) -> None:
    faces = [face.wrapped for face in meshed()]
    one_by_one = [BRep_Tool.Triangulation_s(face, TopLoc_Location()) for face in faces]
    if with_normals:
        for face, kernel in zip(faces, one_by_one, strict=True):
            BRepLib_ToolTriangulatedShape.ComputeNormals_s(face, kernel)
    read = triangulations(faces)
    assert len(read) == len(faces) > 8
    for kernel, ours in zip(one_by_one, read, strict=True):
        nodes = range(1, kernel.NbNodes() + 1)
        assert np.array_equal(ours.places, [kernel.Node(i).Coord() for i in nodes])
        corners = [kernel.Triangle(i).Get() for i in range(1, kernel.NbTriangles() + 1)]
        assert np.array_equal(ours.corners, np.array(corners) - 1)
        # The kernel keeps normals in single precision.
        normals = [kernel.Normal(i).Coord() for i in nodes] if with_normals else np.zeros((0, 3))
        assert ours.normals == pytest.approx(np.array(normals), abs=1e-7)


def test_faces_that_stand_in_several_places_share_their_triangles() -> None:
    ball, *others = meshed()
    placed = [ball, *others, ball.moved(cq.Location((50, 0, 0))), others[0].moved(cq.Location((50, 0, 0)))]
    read = triangulations([face.wrapped for face in placed])
    assert len(read) == len(others) + 3
    assert read[-2] is read[0]
    assert read[-1] is read[1]
    assert read[0] is not read[1]


def test_a_face_without_triangles_is_told() -> None:
    bare = cq.Workplane().box(1, 1, 1).faces(">Z").val()
    with pytest.raises(ValueError, match="could not be meshed"):
        triangulations([bare.wrapped])
