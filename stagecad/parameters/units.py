"""Quantities as text: a number, an optional space, a unit made of known symbols with ``*``, ``/`` and ``^``.

Inside the program a number is a plain float in SI; text with a unit occurs in files, on the command line and in
reports, and is read and written only here. The table of units is small and closed on purpose: an unknown symbol is an
error, never guessed.

Rules
- Radians are a separate dimension: `N*m` differs from `N*m/rad`, and `rad` is not a bare number.
- A bare number is accepted only for a dimensionless quantity; ``inf`` is bare for any dimension.
- An absolute temperature (`degC`, `degF`, `K`) is kept in `degC`; a difference has the unit `K`, and there `degC`
  counts as a kelvin. In products (`um/m/degC`) a temperature is always a difference.
- `%`, `ppm`, `count` and `bit` are dimensionless.
"""

import math
import re
import tomllib
from difflib import SequenceMatcher
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

from stagecad.parameters.errors import InputError, require

BASES = ("m", "kg", "s", "A", "K", "rad")
Dimension = tuple[Fraction | int, ...]
"""Exponents of metre, kilogram, second, ampere, kelvin and radian; integers where they are whole, which are quick."""

ABSOLUTE_ZERO = -273.15
_ABSOLUTE = {"K": ABSOLUTE_ZERO, "mK": ABSOLUTE_ZERO, "degF": -32.0 / 1.8}
"""Zero of the units of an absolute temperature, degC."""


def _power(*exponents: int) -> Dimension:
    return (*exponents, *[0] * (len(BASES) - len(exponents)))


DIMENSIONLESS = _power()

_TABLES = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
_EXPONENTS = {quantity: _power(*exponents) for quantity, exponents in _TABLES["exponents"].items()}

SYMBOLS: dict[str, tuple[float, Dimension]] = {
    symbol: (size, _EXPONENTS[quantity]) for symbol, (size, quantity) in _TABLES["units"].items()
}
"""Every unit symbol: its size in SI, and its dimension."""

for _symbol, (_size, _quantity, _prefixes) in _TABLES["prefixed"].items():
    SYMBOLS[_symbol] = (_size, _EXPONENTS[_quantity])
    for _prefix in _prefixes.split():
        _larger = 1.0 if _prefix + _symbol == "kg" else _size * _TABLES["prefixes"][_prefix]
        SYMBOLS[_prefix + _symbol] = (_larger, _EXPONENTS[_quantity])

_INTENDED = {other: symbol for symbol, others in _TABLES["spellings"].items() for other in others.split()}
"""The symbol that another spelling stands for."""
_FORCE_TIMES = re.compile(r"([numkM])?N([num]?[ms])")

_NUMBER = re.compile(r"[+-]?(?:inf(?![A-Za-z])|(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)")
_DEVIATION = re.compile(r"\s*(?:\+-|\+/-|±)\s*")
_FACTOR = re.compile(r"(?P<symbol>[A-Za-z%]+|1)(?:\^(?P<power>-?[0-9]+(?:\.[0-9]+)?))?")
_TYPOGRAPHIC = str.maketrans(
    {"µ": "u", "μ": "u", "·": "*", "⋅": "*", "−": "-", "²": "^2", "³": "^3", "°": "deg", "Ω": "ohm", "\u2126": "ohm"}
)


def si_unit(dimension: Dimension) -> str:
    """The SI unit of a dimension, in base units (`kg*m/s^2`); empty for a dimensionless one."""

    def power_text(base: str, power: Fraction | int) -> str:
        exponent = str(power) if power.denominator == 1 else f"{float(power):g}"
        return base if power == 1 else f"{base}^{exponent}"

    up = [power_text(base, power) for base, power in zip(BASES, dimension) if power > 0]
    down = [power_text(base, -power) for base, power in zip(BASES, dimension) if power < 0]
    if not up and not down:
        return ""
    return "/".join(["*".join(up) or "1", *down])


def _plain(text: str) -> str:
    """Text with typographic signs replaced by ASCII."""
    return text.replace("°C", "degC").replace("°F", "degF").translate(_TYPOGRAPHIC)


