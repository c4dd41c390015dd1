"""Random overrides: every one is read into a design that can be built, or refused in one line."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.parameters.machine import packaged_machine

THESIS = load_design()
LENGTHS = [entry.key for entry in THESIS.entries if entry.unit == "mm"]
NUMBERS = [entry for entry in THESIS.entries if isinstance(entry.value, float) and math.isfinite(entry.value)]

slight = st.dictionaries(st.sampled_from(LENGTHS), st.floats(0.98, 1.02), min_size=1, max_size=6)
wild = st.dictionaries(
    st.sampled_from([entry.key for entry in NUMBERS]), st.floats(-10.0, 10.0) | st.floats(1e-6, 1e6), max_size=3
)


def overrides(factors: dict[str, float]) -> list[str]:
    texts = []
    for key, factor in factors.items():
        entry = THESIS.entry(key)
        texts.append(f"{key}={entry.value * factor:.9g} {entry.unit}")
    return texts


def attempt(texts: list[str]) -> Design | str:
    """The design, or the line that refuses it."""
    try:
        return load_design(None, texts)
    except InputError as error:
        return str(error)


@settings(max_examples=150)
@given(slight)
def test_slight_changes_give_a_machine_that_goes_together_or_a_line(factors: dict[str, float]) -> None:
    design = attempt(overrides(factors))
    if isinstance(design, str):
        assert design.isprintable()
        return
    # Each seen from the geometry itself, and not from the rule.
    half, way = design.stage.travel / 2, design.bearing_way
    low, high = design.base.way_gap / 2, design.base.way_gap / 2 + way.width - way.ledge_width
    for x, y in design.derived.pad_places:
        assert abs(x) + half + design.pads.length / 2 <= way.length / 2
        assert low <= abs(y) - design.pads.width / 2
        assert abs(y) + design.pads.width / 2 <= high
    assert half < design.stage.length / 2
    for x, y in design.derived.way_screw_places:
        assert abs(x) + way.bolt_hole / 2 < way.length / 2
        assert abs(y) + way.bolt_hole / 2 < design.base.width / 2
        for px, py in design.derived.actuator_places:
            assert math.hypot(x - px, y - py) > way.bolt_hole / 2 + design.base.pocket_diameter / 2
    assert abs(design.derived.tip_apex - design.derived.drive_surface_height) <= design.derived.height_adjustment
    # The pins pass through their bores at the limits of size: the largest pin in the smallest bore.
    for pin, bore in (("height_pin_1.diameter", "base.pin_1_bore"), ("height_pin_2.diameter", "base.pin_2_bore")):
        assert design.si(pin) + 1e-3 * design.deviations(pin)[1] < design.si(bore) + 1e-3 * design.deviations(bore)[0]
    assert design.holder.diameter < design.base.pocket_diameter
    assert 0 < design.derived.way_screw_engagement <= design.base.way_thread_depth


@settings(max_examples=150)
@given(wild)
def test_wild_changes_are_read_or_refused_in_a_line(factors: dict[str, float]) -> None:
    design = attempt(overrides(factors))
    if isinstance(design, str):
        assert design.isprintable()
        return
    for key in factors:
        declaration = packaged_machine().schema().get(key)
        if declaration is not None:
            assert declaration.low <= design.value(key) <= declaration.high


@settings(max_examples=60)
@given(st.text(max_size=40))
def test_any_text_as_an_override_is_read_or_refused_in_a_line(text: str) -> None:
    for override in (text, f"stage.length={text}", f"{text}=3 mm", f"teeth.fitted={text}", f"drawing.title={text}"):
        found = attempt([override])
        assert not isinstance(found, str) or found.isprintable()
