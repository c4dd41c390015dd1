"""`stagecad params`: every number of the machine with unit, tolerance and origin; differences between two files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from workbench.cli.options import Run, common_options

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.file import Entry
    from stagecad.parameters.load import Difference


@click.command("params")
@click.argument("names", nargs=-1, metavar="[TABLE|KEY...]")
@click.option(
    "--diff",
    "other",
    type=click.Path(path_type=Path),
    metavar="OTHER.toml",
    help="Show only what differs from OTHER.toml.",
)
@click.option(
    "--write",
    "target",
    type=click.Path(path_type=Path),
    metavar="FILE.toml",
    help="Write the parameters, with --set applied and comments kept, to a new file to start from.",
)
@common_options
def command(run: Run, names: tuple[str, ...], other: Path | None, target: Path | None) -> None:
    """The parameters with unit, tolerance and origin; all of them, or those of the tables and keys named."""
    from stagecad.parameters.load import diff, load_design
    from workbench.operations.parameter_json import difference_json, entry_json

    design = run.design.values
    if target is not None:
        _write(run, target)
    if other is not None:
        differences = [item for item in diff(design, load_design(other)) if _named(item.key, names, design)]
        show_differences(run, design.file, str(other), differences)
        run.emit({"files": [design.file, str(other)], "differences": [difference_json(d) for d in differences]})
        return
    entries = [entry for entry in design.entries if _named(entry.key, names, design)]
    if target is None:
        _show(run, entries)
    run.emit(
        {
            "file": design.file,
            "digest": design.digest,
            "parameters": {entry.key: entry_json(entry) for entry in entries},
        }
    )


def _named(key: str, names: tuple[str, ...], design: Design) -> bool:
    from stagecad.parameters.design import nearest_key
    from stagecad.parameters.errors import InputError

    known = [entry.key for entry in design.entries]
    for name in names:
        if not any(item == name or item.startswith(f"{name}.") for item in known):
            tables = {item.rpartition(".")[0] for item in known}
            hint = nearest_key(name, known) if "." in name else nearest_key(name, tables)
            raise InputError(f"no table or parameter '{name}'{hint}")
    return not names or any(key == name or key.startswith(f"{name}.") for name in names)


def _write(run: Run, target: Path) -> None:
    from stagecad.parameters.atomic import atomic_write_text
    from stagecad.parameters.errors import InputError

    if target.exists():
        raise InputError(f"{target}: is there already; name a new file")
    atomic_write_text(target, run.design.to_toml())
    run.note(f"written: {target}")


def _text(entry: Entry) -> str:
    return f"{entry.text} {entry.formula}".strip()


def _show(run: Run, entries: list[Entry]) -> None:
    from rich.table import Table
    from rich.text import Text

    if run.json_target is not None:
        return
    table = Table("parameter", "value", "tolerance", "meaning", "origin", box=None, pad_edge=False)
    before = ""
    for entry in entries:
        group = entry.key.rpartition(".")[0]
        if before and group != before:
            table.add_row("", "", "", "", "")
        before = group
        cells = (entry.key, _text(entry), entry.tolerance or "", entry.meaning, entry.origin)
        table.add_row(*(Text(cell) for cell in cells))
    run.console.print(table)


def show_differences(run: Run, one: str, other: str, differences: list[Difference]) -> None:
    """Print the keys that differ with both values."""
    from rich.table import Table
    from rich.text import Text

    if run.json_target is not None:
        return
    if not differences:
        run.echo(f"{one} and {other} do not differ")
        return
    table = Table("parameter", one, other, "what differs", box=None, pad_edge=False)
    for item in differences:
        cells = (item.key, _cell(item.before), _cell(item.after), _what(item))
        table.add_row(*(Text(cell) for cell in cells))
    run.console.print(table)


def _cell(entry: Entry | None) -> str:
    if entry is None:
        return "absent"
    tolerance = f" ({entry.tolerance})" if entry.tolerance else ""
    return f"{_text(entry)}{tolerance}; {entry.origin}"


def _what(difference: Difference) -> str:
    before, after = difference.before, difference.after
    if before is None or after is None:
        return "present in one"
    parts = [name for name in ("value", "tolerance", "origin") if getattr(before, name) != getattr(after, name)]
    return ", ".join(parts)
