"""The assembly procedure: every part once, in an order that can be built, and no number of its own."""

import re
from dataclasses import fields, replace

import pytest

from drawings.friction_stage.procedure import CALCULATED, ProcedureValues, step_templates
from drawings.friction_stage.sheets import Step, procedure
from stagecad.friction_stage.assembly import accessories
from stagecad.friction_stage.construction import MADE
from stagecad.parameters.design import Design
from stagecad.parameters.load import load_design
from stagecad.parameters.machine import packaged_machine
from stagecad.solids.assembly.bill_of_materials import Row
from stagecad.solids.modelling.part import part_names
from tests.reference.tables import cases
from tests.thesis_parts import thesis

QUANTITIES = {
    "bearing_way": 2, "way_screw": 14, "piezo": 3, "tooth_bar": 2, "bar_screw": 10, "stop_bar": 2, "stop_screw": 4,
    "buffer": 4, "tooth_iron": 4, "magnet": 2, "clamp_screw_long": 2, "clamp_screw_short": 2,
}  # fmt: skip

LIFT = {"lift_per_turn": 158.75e-6, "lift_per_degree": 158.75e-6 / 360, "adjustment": 0.5e-3, "ellipse_height": 12e-6}
FORCES = {"way_preload": 7874.0, "bar_preload": 3000.0, "clamp_force": 5249.0, "magnet_pull": 154.8}
CLAMPS = {"clamp_squeeze": 0.14e-6, "clamp_drop": 0.058e-6, "clamp_sideways": 110e-6}
FILM = {"run_in_distance": 1200.0, "run_in_time": 6000.0, "run_in_wear": 0.9e-6, "film_strokes": 4000.0}
VALUES = ProcedureValues(**LIFT, **FORCES, **CLAMPS, **FILM)


def rows(design: Design) -> tuple[Row, ...]:
    names = part_names(design)
    return tuple(
        Row(item, name, name, f"number of {name}", QUANTITIES.get(name, 1), "material", 84.2, name not in MADE)
        for item, name in enumerate(names, start=1)
    )


def made(*overrides: str, values: ProcedureValues = VALUES) -> tuple[Step, ...]:
    design = load_design(overrides=overrides) if overrides else thesis()
    return procedure(design, rows(design), values)


def words(steps: tuple[Step, ...]) -> str:
    texts = ((s.title, *s.sentences, *s.tools, s.torque.text if s.torque else "") for s in steps)
    return "\n".join(map(" ".join, texts))


def test_every_part_of_the_list_goes_in_once() -> None:
    listed = {row.part: (row.item, row.part_number, row.quantity) for row in rows(thesis())}
    used: dict[str, tuple[int, str, int]] = {}
    for use in (use for step in made() for use in step.parts):
        used[use.part] = (use.item, use.part_number, use.quantity + used.get(use.part, (0, "", 0))[2])
    assert used == listed
    # Screws of the bars are put in with the bars, those of the bracket with this.
    rows_of_screws = [use.quantity for step in made() for use in step.parts if use.part == "bar_screw"]
    assert rows_of_screws == [8, 2]
    (mount,) = (step for step in made() if "sensor_bracket" in {use.part for use in step.parts})
    (screw,) = (one for one in accessories(thesis()) if one.name == "screw of mirror and interferometer")
    assert mount.tools[0] == f"{screw.quantity} screws {screw.specification}"
    assert [step.number for step in made()] == list(range(1, len(made()) + 1))


@pytest.mark.parametrize("first, then", cases("procedure", "order"))
def test_a_part_is_put_in_after_the_part_that_carries_it(first: str, then: str) -> None:
    place: dict[str, int] = {}
    for step in made():
        for use in step.parts:
            place.setdefault(use.part, step.number)
    assert place[first] <= place[then]


def test_order_of_the_steps() -> None:
    titles = [step.title for step in made()]
    order = ["Lower the stage onto the ways", "Set the height of the tip", "Close the clamps"]
    order.append("Check the shift by clamping")
    assert [title for title in titles if title in order] == order
    # The tip is bonded to all three piezos: adhesive of the parts list, solvent that releases it, and order agree.
    (bond,) = (step for step in made() if "tip" in {use.part for use in step.parts})
    (adhesive,) = (one for one in accessories(thesis()) if one.name == "adhesive for the tip")
    assert bond.tools[0] in adhesive.specification and "soluble in acetone" in adhesive.specification
    service = made()[-1]
    assert service.title == "Replace a piezo (service)" and not service.parts
    assert any("acetone" in tool for tool in service.tools)
    text = " ".join(service.sentences)
    order = [text.index(words) for words in ("take it off", "Clamps open", "Acetone", "draw the piezo out", "bond the")]
    assert order == sorted(order)
    plain = made("teeth.fitted=false", values=replace(VALUES, magnet_pull=None))[-1]
    assert plain.title == service.title and "Acetone" in " ".join(plain.sentences)


def test_words_figures_and_torques_of_the_steps() -> None:
    """Digits occur only in names; all numbers are figures in braces."""
    for step in step_templates(thesis(), VALUES):
        for text in (*step["sentences"], *step["tools"]):
            assert not re.search(r"\d", re.sub(r"\{\w+\}|height pin [12]|pocket 1|piezos 1 and 2", "", text)), text
    keys = set(packaged_machine().schema())
    for step in made():
        for name, figure in step.figures.items():
            origins = figure.origin.split(", ")
            known = {CALCULATED, "list of parts", "threads"}
            declared = figure.origin.partition(": ")[0] in MADE
            assert declared or all(origin in keys | known for origin in origins), name
            assert "e+" not in figure.text and "e-" not in figure.text
            torque = step.torque.text if step.torque else ""
            assert any(figure.text in text for text in (*step.sentences, *step.tools, torque))
    before = made()
    after = made("screws.way.torque=17 N*m", "base.setting_pin_hole=5 mm", "actuator.bias_voltage=60 V")
    assert [step.torque.text for step in before if step.torque] == ["15 N·m", "3 N·m", "8 N·m", "6 N·m"]
    assert [step.torque.text for step in after if step.torque] == ["17 N·m", "3 N·m", "8 N·m", "6 N·m"]
    assert "in thirds to 17 N·m" in words(after) and "4 setting pins 5 mm" in words(after)
    assert "Piezos at 60 V" in words(after)


@pytest.mark.parametrize("name", [field.name for field in fields(ProcedureValues)])
def test_every_calculated_value_is_in_the_text(name: str) -> None:
    assert words(made(values=replace(VALUES, **{name: 0.3 * getattr(VALUES, name)}))) != words(made())


def test_height_of_the_tip_in_degrees() -> None:
    """Half a thou of shim over 1/8 inch of pitch, 1:20 and 360 degrees: 28.8 degrees."""
    text = words(made())
    assert "a degree by 0.44 µm" in text and "turn on by 29°" in text
    assert "shim 0.0005 in (0.0127 mm)" in text and "right to 6 µm: 14° of the key" in text
    assert "out by 3.1 turns: the tip will be 500 µm below its middle" in text


def test_without_teeth_or_with_a_thin_film() -> None:
    assert "The film wears by 0.9 µm of its 2 µm." in words(made())
    assert "stop after 322" in words(made(values=replace(VALUES, run_in_wear=3.1e-6, film_strokes=322.0)))
    plain = made("teeth.fitted=false", values=replace(VALUES, magnet_pull=None))
    assert "magnet" not in words(plain)
    assert {use.part for step in plain for use in step.parts}.isdisjoint({"magnet", "tooth_bar", "bar_screw"})
    assert len(plain) == len(made()) - 4
