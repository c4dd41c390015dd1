"""`stagecad calc`: one design calculator by itself, its arguments from the command line or the parameter file."""

from __future__ import annotations

from collections.abc import Sequence
from inspect import cleandoc

import click

from stagecad.parameters.errors import InputError
from workbench.cli.console import show
from workbench.cli.options import Run, common_options
from workbench.operations.calculate import CALCULATORS, calculate
from workbench.operations.calculators.declaration import options_of


def _meaning(name: str) -> str:
    return " ".join(cleandoc(CALCULATORS[name].__doc__ or "").split())


def _epilog() -> str:
    lines = []
    for name, calculator in CALCULATORS.items():
        options = " ".join(f"--{option.replace('_', '-')}" for option in options_of(calculator))
        lines.append(f"\b\n{name}: {_meaning(name)}\n  {options}")
    return "\n\n".join(lines)


@click.command("calc", context_settings={"ignore_unknown_options": True, "allow_extra_args": True}, epilog=_epilog())
@click.argument("name", metavar="NAME")
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="[--key value]...")
@common_options
def command(run: Run, name: str, arguments: tuple[str, ...]) -> None:
    """Run one calculator: `stagecad calc hertz --load "20 N"`. Options left out are taken from the parameter file."""
    calculation = calculate(name, run.design, _written(name, arguments))
    show(run, calculation.lines())
    run.emit(calculation.to_json())


def _written(name: str, arguments: Sequence[str]) -> dict[str, str]:
    """The options as written: key (with underscores) to text."""
    written: dict[str, str] = {}
    words = list(arguments)
    while words:
        word = words.pop(0)
        if not word.startswith("--"):
            raise InputError(f"calc {name}: '{word}' belongs to no option; write --key value")
        flag, equals, value = word[2:].partition("=")
        if not equals:
            if not words:
                raise InputError(f"calc {name}: --{flag} needs a value")
            value = words.pop(0)
        key = flag.replace("-", "_")
        if key in written:
            raise InputError(f"calc {name}: --{flag} is given twice")
        written[key] = value
    return written