@cache
def _unit(unit: str) -> tuple[float, Dimension]:
    """Size in SI and dimension of a unit; an InputError where it is no product of known symbols."""
    text = _plain(unit).strip()
    size, dimension = 1.0, list(DIMENSIONLESS)
    position, sign = 0, 1
    while text:
        match = _FACTOR.match(text, position)
        if match is None:
            raise InputError(f"{quoted(unit)} is not a unit; write symbols joined by *, / and ^, like kg*m^2 or N*s/m")
        symbol = match["symbol"]
        if symbol != "1":
            if symbol not in SYMBOLS:
                raise InputError(f"unknown unit symbol '{symbol}'; did you mean '{nearest_symbol(symbol)}'?")
            try:
                power = sign * Fraction(match["power"] or "1")
                factor, exponents = SYMBOLS[symbol]
                size *= factor ** float(power)
            except (OverflowError, ValueError):
                # Python converts no integer of more than 4300 digits.
                size = math.inf
            require(0.0 < size < math.inf, f"{quoted(unit)} is not a unit; its powers overflow")
            dimension = [total + power * exponent for total, exponent in zip(dimension, exponents)]
        position = match.end()
        if position == len(text):
            break
        sign = {"*": 1, "/": -1}.get(text[position], 0)
        require(sign, f"{quoted(unit)} is not a unit; write symbols joined by *, / and ^, like kg*m^2 or N*s/m")
        position += 1
    return size, tuple(part.numerator if part.denominator == 1 else part for part in dimension)


def nearest_symbol(symbol: str) -> str:
    """The unit symbol, or product of two, most likely intended by an unknown symbol."""
    intended = _INTENDED.get(symbol.lower())
    if intended is not None:
        return intended
    product = _FORCE_TIMES.fullmatch(symbol)
    if product is not None:
        # `Nm` is not a nanometre.
        return f"{product[1] or ''}N*{product[2]}"

    def likeness(other: str) -> tuple[float, float, str]:
        folded = SequenceMatcher(None, symbol.lower(), other.lower()).ratio()
        return folded, SequenceMatcher(None, symbol, other).ratio(), other

    return max(SYMBOLS, key=likeness)


def written_out(symbol: str) -> str | None:
    """The symbol of a unit written in another way, such as `sec` or `newtons`; None if it is not known."""
    return _INTENDED.get(symbol.lower())


def unit_dimension(unit: str) -> Dimension:
    """Dimension of a unit; an empty text is dimensionless.

    Raises:
        InputError: naming the unknown symbol and the nearest known one.
    """
    return _unit(unit)[1]


def si_of(unit: str) -> str:
    """SI unit of a quantity that a design keeps in `unit`: geometry in mm and deg, all else in SI already."""
    return {"mm": "m", "deg": "rad"}.get(unit, unit)


def to_si(value: float, unit: str) -> float:
    """`value` in `unit` as SI. A temperature in degC stays in degC."""
    size = _unit(unit)[0]
    # A division rounds once: 13 mm is 0.013 m, not 0.013000000000000001 m.
    return value / round(1 / size) if _is_fraction(size) else value * size


def from_si(value: float, unit: str) -> float:
    """`value` in SI as a number of `unit`. A temperature in degC stays in degC."""
    size = _unit(unit)[0]
    return value * round(1 / size) if _is_fraction(size) else value / size


def _is_fraction(size: float) -> bool:
    """Whether a whole number of the unit makes one SI unit, as with a millimetre."""
    return size < 1.0 and 1 / size < 2**53 and 1 / round(1 / size) == size


def parse_quantity(text: Any, unit: str = "m", where: str = "") -> float:
    """Read a quantity.

    Args:
        text: as written by the user, or a number straight from a file (then only where `unit` is dimensionless).
        unit: any unit of the required dimension; empty for a dimensionless one, `degC` for an absolute temperature.
        where: file and key (or row), put before the message.

    Returns:
        The value in SI.

    Raises:
        InputError: no number, unknown symbol, or a dimension other than that of `unit`.
    """
    value, std = parse_uncertain(text, unit, where)
    if std is not None:
        raise InputError(f"{_place(where)}{quoted(text)} has an uncertainty, which is not allowed here")
    return value


def parse_uncertain(text: Any, unit: str = "m", where: str = "") -> tuple[float, float | None]:
    """Read a quantity with an optional standard deviation: ``1.79 +- 0.01 kg``.

    Arguments and errors as `parse_quantity`.

    Returns:
        The value and its standard deviation (or None), both in SI.
    """
    place = _place(where)
    shown = quoted(text)
    number, std, written = _split(text, shown, place)
    if not written:
        if unit_dimension(unit) != DIMENSIONLESS and not math.isinf(number):
            raise InputError(f"{place}{shown} has no unit; write it with one, like '{number:g} {unit}'")
        return number, std
    try:
        dimension = unit_dimension(written)
    except InputError as error:
        raise InputError(f"{place}{shown}: {error}") from None
    if dimension != unit_dimension(unit):
        if unit_dimension(unit) == DIMENSIONLESS:
            raise InputError(f"{place}{shown} has a unit, but a bare number is needed, like '{number:g}'")
        raise InputError(f"{place}{shown} has the wrong dimension; wanted '{unit}' or a multiple of it")
    offset = _ABSOLUTE.get(_plain(written).strip(), 0.0) if unit == "degC" else 0.0
    return to_si(number, written) + offset, None if std is None else to_si(std, written)


