"""The line as which a face is seen in a view."""

from types import SimpleNamespace
from typing import Any

import cadquery as cq
import pytest

from drawings.dimensions.edges import edge_of_face
from drawings.views.view import PROJECTIONS
from stagecad.parameters.dimension import DatumFeature
from stagecad.solids.modelling.verification import DimensionVerifier


@pytest.mark.parametrize("order", [1, -1])
def test_a_point_on_an_edge_is_on_the_face_of_the_stated_normal(order: int) -> None:
    """The top shares the point, and reaches farther, over the rounded corners; the order of the faces is by chance."""
    body: Any = cq.Workplane().box(96, 54, 10, centered=False).edges("|Z").fillet(6).val()
    view: Any = SimpleNamespace(projection=PROJECTIONS["top"], scale=1.0, cut=None)
    gauge: Any = SimpleNamespace(surfaces=[*DimensionVerifier(body).surfaces][::order])
    line = edge_of_face(view, DatumFeature("C", ((0.0, 18.6, 10.0),), (-1.0, 0.0, 0.0), "top"), gauge)
    assert line is not None
    assert sorted(end[1] for end in line[:2]) == pytest.approx([6.0, 48.0])
