"""The common options of every command, and the destination of its output."""

from __future__ import annotations

import functools
import logging
import os
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import click
from click.core import ParameterSource

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import ViolationsError, one_line, require

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

    from workbench.operations.design import Design
    from workbench.operations.result import ProgressCallback


FILE, FOLDER = click.Path(path_type=Path), click.Path(path_type=Path, file_okay=False)
OUT = click.option("--out", type=FOLDER, default=Path("build"), show_default=True, help="Folder to write to.")
TRUST = "stagecad.trust"
"""Key of the consent that `design_trust` takes."""


@dataclass(frozen=True)
class Run:
    """One run of a command: the options every command has, and its two streams.

    With `--json` the document alone goes to standard output, and all that is meant for a person to standard error.
    """

    params: Path | None
    overrides: tuple[str, ...]
    out: Path
    json_target: str | None
    rules: bool = True  # whether the design must satisfy the rules; a command that repairs a design has none
    out_is_given: bool = True
    """whether `--out` names the folder; else the files of a kind go to a folder of their own in the default one"""

    def folder(self, kind: str) -> Path:
        """Folder of the files of a kind."""
        return self.out if self.out_is_given else self.out / kind

    @functools.cached_property
    def design(self) -> Design:
        """The design of `--params` with `--set` applied."""
        from workbench.operations.design import Design

        return Design.chosen(self.params, self.overrides, self.rules)

    @functools.cached_property
    def console(self) -> Console:
        """Stream of the readable text: standard output, or standard error where a JSON document is printed."""
        from rich.console import Console

        # Where no width is known, tables are laid out for a wide page rather than cut.
        plain = sys.stderr if self.json_target is not None else sys.stdout
        return Console(file=plain, soft_wrap=False, highlight=False, width=_width(plain) or 140)

    def echo(self, text: str) -> None:
        """Print readable text."""
        stream = sys.stderr if self.json_target is not None else sys.stdout
        click.echo(folded(text, stream), file=stream)

    def note(self, text: str) -> None:
        """Print a remark of one line to standard error; it may quote a file."""
        click.echo(folded(one_line(text), sys.stderr), err=True)

    def trust_files(self, *designs: Design) -> None:
        """Store the consent to run the user's own checks and parts as they are now, and name them."""
        from workbench.operations.checks import trust_checks

        for name in dict.fromkeys(file for design in designs or (self.design,) for file in trust_checks(design)):
            self.note(f"trusted as it is now: {name}")

    def emit(self, document: object) -> None:
        """Print the JSON document, and write it to the file named by `--json FILE`; nothing without `--json`."""
        if self.json_target is None:
            return
        from workbench.operations.result import json_text

        text = json_text(document, 1) + "\n"
        if self.json_target != "-":
            atomic_write_text(self.json_target, text)
        click.echo(text, nl=False)

    def progress(self) -> Progress:
        """A progress bar on standard error, drawn on a terminal only, for what takes longer than a second."""
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

        console = Console(file=sys.stderr)
        return Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )

    @contextmanager
    def reporting(self, words: str = "", note: str = "") -> Iterator[ProgressCallback]:
        """A bar as the progress callback of an operation, from its first call on."""
        progress = self.progress()

        def report(step: str, done: int, steps: int) -> None:
            if not progress.tasks:
                if note and not progress.disable:
                    self.note(note)
                progress.add_task(words or step)
                progress.start()
            progress.update(progress.tasks[0].id, description=words or step, completed=done, total=steps or None)

        try:
            yield report
        finally:
            progress.stop()

    @contextmanager
    def busy(self, words: str) -> Iterator[None]:
        """A bar without an end, drawn on a terminal only, while something is done whose steps cannot be counted."""
        with self.progress() as progress:
            progress.add_task(words, total=None)
            yield


def _width(stream: TextIO) -> int | None:
    """Columns of a terminal, or as the variable COLUMNS states them; else None."""
    return shutil.get_terminal_size().columns if stream.isatty() or os.environ.get("COLUMNS") else None


def folded(text: str, stream: TextIO) -> str:
    """Text of which lines that are longer than the stream is wide continue with an indent."""
    width, lines = _width(stream) or 10**6, text.split("\n")
    indents = [" " * (len(line) - len(line.lstrip()) + 2) for line in lines]
    fill = functools.partial(textwrap.fill, width=width, break_long_words=False, break_on_hyphens=False)
    return "\n".join(
        fill(line, subsequent_indent=indent) if len(line) > width else line for line, indent in zip(lines, indents)
    )


