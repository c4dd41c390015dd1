"""What the pages show is true: links lead somewhere, blocks are read by the program's readers, commands run, and print
what is printed there."""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import cadquery
import click
import pytest
from PIL import Image

from drawings.sheets.overrides import read_overrides
from stagecad.parameters.load import load_design
from stagecad.parameters.machine_declaration import read_machine
from sysid.experiment.column_settings import read_channel_settings
from sysid.experiment.experiment import load_experiment, trust_experiment
from sysid.experiment.readers.base import read_format
from sysid.experiment.rig_kinds.declaration import declared_rig, find_rig, kinds
from sysid.experiment.toml_table import TomlTable
from tests.docs.scripts import script
from workbench.cli.dispatch import COMMANDS, stagecad
from workbench.operations.templates import fresh_copy

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
EXAMPLES = sorted((ROOT / "examples").glob("**/README.md"))
"""Pages of the site, too; their files are beside them."""
RUN = ("README.md", "docs/tutorial.md", "docs/parts_and_parameters.md", "docs/checks.md")
"""Pages whose outputs are held against what the commands print."""


def _toml_blocks(page: Path) -> list[str]:
    """Blocks of TOML without a title."""
    return re.findall(r"^```toml\n(.*?)^```", page.read_text("utf-8"), re.MULTILINE | re.DOTALL)


def _records(text: str, folder: Path) -> None:
    top = TomlTable("records.md", "", tomllib.loads(text))
    read_format(top.table("format"))
    for channel, value in top.table("channels").data.items():
        # The block shows channels of several kinds of rig.
        kind = find_rig("velocity-drive" if channel == "friction_force" else "force-drive", "kind")
        assert read_channel_settings(TomlTable("records.md", "channels", {channel: value}), kind)


def _rig_kinds(text: str, folder: Path) -> None:
    if "schema" in text:
        (folder / "experiment.toml").write_text(text)
        for file in re.findall(r'file = "(.*?)"', text):
            (folder / file).write_text(re.findall(r"# (time .*)$", text, re.M)[0] + "\n0,0,0,0\n0.1,1,1,0\n")
        assert load_experiment(folder).rig.kind == "friction-drive"
        return
    kind = declared_rig(TomlTable("rig_kinds.md", "", tomllib.loads(text)), "coil")
    assert kind.base == "force-drive" and list(kind.own) == ["coil_current"]


def _drawings(text: str, folder: Path) -> None:
    (folder / "sheets.toml").write_text(text)
    assert len(read_overrides(folder / "sheets.toml", ["stage"])) == 1


def _design_changes(text: str, folder: Path) -> None:
    machine = tomllib.loads(text)["machine"]
    assert len(read_machine(machine, "stage.toml", load_design()).mates) == len(machine["mates"])


def _parameters(text: str, folder: Path) -> None:
    (folder / "stage.toml").write_text(f'extends = "thesis"\n[stage]\n{text}')
    assert load_design(folder / "stage.toml").entry("stage.thickness").origin.startswith("assumed")


READERS: dict[str, Callable[[str, Path], None]] = {
    "records.md": _records,
    "rig_kinds.md": _rig_kinds,
    "drawings.md": _drawings,
    "design_changes.md": _design_changes,
    "parts_and_parameters.md": _parameters,
}


def test_the_tables_of_rig_kinds_are_those_of_the_program(command) -> None:
    rows = re.findall(r"^\| `([a-z-]+)` \|(.*)\|$", (ROOT / "docs" / "rig_kinds.md").read_text("utf-8"), re.M)
    table = {name: [set(re.findall(r"`(\w+)`", cell)) for cell in text.split("|")] for name, text in rows}
    assert table.keys() == {*kinds()}
    printed = re.sub(r"\s+", " ", command("new", "experiment", "--help").out)
    for name, (first, second, third, *_) in table.items():
        rig = find_rig(name, "")
        recorded, known = (first | second, third) if not rig.base else (first, second)
        needed = {channel for group in (*rig.inputs, *rig.measured) for channel in group}
        assert needed <= recorded <= {*rig.input_channels, *rig.measured_channels}
        # A mass is called inertia on a rotary axis.
        assert known == {*rig.known} - ({"inertia"} if "mass" in rig.known else set())
        assert f"{name} {rig.summary}" in printed
        assert all(re.search(rf"\b{key}\b", rig.summary) for key in (*needed, *rig.known))


