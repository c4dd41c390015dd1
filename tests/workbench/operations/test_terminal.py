"""What a user at a terminal is told: progress, waits of the CAD kernel, and designs that it refuses."""

import io
import pickle
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from rich.console import Console
from rich.progress import Progress

import workbench.cli.commands.parts as parts_command
from stagecad.parameters.design import Design
from stagecad.parameters.errors import PartError
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import CRASHED
from stagecad.solids.artefacts.store import ArtefactStore, DamagedError, write_stored
from sysid.diagnose import diagnose
from workbench.cli.commands.parts import KERNEL
from workbench.cli.console import search_progress
from workbench.cli.options import Run
from workbench.operations import parts
from workbench.operations.parts import MOST_NAMED, refusal_line
from workbench.operations.templates import fresh_copy


def test_a_bar_counts_what_is_done_and_then_runs_on() -> None:
    now = 0.0
    with Progress(console=Console(file=io.StringIO()), get_time=lambda: now, auto_refresh=False) as progress:
        show = search_progress(progress, "afterwards")
        assert progress.tasks[0].total is None
        seen = []
        for count in range(3):
            now += 5.0
            show(f"effect {count}", count, 2)
            (task,) = progress.tasks
            seen.append((task.description, task.completed, task.total, task.elapsed))
    assert seen == [("effect 0", 0, 2, 5.0), ("effect 1", 1, 2, 10.0), ("afterwards", 0, None, 15.0)]


@pytest.mark.slow
def test_a_diagnosis_knows_from_the_first_step_how_many_it_counts(tmp_path: Path) -> None:
    steps: list[tuple[str, int, int]] = []
    found = diagnose(fresh_copy(tmp_path / "rig"), progress=lambda *step: steps.append(step))
    assert len({total for _, _, total in steps}) == 1
    total = steps[0][2]
    assert [count for _, count, _ in steps] == list(range(total + 1))
    # The screening is counted: each effect is scored, and the promising ones are fitted.
    assert found.best is not None and found.best.name in [name for name, _, _ in steps]
    assert steps[-1] == ("", total, total)


def test_what_cannot_be_counted_shows_that_it_runs_on_a_terminal_alone(tmp_path, monkeypatch, command) -> None:
    folder = fresh_copy(tmp_path / "rig")
    assert "fitting the model" not in command("compare", folder, "--no-figures").err
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert "fitting the model as it stands" in command("compare", folder, "--no-figures").err
    assert "fitting the model without viscous" in command("add", folder, "--drop", "viscous").err


def test_changes_of_a_refusal_are_of_the_part_first_and_counted() -> None:
    design = load_design(None, ["stage.thickness=13 mm", "tip.hub_diameter=24 mm"], rules=False)
    error = pickle.loads(pickle.dumps(PartError("tip", design, "StdFail_NotDone: BRep_API: command not done")))
    line = refusal_line(error)
    assert line is not None
    assert "no valid solid of 'tip' with tip.hub_diameter = 24 mm (packaged: 22 mm), stage.thickness = 13 mm" in line
    assert "StdFail_NotDone" in line
    keys = [entry.key for entry in load_design().entries if entry.unit == "mm" and entry.key.startswith("base.")][:9]
    packaged = load_design()
    design = load_design(None, [f"{key}={1.01 * packaged.value(key):.6g} mm" for key in keys], rules=False)
    line = refusal_line(PartError("base", design, "failed"))
    assert line is not None and line.count("(packaged: ") == MOST_NAMED and " more; bring them" in line


def test_the_packaged_design_is_a_fault_of_the_program(design: Design) -> None:
    assert refusal_line(PartError("tip", design, "failed")) is None
    # A part of one's own is no part of the packaged design.
    assert refusal_line(PartError("bracket", design, "not meshed")) == "part 'bracket': not meshed"
    assert refusal_line(PartError("tip", design, CRASHED)) == f"part 'tip': {CRASHED}; is there enough memory?"


def test_the_command_ends_with_that_line(monkeypatch: pytest.MonkeyPatch, command: Any) -> None:
    def refused(*arguments: object) -> None:
        raise PartError("tip", load_design(None, ["tip.hub_diameter=24 mm"]), "failed")

    monkeypatch.setattr(parts_command, "parts", refused)
    said = command("parts", status=2).err
    assert said.startswith("stagecad: thesis.toml: the CAD kernel makes no valid solid of 'tip'")


@pytest.mark.slow
def test_what_no_rule_forbids_and_the_kernel_refuses(tmp_path: Path, command: Any) -> None:
    """Slots of the clamps that cut the base in two."""
    said = command.refused("parts", "base", "--set", "base.clamp_reach=347.2 mm", "--out", tmp_path)
    assert "'base' with base.clamp_reach = 347.2 mm (packaged: 69.5 mm)" in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("cached", "terminal", "notes"), [(False, True, 1), (False, False, 0), (True, True, 0)])
def test_the_wait_is_told_on_a_terminal_before_the_kernel_begins(monkeypatch, capsys, cached, terminal, notes):
    stored, made = object(), object()
    monkeypatch.setattr(parts, "find_machine", lambda design: stored if cached else None)
    monkeypatch.setattr(parts, "build_machine", lambda design, store, advance: made)
    monkeypatch.setattr(parts, "part_names", lambda design: ("tip",))
    bar = Progress(console=Console(file=io.StringIO()), disable=not terminal)
    monkeypatch.setattr(Run, "progress", lambda run: bar)
    with Run(None, (), Path("build"), None).reporting(note=KERNEL) as report:
        machine = parts.built_machine(cast(Any, None), report)
    assert machine is (stored if cached else made)
    assert capsys.readouterr().err.count("Ctrl-C") == notes


def test_every_damaged_artefact_is_made_again(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    store = ArtefactStore(tmp_path / "cache")

    def write() -> list[str]:
        modules = ("stagecad.solids.modelling.frame",)
        entries = {
            f"{name}.txt": store.make(name, object(), modules, lambda _, folder, name=name: _text(folder, name))
            for name in ("one", "two", "three")
        }
        for name in damaged:
            entries[name].path(name).write_text("damaged")
        damaged.clear()
        return write_stored(tmp_path / "out", entries)

    damaged = ["one.txt", "three.txt"]
    parts.with_repair(store, write)
    assert [(tmp_path / "out" / f"{name}.txt").read_text() for name in ("one", "two", "three")] == ["good"] * 3
    assert caplog.messages == ["a stored result was damaged; it is made again"] * 2


def test_a_cache_that_never_keeps_what_it_stores_is_one_line(tmp_path: Path) -> None:
    entry: Any = SimpleNamespace(key="a")
    store: Any = SimpleNamespace(folder=tmp_path, drop=lambda entry: None)

    def write() -> None:
        raise DamagedError(entry)

    with pytest.raises(OSError, match="does not keep what is written to it"):
        parts.with_repair(store, write)


def _text(folder: Path, name: str) -> None:
    (folder / f"{name}.txt").write_text("good")
