"""Configuration of the documentation site: its contents, its links, and the reference pages made from the code.

`stagecad docs` copies the pages into a folder (README.md as readme.md, that of the examples as examples.md) and builds
the site there. A link to a file that does not exist, or to a heading that does not exist, is an error of the build.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click

project = "stagecad"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = "stagecad"
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
nb_execution_mode = "off"
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
autodoc_typehints = "description"
autodoc_member_order = "bysource"
napoleon_use_rtype = False
default_role = "code"
# Lexers that meet shell output and cut TOML.
suppress_warnings = ["misc.highlighting_failure", "myst.header"]

CONTENTS: dict[str, tuple[str, ...]] = {
    "Start": ("readme", "examples"),
    "Tutorials": (
        "tutorial",
        "notebooks/design_and_checks",
        "notebooks/measurement_to_model",
        "notebooks/new_friction_law",
        "notebooks/compensation",
    ),
    "How to": (
        "records",
        "rig_kinds",
        "workbench",
        "export",
        "parts_and_parameters",
        "design_changes",
        "checks",
        "drawings",
        "step_ap242",
        "stage_simulation",
    ),
    "Reference": ("reference_python", "reference_commands", "reference_parameters", "effects"),
    "Theory": ("theory", "diagnosis_step_by_step", "physical_model", "simulation", "causal_friction_model"),
    "Project": ("glossary", "decisions"),
}
"""Pages by part of the site; pages that are not listed are put under "More"."""
HEAD = """<link rel="icon" href="data:,">
<style>
.cell_output, .output { overflow-x: auto; }
table.dataframe { border: 0; border-collapse: collapse; font-size: 0.8rem; }
table.dataframe th, table.dataframe td { border: 0; border-bottom: 1px solid var(--color-background-border); }
</style>
"""
"""In each page: no output of a notebook is wider than its column, and its tables have the colours of the theme."""
BESIDE = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
"""Files beside README.md that are no pages of the site."""
LINK = re.compile(r"(?P<text>\[[^\]\n]*\])\((?P<target>[^)\s]+)\)")


def setup(app: Any) -> None:
    """Connect what writes the reference pages and adapts the others."""
    app.connect("builder-inited", write_reference)
    app.connect("env-get-outdated", lambda *_: ["index"])
    app.connect("source-read", read_page)
    app.connect("html-page-context", add_to_head)


def write_reference(app: Any) -> None:
    """Write the reference pages beside the others."""
    from workbench.cli.dispatch import stagecad

    pages = {"python": python_page(), "commands": commands_page(stagecad), "parameters": parameters_page()}
    for name, text in pages.items():
        (Path(app.srcdir) / f"reference_{name}.md").write_text(text, encoding="utf-8")


def read_page(app: Any, name: str, source: list[str]) -> None:
    """Adapt the links of a page; the first one gets the tables of contents."""
    if Path(app.env.doc2path(name)).suffix == ".md":
        source[0] = site_links(source[0])
    if name == "index":
        source[0] += contents(set(app.env.found_docs) - {"index"})


def add_to_head(app: Any, name: str, template: str, context: dict[str, Any], document: Any) -> None:
    context["metatags"] = context.get("metatags", "") + HEAD


def contents(pages: set[str]) -> str:
    """The tables of contents of the first page."""
    listed = {page for group in CONTENTS.values() for page in group}
    groups = {**CONTENTS, "More": tuple(sorted(pages - listed))}
    return "".join(
        f"\n```{{toctree}}\n:hidden:\n:caption: {title}\n\n" + "\n".join(names) + "\n```\n"
        for title, names in groups.items()
        if names
    )


def site_links(text: str) -> str:
    """A page with links as in the site: `docs/` is the root, and files that are no pages are only named."""

    def adapted(link: re.Match[str]) -> str:
        target = link["target"]
        if re.match(r"[a-z]+:|#", target):
            return link[0]
        path, mark, anchor = target.partition("#")
        path = re.sub(r"^(\.\./)?README\.md$", "readme.md", path).removeprefix("docs/").removeprefix("../docs/")
        path = "examples.md" if path in ("examples", "../examples", "../examples/README.md") else path
        if not path.endswith((".md", ".ipynb", ".png", ".svg")) or path.startswith("../") or path in BESIDE:
            return f"{link['text'][1:-1]} (`{path}`)"
        return f"{link['text']}({path}{mark}{anchor})"

    return LINK.sub(adapted, text)


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
