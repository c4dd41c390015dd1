"""Quantities: what is read, what is refused, and that writing and reading agree."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stagecad.parameters.errors import InputError
from stagecad.parameters.units import (
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


REFUSED = [*cases("units", "refused"), (math.nan, "", "is not a number"), (None, "m", "is not a quantity")]


@pytest.mark.parametrize(("text", "unit", "message"), REFUSED)
def test_refuses_in_one_line_that_names_the_place(text: object, unit: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_quantity(text, unit, "stage.toml: stage.length")
    line = str(caught.value)
    assert line.startswith("stage.toml: stage.length: ")
    assert message in line
    assert "\n" not in line


def test_uncertain() -> None:
    assert parse_uncertain("1.79 +- 0.01 kg", "kg") == (1.79, 0.01)
    assert parse_uncertain("1.79±10e-3kg", "kg") == (1.79, 0.01)
    assert parse_uncertain("20 +- 1 mm", "m") == (0.02, 0.001)
    assert parse_uncertain("293.15 +- 0.5 K", "degC") == (pytest.approx(20.0), 0.5)
    assert parse_uncertain("5 N", "N") == (5.0, None)
    for text in ("1.79 +- kg", "1.79 +- -0.01 kg", "1.79 +- inf kg", "1 kg +- 0.1 kg"):
        with pytest.raises(InputError):
            parse_uncertain(text, "kg")


def test_a_bare_infinity_has_any_dimension_and_a_written_unit_must_still_fit() -> None:
    assert parse_quantity("inf N", "N") == math.inf
    with pytest.raises(InputError):
        parse_quantity("inf N", "m")


def test_relations_between_units_that_physics_fixes() -> None:
    for one, other in cases("units", "equal"):
        assert unit_dimension(one) == unit_dimension(other)
        assert to_si(1.0, one) == pytest.approx(to_si(1.0, other), rel=1e-12)
    assert unit_dimension("N*m") != unit_dimension("N*m/rad")


def test_exact_where_decimals_are_exact() -> None:
    assert to_si(13.0, "mm") == 0.013
    assert parse_quantity("38.1 mm") == 0.0381
    assert from_si(0.0127, "mm") == 12.7


finite = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e30, max_value=1e30).filter(
    lambda v: v == 0 or abs(v) > 1e-30
)
units = st.lists(
    st.tuples(st.sampled_from(sorted(SYMBOLS)), st.sampled_from([1, 2, 3, -1, -2])), min_size=1, max_size=3
).map(lambda parts: "*".join(name if power == 1 else f"{name}^{power}" for name, power in parts))


@given(value=finite, unit=units)
def test_what_is_written_is_read_back(value: float, unit: str) -> None:
    parsed = parse_quantity(f"{value!r} {unit}", unit)
    expected = value if unit == "degC" else to_si(value, unit)
    assert parsed == pytest.approx(expected, rel=1e-12)
    assert from_si(parsed, unit) == pytest.approx(value, rel=1e-12)


@given(
    value=finite,
    unit=st.sampled_from(
        ["m", "N", "kg", "Pa", "N/m", "m/s", "s", "rad", "1/K", "J", "F", "kg*m^2", "", "degC", "m^2"]
    ),
)
def test_what_people_are_shown_is_read_back(value: float, unit: str) -> None:
    shown = format_quantity(value, unit, digits=15)
    assert parse_quantity(shown, unit) == pytest.approx(value, rel=1e-13)


@given(unit=units)
def test_the_si_unit_of_a_dimension_has_that_dimension_and_size_one(unit: str) -> None:
    dimension = unit_dimension(unit)
    spelt = si_unit(dimension)
    assert unit_dimension(spelt) == dimension
    assert to_si(1.0, spelt) == 1.0


@given(st.text(max_size=30))
def test_any_text_is_read_or_refused(text: str) -> None:
    found: float | str
    try:
        found = parse_quantity(text, "m", "here")
    except InputError as error:
        found = str(error)
    assert found.isprintable() if isinstance(found, str) else not math.isnan(found)


def test_sensible_prefixes() -> None:
    shown = [(0.27, "m"), (1.5e8, "N/m"), (2e-9, "m"), (2.07e11, "Pa"), (0.04, "kg"), (0.99996, "m"), (0.0, "N")]
    assert [format_quantity(value, unit) for value, unit in shown] == [
        "270 mm",
        "150 N/um",
        "2 nm",
        "207 GPa",
        "40 g",
        "1 m",
        "0 N",
    ]
    assert format_quantity(-0.0123456, "m") == "-12.35 mm"
    assert format_quantity(math.inf, "N") == "inf"
    assert format_quantity(5.0) == "5"


def test_json_has_interval_only_where_fitted() -> None:
    assert as_json(1.79, "kg") == {"value": 1.79, "unit": "kg"}
    assert as_json(1.0, "N", std=0.1, low=0.8, high=1.2) == {
        "value": 1.0,
        "unit": "N",
        "std": 0.1,
        "low": 0.8,
        "high": 1.2,
    }
