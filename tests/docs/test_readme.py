"""The pages keep their word: links lead somewhere, commands and options exist, and outputs are what is printed now."""

import re
import shlex
import shutil
from pathlib import Path

import click
import pytest
from PIL import Image

from sysid.experiment.experiment import trust_experiment
from tests.docs.scripts import script
from workbench.cli.dispatch import COMMANDS, stagecad

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
RUN = ("README.md", "docs/tutorial.md", "docs/parts_and_parameters.md", "docs/checks.md")
"""Pages whose outputs are held against what the commands print."""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
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


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_that_a_page_names_are_there(page: Path) -> None:
    folders = "benchmarks|designcalc|docs|drawings|examples|sim|stagecad|sysid|tests|workbench"
    for name in re.findall(rf"`((?:{folders})/[\w./]+)`", page.read_text(encoding="utf-8")):
        assert (ROOT / name).exists(), f"{page.name}: {name}"


def _anchor(heading: str) -> str:
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def _commands(page: Path) -> list[list[str]]:
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
    for words in _commands(page):
        assert words and words[0] in COMMANDS, f"{page.name}: stagecad {' '.join(words)}"
        command = stagecad.get_command(context, words[0])
        assert command is not None
        known = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
        if words[0] == "calc":
            continue  # its options are those of each calculator, and checked where the page is run
        for word in words[1:]:
            if word.startswith("--"):
                assert word.partition("=")[0] in known, f"{page.name}: stagecad {' '.join(words)}"


def test_readme_names_commands() -> None:
    # The test above would pass on a page in which it finds none.
    assert len(_commands(ROOT / "README.md")) > 10


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
    assert old != new
    assert new.endswith("$ cat a.txt\nword\n```\n")


@pytest.mark.slow
@pytest.mark.parametrize("name", RUN)
def test_outputs_are_what_the_commands_print(name: str) -> None:
    old, new = script("refresh").refresh(ROOT / name)
    assert new == old, f"run 'python docs/refresh.py {name}'"