@contextmanager
def _remarks_shown() -> Iterator[None]:
    """Print the remarks of operations."""
    log, handler = logging.getLogger("stagecad"), logging.Handler()
    handler.emit = lambda record: click.echo(folded(record.getMessage(), sys.stderr), err=True)
    log.addHandler(handler)
    log.propagate = False
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.propagate = True


def experiment_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the argument EXPERIMENT, and `--trust`; below `common_options`, whose `Run` comes first."""

    @click.argument("experiment", type=FILE)
    @trust_option
    @functools.wraps(function)
    def wrapper(run: Run, experiment: Path, trust: bool, **rest: Any) -> Any:
        if trust:
            consent(run, experiment)
        return function(run, experiment, **rest)

    return wrapper


def whole_number(flag: str, low: int, high: int | None, default: int | None, words: str, metavar: str = "") -> Any:
    """An option that takes a whole number from `low` to `high`."""
    shown = default is not None
    kind = click.IntRange(low, high)
    return click.option(flag, type=kind, default=default, show_default=shown, metavar=metavar or None, help=words)


def port_option(default: int) -> Any:
    """The option of a command that serves pages."""
    return whole_number("--port", 0, 65535, default, "Port to serve on; 0 for any free one.")


trust_option = click.option(
    "--trust", is_flag=True, help="Consent to run the Python files of EXPERIMENT ([model] custom) as they are now."
)


def consent(run: Run, experiment: Path) -> None:
    """Store the consent to run the Python files of an experiment, and name them."""
    from sysid.experiment.experiment import trust_experiment

    for path in trust_experiment(experiment):
        run.note(f"trusted as it is now: {path}")


def design_trust(words: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Add `--trust`, the consent to run the user's own checks and parts; above `common_options`, which stores it."""

    def keep(context: click.Context, _: click.Parameter, given: bool) -> None:
        context.meta[TRUST] = given

    what = f"Consent to run the files of {words} as they are now."
    return click.option("--trust", is_flag=True, expose_value=False, callback=keep, help=what)


def without_rules(function: Callable[..., Any]) -> Callable[..., Any]:
    """Below `common_options`: the command accepts a design that violates rules."""
    function.without_rules = True  # type: ignore[attr-defined]
    return function


def without_effect(*names: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Above `common_options`: options that the command accepts as every command does, but has no use for."""

    def hide(function: Callable[..., Any]) -> Callable[..., Any]:
        for option in function.__click_params__:  # type: ignore[attr-defined]
            option.hidden |= option.name in names
        return function

    return hide


def common_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of every command; the function receives them as its first argument, a `Run`."""

    @click.option(
        "--params", type=FILE, help="Parameter file (default: stage.toml here, else the packaged thesis design)."
    )
    @click.option(
        "--set", "overrides", multiple=True, metavar="KEY=VALUE", help="Override a parameter; may be repeated."
    )
    @OUT
    @click.option(
        "--json",
        "json_target",
        metavar="[FILE.json]",
        help="Print one JSON document (and write it to FILE.json when given).",
    )
    @functools.wraps(function)
    def wrapper(
        params: Path | None, overrides: tuple[str, ...], out: Path, json_target: str | None, **rest: Any
    ) -> Any:
        given = click.get_current_context().get_parameter_source("out") is not ParameterSource.DEFAULT
        run = Run(params, overrides, out, json_target, not getattr(function, "without_rules", False), given)
        try:
            if params is not None or overrides:
                # A mistake in them is reported by every command, also by one that reads little of the design.
                _ = run.design.values
            if json_target not in (None, "-"):
                # While nothing has been done yet, rather than after all the work.
                file, name = Path(json_target), f"--json {json_target}"
                above = next(folder for folder in file.absolute().parents if folder.exists())
                require(not file.is_dir(), f"{name}: is a folder; a file is required")
                require(above.is_dir(), f"{name}: {above} is a file, not a folder")
                require(os.access(file if file.exists() else above, os.W_OK), f"{name}: cannot be written")
            if click.get_current_context().meta.get(TRUST):
                run.trust_files()
            with _remarks_shown():
                return function(run, **rest)
        except ViolationsError as error:
            run.emit({"violations": error.documents})
            raise

    return wrapper


def given_options(*names: str) -> list[str]:
    """Those of the options of the command, by the names of its arguments, that are on the command line."""
    context = click.get_current_context()
    default = ParameterSource.DEFAULT
    return [
        p.opts[-1]
        for p in context.command.params
        if p.name in names and context.get_parameter_source(p.name) != default
    ]
