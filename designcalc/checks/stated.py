"""Checks that a file states as text: below the name of their subject a table for each, in the order of the report.

A table has the name, the formula and the texts of a `FormulaCheck`, and the changes that are proposed: the formula of
the value that passes by its key, rounded `up` or `down`. `$NAME` stands for one of the `terms` of the subject, for a
word of the design, or for one of the words that `each` gives for several checks of one kind. `where` names a switch
without which there is no such check, `uses` the quantities of this check alone. A check without a formula is written in
Python.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, wraps
from string import Template
from typing import Any

from designcalc.checks.check import CheckFunction, DesignInputs, FormulaCheck, Quantities
from stagecad.parameters.design import Design

TEXTS = ("source", "proposal", "thesis", "requirement", "note")

Given = Callable[[DesignInputs], Quantities]
"""Calculates quantities of a check before its formula is evaluated."""


@dataclass(frozen=True)
class Calculated:
    """What the checks of a file need besides it."""

    quantities: Quantities  # that every formula may name
    words: Callable[[Design], Mapping[str, str]]  # of a design, for its texts
    groups: Mapping[str, Quantities]  # quantities of single checks, by what a check `uses`
    given: Mapping[str, Given]  # by subject and key of a check: `stage plate.stiffness`
    written: Mapping[str, Sequence[CheckFunction]]  # checks without a formula, likewise


def stated_checks(
    subjects: Mapping[str, Any], calculated: Calculated
) -> dict[str, Callable[[Design], list[CheckFunction]]]:
    """The checks of a design by subject, from the tables of each subject."""
    return {subject: partial(_checks, subject, tables, calculated) for subject, tables in subjects.items()}


def _checks(subject: str, tables: Mapping[str, Any], calculated: Calculated, design: Design) -> list[CheckFunction]:
    terms = _filled(tables.get("terms", {}), calculated.words(design))
    found: list[CheckFunction] = []
    for key, table in tables.items():
        place = f"{subject}.{key}"
        if key == "terms" or ("where" in table and not design.value(table["where"])):
            continue
        if "formula" not in table:
            found += calculated.written[place]
        for row in table.get("each", ({},)) if "formula" in table else ():
            check = _check(table, _filled(row, terms), calculated)
            given = calculated.given.get(place)
            found.append(check if given is None else _with_given(check, given))
    return found


def _filled(texts: Mapping[str, str], terms: Mapping[str, str]) -> dict[str, str]:
    """Terms, and texts in which they and the texts before each are put in."""
    filled = dict(terms)
    for name, text in texts.items():
        filled[name] = Template(text).substitute(filled)
    return filled


def _check(table: Mapping[str, Any], terms: Mapping[str, str], calculated: Calculated) -> FormulaCheck:
    def text(stated: str) -> str:
        return Template(stated).substitute(terms)

    changes = [
        (text(key), text(value), way == "up") for way in ("up", "down") for key, value in table.get(way, {}).items()
    ]
    texts = {name: text(table[name]) for name in TEXTS if name in table}
    own = calculated.groups[text(table["uses"])] if "uses" in table else {}
    return FormulaCheck(text(table["name"]), text(table["formula"]), texts, {**calculated.quantities, **own}, changes)


def _with_given(check: FormulaCheck, given: Given) -> CheckFunction:
    """A check with quantities that are calculated first, under the name of what calculates them."""

    @wraps(given)
    def reading(r: DesignInputs) -> Any:
        return replace(check, quantities={**check.quantities, **given(r)})(r)

    return reading
