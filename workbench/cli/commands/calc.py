"""`stagecad calc`: one design calculator by itself, its arguments from the command line or the parameter file."""

import click

from workbench.cli.console import show
from workbench.cli.options import Run, common_options, without_effect
from workbench.operations.calculate import CALCULATORS, calculate, meaning, option_rows, written_options


class Calculators(click.Command):
    """`calc NAME --help` shows the options of that calculator alone."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if args and args[0] in CALCULATORS and {"-h", "--help"} & set(args):
            click.echo(_help(args[0], ctx))
            ctx.exit()
        return super().parse_args(ctx, args)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Calculators (`stagecad calc NAME --help` shows the options of one)"):
            formatter.write_dl([(name, meaning(name)) for name in CALCULATORS])
        super().format_epilog(ctx, formatter)


def _help(name: str, ctx: click.Context) -> str:
    """Purpose of a calculator, and its options with unit and default."""
    formatter = ctx.make_formatter()
    formatter.write_usage(f"stagecad calc {name}", "[--key value]...")
    formatter.write_paragraph()
    with formatter.indentation():
        formatter.write_text(meaning(name))
    rows = option_rows(name)
    if rows:
        with formatter.section("Options"):
            formatter.write_dl(rows)
    return formatter.getvalue()


@click.command("calc", cls=Calculators, context_settings={"ignore_unknown_options": True, "allow_extra_args": True})
@click.argument("name", metavar="NAME")
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="[--key value]...")
@without_effect("out")
@common_options
def command(run: Run, name: str, arguments: tuple[str, ...]) -> None:
    """Run one calculator: `stagecad calc hertz --load "20 N"`. Options left out are taken from the parameter file."""
    calculation = calculate(name, run.design, written_options(name, arguments))
    show(run, calculation.lines())
    run.emit(calculation.to_json())
