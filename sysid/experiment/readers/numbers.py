"""Numbers as loggers write them: other minus signs, grouped thousands, Fortran exponents, a unit behind the number.

A number has one meaning here or none: what a mark means is decided by the file (`Dialect`) or by `[format]`.
"""

import re
from dataclasses import dataclass
from functools import cached_property
from typing import Any

MINUS = "−–‒‐‑﹣－"
"""Signs that are written for a minus: U+2212 and the dashes and full-width forms that keyboards give."""
NO_BREAK = "\u00a0\u2009\u202f"
"""Blanks between groups of three digits, besides the plain one: no-break, thin, narrow no-break (CGPM 2003)."""
APOSTROPHES = "'’"

GAPS = (
    *("", "nan", "NaN", "NAN", "-nan", "-NaN", "NA", "N/A", "n/a", "null", "NULL", "None", "none", "NaT"),
    *("nan(ind)", "-nan(ind)", "-nan(snan)", "1.#IND", "-1.#IND", "1.#QNAN", "-1.#QNAN", "1.#SNAN"),
    *("1.#INF", "-1.#INF", "\\N", "(null)"),
    *("#N/A", "#N/A N/A", "#NA", "#NV", "#NUM!", "#ZAHL!", "#VALUE!", "#WERT!", "#DIV/0!", "#REF!", "<NA>"),
)
"""Cells that mean 'no number' in the output of C libraries, spreadsheets and data frames."""

_EXPONENT = r"(?:[eEdDqQ][+-]?\d+)?"
_BARE_EXPONENT = re.compile(r"(.*\d*\.\d*)([+-]\d{3})")
"""Fortran leaves out the letter before an exponent of three digits."""
SCPI_OVERLOAD = 9.9e37
"""Instruments write this number for an overload, and one above it for 'not a number' (SCPI-1999, 7.2.1)."""
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
    def pattern(self) -> str:
        """Regular expression (of RE2 too) of a number after `respelled`."""
        return rf"[+-]?(?:\d+\.?\d*|\.\d+){_EXPONENT}"

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
        return re.sub("[dDqQ]", "e", text) if re.fullmatch(self.pattern, text) else None


def respelled_column(text: Any, form: NumberForm, gaps: tuple[str, ...], unit: str = "") -> Any | None:
    """A column of numbers (n,) of an array of texts, with `unit` behind each; None where a cell needs a look."""
    import pyarrow
    from pyarrow import compute

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
    if not pc.all(pc.match_substring_regex(cells, f"^{form.pattern}$")).as_py():
        return None
    try:
        return cells.cast(pyarrow.float64())
    except pyarrow.ArrowInvalid:
        return None
