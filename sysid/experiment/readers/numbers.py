"""Numbers as loggers write them: other minus signs, grouped thousands, Fortran exponents, a unit behind the number.

A number has one meaning here or none: what a mark means is decided by the file (`Dialect`) or by `[format]`.
"""

import re
from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from functools import cached_property
from typing import Any

import numpy as np

from stagecad.deferred import compute, pyarrow
from stagecad.parameters.errors import InputError
from sysid.experiment.column_settings import WORDS
from sysid.experiment.readers.base import Column, to_numpy
from sysid.experiment.toml_table import shown

MINUS = "−–‒‐‑﹣－⁃⁻\u00ad"
"""Signs that are written for a minus: U+2212, the dashes and full-width forms that keyboards give, the soft hyphen."""
NO_BREAK = "\u00a0\u2009\u202f"
"""Blanks between groups of three digits, besides the plain one: no-break, thin, narrow no-break (CGPM 2003)."""
APOSTROPHES = "'’_"

GAPS: tuple[str, ...] = ("", *WORDS["gaps"])
"""Cells that mean 'no number' in the output of C libraries, spreadsheets and data frames."""

_EXPONENT = r"(?:[eEdDqQ][+-]?\d+)?"
_NUMBER = rf"[+-]?(?:\d+\.?\d*|\.\d+){_EXPONENT}"
"""Regular expression (of RE2 too) of a number with a decimal point."""
_BARE_EXPONENT = re.compile(r"(.*\d*\.\d*)([+-]\d{3})")
"""Fortran leaves out the letter before an exponent of three digits."""
SCPI_OVERLOAD = 9.9e37
"""Instruments write this number for an overload, and one above it for 'not a number' (SCPI-1999, 7.2.1)."""
_POWER = re.compile(r"(?:\s*(?:[x×*·]\s*10\s*\^?|\*\^)|(?<=[\d.])\s*[eEdD])\s*(?=[+-]?\d+$)")
"""An exponent that is written out, such as ×10^-3 or *^-3 (Mathematica), or apart from its number."""
_HEXADECIMAL = re.compile(r"0[xX][0-9a-fA-F]+|[0-9a-fA-F]{2,}[hH]")


def is_hexadecimal(cell: str) -> bool:
    """Whether a cell is a count in hexadecimal digits, such as 0x1F."""
    return _HEXADECIMAL.fullmatch(cell) is not None and not cell.isdigit()


@dataclass(frozen=True)
class NumberForm:
    """How the numbers of a file are written: the decimal sign, the mark between groups of three digits beside blanks
    and apostrophes (empty for none), and whether plain blanks group digits, too: not where they separate columns."""

    decimal: str = "."
    thousands: str = ""
    blanks: bool = True

    @cached_property
    def _grouped(self) -> re.Pattern[str]:
        return re.compile(self.grouped_pattern)

    @cached_property
    def grouped_pattern(self) -> str:
        """Regular expression (of RE2 too) of a number whose digits are grouped by one mark."""
        marks = (self.thousands, "[" + APOSTROPHES + "]", "[" + NO_BREAK + " " * self.blanks + "]")
        patterns = [mark if mark.startswith("[") else re.escape(mark) for mark in marks if mark]
        # With commas, groups before the last may have two digits, as in India.
        least = {mark: 2 if mark == "," else 3 for mark in patterns}
        forms = "|".join(rf"\d{{1,3}}(?:{mark}\d{{{least[mark]},3}})*{mark}\d{{3}}" for mark in patterns)
        return rf"[+-]?(?:{forms})(?:{re.escape(self.decimal)}\d*)?{_EXPONENT}"

    @cached_property
    def marks(self) -> str:
        """Every character that may group digits."""
        return self.thousands + APOSTROPHES + NO_BREAK + " " * self.blanks

    def value(self, cell: str) -> float | None:
        """The number in a cell; None if it is none."""
        if not cell:
            return None
        if self.decimal == "." or ("," not in cell and "." not in cell):
            try:
                return float(cell) if "_" not in cell else None
            except ValueError:
                pass
        plain = self.respelled(cell)
        return float(plain) if plain is not None else None

    def respelled(self, cell: str) -> str | None:
        """The number in a cell as Python writes it; None if it is none."""
        text = cell.strip().strip('"').strip()
        for sign in MINUS:
            text = text.replace(sign, "-")
        text = _POWER.sub("e", text).replace("٫", self.decimal)
        if text.startswith("(") and text.endswith(")") and "-" not in text:
            text = f"-{text[1:-1].strip()}"
        if text.endswith("-"):
            text = f"-{text[:-1].rstrip()}"
        if re.match(r"[+-]\s", text):
            text = text[0] + text[1:].lstrip()
        if self._grouped.fullmatch(text):
            text = text.translate({ord(mark): None for mark in self.marks})
        if self.decimal == ",":
            if "." in text:
                return None
            text = text.replace(",", ".")
        if bare := _BARE_EXPONENT.fullmatch(text):
            text = f"{bare[1]}e{bare[2]}"
        return re.sub("[dDqQ]", "e", text) if re.fullmatch(_NUMBER, text) else None


