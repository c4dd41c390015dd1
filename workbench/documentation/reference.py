"""Reference pages from the code: the Python interface, the commands, the parameters."""

from __future__ import annotations

from collections.abc import Iterable

import click

GROUPS: dict[str, tuple[str, ...]] = {
    "A design": (
        "load_design",
        "Design",
        "checks",
        "Checks",
        "diff",
        "Differences",
        "optimize",
        "Optimisation",
        "parts",
        "Parts",
        "drawings",
        "Drawings",
    ),
    "An experiment": ("Experiment", "Record", "Rig", "RigKind", "Model", "Effect", "Parameter", "Scan"),
    "A measurement and its model": (
        "look",
        "Look",
        "compare",
        "Comparison",
        "diagnose",
        "Diagnosis",
        "add",
        "Addition",
        "undo",
        "Restoration",
        "ladder",
        "Ladder",
        "suggest",
        "Suggestion",
        "export",
        "Export",
    ),
    "Simulation": ("simulate", "Simulation", "SimulatedRecords"),
    "Errors": ("InputError",),
}
"""Public names of `stagecad` by section of their page."""

INTRODUCTION = """\
# Python interface

`import stagecad` offers what the commands do, on objects. Results print as one line; a notebook shows a table.
`to_dataframe()` gives the data, `to_json()` the document that the command prints with `--json`, `plot()` a figure for
print (`savefig("name.pdf")`). Numbers are in SI; where a text with a unit is required, it is written as in the files.
A mistake raises `InputError` with one line that names what is wrong and what is allowed.

```python
import stagecad

experiment = stagecad.Experiment.from_dataframes({"fit": log}, rig="velocity-drive", model=["coulomb", "viscous"])
found = stagecad.diagnose(experiment)
print(found.verdict, found.effect)
```

The [notebooks](notebooks/design_and_checks.ipynb) show it at work.
"""


def python_page() -> str:
    """The page on `import stagecad`, for Sphinx to fill from the docstrings."""
    parts = [INTRODUCTION]
    for title, names in GROUPS.items():
        directives = "\n".join(_directive(name) for name in names)
        parts.append(f"## {title}\n\n```{{eval-rst}}\n.. currentmodule:: stagecad\n\n{directives}```\n")
    return "\n".join(parts)


def _directive(name: str) -> str:
    if name[0].islower():
        return f".. autofunction:: {name}\n"
    return f".. autoclass:: {name}\n   :members:\n   :inherited-members: Exception\n   :exclude-members: summary\n"


def commands_page(group: click.Group) -> str:
    """The page on the commands: purpose, arguments and options of each."""
    context = click.Context(group, info_name="stagecad")
    parts = [
        "# Commands\n",
        "Exit status: 0 done; 1 a check fails or a drawing has a lint hit; 2 bad input, with one line that says what "
        "is wrong and what is allowed; 130 on Ctrl-C.\n",
    ]
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if command is not None:
            inner = click.Context(command, info_name=name, parent=context)
            parts += [f"## stagecad {name}\n", f"    {command.get_usage(inner)}\n", f"{_text(command.help or '')}\n"]
            rows = [record for p in command.params if (record := p.get_help_record(inner)) is not None]
            parts.append(_table(("option", "meaning"), [(f"`{option}`", _text(text)) for option, text in rows]))
    return "\n".join(parts)


def parameters_page() -> str:
    """The page on the keys of a parameter file: meaning, unit, value of the packaged machine."""
    from stagecad.parameters.load import load_design

    design = load_design()
    tables: dict[str, list[tuple[str, str, str, str]]] = {}
    for entry in design.entries:
        row = (f"`{entry.key}`", entry.text, _text(entry.meaning), _text(entry.origin))
        tables.setdefault(entry.key.rpartition(".")[0], []).append(row)
    parts = ["# Parameters\n", "Keys of a parameter file, with the values of the packaged machine and their origins.\n"]
    for name, rows in tables.items():
        parts += [f"## {name}\n", _table(("key", "value", "meaning", "origin"), rows)]
    return "\n".join(parts)


def _text(words: str) -> str:
    """A text of the code in one line, with the characters that Markdown would take for its own."""
    return " ".join(words.split()).replace("\\", "\\\\").replace("*", "\\*").replace("<", "&lt;").replace("|", "\\|")


def _table(titles: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    titles = tuple(titles)
    head = f"| {' | '.join(titles)} |\n|{' --- |' * len(titles)}\n"
    lines = [f"| {' | '.join(cell.replace('`|', '`').replace(chr(10), ' ') for cell in row)} |" for row in rows]
    return head + "\n".join(lines) + "\n"
