"""The documentation site: the pages of `docs/` and the reference pages in one folder, built by Sphinx.

A link to a file that does not exist, or to a heading that does not exist, is an error of the build.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable, Mapping
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import click

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError

ROOT = Path(__file__).resolve().parents[2]

CONTENTS: dict[str, tuple[str, ...]] = {
    "Start": ("readme", "examples"),
    "Tutorials": (
        "tutorial",
        "notebooks/design_and_checks",
        "notebooks/measurement_to_model",
        "notebooks/new_friction_law",
    ),
    "How to": ("workbench", "checks", "drawings", "step_ap242", "parts_and_parameters", "stage_simulation"),
    "Reference": ("reference_python", "reference_commands", "reference_parameters", "effects"),
    "Theory": ("theory", "diagnosis_step_by_step", "physical_model", "simulation", "causal_friction_model"),
    "Project": ("glossary", "decisions"),
}
"""Pages by part of the site; pages of `docs/` that are not listed are put under "More"."""

CONFIGURATION = """\
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
"""


def documentation_source() -> Path:
    """The folder `docs` beside the packages."""
    folder = ROOT / "docs"
    if not (folder / "index.md").is_file():
        raise InputError(
            f"{folder}: the pages of the documentation are not installed; they are in the source of stagecad"
        )
    return folder


def build_site(folder: Path, generated: Mapping[str, str]) -> Path:
    """Build the site; returns its folder of HTML pages."""
    try:
        from sphinx.cmd.build import build_main
    except ImportError:
        raise InputError("the documentation is built by Sphinx: pip install 'stagecad[docs]'") from None
    source, html, log = folder / "source", folder / "html", folder / "warnings.txt"
    write_source(source, generated)
    arguments = ["-q", "-b", "html", "-d", str(folder / "doctrees"), "-w", str(log), str(source), str(html)]
    status = build_main(arguments)
    faults = [line for line in log.read_text("utf-8").splitlines() if line.strip()] if log.is_file() else []
    if status or faults:
        raise InputError(f"documentation: {faults[0] if faults else 'was not built'} ({len(faults)} faults in {log})")
    return html


def write_source(folder: Path, generated: Mapping[str, str]) -> None:
    """Put pages, pictures and configuration into one folder, their links adapted to it."""
    docs = documentation_source()
    texts = {page.relative_to(docs).as_posix(): page.read_text("utf-8") for page in sorted(docs.rglob("*.md"))}
    texts["readme.md"] = (ROOT / "README.md").read_text("utf-8")
    texts["examples.md"] = (ROOT / "examples" / "README.md").read_text("utf-8")
    texts |= {f"{name}.md": text for name, text in generated.items()}
    texts = {name: site_links(text) for name, text in texts.items()}
    notebooks = {page.relative_to(docs).as_posix() for page in docs.rglob("*.ipynb")}
    pages = {name.rpartition(".")[0] for name in (*texts, *notebooks)} - {"index"}
    texts["index.md"] += contents(pages)
    texts["conf.py"] = CONFIGURATION
    for name, text in texts.items():
        _write_changed(folder / name, text)
    for file in docs.rglob("*"):
        if file.suffix in (".png", ".svg", ".ipynb"):
            target = folder / file.relative_to(docs)
            target.parent.mkdir(parents=True, exist_ok=True)
            if not target.is_file() or target.read_bytes() != file.read_bytes():
                shutil.copyfile(file, target)
    kept = {folder / name for name in texts}
    for file in [*folder.rglob("*.md"), *folder.rglob("*.ipynb")]:
        if file not in kept and not (docs / file.relative_to(folder)).is_file():
            file.unlink()


def contents(pages: set[str]) -> str:
    """The tables of contents of the first page."""
    listed = [page for group in CONTENTS.values() for page in group]
    missing = [page for page in listed if page not in pages]
    if missing:
        raise InputError(f"documentation: page '{missing[0]}' of the contents does not exist")
    groups = {**CONTENTS, "More": tuple(sorted(pages - set(listed)))}
    return "".join(
        f"\n```{{toctree}}\n:hidden:\n:caption: {title}\n\n" + "\n".join(names) + "\n```\n"
        for title, names in groups.items()
        if names
    )


LINK = re.compile(r"(?P<text>\[[^\]\n]*\])\((?P<target>[^)\s]+)\)")


def site_links(text: str) -> str:
    """A page with links as in the site: `docs/` is the root, and files that are no pages are only named."""

    def adapted(link: re.Match[str]) -> str:
        target = link["target"]
        if re.match(r"[a-z]+:|#", target):
            return link[0]
        path, mark, anchor = target.partition("#")
        path = re.sub(r"^(\.\./)?README\.md$", "readme.md", path).removeprefix("docs/").removeprefix("../docs/")
        path = "examples.md" if path in ("examples", "../examples", "../examples/README.md") else path
        beside = (ROOT / path).is_file() and not (ROOT / "docs" / path).is_file()
        if not path.endswith((".md", ".ipynb", ".png", ".svg")) or path.startswith("../") or beside:
            return f"{link['text'][1:-1]} (`{path}`)"
        return f"{link['text']}({path}{mark}{anchor})"

    return LINK.sub(adapted, text)


def _write_changed(file: Path, text: str) -> None:
    if not file.is_file() or file.read_text("utf-8") != text:
        atomic_write_text(file, text)


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


class _Quiet(SimpleHTTPRequestHandler):
    """Files of one folder; requests are not logged."""

    def log_message(self, format: str, *arguments: Any) -> None:
        pass


def documentation_server(folder: Path, port: int) -> ThreadingHTTPServer:
    """A server of the files of a folder on 127.0.0.1; `port` 0 takes a free one."""
    try:
        return ThreadingHTTPServer(("127.0.0.1", port), partial(_Quiet, directory=str(folder)))
    except OSError as error:
        raise InputError(f"--port {port}: {error.strerror}; choose another, or 0 for a free one") from None