def test_pages_with_toml_and_commands_are_found() -> None:
    assert {page.name for page in PAGES if _toml_blocks(page)} == set(READERS)
    found = {page.name: len(_commands(page)) for page in PAGES if _commands(page)}
    assert found["README.md"] == 13 and found["workbench.md"] == 5 and found["drawings.md"] == 8
    assert {page.parent.name for page in EXAMPLES if _commands(page)} == {"improved_stage"}
    assert found["stage_simulation.md"] == 3 and found["causal_friction_model.md"] == 3
    # The test above would pass on a page in which it finds none.
    assert len(_commands_of(ROOT / "README.md")) > 10


@pytest.mark.parametrize("name", READERS)
def test_toml_of_a_page_is_what_the_program_reads(name: str, tmp_path: Path) -> None:
    for block in _toml_blocks(ROOT / "docs" / name):
        READERS[name](block, tmp_path)


def _commands(page: Path) -> list[str]:
    """Commands in blocks without a mark, and in indented ones; comments left out."""
    text = page.read_text("utf-8")
    # The first block of the README is of a shell of its own: make.
    blocks = [body for kind, body in re.findall(r"^```(\S*).*?\n(.*?)^```", text, re.M | re.S) if not kind]
    indented = "\n".join(re.findall(r"^    (stagecad .*)$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.M))
    lines = [line for block in (*blocks, indented) for line in block.splitlines() if line.startswith("stagecad ")]
    return [re.split(r"\s{2,}#", line)[0].rstrip() for line in lines]


SHORTER = {
    "--draws 1000": "--draws 20",
    " --scheduler tcp://ADDRESS": "",
    "--budget 400": "--budget 20",
    '--time "150 s"': '--time "5 s"',
    "0.15:0.45:7": "0.15:0.45:2",
}
"""What is replaced so that a command ends in time, or needs no cluster."""
PREPARED = {
    "issue_a.toml": 'extends = "thesis"\n',
    "rig.toml": 'extends = "thesis"\n',
    "script.py": 'import cadquery\nshow_object(cadquery.Workplane().box(40, 30, 10).faces(">Z").hole(6))\n',
    "part.py": (ROOT / "tests" / "drawings" / "parts" / "housing.py").read_text("utf-8"),
}


LONGEST = 1800.0
"""Wall-clock limit of one command, s: the longest, `simulate stage`, takes minutes on a busy machine of two cores."""


def _environment() -> dict[str, str]:
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    return {**os.environ, "PYTHONPATH": path, "MPLBACKEND": "Agg"}


def _run(command: str, folder: Path) -> None:
    command = "stagecad optimize --budget 20" if command == "stagecad optimize" else command
    for text, other in SHORTER.items():
        command = command.replace(text, other)
    line = command.replace("stagecad ", f"{sys.executable} -m workbench.cli ", 1)
    # A command that never ends, or leaves a process that holds its output, is named.
    done = subprocess.run(
        ["bash", "-c", f"exec {line}"], cwd=folder, env=_environment(), capture_output=True, text=True, timeout=LONGEST
    )
    assert done.returncode in (0, 1) and "Traceback" not in done.stderr, f"{command}\n{done.stderr[-2000:]}"


def _serve(command: str, folder: Path) -> None:
    """Start a server as the page says, but for the browser; it prints its address and ends with Ctrl-C."""
    words = command.split()[1:]
    port = [] if "--port" in words else ["--port", "0"]
    line = [sys.executable, "-m", "workbench.cli", *words, "--no-browser", *port]
    given = {"cwd": folder, "env": _environment(), "stderr": subprocess.PIPE, "text": True}
    # What a shell starts in the background ignores Ctrl-C, and so would the server.
    heed = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    with subprocess.Popen(line, **given, preexec_fn=heed) as server:
        try:
            assert server.stderr is not None
            assert "http://" in (first := server.stderr.readline()), first
            server.send_signal(signal.SIGINT)
            assert server.wait(120.0) in (0, 130)
        finally:
            server.kill()


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [page for page in (*PAGES, *EXAMPLES) if _commands(page)],
    ids=lambda page: page.relative_to(ROOT).as_posix(),
)
def test_commands_of_a_page_run(page: Path, tmp_path: Path) -> None:
    fresh_copy(tmp_path / "rig")
    if page in EXAMPLES:
        folder = page.parent.relative_to(ROOT)
        shutil.copytree(ROOT / folder, tmp_path / folder)
    for name, text in PREPARED.items():
        (tmp_path / name).write_text(text)
    if page.name == "README.md":
        # Its first command makes the experiment of two files.
        for name in ("fit.csv", "validate.csv"):
            shutil.move(tmp_path / "rig" / name, tmp_path / name)
        shutil.rmtree(tmp_path / "rig")
    if "bracket.step" in page.read_text("utf-8"):
        cadquery.exporters.export(cadquery.Workplane().box(40.0, 30.0, 10.0), str(tmp_path / "bracket.step"))
    for command in _commands(page):
        act: Callable[[str, Path], Any] = _serve if command.startswith("stagecad workbench") else _run
        act(command, tmp_path)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_files_of_a_page_are_there(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)]+)\)", text):
        if "://" in target:
            continue
        file, _, anchor = target.partition("#")
        linked = page.parent / file if file else page
        assert linked.exists(), f"{page.name}: {target}"
        if anchor:
            headings = re.findall(r"^#+ (.+)$", linked.read_text(encoding="utf-8"), flags=re.MULTILINE)
            assert anchor in {_anchor(heading) for heading in headings}, f"{page.name}: {target}"
    folders = "benchmarks|designcalc|docs|drawings|examples|sim|stagecad|sysid|tests|workbench"
    for name in re.findall(rf"`((?:{folders})/[\w./]+)`", page.read_text(encoding="utf-8")):
        assert (ROOT / name).exists(), f"{page.name}: {name}"


