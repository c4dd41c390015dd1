"""Which unit symbol was meant by one that is not known."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import SequenceMatcher

_WRITTEN_OUT = {
    "s": ("sec", "secs", "second", "seconds", "sek"),
    "ms": ("msec", "msecs", "millisecond", "milliseconds"),
    "us": ("usec", "microsecond", "microseconds"),
    "min": ("minute", "minutes"),
    "h": ("hr", "hrs", "hour", "hours"),
    "day": ("d", "days"),
    "m": ("meter", "meters", "metre", "metres"),
    "mm": ("millimeter", "millimeters", "millimetre", "millimetres"),
    "um": ("micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"),
    "in": ("inch", "inches"),
    "g": ("gram", "grams", "gr", "gm"),
    "kg": ("kilo", "kilos", "kilogram", "kilograms", "kgs"),
    "N": ("newton", "newtons"),
    "Pa": ("pascal", "pascals"),
    "V": ("volt", "volts"),
    "A": ("amp", "amps", "ampere", "amperes"),
    "T": ("tesla",),
    "Hz": ("hertz", "cps"),
    "rad": ("radian", "radians"),
    "deg": ("degree", "degrees"),
    "degC": ("celsius", "centigrade"),
    "K": ("kelvin", "kelvins"),
    "%": ("percent", "pct"),
}
"""Other ways to write a unit, many of which look more like a wrong symbol than like the right one."""

_MEANT = {other: symbol for symbol, others in _WRITTEN_OUT.items() for other in others}
_FORCE_TIMES = re.compile(r"([numkM])?N([num]?[ms])")


def nearest_symbol(symbol: str, known: Iterable[str]) -> str:
    """The unit symbol, or product of two, that was meant by one that is not known.

    Args:
        symbol: as written.
        known: every symbol there is.
    """
    meant = _MEANT.get(symbol.lower())
    if meant is not None:
        return meant
    product = _FORCE_TIMES.fullmatch(symbol)
    if product is not None:
        # `Nm` is not a nanometre.
        return f"{product[1] or ''}N*{product[2]}"

    def likeness(other: str) -> tuple[float, float, str]:
        folded = SequenceMatcher(None, symbol.lower(), other.lower()).ratio()
        return folded, SequenceMatcher(None, symbol, other).ratio(), other

    return max(known, key=likeness)
