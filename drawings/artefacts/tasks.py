"""All sheets that are wanted, drawn side by side: what has to be made before what, and in which order.

A sheet of one part needs that part. A sheet of the whole machine needs every part, and its pictures, which are tasks of
their own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from drawings.artefacts.pictures import PICTURES, PROCEDURE, find_picture, make_picture
from drawings.artefacts.sheets import WHOLE, Calculate, MadeSheet, all_parts, draw_part, draw_whole, find_sheets
from drawings.artefacts.workers import run_tasks
from stagecad.solids.artefacts.part import build_part, find_part
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.modelling.registry import ASSEMBLY, part_names

MAKE, SHOW = "make ", "show "
"""Begin the names of tasks that draw no sheet: one makes a part, the other a picture of the machine."""

SLOWEST_FIRST = ("base", "spring", PROCEDURE, ASSEMBLY, "stage", "holder", "tip", "tooth_bar", "bearing_way")
"""Order in which parts are made and sheets drawn, so that no long one is left for the end."""


def make_sheets(
    store: ArtefactStore,
    parts: Iterable[str],
    design: Any,
    advance: Callable[[str], None] = lambda name: None,
    workers: int | None = None,
    calculate: Calculate | None = None,
) -> dict[str, tuple[MadeSheet, ...]]:
    """The sheets of some parts, those that the cache lacks drawn side by side in processes of their own.

    Args:
        store: the cache.
        parts: names.
        design: it must pickle.
        advance: called with each part as it is done.
        workers: processes; the number of processors when left out.
        calculate: gives the calculated numbers of the procedure, where its sheet is among them.
    """
    wanted = tuple(parts)
    found: dict[str, tuple[MadeSheet, ...]] = {}
    for part in wanted:
        sheets = find_sheets(store, part, design, calculate)
        if sheets is not None:
            found[part] = sheets
            advance(part)
    missing = sorted((part for part in wanted if part not in found), key=_slowness)
    needs = _needs(store, missing, design) if any(part in WHOLE for part in missing) else {}
    before = tuple(dict.fromkeys(task for tasks in needs.values() for task in tasks if task not in missing))
    if missing:
        work = partial(_draw_elsewhere, store.folder, design, calculate)

        def tell(task: str) -> None:
            if task in missing:
                advance(task)

        first = sorted((t for t in before if t.startswith(MAKE)), key=lambda task: _slowness(task.removeprefix(MAKE)))
        # The first sheet, which takes longest, is drawn beside the pictures.
        shows = [task for task in before if task.startswith(SHOW)]
        tasks = (*first, *missing[:1], *shows, *missing[1:])
        drawn = run_tasks(tasks, work, tell, workers=workers, needs=needs)
        found |= {part: drawn[part] for part in missing}
    return {part: found[part] for part in wanted}


def _needs(store: ArtefactStore, missing: Sequence[str], design: Any) -> dict[str, tuple[str, ...]]:
    """What has to be done before each of some sheets, one of the whole machine among them, and before that.

    The whole machine needs every part, and its pictures: they are made first, side by side.
    """
    found = {name: find_part(store, name, design) for name in part_names(design)}
    parts = {name: made for name, made in found.items() if made is not None}
    makes = tuple(f"{MAKE}{name}" for name in sorted(found, key=_slowness) if name not in parts)
    pictures = dict.fromkeys(name for part in missing if part in WHOLE for name in PICTURES[part])
    if not makes:
        pictures = {name: None for name in pictures if find_picture(store, name, parts, design) is None}
    shows = {name: f"{SHOW}{name}" for name in pictures}
    needs = {part: tuple(make for make in makes if make == f"{MAKE}{part}") for part in missing if part not in WHOLE}
    needs |= dict.fromkeys(shows.values(), makes)
    for part in WHOLE:
        if part in missing:
            needs[part] = (*makes, *(shows[name] for name in PICTURES[part] if name in shows))
    return needs


def _slowness(part: str) -> int:
    return SLOWEST_FIRST.index(part) if part in SLOWEST_FIRST else len(SLOWEST_FIRST)


def _draw_elsewhere(
    folder: Path, design: Any, calculate: Calculate | None, part: str, late: bool
) -> tuple[MadeSheet, ...]:
    if part.startswith(MAKE):
        build_part(ArtefactStore(folder), part.removeprefix(MAKE), design)
        return ()
    if part.startswith(SHOW):
        store = ArtefactStore(folder)
        make_picture(store, part.removeprefix(SHOW), all_parts(store, design), design, exact=not late)
        return ()
    if part in WHOLE:
        return draw_whole(ArtefactStore(folder), part, design, calculate, exact=not late)
    return draw_part(ArtefactStore(folder), part, design, exact=not late)
