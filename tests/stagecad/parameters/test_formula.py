"""Units, and formulas of parameters with units."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stagecad.parameters.errors import InputError
from stagecad.parameters.formula import FormulaError, Value, parse_formula
from stagecad.parameters.load import changed_text, design_from_text, diff, load_design
from stagecad.parameters.rules import violations
from stagecad.parameters.units import (
    DIMENSIONLESS,
    SYMBOLS,
    as_json,
    format_quantity,
    from_si,
    parse_quantity,
    parse_uncertain,
    si_unit,
    to_si,
    unit_dimension,
)
from tests.reference.tables import cases
from tests.refusals import refused

START = 'extends = "thesis"\n'
REFUSED = [*cases("units", "refused"), (math.nan, "", "is not a number"), (None, "m", "is not a quantity")]


def _value(text: str, unit: str = "", **known: float) -> float:
    parameters = {f"a.{name}": Value(value, unit_dimension("m")) for name, value in known.items()}
    return parse_formula(text).value(parameters.__getitem__, unit, "key")


@pytest.mark.parametrize("text, unit, expected", [
    *cases("formulas", "values"), ("= a.x*2/sqrt(3)", "m", 0.2 / math.sqrt(3)),
    ("=sqrt(a.x^2 + a.y^2)", "m", math.hypot(0.1, 0.2)), ("=atan(1)", "deg", math.pi / 4),
])  # fmt: skip
def test_values_with_units(text: str, unit: str, expected: float) -> None:
    assert _value(text, unit, x=0.1, y=0.2) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("text, unit, words", cases("formulas", "units"))
def test_units_that_do_not_match(text: str, unit: str, words: str) -> None:
    refused(words.replace("^", r"\^"), _value, text, unit, x=0.1)


@pytest.mark.parametrize("text", [*cases("formulas", "refused"), "=" + "(" * 400])
def test_what_is_no_formula_is_refused(text: str) -> None:
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


def test_formulas_in_files_and_overrides_carry_a_change_through() -> None:
    design = design_from_text(START + '[pads]\nwidth = "=pads.length/pads.ratio"\nlength = "26 mm"\n', "s.toml")
    entry = design.entry("pads.width")
    assert (entry.value, entry.text, entry.formula) == (13.0, "13 mm", "=pads.length/pads.ratio")
    assert design.si("pads.width") == pytest.approx(0.013)
    # Piezos 14 mm farther apart: holder, pocket, clamp, bars and ways follow, and no rule is violated.
    design = load_design(None, ["actuator.piezo_spacing=60 mm"])
    assert violations(design) == []
    assert design.holder.diameter >= 2 * (60 / math.sqrt(3) + design.holder.bore_diameter / 2)
    assert design.base.pocket_diameter == pytest.approx(design.holder.diameter + 0.03)
    wider = load_design(None, ["actuator.piezo_spacing=60.5 mm"])
    assert violations(wider) == [] and wider.base.width > design.base.width
    design = load_design(None, ["base.pocket_diameter=76.03 mm"])
    assert (design.base.pocket_diameter, design.entry("base.pocket_diameter").formula) == (76.03, "")
    assert load_design(None, ["base.pocket_diameter==holder.diameter + 30 um"]).digest == design.digest


@pytest.mark.parametrize("content, words", cases("formulas", "faults"))
def test_faults_name_file_and_key(content: str, words: str) -> None:
    with pytest.raises(InputError) as error:
        design_from_text(START + content, "s.toml")
    assert words in str(error.value) and str(error.value).startswith("s.toml: ")


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


READ = [
    *cases("units", "read"),
    ("180 deg", "rad", math.pi),
    ("3600 arcsec", "rad", math.pi / 180),
    ("60 rpm", "rad/s", 2 * math.pi),
    *((text, unit, float(text)) for text, unit in (("inf", "N"), ("-inf", "m"), ("inf", ""))),
]


@pytest.mark.parametrize(("text", "unit", "value"), READ)
def test_reads(text: str, unit: str, value: float) -> None:
    assert parse_quantity(text, unit) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(("text", "unit", "message"), REFUSED)
def test_refuses_in_one_line_that_names_the_place(text: object, unit: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_quantity(text, unit, "stage.toml: stage.length")
    line = str(caught.value)
    assert line.startswith("stage.toml: stage.length: ") and message in line and "\n" not in line


def test_uncertain() -> None:
    assert parse_uncertain("1.79 +- 0.01 kg", "kg") == (1.79, 0.01)
    assert parse_uncertain("1.79±10e-3kg", "kg") == (1.79, 0.01)
    assert parse_uncertain("20 +- 1 mm", "m") == (0.02, 0.001)
    assert parse_uncertain("293.15 +- 0.5 K", "degC") == (pytest.approx(20.0), 0.5)
    assert parse_uncertain("5 N", "N") == (5.0, None)
    for text in ("1.79 +- kg", "1.79 +- -0.01 kg", "1.79 +- inf kg", "1 kg +- 0.1 kg"):
        with pytest.raises(InputError):
            parse_uncertain(text, "kg")


def test_infinities_and_relations_between_units() -> None:
    assert parse_quantity("inf N", "N") == math.inf
    with pytest.raises(InputError):
        parse_quantity("inf N", "m")
    for one, other in cases("units", "equal"):
        assert unit_dimension(one) == unit_dimension(other)
        assert to_si(1.0, one) == pytest.approx(to_si(1.0, other), rel=1e-12)
    assert unit_dimension("N*m") != unit_dimension("N*m/rad")
    assert to_si(13.0, "mm") == 0.013
    assert parse_quantity("38.1 mm") == 0.0381
    assert from_si(0.0127, "mm") == 12.7


finite = st.floats(-1e30, 1e30).filter(lambda v: v == 0 or abs(v) > 1e-30)
powers = st.tuples(st.sampled_from(sorted(SYMBOLS)), st.sampled_from([1, 2, 3, -1, -2]))
units = st.lists(powers, min_size=1, max_size=3).map(
    lambda parts: "*".join(name if power == 1 else f"{name}^{power}" for name, power in parts)
)
SHOWN = ["m", "N", "kg", "Pa", "N/m", "m/s", "s", "rad", "1/K", "J", "F", "kg*m^2", "", "degC", "m^2"]


@given(value=finite, unit=units)
def test_what_is_written_is_read_back(value: float, unit: str) -> None:
    parsed = parse_quantity(f"{value!r} {unit}", unit)
    expected = value if unit == "degC" else to_si(value, unit)
    assert parsed == pytest.approx(expected, rel=1e-12) and from_si(parsed, unit) == pytest.approx(value, rel=1e-12)


@given(value=finite, unit=st.sampled_from(SHOWN))
def test_what_people_are_shown_is_read_back(value: float, unit: str) -> None:
    assert parse_quantity(format_quantity(value, unit, digits=15), unit) == pytest.approx(value, rel=1e-13)


@given(unit=units)
def test_the_si_unit_of_a_dimension_has_that_dimension_and_size_one(unit: str) -> None:
    dimension = unit_dimension(unit)
    spelt = si_unit(dimension)
    assert unit_dimension(spelt) == dimension and to_si(1.0, spelt) == 1.0


@given(st.text(max_size=30))
def test_any_text_is_read_or_refused(text: str) -> None:
    found: float | str
    try:
        found = parse_quantity(text, "m", "here")
    except InputError as error:
        found = str(error)
    assert found.isprintable() if isinstance(found, str) else not math.isnan(found)


def test_sensible_prefixes() -> None:
    lengths = [(0.27, "270 mm"), (2e-9, "2 nm"), (0.99996, "1 m"), (-0.0123456, "-12.35 mm")]
    forces = [(0.0, "0 N"), (5.893e-9, "5.893 nN"), (math.inf, "inf")]
    others = [("N/m", 1.5e8, "150 N/um"), ("Pa", 2.07e11, "207 GPa"), ("kg", 0.04, "40 g"), ("", 5.0, "5")]
    for unit, value, shown in [*(("m", *one) for one in lengths), *(("N", *one) for one in forces), *others]:
        assert format_quantity(value, unit) == shown


def test_json_has_interval_only_where_fitted() -> None:
    assert as_json(1.79, "kg") == {"value": 1.79, "unit": "kg"}
    interval = {"std": 0.1, "low": 0.8, "high": 1.2}
    assert as_json(1.0, "N", **interval) == {"value": 1.0, "unit": "N", **interval}