def respelled_column(text: Any, form: NumberForm, gaps: tuple[str, ...], unit: str = "") -> Any | None:
    """A column of numbers (n,) of an array of texts, with `unit` behind each; None where a cell needs a look."""
    pc: Any = compute
    cells = pc.utf8_trim(text, characters=' \t\u00a0"')
    cells = pc.if_else(pc.is_in(cells, pyarrow.array(gaps, pyarrow.string())), None, cells)
    if unit:
        cells = pc.replace_substring_regex(cells, rf"\s*{re.escape(unit)}$", "")
    cells = pc.replace_substring_regex(cells, f"[{MINUS}]", "-")
    cells = pc.replace_substring_regex(cells, r"^([^-]*[^-\s])\s*-$", r"-\1")
    grouped = pc.match_substring_regex(cells, f"^(?:{form.grouped_pattern})$")
    for mark in form.marks:
        cells = pc.if_else(grouped, pc.replace_substring(cells, mark, ""), cells)
    if form.decimal == ",":
        if pc.any(pc.match_substring(cells, ".")).as_py():
            return None
        cells = pc.replace_substring(cells, ",", ".")
    cells = pc.replace_substring_regex(cells, "[dDqQ]", "e")
    if not pc.all(pc.match_substring_regex(cells, f"^{_NUMBER}$")).as_py():
        return None
    try:
        return cells.cast(pyarrow.float64())
    except pyarrow.ArrowInvalid:
        return None


DAY = 86400.0
MONTHS: dict[str, int] = WORDS["months"]

