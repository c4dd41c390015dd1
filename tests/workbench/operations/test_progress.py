"""The bar of a search counts every step, runs on without an end afterwards, and its clock never restarts."""

import io
from pathlib import Path

import pytest
from rich.console import Console
from rich.progress import Progress

from sysid.diagnose import diagnose
from workbench import cli
from workbench.cli.console import search_progress
from workbench.operations.measurement.demonstration import fresh_copy


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


def test_what_cannot_be_counted_shows_that_it_runs_on_a_terminal_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = str(fresh_copy(tmp_path / "rig"))
    assert cli.run(["compare", folder, "--no-figures"]) == 0
    assert "fitting the model" not in capsys.readouterr().err
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert cli.run(["compare", folder, "--no-figures"]) == 0
    assert "fitting the model as it stands" in capsys.readouterr().err
    assert cli.run(["add", folder, "--drop", "viscous"]) == 0
    assert "fitting the model without viscous" in capsys.readouterr().err