def _anchor(heading: str) -> str:
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def _commands_of(page: Path) -> list[list[str]]:
    """Words of each stagecad command in the page's blocks, up to a pipe or a comment."""
    found = []
    blocks = re.compile(r"^```\w*\n.*?^```|(?:^    .*\n)+", re.MULTILINE | re.DOTALL)
    for block in blocks.finditer(page.read_text(encoding="utf-8")):
        for line in block[0].splitlines():
            match = re.match(r"\s*(?:\$ )?(?:\.venv\S+[/\\])?stagecad (?P<rest>.*)", line)
            if match:
                words = shlex.split(match["rest"].replace("\\", "/"), comments=True)
                found.append(words[: words.index("|")] if "|" in words else words)
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_and_options_exist(page: Path) -> None:
    context = click.Context(stagecad)
    for words in _commands_of(page):
        assert words and words[0] in COMMANDS, f"{page.name}: stagecad {' '.join(words)}"
        command = stagecad.get_command(context, words[0])
        assert command is not None
        known = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
        if words[0] == "calc":
            continue  # its options are those of each calculator, and checked where the page is run
        for word in words[1:]:
            if word.startswith("--"):
                assert word.partition("=")[0] in known, f"{page.name}: stagecad {' '.join(words)}"


def test_python_of_the_readme_runs(tmp_path, monkeypatch, capsys) -> None:
    (block,) = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text("utf-8"), re.MULTILINE | re.DOTALL)
    shutil.copytree(ROOT / "examples" / "own_effect", tmp_path / "rig")
    trust_experiment(tmp_path / "rig")
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "README.md", "exec"), {})
    before, verdict, after = capsys.readouterr().out.splitlines()
    assert verdict == "missing-effect bellows ()"
    assert float(before) > 10.0 > 1.1 > float(after)


def test_picture_is_small_and_not_blank() -> None:
    file = ROOT / "docs" / "images" / "stagecad.png"
    assert file.stat().st_size < 300_000
    with Image.open(file) as image:
        colours = image.convert("RGB").getcolors(maxcolors=1 << 24)
    assert colours is not None
    total = sum(count for count, _ in colours)
    assert max(count for count, _ in colours) < 0.6 * total


def test_a_page_with_a_false_output_is_found_out(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "# Page\n\n```text title=a.txt\nword\n```\n\n```console\n$ cat a.txt\nother\n```\n", encoding="utf-8"
    )
    old, new = script("refresh").refresh(page)
    assert old != new and new.endswith("$ cat a.txt\nword\n```\n")


@pytest.mark.slow
@pytest.mark.parametrize("name", RUN)
def test_outputs_are_what_the_commands_print(name: str) -> None:
    old, new = script("refresh").refresh(ROOT / name)
    assert new == old, f"run 'python docs/refresh.py {name}'"
