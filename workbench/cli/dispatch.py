"""The command line: finds the command, and turns every way a run can end into an exit status.

A command's module is imported only when that command runs, so `stagecad --help` is fast.
Exit status: 0 done; 1 a check fails or a drawing has a lint hit; 2 bad input or usage, one line; 130 Ctrl-C.
"""

import errno
import os
import sys
import tomllib
import traceback
from collections.abc import Sequence
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from re import findall

import click

from stagecad import __version__
from stagecad.parameters.errors import InputError, LostProcessError, PartError, ViolationsError, nearest, one_line

GROUPS: dict[str, dict[str, list[str]]] = tomllib.loads(Path(__file__).with_name("commands.toml").read_text("utf-8"))
"""Commands by what one wants to do, each with what it is for, and examples."""
COMMANDS = {name: words for commands in GROUPS.values() for name, words in commands.items()}


class Group(click.Group):
    """A group of commands with their whole help; an unknown one is refused with the most similar one."""

    refusal = "no command '{}'"

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        known = self.list_commands(ctx)
        if args and not args[0].startswith("-") and args[0] not in known:
            raise click.UsageError(self.refusal.format(args[0]) + self.hint(args[0], known), ctx)
        return super().resolve_command(ctx, args)

    def hint(self, word: str, known: list[str]) -> str:
        """Which command may be meant by an unknown word, as the end of a line."""
        return nearest(word, known)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, " ".join((one.help or "").split())) for name, one in self.commands.items()])


SPELLING = 0.85
"""Similarity of a word with the name of a command from which it is that name, misspelt or in the plural."""


class LazyGroup(Group):
    """A command group that imports `workbench.cli.commands.NAME` only when NAME is run."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command = import_module(f"workbench.cli.commands.{cmd_name}").command
        command.epilog = "\b\n" + "\n".join(COMMANDS[cmd_name][1:])
        return command

    def hint(self, word: str, known: list[str]) -> str:
        if get_close_matches(word, known, n=1, cutoff=SPELLING):
            return nearest(word, known)
        one = word.lower().removesuffix("s")
        said = {
            name: [w.removesuffix("s") for w in findall(r"\w+", words[0].lower())] for name, words in COMMANDS.items()
        }
        places = {name: words.index(one) for name, words in said.items() if one in words}
        return f"; did you mean '{min(places, key=places.__getitem__)}'?" if places else nearest(word, known)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        width = max(map(len, COMMANDS))
        for title, commands in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([(name.ljust(width), words) for name, (words, *_) in commands.items()])
                formatter.write_paragraph()
                for _, example, *_ in list(commands.values())[:2]:
                    formatter.write_text(example)


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(__version__, "-V", "--version", prog_name="stagecad")
def stagecad() -> None:
    """Design a piezo friction-drive stage, and find out why the real one does not behave like the model."""


def _settled(arguments: Sequence[str]) -> list[str]:
    """`help COMMAND` as `COMMAND --help`; and `--json` with its value: the next word when that ends in `.json`, else
    standard output."""
    settled: list[str] = []
    words = [*arguments[1:], "--help"] if arguments[:1] == ["help"] else list(arguments)
    while words:
        word = words.pop(0)
        if word == "--":
            return [*settled, word, *words]
        if word == "--json":
            word = f"--json={words.pop(0)}" if words and words[0].endswith(".json") else "--json=-"
        settled.append(word)
    return settled


def _refused(*lines: str) -> int:
    """Write lines on a mistake; the exit status."""
    for line in lines:
        sys.stderr.write(f"stagecad: {one_line(line)}\n")
    return 2


def run_line(arguments: Sequence[str]) -> int:
    """Run one command line (without the program's name) and return its exit status."""
    stdout = sys.stdout
    try:
        status = stagecad.main(args=_settled(arguments), prog_name="stagecad", standalone_mode=False)
    except click.Abort as end:
        if isinstance(end.__cause__, EOFError):
            # No command reads its input: the compiled form of a module may have been cut off by a full disk.
            files = (frame.f_locals.get("bytecode_path") for frame, _ in traceback.walk_tb(end.__cause__.__traceback__))
            return _refused(f"{next(filter(None, files), 'a file')}: is cut off; remove it")
        sys.stderr.write("stopped\n")
        return 130
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return 0
    except click.exceptions.Exit as end:
        return end.exit_code
    except click.ClickException as error:
        return _refused(error.format_message())
    except ViolationsError as error:
        return _refused(*error.explained())
    except InputError as error:
        sys.stderr.write(f"stagecad: {error}\n")
        return 2
    except PartError as error:
        from workbench.operations.parts import refusal_line

        line = refusal_line(error)
        if line is None:
            raise
        return _refused(line)
    except LostProcessError as error:
        return _refused(f"{error}; is there enough memory?")
    except (MemoryError, ImportError) as error:
        # A library that finds no room for its code is an import that fails.
        if isinstance(error, ImportError) and "failed to map segment" not in str(error):
            raise
        return _refused("there is not enough memory; give shorter records, or fewer of them")
    except (SystemExit, BrokenPipeError) as error:
        if "_STAGECAD_COMPLETE" in os.environ:
            return 0  # a shell has asked for the completion of a word
        # Where the reader has gone, rich ends the program, and so does click, which replaces the stream.
        gone = sys.stdout is not stdout or isinstance(error.__context__, BrokenPipeError)
        if isinstance(error, SystemExit) and not gone:
            return _refused("Python code of your own ended the program (sys.exit); it must return")
        # The reader (head, less) has gone; this is not an error. Prevent the interpreter's message at exit.
        sys.stdout = None
        return 0
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            # An error of a write names no file. The rest of the output cannot be printed at exit either.
            sys.stdout = None
            return _refused("no space is left to write to; no file is left half written")
        place = "" if error.filename is None else f"{error.filename}: "
        return _refused(f"{place}{error.strerror or error}")
    return status if isinstance(status, int) else 0
