"""The bar of a search counts the effects, runs on without an end afterwards, and its clock never starts again."""

from __future__ import annotations

import io

from rich.console import Console
from rich.progress import Progress

from workbench.loop_progress import shown_on


def test_a_bar_counts_what_is_scored_and_then_runs_on() -> None:
    now = 0.0
    with Progress(console=Console(file=io.StringIO()), get_time=lambda: now, auto_refresh=False) as progress:
        show = shown_on(progress, "afterwards")
        assert progress.tasks[0].total is None
        seen = []
        for count in range(3):
            now += 5.0
            show(f"effect {count}", count, 3)
            (task,) = progress.tasks
            seen.append((task.description, task.completed, task.total, task.elapsed))
    assert seen == [("effect 0", 0, 3, 5.0), ("effect 1", 1, 3, 10.0), ("afterwards", 0, None, 15.0)]
