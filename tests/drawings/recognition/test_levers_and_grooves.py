"""Arms at an angle have a distance and an angle and a width; a V has the angle between its flanks and its depth."""

import math
from dataclasses import replace

import cadquery as cq

from drawings.dimensions.definition import Notes, definition
from drawings.recognition.part_file import Proposal, as_dimension
from stagecad.solids.modelling.verification import DimensionVerifier
from tests.drawings.recognition import proposals
from tests.drawings.recognition.proposals import W


def lever(*arms: tuple[float, float]) -> cq.Workplane:
    """A hub at the origin with arms of angles, degrees, and lengths."""
    body, bores = W().circle(16).extrude(24), W().circle(8).extrude(50)
    for angle, length in arms:
        x, y = length * math.cos(math.radians(angle)), length * math.sin(math.radians(angle))
        web = W().center(x / 2, y / 2).transformed(rotate=(0, 0, angle)).rect(length, 11).extrude(8)
        body = body.union(web).union(W().center(x, y).circle(10).extrude(16))
        bores = bores.union(W().center(x, y).circle(4).extrude(50))
    return body.cut(bores)


def proposal_of(body: cq.Workplane) -> tuple[DimensionVerifier, Proposal]:
    return proposals.verifier_of(body), proposals.proposal_of(body)


def values(found: Proposal, method: str) -> list[float]:
    return [value for value, _ in proposals.values(found, method)]


def test_an_arm_at_an_angle_has_a_distance_an_angle_and_a_width() -> None:
    verifier, found = proposal_of(lever((0, 60), (110, 45)))
    assert values(found, "angle") == [110.0]
    assert values(found, "linear") == [8.0, 11.0, 16.0, 24.0, 45.0, 60.0]
    # Neither of them alone gives the place, and a dimension along an axis beside them is one too many.
    dimensions = [as_dimension(one) for one in found.dimensions]
    for kind, value in (("angle", 110.0), ("linear", 45.0), ("linear", 11.0)):
        rest = [d for d in dimensions if (d.kind, round(d.value, 6)) != (kind, value)]
        assert any("place" in line for line in definition(verifier, rest, (), Notes(packaged=False)).problems)
    ray = next(d for d in dimensions if round(d.value, 6) == 45.0)
    step = abs(ray.points[1][1] - ray.points[0][1])
    twice = [*dimensions, replace(ray, name="height of the axis", direction=(0.0, 1.0, 0.0), value=step)]
    assert "follows from others" in definition(verifier, twice, (), Notes(packaged=False)).problems[0]


def test_equal_arms_have_one_width_for_all_of_them_and_those_of_a_star_no_other_place() -> None:
    for angles in ((90, 210, 330), (0, 72, 144, 216, 288), (0, 90, 180, 270), (0, 90, 210)):
        body = lever(*((angle, 45.0) for angle in angles))
        for one in (body, body.edges("|Z").fillet(1.5)):
            _, found = proposal_of(one)
            (arm,) = [d for d in found.dimensions if abs(d.value - 11.0) < 1e-6]
            assert arm.fields["count"] == len(angles)
            assert values(found, "pitch_circle") == [90.0] and values(found, "linear") == [8.0, 11.0, 16.0, 24.0]
            assert not any(d.fields.get("note") == "HEX AF" for d in found.dimensions)
    verifier, found = proposal_of(lever((90, 45), (210, 45), (330, 45)))
    dimensions = [as_dimension(one) for one in found.dimensions]
    fewer = [replace(d, count=2) if d.count == 3 and d.value == 11.0 else d for d in dimensions]
    assert any("place" in line for line in definition(verifier, fewer, (), Notes("xy", packaged=False)).problems)


def test_a_wall_that_touches_two_round_faces_needs_no_dimension() -> None:
    far, angle = 60.0, math.acos((16 - 10) / 60.0)
    ends = [(r * math.cos(angle) + x, side * r * math.sin(angle)) for side in (1, -1) for x, r in ((0, 16), (far, 10))]
    web = W().polyline([ends[0], ends[1], ends[3], ends[2]]).close().extrude(8)
    body = web.union(W().circle(16).extrude(20)).union(W().center(far, 0).circle(10).extrude(14))
    _, found = proposal_of(body.cut(W().circle(7).extrude(50)).cut(W().center(far, 0).circle(4).extrude(50)))
    assert not values(found, "angle") and values(found, "linear") == [8.0, 14.0, 20.0, 60.0]


def test_a_v_with_a_relief_has_its_angle_and_the_depth_of_its_theoretical_edge() -> None:
    block = W().box(60, 40, 40, centered=(True, True, False))
    block = block.cut(W("XZ").moveTo(-27, 45).lineTo(0, 18).lineTo(27, 45).close().extrude(50, both=True))
    _, found = proposal_of(block.cut(W().box(4, 60, 12, centered=(True, True, False)).translate((0, 0, 12))))
    assert values(found, "angle") == [90.0] and values(found, "linear") == [4.0, 12.0, 22.0, 40.0, 40.0, 60.0]
