"""The progress bar of a search for effects: counted while effects are scored, running while the best are refitted."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress


def shown_on(
    progress: Progress, afterwards: str = "refitting the best, alone and in pairs"
) -> Callable[[str, int, int], None]:
    """What to call with a name, a count and a total; after the last of them the bar runs on, `afterwards` beside it.

    How many pairs will be looked at, and how many effects searched for anew, depends on what the scores and refits
    find: nobody knows that beforehand.
    """
    task = progress.add_task("reading, and fitting the model as it stands", total=None)
    began = progress.tasks[-1].start_time

    def another(words: str, total: int | None) -> None:
        # A bar once given a total cannot lose it: another one takes its place, and its clock goes on.
        nonlocal task
        progress.remove_task(task)
        task = progress.add_task(words, total=total)
        progress.tasks[-1].start_time = began

    def show(name: str, count: int, total: int) -> None:
        if count + 1 == total:
            another(afterwards, None)
            return
        if count == 0:
            another(name, total)
        progress.update(task, description=name, completed=count)

    return show
