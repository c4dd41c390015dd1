"""`calc`: one design calculator by itself, its options given or taken from the parameter file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from inspect import cleandoc
from typing import Any

from designcalc.checks.check import DesignInputs
from stagecad.deferred import pd
from stagecad.parameters.errors import require, require_known
from stagecad.parameters.units import as_json, format_quantity
from workbench.operations.calculators import bearing, contact, drive, errors
from workbench.operations.calculators.declaration import Values, command_name, options_of, values_of
from workbench.operations.design import Design
from workbench.operations.result import NUMBER, Line, Result, Table, finite, plain_table

CALCULATORS: dict[str, type] = {
    command_name(one): one
    for module in (contact, drive, bearing, errors)
    for one in vars(module).values()
    if isinstance(one, type) and one.__module__ == module.__name__
}
"""All calculators by their name: the classes of these modules."""


class Calculation(Result):
    """Results of a calculator."""

    def __init__(self, name: str, inputs: Values, results: dict[str, Any]) -> None:
        self.name, self.inputs, self.results = name, inputs, results

    def _input_documents(self) -> dict[str, Any]:
        options = options_of(CALCULATORS[self.name])
        quantities = {key: option.unit for key, option in options.items() if option.unit is not None}
        values = self.inputs
        documents = {
            key: None if values[key] is None else as_json(values[key], unit) for key, unit in quantities.items()
        }
        return documents | {key: values[key] for key in options if key not in quantities}

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each result that is a number: value, SI, and unit; index `result`."""
        rows = {name: item for name, item in self.results.items() if isinstance(item, dict) and "value" in item}
        return pd.DataFrame(rows.values(), index=pd.Index(list(rows), name="result"))

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad calc --json`."""
        return finite({"inputs": self._input_documents(), "results": self.results})

    def lines(self) -> list[Line]:
        """Inputs with their meaning, results, and tables."""
        options = options_of(CALCULATORS[self.name])
        rows = [
            (key.replace("_", " "), _shown(item), options[key].meaning) for key, item in self._input_documents().items()
        ]
        numbers = {key: item for key, item in self.results.items() if not isinstance(item, list)}
        rows += [("", "", "")] if rows else []
        rows += [(key.replace("_", " "), _shown(item), "") for key, item in numbers.items()]
        lines: list[Line] = [plain_table("", "||", rows, "*")] if rows else []
        for key, items in self.results.items():
            if isinstance(items, list):
                columns = tuple((column.replace("_", " "), NUMBER) for column in items[0])
                lines.append(Table(key, columns, tuple(tuple(map(_shown, item.values())) for item in items)))
        return lines

    def __repr__(self) -> str:
        return f"<Calculation '{self.name}': {', '.join(self.results)}>"


def _shown(item: Any) -> str:
    if isinstance(item, dict) and "value" in item:
        return format_quantity(item["value"], item["unit"], 5)
    if isinstance(item, bool):
        return "yes" if item else "no"
    return "none" if item is None else f"{item:g}" if isinstance(item, int | float) else str(item)


def meaning(name: str) -> str:
    """What a calculator computes."""
    return " ".join(cleandoc(CALCULATORS[name].__doc__ or "").split())


def option_rows(name: str) -> list[tuple[str, str]]:
    """Each option of a calculator with its unit; its meaning and default."""
    rows = []
    for key, option in options_of(CALCULATORS[name]).items():
        kind = "|".join(option.words) or "FILE" if option.unit is None else option.unit or "NUMBER"
        rows.append((f"--{key.replace('_', '-')} {kind}", f"{option.meaning}  [default: {option.origin}]".strip()))
    return rows


def written_options(name: str, arguments: Sequence[str]) -> dict[str, str]:
    """The words `--key value` of a command line: key (with underscores) to text."""
    written: dict[str, str] = {}
    words = list(arguments)
    while words:
        word = words.pop(0)
        require(word.startswith("--"), f"calc {name}: '{word}' belongs to no option; write --key value")
        flag, equals, value = word[2:].partition("=")
        if not equals:
            require(words, f"calc {name}: --{flag} needs a value")
            value = words.pop(0)
        key = flag.replace("-", "_")
        require(key not in written, f"calc {name}: --{flag} is given twice")
        written[key] = value
    return written


def calculate(name: str, design: Design, written: Mapping[str, str]) -> Calculation:
    """Run a calculator."""
    require_known(name, CALCULATORS, f"no calculator '{name}'")
    calculator, r = CALCULATORS[name], DesignInputs(design.values)
    known = [f"--{key.replace('_', '-')}" for key in options_of(calculator)]
    for key in written:
        flag = f"--{key.replace('_', '-')}"
        require_known(flag, known, f"calc {name}: no option '{flag}'")
    values = values_of(calculator, written, r)
    return Calculation(name, values, calculator(**values).results(r))
