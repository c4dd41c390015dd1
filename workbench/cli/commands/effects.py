"""`stagecad effects`: the library of physical effects, printed from its declarations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from workbench.cli.options import Run, common_options


@click.command("effects")
@click.argument("name", required=False)
@click.option(
    "--custom",
    "custom_files",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE.py",
    help="A file of your own effects, checked and listed with the built-in ones; may be repeated.",
)
@click.option(
    "--write",
    "target",
    type=click.Path(path_type=Path),
    metavar="FILE.py",
    help="Write an effect of your own to a new file to start from.",
)
@common_options
def command(run: Run, name: str | None, custom_files: tuple[Path, ...], target: Path | None) -> None:
    """List the physical effects, or describe one: NAME, NAME:VARIANT."""
    from sim.effects.catalogue import find, library
    from sim.effects.custom import load_all_custom

    if target is not None:
        from workbench.operations.templates import write_effect

        name = write_effect(target)
        run.note(
            f'written: {target}; to have it tried, put custom = ["{target.name}"] under [model] in experiment.toml '
            "and give --trust after each change"
        )
        custom_files = (*custom_files, target)
    custom = load_all_custom(custom_files)
    if name is None:
        effects = [*library().values(), *custom]
        _list(run, effects)
        run.emit([_document(effect) for effect in effects])
        return
    effect = find(name, custom)
    _tell(run, effect)
    run.emit(_document(effect))


def _document(effect: Any) -> dict[str, Any]:
    return {
        "name": effect.name,
        "meaning": effect.meaning,
        "equation": effect.equation,
        "acts_on": effect.acts_on,
        "core": effect.friction_state is not None,
        "shows": effect.shows,
        "dissipation": effect.energy,
        "coordinates": list(effect.coordinates),
        "needs": list(effect.needs),
        "source": effect.source,
        "parameters": [
            {
                "name": f"{effect.name}.{parameter.name}",
                "unit": parameter.unit,
                "default": {"value": parameter.default, "unit": parameter.unit},
                "low": {"value": parameter.low, "unit": parameter.unit},
                "high": {"value": parameter.high, "unit": parameter.unit},
                "meaning": parameter.meaning,
                "source": parameter.source,
                "role": parameter.role,
                "fixed": parameter.fixed,
            }
            for parameter in effect.parameters
        ],
        "variants": [variant.name for variant in effect.variants],
    }


def _list(run: Run, effects: list[Any]) -> None:
    from rich.table import Table

    table = Table(box=None, header_style="bold", pad_edge=False)
    for heading in ("effect", "acts on", "meaning", "parameters"):
        table.add_column(heading, overflow="fold")
    for effect in effects:
        kind = f"{effect.acts_on} (state model)" if effect.friction_state is not None else effect.acts_on
        names = ", ".join(p.name if p.unit == "1" else f"{p.name} \\[{p.unit}]" for p in effect.parameters)
        table.add_row(effect.name, kind, effect.meaning, names)
    run.console.print(table)


def _tell(run: Run, effect: Any) -> None:
    from rich.table import Table

    lines = [("", effect.meaning), ("law", effect.equation), ("shows", effect.shows), ("acts on", effect.acts_on)]
    if effect.friction_state is not None:
        lines.append(("state model", f"turns the friction level into a force; state: {effect.friction_state.state}"))
    if effect.coordinates:
        lines.append(("depends on", ", ".join(effect.coordinates)))
    if effect.needs:
        lines.append(("needs", ", ".join(effect.needs)))
    lines += [("dissipation", effect.energy), ("source", effect.source)]
    if effect.variants:
        lines.append(("variants", ", ".join(variant.name for variant in effect.variants)))
    grid = Table(box=None, show_header=False, pad_edge=False)
    grid.add_column(style="bold", no_wrap=True)
    grid.add_column(overflow="fold")
    grid.add_row(effect.name, lines[0][1], style="bold")
    for label, text in lines[1:]:
        if text:
            grid.add_row(label, text)
    run.console.print(grid)
    if not effect.parameters:
        return
    run.console.print()
    table = Table(box=None, header_style="bold", pad_edge=False)
    for heading in ("parameter", "default", "bounds", "role", "meaning", "source of default and bounds"):
        table.add_column(heading, overflow="fold")
    for parameter in effect.parameters:
        table.add_row(
            parameter.name,
            f"{parameter.default:g} {parameter.unit}" if parameter.unit != "1" else f"{parameter.default:g}",
            f"{parameter.low:g} .. {parameter.high:g}",
            f"{parameter.role}, fixed" if parameter.fixed else parameter.role,
            parameter.meaning,
            parameter.source,
        )
    run.console.print(table)
