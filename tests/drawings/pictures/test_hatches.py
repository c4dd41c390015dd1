"""Hatches of the parts in a section: neighbours differ."""

from itertools import combinations

from drawings.pictures.machine import HATCHES, different_hatches
from stagecad.solids.modelling.frame import Box, near


def test_neighbours_have_different_hatches() -> None:
    base: Box = ((0.0, 0.0, 0.0), (100.0, 10.0, 20.0))
    on_base: list[Box] = [((x, 0.0, 20.0), (x + 10.0, 10.0, 30.0)) for x in (0.0, 10.0, 50.0)]
    boxes = [base, *on_base, ((0.0, 0.0, 30.0), (60.0, 10.0, 35.0))]
    hatches = different_hatches(boxes)
    for (one, first), (two, second) in combinations(zip(boxes, hatches, strict=True), 2):
        assert first != second or not near(one, two, 0.0)
    # What stands alone has the ordinary hatch of a part on the base.
    assert hatches[0] == HATCHES[0] and hatches[3] == HATCHES[1]


def test_there_is_a_hatch_for_each_of_more_neighbours_than_hatches() -> None:
    box: Box = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    hatches = different_hatches([box] * (len(HATCHES) + 2))
    assert len(hatches) == len(HATCHES) + 2 and set(hatches) == set(HATCHES)
