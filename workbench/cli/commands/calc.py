"""`stagecad calc`: one design calculator by itself, its arguments from the command line or the parameter file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.units import as_json, format_quantity, parse_quantity
from workbench.calculators.bearing import BEARING_CALCULATORS
from workbench.calculators.catalogue import CALCULATORS, Calculator, Values
from workbench.calculators.drive import DRIVE_CALCULATORS
from workbench.calculators.errors import ERROR_CALCULATORS
from workbench.cli.options import Run, common_options

if TYPE_CHECKING:
    from designcalc.checks.inputs import DesignInputs

ALL = {**CALCULATORS, **DRIVE_CALCULATORS, **BEARING_CALCULATORS, **ERROR_CALCULATORS}
"""All calculators by their name."""


def _epilog() -> str:
    lines = []
    for name, calculator in ALL.items():
        options = " ".join(f"--{option.replace('_', '-')}" for option in [*calculator.options, *calculator.words])
        lines.append(f"\b\n{name}: {calculator.meaning}\n  {options}")
    return "\n\n".join(lines)


@click.command("calc", context_settings={"ignore_unknown_options": True, "allow_extra_args": True}, epilog=_epilog())
@click.argument("name", metavar="NAME")
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="[--key value]...")
@common_options
def command(run: Run, name: str, arguments: tuple[str, ...]) -> None:
    """Run one calculator: `stagecad calc hertz --load "20 N"`. Options left out are taken from the parameter file."""
    if name not in ALL:
        raise InputError(f"no calculator '{name}'{nearest(name, ALL)}")
    calculator = ALL[name]
    values = _values(run, name, calculator, _written(name, calculator, arguments))
    results = calculator.results(run, values)
    inputs = {
        key: None if values[key] is None else as_json(values[key], option.unit)
        for key, option in calculator.options.items()
    }
    inputs.update({key: values[key] for key in calculator.words})
    _print(run, calculator, inputs, results)
    run.emit({"inputs": inputs, "results": results})


def _written(name: str, calculator: Calculator, arguments: Sequence[str]) -> dict[str, str]:
    """The options as written: key (with underscores) to text."""
    known = [*calculator.options, *calculator.words]
    options = ["--" + key.replace("_", "-") for key in known]
    written: dict[str, str] = {}
    words = list(arguments)
    while words:
        word = words.pop(0)
        if not word.startswith("--"):
            raise InputError(f"calc {name}: '{word}' belongs to no option; write --key value")
        flag, equals, value = word[2:].partition("=")
        key = flag.replace("-", "_")
        if key not in known:
            raise InputError(f"calc {name}: no option '--{flag}'{nearest('--' + flag, options)}")
        if not equals:
            if not words:
                raise InputError(f"calc {name}: --{flag} needs a value")
            value = words.pop(0)
        if key in written:
            raise InputError(f"calc {name}: --{flag} is given twice")
        written[key] = value
    return written


def _values(run: Run, name: str, calculator: Calculator, written: Mapping[str, str]) -> Values:
    """SI values of all options: as written, else from the design."""
    from designcalc.checks.inputs import DesignInputs

    values: Values = {}
    inputs: DesignInputs | None = None
    for key, option in calculator.options.items():
        if key in written:
            values[key] = parse_quantity(written[key], option.unit, f"calc {name}: --{key.replace('_', '-')}")
            continue
        if inputs is None:
            inputs = DesignInputs(run.design.values)
        values[key] = option.default(inputs, values)
    for key, allowed in calculator.words.items():
        word = written.get(key)
        if word is not None and allowed and word not in allowed:
            raise InputError(f"calc {name}: --{key} {word}: not a choice{nearest(word, allowed)}")
        values[key] = word
    return values


def _shown(item: Any) -> str:
    if isinstance(item, dict) and "value" in item:
        return format_quantity(item["value"], item["unit"], 5)
    if isinstance(item, bool):
        return "yes" if item else "no"
    return "none" if item is None else f"{item:g}" if isinstance(item, int | float) else str(item)


def _print(run: Run, calculator: Calculator, inputs: Mapping[str, Any], results: Mapping[str, Any]) -> None:
    from rich.table import Table

    table = Table(show_header=False, box=None, pad_edge=False)
    for key, item in inputs.items():
        meaning = calculator.options[key].meaning if key in calculator.options else ""
        table.add_row(key.replace("_", " "), _shown(item), meaning)
    table.add_section()
    for key, item in results.items():
        if not isinstance(item, list):
            table.add_row(f"[bold]{key.replace('_', ' ')}[/bold]", f"[bold]{_shown(item)}[/bold]", "")
    run.console.print(table)
    for key, rows in results.items():
        if isinstance(rows, list):
            listed = Table(title=key)
            for column in rows[0]:
                listed.add_column(column.replace("_", " "), justify="right")
            for row in rows:
                listed.add_row(*(_shown(item) for item in row.values()))
            run.console.print(listed)
