"""Every command creates and changes only files below `--out`, those that it is told to write and, of `add`, the
experiment's own, whatever names are in the user's files."""

import hashlib
import os
from pathlib import Path

import pytest

from tests.stagecad.parameters.test_broken_files import PIEZOS
from tests.sysid.slide import SIGN, VELOCITY, slide
from workbench.cli import run
from workbench.cli.dispatch import COMMANDS as EVERY

LEFT_OUT = {"effects", "calc", "docs", "workbench"}
"""Commands that write no files, or that serve until they are ended."""
COMMANDS = {
    "params": ("params --write new.toml", {"new.toml"}),
    "new experiment": ("new experiment other rig/fit.csv --kind velocity-drive", {"other"}),
    "new machine": ("new machine mine", {"mine"}),
    "new effect": ("new effect mine", {"mine.py"}),
    "new part": ("new part mine", {"mine.py"}),
    "new check": ("new check mine", {"checks"}),
    "new hardware": ("new hardware springs", {"springs.csv"}),
    "new example": ("new example own_effect", {"own_effect"}),
    "look": ("look rig --json out.json", {"out.json"}),
    "compare": ("compare rig", set()),
    "diagnose": ("diagnose rig", set()),
    "suggest": ("suggest rig", set()),
    "add": ("add rig viscous", {"rig"}),
    "ladder": ("ladder rig", set()),
    "export": ("export rig --to python", set()),
    "simulate": ("simulate rig", set()),
    "check": ("check --no-solids --figures --sweep preload.force=3N:4N:2", set()),
    "optimize": ("optimize --no-solids --no-figures --budget 20 --evaluations 50 --write b.toml", {"b.toml", "b.md"}),
    "demo": ("demo", set()),
    "parts": ("parts magnet piezo", set()),
    "drawings": ("drawings magnet tooth_bar", set()),
    "make": ("make --no-simulations", set()),
    "diff": ("diff thesis other.toml", set()),
}  # fmt: skip
LONG = ("make", "diff", "drawings", "parts", "demo", "suggest", "optimize", "diagnose")
HOSTILE = "../../UP /tmp/ABS =cmd <b>"
"""Name of a row of a catalogue, and title of the drawings."""


def test_every_command_that_writes_is_tried() -> None:
    assert {name.split()[0] for name in COMMANDS} | LEFT_OUT == set(EVERY)


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in COMMANDS])
def test_nothing_else_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    work = tmp_path / "outer" / "work"
    slide(work / "rig", 1.3 * SIGN + 20.0 * VELOCITY, "coulomb", held_out=True)
    stage = f"extends = 'thesis'\n[hardware]\npiezos = 'piezos.csv'\n[piezo]\nrow = '{HOSTILE}'\n"
    (work / "other.toml").write_text(stage)
    (work / "stage.toml").write_text(f"{stage}[drawing]\ntitle = {{value = '{HOSTILE}', origin = 'assumed: any'}}\n")
    (work / "piezos.csv").write_text(PIEZOS.replace("long stroke", HOSTILE))
    monkeypatch.chdir(work)
    words, own = COMMANDS[name]
    if name == "ladder":
        assert run(["add", "rig", "viscous"]) == 0
    before = content(tmp_path)
    out = [] if name.split()[0] in ("new", "params") else ["--out", "results"]
    assert run([*words.split(), *out]) in (0, 1)
    after = content(tmp_path)
    changed = {path for path in {*before, *after} if before.get(path) != after.get(path)}
    allowed = tuple(str(work / one) for one in {"results", *own})
    assert changed and all(path.startswith(allowed) for path in changed), sorted(changed)


def content(folder: Path) -> dict[str, str]:
    files = (Path(root) / name for root, _, names in os.walk(folder) for name in names)
    return {str(file): hashlib.sha256(file.read_bytes()).hexdigest() for file in files}
