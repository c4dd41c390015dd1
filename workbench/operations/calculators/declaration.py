"""How a calculator is declared, and how its options are read.

A calculator is a frozen dataclass; its docstring says what it computes. A field is an option, annotated with its unit,
its meaning and its default: a key of the parameter file, `part:quantity` for a number of a part's material, `=field`
for another option's value, a number, None, a formula as of the checks, which may name the options before it
(`option.travel`), or a function of the design's numbers and these. A field of type `Word` takes a word, one of those
annotated or, without any, every text.
"""

import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from designcalc.checks.check import DesignInputs, FormulaCheck
from designcalc.friction_stage.quantities import QUANTITIES
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.units import as_json, parse_quantity

Word = str | None
Values = dict[str, Any]
Known = dict[str, tuple[Any, str]]
"""Value and unit of the options before one, by `option.NAME`."""


@dataclass(frozen=True)
class Option:
    """An option of a calculator; a unit of None means that it takes a word."""

    unit: str | None
    meaning: str
    default: Any
    words: tuple[str, ...] = ()

    @property
    def origin(self) -> str:
        """Where the default comes from, for help."""
        text = self.default if isinstance(self.default, str) else ""
        # A formula of several numbers, or a calculated number.
        if callable(self.default) or text in QUANTITIES or re.search(r"[^\w.:=]", text):
            return "from the parameter file"
        if not isinstance(self.default, str):
            return "none" if self.default is None else f"{self.default:g}"
        if self.default.startswith("="):
            return f"--{self.default[1:].replace('_', '-')}"
        part, colon, quantity = self.default.partition(":")
        return f"{quantity.replace('_', ' ')} of {part}" if colon else part


def options_of(calculator: type) -> dict[str, Option]:
    """The options of a calculator by name."""
    options, names = {}, vars(sys.modules[calculator.__module__])
    for name, hint in get_type_hints(calculator, names, include_extras=True).items():
        kind, *stated = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        options[name] = Option(*stated) if kind is float else Option(None, "", None, tuple(stated))
    return options


def command_name(calculator: type) -> str:
    """`AirBearing` -> `air-bearing`."""
    return re.sub(r"(?<!^)(?=[A-Z])", "-", calculator.__name__).lower()


def values_of(calculator: type, written: Mapping[str, str], r: DesignInputs) -> Values:
    """SI values of all options: as written, else their defaults."""
    name, values, options = command_name(calculator), {}, options_of(calculator)
    for key, option in options.items():
        flag = f"--{key.replace('_', '-')}"
        if option.unit is None:
            word = written.get(key)
            if word is not None and option.words and word not in option.words:
                raise InputError(f"calc {name}: {flag} {word}: not a choice{nearest(word, option.words)}")
            values[key] = word
        elif key in written:
            values[key] = parse_quantity(written[key], option.unit, f"calc {name}: {flag}")
        else:
            known = {f"option.{name}": (value, options[name].unit or "") for name, value in values.items()}
            values[key] = _default(option.default, r, known)
    return values


def _default(default: Any, r: DesignInputs, known: Known) -> Any:
    if callable(default):
        return default(r, known)
    if not isinstance(default, str):
        return default
    if default.startswith("="):
        return known[f"option.{default[1:]}"][0]
    part, colon, quantity = default.partition(":")
    if colon:
        return r.material(part, quantity)
    found = FormulaCheck("", "", {}, QUANTITIES).evaluate(r, default, known)
    return inf if found is None else found.si


def quantities(**named: tuple[Any, str]) -> dict[str, Any]:
    """Results as JSON quantities, from (value, SI unit); null for a value of None."""
    return {name: None if value is None else as_json(float(value), unit) for name, (value, unit) in named.items()}
