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

READ = [
    ("12 mm", "m", 0.012),
    ("12mm", "m", 0.012),
    ("  12  mm ", "m", 0.012),
    ("+1e-3 m", "m", 1e-3),
    ("-.5 um", "m", -5e-7),
    ("0.375 in", "m", 0.009525),
    ("30 mil", "m", 0.000762),
    ("20 g", "kg", 0.02),
    ("1.79kg", "kg", 1.79),
    ("5752 N/m", "N/m", 5752.0),
    ("30 N/um", "N/m", 3e7),
    ("2 kg*m^2", "kg*m^2", 2.0),
    ("3 N*s/m", "N*s/m", 3.0),
    ("3 kg/s", "N*s/m", 3.0),
    ("4 N*m/rad", "N*m/rad", 4.0),
    ("180 deg", "rad", math.pi),
    ("3600 arcsec", "rad", math.pi / 180),
    ("60 rpm", "rad/s", 2 * math.pi),
    ("207 GPa", "N/m^2", 2.07e11),
    ("1 bar", "Pa", 1e5),
    ("1 MPa*m/s", "W/m^2", 1e6),
    ("1.3 um/m/K", "1/K", 1.3e-6),
    ("1.3 ppm/K", "1/K", 1.3e-6),
    ("1.3 um/m/degC", "1/K", 1.3e-6),
    ("1.3e-6 1/K", "1/K", 1.3e-6),
    ("5 kHz", "Hz", 5e3),
    ("2 1/s", "Hz", 2.0),
    ("9 ms", "s", 9e-3),
    ("2 h", "s", 7200.0),
    ("1.4 uF", "F", 1.4e-6),
    ("1 V*A", "W", 1.0),
    ("1 C/s", "A", 1.0),
    ("1 ohm", "V/A", 1.0),
    ("1 H", "V*s/A", 1.0),
    ("1.2 T", "V*s/m^2", 1.2),
    ("10 %", "", 0.1),
    ("12 bit", "", 12.0),
    ("0.3", "", 0.3),
    (0.3, "", 0.3),
    (3, "", 3.0),
    ("inf", "N", math.inf),
    ("-inf", "m", -math.inf),
    ("inf", "", math.inf),
    ("20 degC", "degC", 20.0),
    ("293.15 K", "degC", 20.0),
    ("5 degC", "K", 5.0),
    ("5 K", "K", 5.0),
    ("20 °C", "degC", 20.0),
    ("2 µm", "m", 2e-6),
    ("1 N·m", "N*m", 1.0),
]


@pytest.mark.parametrize(("text", "unit", "value"), READ)
def test_reads(text: str, unit: str, value: float) -> None:
    assert parse_quantity(text, unit) == pytest.approx(value, rel=1e-14)


REFUSED = [
    ("12", "m", "has no unit"),
    (12, "m", "12 has no unit"),
    ("12 kg", "m", "wrong dimension; wanted 'm'"),
    ("3 N*m", "N*m/rad", "wrong dimension"),
    ("3 N*m/rad", "N*m", "wrong dimension"),
    ("3 rad", "m", "wrong dimension"),
    ("3", "rad", "has no unit"),
    ("3 rad", "", "a bare number is needed"),
    ("3 1/s", "rad/s", "wrong dimension"),
    ("12 mmm", "m", "did you mean 'mm'"),
    ("12 MM", "m", "did you mean 'mm'"),
    ("2 sec", "s", "did you mean 's'"),
    ("2 Seconds", "s", "did you mean 's'"),
    ("5 msec", "s", "did you mean 'ms'"),
    ("3 micron", "m", "did you mean 'um'"),
    ("5 Nm", "N*m", "did you mean 'N*m'"),
    ("5 Ns/m", "N*s/m", "did you mean 'N*s'"),
    ("5 mNmm", "N*m", "did you mean 'mN*mm'"),
    ("5 KHz", "Hz", "did you mean 'kHz'"),
    ("5 newton", "N", "unknown unit symbol 'newton'"),
    ("8..20mm", "m", "one number, then one unit"),
    ("1 Ra", "m", "unknown unit symbol 'Ra'"),
    ("1,5 mm", "m", "one number, then one unit"),
    ("12 mm mm", "m", "is not a unit"),
    ("12 mm^", "m", "is not a unit"),
    ("12 *mm", "m", "is not a unit"),
    ("12 mm*", "m", "is not a unit"),
    ("12 (mm)", "m", "is not a unit"),
    ("12 m**2", "m^2", "is not a unit"),
    ("mm", "m", "is not a quantity"),
    ("", "m", "is not a quantity"),
    ("nan m", "m", "is not a quantity"),
    (math.nan, "", "is not a number"),
    ("1e999 m", "m", "too large for a floating-point number"),
    (True, "", "is not a quantity"),
    (None, "m", "is not a quantity"),
    ([1], "m", "is not a quantity"),
    ("1.79 +- 0.01 kg", "kg", "has an uncertainty"),
    ("1 km^9999999", "m", "its powers overflow"),
]


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
    for one, other in [
        ("N*m", "J"),
        ("J/s", "W"),
        ("Pa*m^2", "N"),
        ("V*A", "W"),
        ("F*V", "C"),
        ("T*A*m", "N"),
        ("H*A^2", "J"),
        ("ohm*A", "V"),
        ("psi*in^2", "lbf"),
    ]:
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
