"""Each rule: an override that breaks it gets its message; the thesis's design passes all."""

import pytest

from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.parameters.machine import packaged_machine
from stagecad.parameters.rules import all_rules, violations
from tests.reference.tables import cases

BREAKS = cases("broken_rules", "breaks")


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
    with pytest.raises(InputError, match="second axis"):
        load_design(None, [*two, "stage.travel=40 mm"])
