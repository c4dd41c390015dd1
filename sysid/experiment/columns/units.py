"""Units as instruments write them in headers: `Nm`, `sec`, `m/s2`, `U/min`; read as the unit they can only mean."""

import re
from collections.abc import Iterator
from functools import cache

from stagecad.parameters.errors import InputError
from stagecad.parameters.units import SYMBOLS, unit_dimension, written_out

_SPELLINGS = {
    "Nm": "N*m",
    "mNm": "mN*m",
    "uNm": "uN*m",
    "kNm": "kN*m",
    "Ncm": "N*cm",
    "Nmm": "N*mm",
    "bits": "bit",
    "Ohm": "ohm",
    "lb": "lbf",
    "lbs": "lbf",
}
_WHOLE: dict[str, str] = dict.fromkeys(
    ("1/min", "min^-1", "min-1", "r/min", "rev/min", "u/min", "umdr/min", "upm"), "rpm"
)
_WHOLE |= dict.fromkeys(("tr/min", "t/min", "giri/min"), "rpm")
_WHOLE |= {"rps": "rev/s", "u/s": "rev/s", "r/s": "rev/s", "tr/s": "rev/s", "ips": "in/s"}
_MASS_TIMES_LENGTH = re.compile(
    r"(?P<mass>kg|g|oz|lbs?)\*(?P<length>in|ft|mm|cm|m)|(?P<first>in|ft)\*(?P<last>oz|lbs?)"
)
"""Torques of motors' data sheets, where the pound, ounce or kilogram is a force."""


@cache
def column_unit(text: str) -> str | None:
    """The unit meant by the text of a header, in the symbols of `stagecad.parameters.units`; None if there is none."""
    written = text.strip()
    if not written:
        return None
    if written.casefold() in _WHOLE:
        return _WHOLE[written.casefold()]
    if written.startswith("%"):
        # Of full scale or of a rated value.
        return "%"
    if _known(written) and not _MASS_TIMES_LENGTH.fullmatch(written):
        return written
    plain = re.sub(r"(?<=[A-Za-z])(-?\d)", r"^\1", re.sub(r"(?<=[A-Za-z0-9])\s*[.·× -]\s*(?=[A-Za-z])", "*", written))
    plain = re.sub(r"[A-Za-z%]+", lambda match: _symbol(match[0]), plain)
    if (torque := _MASS_TIMES_LENGTH.fullmatch(plain)) is not None:
        mass, length = torque["mass"] or torque["last"], torque["length"] or torque["first"]
        plain = f"{mass.rstrip('s')}f*{length}"
    return plain if _known(plain) else None


def unit_endings(name: str) -> Iterator[tuple[str, str]]:
    """The ways to read a name such as `position_mm` as a name and a unit behind it."""
    parts = re.split(r"[\s_]+", name.strip())
    for k in range(1, len(parts)):
        unit = column_unit("/".join(part for part in parts[k:] if part != "per"))
        if unit is not None:
            yield "_".join(parts[:k]), unit


def _symbol(symbol: str) -> str:
    if symbol in SYMBOLS:
        return symbol
    return _SPELLINGS.get(symbol) or written_out(symbol) or symbol


def _known(unit: str) -> bool:
    try:
        unit_dimension(unit)
    except InputError:
        return False
    return True
