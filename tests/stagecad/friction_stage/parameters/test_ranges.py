"""Ranges and rules of the packaged machine."""

import math
import re

import pytest

from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError
from stagecad.parameters.file import bounds_text, in_bounds
from stagecad.parameters.load import load_design
from stagecad.parameters.machine import packaged_machine
from stagecad.parameters.rules import all_rules, violations
from tests.reference.tables import cases
from tests.refusals import refused

EMPTY_UNITS = {"deg", "rad", "degC", "1/K"}
"""Units whose keys have bounds of their own, or none."""
BREAKS = cases("broken_rules", "breaks")


@pytest.mark.parametrize(("override", "said"), cases("ranges", "beyond"))
def test_a_value_beyond_its_range_is_refused_with_the_reason(override: str, said: str) -> None:
    refused(re.escape(said), load_design, None, [override])


@pytest.mark.parametrize("override", cases("ranges", "edges"))
def test_edges_that_consume_their_faces_violate_a_rule(override: str) -> None:
    refused(override.partition("=")[0], load_design, None, [override])


def test_every_number_has_a_range_that_the_packaged_design_is_well_inside(design: Design) -> None:
    keys = packaged_machine().schema(tuple(sorted(design.materials)))
    for key, declared in keys.items():
        if declared.kind == "number" and declared.unit not in EMPTY_UNITS:
            assert math.isfinite(declared.high), key
    for entry in design.entries:
        declared = keys[entry.key]
        if declared.kind == "number" and declared.why and "thread" not in declared.why and "pitch" not in entry.key:
            assert entry.value <= declared.high / 1.6, entry.key
            assert entry.value == 0.0 or declared.low <= 0.0 or entry.value > 1.04 * declared.low, entry.key


def test_a_bound_is_permitted_where_the_message_says_so(design: Design) -> None:
    """'between 1 and 100 mm' holds 1 mm; 'more than 0' does not hold zero."""
    between = 0
    for key, declared in packaged_machine().schema(tuple(sorted(design.materials))).items():
        if declared.kind == "number" and math.isfinite(declared.low) and math.isfinite(declared.high):
            text = bounds_text(declared, 2.0 * declared.high)
            between += "between" in text
            assert ("between" in text) == in_bounds(declared.low, declared), key
            assert in_bounds(declared.high, declared), key
    assert between > 100


@pytest.mark.parametrize(("rule", "overrides", "words"), BREAKS)
def test_what_breaks_a_rule_is_told_in_the_users_words(rule: str, overrides: list[str], words: str) -> None:
    found = violations(load_design(None, overrides, rules=False))
    messages = [item.message for item in found if item.rule == rule]
    assert any(words in message for message in messages), found
    with pytest.raises(InputError) as caught:
        load_design(None, overrides)
    assert str(caught.value).isprintable()


def test_every_rule_can_be_broken_and_the_thesis_breaks_none() -> None:
    assert {rule for rule, _, _ in BREAKS} == set(all_rules(packaged_machine()))
    assert violations(load_design(rules=False)) == []


@pytest.mark.parametrize("overrides", cases("broken_rules", "alone"))
def test_the_keys_that_scripts_change_can_be_changed_alone(overrides: list[str]) -> None:
    design = load_design(None, overrides)
    assert design.derived.tip_apex == pytest.approx(design.derived.drive_surface_height, abs=1e-9)


def test_two_axes_with_a_smaller_travel_can_be_built() -> None:
    two = ["actuator.fitted=3", "teeth.fitted=false", "sea.whole_underside=true", "pads.count=4"]
    assert len(load_design(None, [*two, "stage.travel=24 mm"]).derived.fitted_places) == 3
    refused("second axis", load_design, None, [*two, "stage.travel=40 mm"])