_DATE = (
    r"\d{4}[-/.]\d{1,2}[-/.]\d{1,2}|\d{4}-\d{3}|\d{1,2}[-./]\d{1,2}[-./](?:\d{4}|\d\d)"
    r"|\d{1,2}[-. ]{1,2}\pL{3,9}\.?[-. ]\d{2,4}|\pL{3,9}\.? +\d{1,2},? +\d{4}"
)
_HALVES = {word: k for k, words in enumerate(WORDS["halves"], start=1) for word in words}
"""Words for the halves of a day, 1 and 2."""
_HALF = "(?i:" + "|".join(r"\.?\s?".join(word) + r"\.?" for word in _HALVES) + ")"
HALF = re.compile(_HALF)
_REST = rf"\s?(?P<half>{_HALF})?\s?(?P<zone>Z|UTC|[+-]\d\d:?\d\d)?"
_BEFORE = rf"(?:(?P<before>{_HALF})\s?)?"
_CLOCK = _BEFORE + r"(?P<h>\d{1,2})[:.](?P<m>\d\d)(?:[:.](?P<s>\d\d)(?:[.,:](?P<f>\d+))?)?" + _REST
_SIGN = f"(?P<sign>[-{MINUS}])?"
_FORMS = {
    "date": rf"\[?(?:\pL{{2,10}}\.?,? +)?(?P<date>{_DATE})(?:[ T,]\s*|[-/]){_CLOCK}\]?",
    "day": rf"(?P<date>{_DATE})",
    "turned": rf"{_CLOCK}[ ,]\s*(?P<date>{_DATE})",
    "ctime": rf"(?:\pL{{2,4}} )?(?P<date>\pL{{3}} +\d{{1,2}}) {_CLOCK} (?P<year>\d{{4}})",
    "clock": rf"{_SIGN}(?:(?P<days>\d+)(?: days?,? |\.))?{_BEFORE}"
    + r"(?P<h>\d{1,2}):(?P<m>\d\d):(?P<s>\d\d)(?:[.,:](?P<f>\d+))?"
    + _REST,
    "dotted": r"(?P<h>\d{1,2})\.(?P<m>\d\d)\.(?P<s>\d\d)[.,](?P<f>\d+)",
    "compact": r"(?P<date>(?:19|20)\d{6})[T_ ]?(?P<h>[0-2]\d)(?P<m>[0-5]\d)(?P<s>[0-5]\d)(?:[.,](?P<f>\d+))?",
    "minutes": _SIGN + r"(?P<m>\d{1,4})[:'′](?P<s>\d\d)[.,\"″](?P<f>\d+)",
    "marked": r"(?:PT)?(?:(?P<h>\d+) ?[hH] ?)?(?:(?P<m>\d+) ?[mM](?:in)? ?)?(?P<s>\d+)(?:[.,](?P<f>\d+))? ?[sS](?:ec)?",
}
"""Regular expressions of RE2 by kind of stamp; a time of day alone has seconds."""
STAMPS = {kind: re.compile(form.replace(r"\pL", r"[^\W\d_]")) for kind, form in _FORMS.items()}
# Below a minute there are seconds alone, from an hour on there are hours.
_FORMS["minutes"] = _SIGN + r"(?:(?:(?P<h>\d+):)?(?P<m>\d{1,4})[:'′])?(?P<s>\d{1,2})(?:[.,\"″](?P<f>\d+))?"


def seconds(column: Any, kind: str, time_format: str | None, file: str, label: str) -> Column:
    """Seconds (n,) since the first row of a column of time stamps, exact to a nanosecond."""
    pc: Any = compute
    if column.null_count:
        row = int(np.flatnonzero(~np.array(column.is_valid()))[0])
        raise InputError(f"{file}: value {row + 1} of column '{label}': is empty; every row needs its time")
    text = pc.utf8_trim_whitespace(pc.replace_substring_regex(column, f"[{NO_BREAK}]", " "))
    first = text[0].as_py()
    try:
        counted, origin = _own_format(text, time_format or "") if kind == "stamp" else _counted(text, kind)
    except ValueError as error:
        raise InputError(
            f"{file}: column '{label}': a time stamp is not of the form of the first, {shown(first)} ({error}); "
            'name the form, such as [format] time_format = "%d.%m.%Y %H:%M:%S.%f"'
        ) from None
    said = f"'{label}' is counted from its first row, {first}"
    if kind == "clock" and (midnights := np.cumsum(np.diff(counted, prepend=counted[:1]) < -DAY / 2))[-1]:
        counted = counted + DAY * midnights
        said += "; it passes midnight"
    return Column(counted, origin, said)


