"""`stagecad calc`: one design calculator by itself, its arguments from the command line or the parameter file."""

from collections.abc import Sequence
from inspect import cleandoc

import click

from stagecad.parameters.errors import InputError, require
from workbench.cli.console import show
from workbench.cli.options import Run, common_options
from workbench.operations.calculate import CALCULATORS, calculate
from workbench.operations.calculators.declaration import options_of


def _meaning(name: str) -> str:
    return " ".join(cleandoc(CALCULATORS[name].__doc__ or "").split())


class Calculators(click.Command):
    """`calc NAME --help` shows the options of that calculator alone."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if args and args[0] in CALCULATORS and {"-h", "--help"} & set(args):
            click.echo(_help(args[0], ctx))
            ctx.exit()
        return super().parse_args(ctx, args)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Calculators (`stagecad calc NAME --help` shows the options of one)"):
            formatter.write_dl([(name, _meaning(name)) for name in CALCULATORS])


def _help(name: str, ctx: click.Context) -> str:
    """Purpose of a calculator, and its options with unit and default."""
    formatter = ctx.make_formatter()
    formatter.write_usage(f"stagecad calc {name}", "[--key value]...")
    formatter.write_paragraph()
    with formatter.indentation():
        formatter.write_text(_meaning(name))
    rows = []
    for key, option in options_of(CALCULATORS[name]).items():
        kind = "|".join(option.words) or "FILE" if option.unit is None else option.unit or "NUMBER"
        rows.append((f"--{key.replace('_', '-')} {kind}", f"{option.meaning}  [default: {option.origin}]".strip()))
    if rows:
        with formatter.section("Options"):
            formatter.write_dl(rows)
    return formatter.getvalue()


@click.command("calc", cls=Calculators, context_settings={"ignore_unknown_options": True, "allow_extra_args": True})
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
        require(word.startswith("--"), f"calc {name}: '{word}' belongs to no option; write --key value")
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
