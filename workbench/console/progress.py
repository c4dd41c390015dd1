"""The progress bar of a search for effects: counted while they are scored and the best refitted, running after that."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress


def shown_on(progress: Progress, afterwards: str = "weighing what was found") -> Callable[[str, int, int], None]:
    """What to call with a name, a count and a total; when all are counted the bar runs on, `afterwards` beside it.

    Whether pairs are looked at then, or effects of the model searched for anew, depends on what the refits found:
    nobody knows that beforehand, and it takes less time than what was counted.
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
        if count == total:
            another(afterwards, None)
            return
        if count == 0:
            another(name, total)
        progress.update(task, description=name, completed=count)

    return show