def _counted(text: Any, kind: str) -> tuple[np.ndarray, float]:
    """Seconds (n,) since the first row, and those of the first row since 1970 or midnight. ValueError: another form."""
    pc: Any = compute
    for zone in (None, "UTC") if kind == "date" else ():
        # Arrow reads ISO 8601 ten times as fast.
        with suppress(pyarrow.ArrowInvalid):
            counts = text.cast(pyarrow.timestamp("ns", zone)).cast("int64")
            return to_numpy(pc.subtract(counts, counts[0]).cast("float64")) / 1e9, counts[0].as_py() / 1e9
    parts = pc.extract_regex(text, f"^(?:{_FORMS[kind]})$")
    if parts.null_count:
        row = int(np.flatnonzero(~np.array(parts.is_valid()))[0])
        raise ValueError(f"another is {shown(text[row].as_py())}")

    def number(name: str, most: float = np.inf) -> np.ndarray:
        if f"(?P<{name}>" not in _FORMS[kind]:
            return np.zeros(1)
        digits = pc.struct_field(parts, name)
        digits = pc.binary_join_element_wise("0", digits, "." if name == "f" else "")
        values = to_numpy(digits.cast("float64"))
        if np.max(values) > most:
            raise ValueError(f"a number above {most}")
        return values

    def by_word(name: str, meaning: Any) -> np.ndarray:
        """Number (n,) of each word of a field that has few different ones."""
        if f"(?P<{name}>" not in _FORMS[kind]:
            return np.zeros(1)
        words = pc.struct_field(parts, name)
        if name == "date" and "(?P<year>" in _FORMS[kind]:
            words = pc.binary_join_element_wise(words, pc.struct_field(parts, "year"), " ")
        words = words.combine_chunks().dictionary_encode()
        return np.array(meaning(words.dictionary.to_pylist()), dtype=float)[np.array(words.indices)]

    halves = [
        by_word(place, lambda words: [_HALVES.get(re.sub(r"[.\s]", "", word).casefold(), 0) for word in words])
        for place in ("before", "half")
    ]
    half = np.maximum(*halves)
    hours = number("h", 24 if not half.any() else 12)
    hours = np.where(half > 0.0, hours % 12.0, hours) + 12.0 * (half == 2.0)
    sign = 1.0 - 2.0 * by_word("sign", lambda words: [word != "" for word in words])
    clock = 3600.0 * hours + 60.0 * number("m", 59 if kind != "minutes" else 9999) + number("s", 60)
    days = by_word("date", _days) + number("days")
    whole = DAY * days + sign * clock - by_word("zone", lambda words: [*map(_offset, words)])
    part = sign * number("f")
    return whole - whole[0] + (part - part[0]), float(whole[0] + part[0])


def _days(words: list[str]) -> list[int]:
    """Days since 1970 of dates, in the order of their numbers that makes them dates that do not fall: where several
    do, the days between them must be the same."""
    parts = [re.findall(r"\d+|[^\W\d_]+", re.sub(r"^(\d{4})(\d\d)(\d\d)$", r"\1-\2-\3", word)) for word in words]
    first = parts[0]
    if len(first) == 2:
        return [(date(int(year), 1, 1) - date(1970, 1, 1)).days + int(day) - 1 for year, day in parts]
    if len(first[0]) == 4:
        orders = ["ymd"]
    elif any(part.isalpha() for part in first):
        orders = ["mdy" if first[0].isalpha() else "dmy"]
    else:
        orders = ["dmy", *([] if "." in words[0] else ["mdy"]), *(["ymd"] if len(first[2]) == 2 else [])]
    found: dict[tuple[int, ...], list[int]] = {}
    problem = ""
    for order in orders:
        try:
            days = [(_date(dict(zip(order, part))) - date(1970, 1, 1)).days for part in parts]
        except ValueError as error:
            problem = str(error)
        else:
            if days == sorted(days):
                found.setdefault(tuple(day - days[0] for day in days), days)
    if len(found) != 1:
        raise ValueError("which of the numbers is the day is not known" if found else problem or "dates fall")
    return next(iter(found.values()))


def _date(parts: dict[str, str]) -> date:
    """A date of year, month and day; years of two digits are after 2000."""
    month = MONTHS.get(parts["m"][:3].lower()) if parts["m"].isalpha() else int(parts["m"])
    if month is None:
        raise ValueError(f"the month {parts['m']}")
    return date(int(parts["y"]) + 2000 * (len(parts["y"]) < 4), month, int(parts["d"]))


def _offset(zone: str) -> float:
    """Seconds by which a zone such as +02:00 is ahead of UTC."""
    digits = zone.replace(":", "")[1:]
    return float(zone[0] + "1") * (3600.0 * int(digits[:2]) + 60.0 * int(digits[2:])) if zone[:1] in ("+", "-") else 0.0


def _own_format(text: Any, time_format: str) -> tuple[np.ndarray, float]:
    import pandas

    stamps = pandas.to_datetime(pandas.Series(text.to_pylist()), format=time_format).astype("datetime64[ns]")
    nanoseconds = stamps.to_numpy().astype(np.int64)
    return (nanoseconds - nanoseconds[0]) / 1e9, nanoseconds[0] / 1e9
