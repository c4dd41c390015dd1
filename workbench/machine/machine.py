"""The machine's solids, from the cache or made, with a bar while they are made."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from workbench.options import Run

if TYPE_CHECKING:
    from stagecad.solids.assembly.machine import Machine


def made_machine(run: Run, store: Any = None) -> Machine:
    """The machine of the run's design; `store` is the cache, the user's own when left out.

    The CAD kernel cannot be interrupted within a step, and a person who waits after Ctrl-C should know: it is said on a
    terminal before the kernel begins.
    """
    from stagecad.solids.assembly.machine import build_machine, find_machine
    from stagecad.solids.modelling.registry import part_names

    machine = find_machine(run.design, store)
    if machine is not None:
        return machine
    with run.progress() as progress:
        if not progress.disable:
            run.note("making the parts; Ctrl-C ends it after the CAD kernel's step, which may take some seconds")
        task = progress.add_task("parts", total=len(part_names(run.design)) + 1)
        return build_machine(run.design, store, lambda name: progress.update(task, advance=1, description=name))