def parse_any(text: Any) -> tuple[float, float | None, Dimension]:
    """Value and standard deviation (or None) of a quantity of any dimension in SI, and its dimension."""
    number, std, written = _split(text, quoted(text), "")
    return to_si(number, written), None if std is None else to_si(std, written), unit_dimension(written)


def quoted(text: Any) -> str:
    """The user's text as shown in a one-line message."""
    if not isinstance(text, str):
        return str(text).lower()
    short = text if len(text) <= 60 else f"{text[:57]}..."
    return f"'{short}'" if short.isprintable() else repr(short)


def _place(where: str) -> str:
    return f"{where}: " if where else ""


def _split(text: Any, shown: str, place: str) -> tuple[float, float | None, str]:
    """Number, deviation and unit as written."""
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        raise InputError(f"{place}{shown} is not a quantity; write a number with its unit in quotes, like '12 mm'")
    if not isinstance(text, str):
        value = float(text)
        require(not math.isnan(value), f"{place}{shown} is not a number")
        return value, None, ""
    plain = _plain(text).strip()
    match = _NUMBER.match(plain)
    if match is None:
        raise InputError(f"{place}{shown} is not a quantity; write a number and a unit, like '12 mm'")
    value, end = _number(match[0], shown, place), match.end()
    std = None
    between = _DEVIATION.match(plain, end)
    if between is not None:
        deviation = _NUMBER.match(plain, between.end())
        if deviation is None:
            raise InputError(f"{place}{shown} has no number after +-; write it like '1.79 +- 0.01 kg'")
        std, end = _number(deviation[0], shown, place), deviation.end()
        require(0.0 <= std < math.inf, f"{place}{shown} has an uncertainty that is not a positive number")
    rest = plain[end:].strip()
    if rest[:1] in (".", "+", "-", ",") or (rest[:1].isdigit() and not rest.startswith("1/")):
        raise InputError(f"{place}{shown} is not a quantity; one number, then one unit, like '12 mm'")
    return value, std, rest


def _number(digits: str, shown: str, place: str) -> float:
    value = float(digits)
    require(not math.isinf(value) or "inf" in digits, f"{place}{shown} is too large for a floating-point number")
    return value


_SCALED_UNITS: dict[str, list[str]] = {unit: shown.split() for unit, shown in _TABLES["shown"].items()}


def format_quantity(value_si: float, unit: str = "", digits: int = 4) -> str:
    """A quantity as text with a suitable prefix and `digits` significant digits.

    Args:
        value_si: in SI (an absolute temperature in degC).
        unit: the SI unit (`N/m`), or another unit, which is then kept (`mm`).
        digits: significant digits.
    """
    if math.isnan(value_si):
        return "nan"
    if math.isinf(value_si):
        return "inf" if value_si > 0 else "-inf"
    shown = unit
    scaled = _SCALED_UNITS.get(unit, ())
    if scaled and value_si != 0.0:
        # A value that rounds up to the next step is shown in the next step: 999.96 mm with four digits is 1 m.
        rounded = abs(float(f"{value_si:.{digits}g}"))
        shown = next((step for step in reversed(scaled) if rounded / _unit(step)[0] >= 1.0), scaled[0])
    number = f"{from_si(value_si, shown):.{digits}g}"
    return f"{number} {shown}" if shown else number


def attributes(one: object, *names: str) -> dict[str, Any]:
    """Attributes of an object by their names, for a document."""
    return {name: getattr(one, name) for name in names}


def as_json(
    value: float, unit: str, std: float | None = None, low: float | None = None, high: float | None = None
) -> dict[str, Any]:
    """A quantity in a JSON document: `{"value": 1.79, "unit": "kg"}`, in SI.

    A fitted quantity also has its standard deviation and the bounds of its 95 % interval.
    """
    document: dict[str, Any] = {"value": value, "unit": unit}
    document.update({name: item for name, item in (("std", std), ("low", low), ("high", high)) if item is not None})
    return document
