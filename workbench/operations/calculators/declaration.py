"""How a calculator is declared, and how its options are read.

A calculator is a frozen dataclass; its docstring says what it computes. A field is an option, annotated with its unit,
its meaning and its default: a key of the parameter file, `part:quantity` for a number of a part's material, `=field`
for another option's value, a number, None, or a function of the design's numbers and of the options before it. A field
of type `Word` takes a word, one of those annotated or, without any, every text.
"""

import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from designcalc.checks.check import DesignInputs
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.units import as_json, parse_quantity

Word = str | None
Values = dict[str, Any]


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
        if callable(self.default):
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
    name, values = command_name(calculator), {}
    for key, option in options_of(calculator).items():
        flag = f"--{key.replace('_', '-')}"
        if option.unit is None:
            word = written.get(key)
            if word is not None and option.words and word not in option.words:
                raise InputError(f"calc {name}: {flag} {word}: not a choice{nearest(word, option.words)}")
            values[key] = word
        elif key in written:
            values[key] = parse_quantity(written[key], option.unit, f"calc {name}: {flag}")
        else:
            values[key] = _default(option.default, r, values)
    return values


def _default(default: Any, r: DesignInputs, values: Values) -> Any:
    if callable(default):
        return default(r, values)
    if not isinstance(default, str):
        return default
    if default.startswith("="):
        return values[default[1:]]
    part, colon, quantity = default.partition(":")
    return r.material(part, quantity) if colon else r(default)


def of(model: Callable[[DesignInputs], float]) -> Callable[[DesignInputs, Values], float]:
    """A default that a model of the stage computes."""
    return lambda r, values: model(r)


def quantities(**named: tuple[Any, str]) -> dict[str, Any]:
    """Results as JSON quantities, from (value, SI unit)."""
    return {name: as_json(float(value), unit) for name, (value, unit) in named.items()}
