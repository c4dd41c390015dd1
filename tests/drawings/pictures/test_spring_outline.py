"""Outlines of bent wire in closed form: against the kernel's exact algorithm, and against a torus's own equations."""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import KDTree

from drawings.pictures.depth_refinement import CloseUp
from drawings.pictures.picture import picture
from drawings.pictures.spring_outline import wire_of
from drawings.pictures.visibility import Scene
from drawings.views.projection import hidden_lines
from drawings.views.view import PROJECTIONS, Arc, Curve, Polyline, Projection, Segment
from stagecad.solids.modelling.frame import UNMOVED, Frame
from stagecad.solids.purchased import spring
from tests.drawings.drawn import thesis

STEP = 0.05
"""Distance of the places at which lines are compared, mm."""


def _finely_meshed(shape):
    """The shape with triangles as fine as those of the parts that are exported."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh

    BRepMesh_IncrementalMesh(shape, 0.01, False, 0.1, False)
    return shape


@pytest.fixture(scope="module")
def coil():
    return _finely_meshed(spring.build(thesis()).wrapped)


def _along(curves: tuple[Curve, ...]) -> np.ndarray:
    found = []
    for curve in curves:
        if isinstance(curve, Arc):
            turns = np.radians(np.linspace(curve.start_angle, curve.end_angle, 200))
            found.append(curve.centre + curve.radius * np.column_stack((np.cos(turns), np.sin(turns))))
            continue
        points = curve.points if isinstance(curve, Polyline) else (curve.start, curve.end)
        for a, b in pairwise(np.array(points)):
            found.append(a + (b - a) * np.linspace(0.0, 1.0, max(2, math.ceil(math.dist(a, b) / STEP)))[:, None])
    return np.concatenate(found)


TILTED = Projection("tilted", (math.cos(0.4), math.sin(0.4), 0.0), (-0.6 * math.sin(0.4), 0.6 * math.cos(0.4), 0.8))


@pytest.mark.parametrize("projection", [PROJECTIONS["iso"], TILTED], ids=lambda p: p.name)
def test_a_spring_looks_as_the_exact_algorithm_draws_it(coil, projection: Projection) -> None:
    scene = Scene({"spring": coil})
    ours = _along(picture("one", projection, scene, [("spring", "spring", UNMOVED)]).pieces[0][1])
    theirs = _along(hidden_lines([coil], projection)[0])
    for one, other in ((ours, theirs), (theirs, ours)):
        away, _ = KDTree(other).query(one)
        # Where an outline goes behind the wire, the two end it some tenths of a millimetre apart.
        assert np.quantile(away, 0.97) < 0.06
        assert away.max() < 0.8


def test_a_wire_that_runs_at_the_eye_and_back_is_closed_there(coil) -> None:
    projection = PROJECTIONS["right"]
    scene = Scene({"spring": coil})
    ours = _along(picture("one", projection, scene, [("spring", "spring", UNMOVED)]).pieces[0][1])
    theirs = _along(hidden_lines([coil], projection)[0])
    away, _ = KDTree(ours).query(theirs)
    assert np.quantile(away, 0.995) < 0.06
    away, _ = KDTree(theirs).query(ours)
    # The exact algorithm leaves out one side of a flat end that is seen from its edge.
    edge = abs(ours[:, 1] - thesis().spring.wire_diameter) < 1e-3
    assert np.quantile(away[~edge], 0.995) < 0.06


def test_outlines_of_a_ring_seen_from_above_are_two_circles() -> None:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus

    scene = Scene({"ring": _finely_meshed(BRepPrimAPI_MakeTorus(10.0, 1.0).Shape())})
    shown = picture("one", PROJECTIONS["top"], scene, [("ring", "ring", Frame(shift=(3.0, 4.0, 5.0)))])
    places = _along(shown.pieces[0][1]) - (3.0, 4.0)
    radii = np.linalg.norm(places, axis=1)
    assert (np.minimum(abs(radii - 9.0), abs(radii - 11.0)) < 0.04).all()
    turns = np.sort(np.degrees(np.arctan2(places[:, 1], places[:, 0]))[radii > 10.0])
    assert np.diff(turns).max() < 4.0


def test_only_round_wire_is_taken_for_wire(coil) -> None:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder

    from drawings.pictures.visibility import faces_of

    found = wire_of(tuple(faces_of(coil)))
    assert found
    assert found.radius == pytest.approx(thesis().spring.wire_diameter / 2)
    assert len(found.arcs) == 2 * thesis().spring.coils + 2
    for other in (BRepPrimAPI_MakeBox(1, 2, 3), BRepPrimAPI_MakeCylinder(1, 2)):
        assert wire_of(tuple(faces_of(other.Shape()))) is None


def test_what_lies_behind_a_wire_is_hidden_and_what_lies_before_it_is_not() -> None:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeTorus

    shapes = {
        "ring": _finely_meshed(BRepPrimAPI_MakeTorus(10.0, 1.0).Shape()),
        "bar": BRepPrimAPI_MakeBox(40.0, 4.0, 1.0).Shape(),
    }
    scene = Scene(shapes)
    for height, gaps in ((-5.0, 2), (5.0, 0)):
        pieces = [("ring", "ring", UNMOVED), ("bar", "bar", Frame(shift=(-20.0, -2.0, height)))]
        _, (_, lines) = picture("two", PROJECTIONS["top"], scene, pieces).pieces
        edge = sorted(
            sorted((s.start[0], s.end[0]))
            for s in lines
            if isinstance(s, Segment) and abs(s.start[1] - 2.0) < 1e-6 and abs(s.end[1] - 2.0) < 1e-6
        )
        assert len(edge) == gaps + 1
        if gaps:
            inner, outer = math.sqrt(9.0**2 - 4.0), math.sqrt(11.0**2 - 4.0)
            ends = [end for span in edge for end in span]
            assert ends == pytest.approx([-20.0, -outer, -inner, inner, outer, 20.0], abs=0.15)


def test_what_is_left_of_each_kind_of_curve() -> None:
    own = np.zeros((100, 100), dtype=bool)
    own[:, 40:60] = True
    seen = CloseUp(PROJECTIONS["top"], (0.0, -10.0), 0.1, np.zeros((100, 100), dtype=np.float32), own)
    # The window reaches from (0, 0) to (10, 10); a band from x = 4 to x = 6 hides.
    curves = (
        Segment((0.0, 5.0), (10.0, 5.0)),
        Polyline(((0.0, 5.0), (5.0, 6.0), (10.0, 5.0))),
        Arc((5.0, 0.0), 5.0, 0.0, 180.0),
    )
    for curve in curves:
        assert seen.meets(curve)
        places = [_along((piece,)) for piece in seen.without_hidden(curve)]
        assert len(places) == 2
        first, second = sorted(places, key=lambda p: p[:, 0].min())
        assert (first[:, 0].min(), first[:, 0].max()) == pytest.approx((0.0, 4.0), abs=0.31)
        assert (second[:, 0].min(), second[:, 0].max()) == pytest.approx((6.0, 10.0), abs=0.31)
        assert all(type(piece) is type(curve) for piece in seen.without_hidden(curve))
    away = Segment((20.0, 5.0), (30.0, 5.0))
    assert not seen.meets(away)
    assert list(seen.without_hidden(away)) == [away]
