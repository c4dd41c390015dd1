"""Formulas in a parameter file: values, units, circles, what is refused, and what follows from a changed value."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stagecad.parameters.errors import InputError
from stagecad.parameters.formula import FormulaError, Value, parse_formula
from stagecad.parameters.load import changed_text, design_from_text, diff, load_design
from stagecad.parameters.rules import violations
from stagecad.parameters.units import DIMENSIONLESS, unit_dimension
from tests.reference.tables import cases

START = 'extends = "thesis"\n'


def _value(text: str, unit: str = "", **known: float) -> float:
    parameters = {f"a.{name}": Value(value, unit_dimension("m")) for name, value in known.items()}
    return parse_formula(text).value(parameters.__getitem__, unit, "key")


@pytest.mark.parametrize(
    "text, unit, expected",
    [
        *cases("formulas", "values"),
        ("= a.x*2/sqrt(3)", "m", 0.2 / math.sqrt(3)),
        ("=sqrt(a.x^2 + a.y^2)", "m", math.hypot(0.1, 0.2)),
        ("=atan(1)", "deg", math.pi / 4),
    ],
)
def test_values_with_units(text: str, unit: str, expected: float) -> None:
    assert _value(text, unit, x=0.1, y=0.2) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("text, unit, words", cases("formulas", "units"))
def test_units_that_do_not_match(text: str, unit: str, words: str) -> None:
    with pytest.raises(InputError, match=words.replace("^", r"\^")):
        _value(text, unit, x=0.1)


@pytest.mark.parametrize("text", [*cases("formulas", "refused"), "=" + "(" * 400])
def test_what_is_no_formula_is_refused(text: str) -> None:
    """Nothing but arithmetic is accepted."""
    with pytest.raises(FormulaError):
        parse_formula(text)


@given(st.lists(st.floats(0.1, 10), min_size=2, max_size=5), st.data())
def test_arithmetic_agrees_with_python(numbers: list[float], data: st.DataObject) -> None:
    """Sums, products and brackets of numbers, against Python's own evaluation of the same text."""
    text = f"{numbers[0]:.3f}"
    for number in numbers[1:]:
        sign = data.draw(st.sampled_from("+-*/"))
        text = f"({text}) {sign} {number:.3f}" if data.draw(st.booleans()) else f"{number:.3f} {sign} {text}"
    try:
        expected = eval(text)
    except ZeroDivisionError:
        with pytest.raises((FormulaError, InputError)):
            parse_formula(f"={text}").value(lambda key: Value(0.0, DIMENSIONLESS), "", "key")
        return
    found = parse_formula(f"={text}").value(lambda key: Value(0.0, DIMENSIONLESS), "", "key")
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_formula_in_a_file() -> None:
    design = design_from_text(START + '[pads]\nwidth = "=pads.length/pads.ratio"\nlength = "26 mm"\n', "s.toml")
    entry = design.entry("pads.width")
    assert (entry.value, entry.text, entry.formula) == (13.0, "13 mm", "=pads.length/pads.ratio")
    assert design.si("pads.width") == pytest.approx(0.013)


@pytest.mark.parametrize("content, words", cases("formulas", "faults"))
def test_faults_name_file_and_key(content: str, words: str) -> None:
    with pytest.raises(InputError) as error:
        design_from_text(START + content, "s.toml")
    assert words in str(error.value) and str(error.value).startswith("s.toml: ")


def test_packaged_formulas_carry_one_change_through() -> None:
    """Piezos 14 mm farther apart: holder, pocket, clamp, bars and ways follow, and no rule is violated."""
    design = load_design(None, ["actuator.piezo_spacing=60 mm"])
    assert violations(design) == []
    assert design.holder.diameter >= 2 * (60 / math.sqrt(3) + design.holder.bore_diameter / 2)
    assert design.base.pocket_diameter == pytest.approx(design.holder.diameter + 0.03)
    wider = load_design(None, ["actuator.piezo_spacing=60.5 mm"])
    assert violations(wider) == [] and wider.base.width > design.base.width


def test_override_of_a_key_with_a_formula() -> None:
    design = load_design(None, ["base.pocket_diameter=76.03 mm"])
    assert (design.base.pocket_diameter, design.entry("base.pocket_diameter").formula) == (76.03, "")
    other = load_design(None, ["base.pocket_diameter==holder.diameter + 30 um"])
    assert other.digest == design.digest


def test_differences_write_back_and_origins(tmp_path: Path) -> None:
    """A formula with the same value is not a difference; a value written over a formula replaces it."""
    text = START + '[pads]\nwidth = {value = "=pads.length/2", tolerance = "X.X", origin = "assumed: 2:1"}\n'
    design = design_from_text(text, "s.toml")
    assert [item.key for item in diff(load_design(), design)] == ["pads.width"]  # its origin
    assert design.entry("pads.width").origin == "assumed: 2:1"
    changed = changed_text(text, "s.toml", {"pads.length": ("24.2 mm", "measured: probe")})
    assert design_from_text(changed, "s.toml").pads.width == 12.1
    replaced = changed_text(text, "s.toml", {"pads.width": ("12.1 mm", "measured: probe")})
    entry = design_from_text(replaced, "s.toml").entry("pads.width")
    assert (entry.value, entry.formula, entry.origin) == (12.1, "", "measured: probe")
