"""Sheets drawn in several processes: which of them, in which order, and the parts that have to be built first."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from drawings.artefacts.sheets import PICTURES, PROCEDURE, BuiltSheet, CalculateValues, build_sheets, find_sheets
from drawings.sheets.plans import sheets_of
from stagecad.parameters.errors import InputError, LostProcessError, PartError, nearest
from stagecad.processes import TimeLimit, parallel_map
from stagecad.solids.artefacts.part import CRASHED, build_part, find_part
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.modelling.kernel import load_kernel
from stagecad.solids.modelling.part import ASSEMBLY, construction, part_names

BUILD = "build "
"""Begins the name of a task that builds a part; the other tasks draw the sheets of their name."""

TIME_LIMIT = 120.0
"""Processor time after which a task is repeated without exact hidden-line removal, which can hang, s; the longest takes
some ten."""

SLOWEST_FIRST = ("base", "spring", ASSEMBLY, PROCEDURE, "stage", "holder", "tip", "tooth_bar", "bearing_way")
"""Order in which parts are built and sheets drawn, so that no long task is left for the end."""


def build_all_sheets(
    store: ArtefactStore,
    subjects: Iterable[str],
    design: Any,
    advance: Callable[[str], None] = lambda name: None,
    workers: int | None = None,
    calculate: CalculateValues | None = None,
) -> dict[str, tuple[BuiltSheet, ...]]:
    """The sheets of parts and of the machine; those that the store lacks are drawn in several processes."""
    wanted = tuple(subjects)
    found: dict[str, tuple[BuiltSheet, ...]] = {}
    for subject in wanted:
        sheets = find_sheets(store, subject, design, calculate)
        if sheets is not None:
            found[subject] = sheets
            advance(subject)
    missing = slowest_first(subject for subject in wanted if subject not in found)
    if missing:
        before: tuple[str, ...] = ()
        if any(subject in PICTURES for subject in missing):
            parts = slowest_first(name for name in part_names(design) if find_part(store, name, design) is None)
            before = tuple(f"{BUILD}{name}" for name in parts)

        def report(task: str) -> None:
            if task in missing:
                advance(task)

        requires = {
            subject: [task for task in before if subject in PICTURES or task == f"{BUILD}{subject}"]
            for subject in missing
        }
        tasks = (*before, *missing)
        run = partial(_run, store.folder, design, calculate)
        limit = TimeLimit(TIME_LIMIT, fallback=partial(run, exact=False))
        try:
            built = parallel_map(run, tasks, progress=report, workers=workers, limit=limit, requires=requires)
        except LostProcessError as error:
            if str(error.item).startswith(BUILD):
                raise PartError(str(error.item).removeprefix(BUILD), design, CRASHED) from None
            raise
        found |= dict(zip(missing, built[len(before) :]))
    return {subject: found[subject] for subject in wanted}


def slowest_first(names: Iterable[str]) -> Sequence[str]:
    return sorted(names, key=lambda name: SLOWEST_FIRST.index(name) if name in SLOWEST_FIRST else len(SLOWEST_FIRST))


def _run(
    folder: Path, design: Any, calculate: CalculateValues | None, task: str, exact: bool = True
) -> tuple[BuiltSheet, ...]:
    """Run a task in a worker process, with or without exact hidden-line removal."""
    load_kernel()
    store = ArtefactStore(folder)
    if task.startswith(BUILD):
        build_part(store, task.removeprefix(BUILD), design)
        return ()
    return build_sheets(store, task, design, calculate, exact=exact)


def sheet_names(design: Any) -> dict[str, tuple[str, ...]]:
    """Names of the sheets of each subject: the parts that are made, the assembly, the procedure."""
    sheets: dict[str, tuple[str, ...]] = {}
    for name, source in construction(design).sources(design).items():
        if not source.purchased:
            plans = sheets_of(design).plans(source.kind, source.design_of(design))
            sheets[name] = tuple(plan.name for plan in plans) or (source.kind,)
    return {**sheets, ASSEMBLY: (ASSEMBLY,), PROCEDURE: (PROCEDURE,)}


def chosen_sheets(names: Sequence[str], design: Any) -> dict[str, tuple[str, ...]]:
    """The sheets that are named, by subject or one by one; all when none is named."""
    known = sheet_names(design)
    if not names:
        return known
    chosen: set[str] = set()
    for name in names:
        subject = next((subject for subject, sheets in known.items() if name == subject or name in sheets), None)
        if subject is None:
            raise InputError(_unknown(name, known, design))
        chosen.update(known[subject] if name == subject else (name,))
    found = {subject: tuple(sheet for sheet in sheets if sheet in chosen) for subject, sheets in known.items()}
    return {subject: sheets for subject, sheets in found.items() if sheets}


def _unknown(name: str, known: dict[str, tuple[str, ...]], design: Any) -> str:
    if name in part_names(design):
        return f"part '{name}' is bought; it has no drawing"
    reason = construction(design).refusal(name, design)
    if reason:
        return f"part '{name}': {reason}"
    everything = [*known, *(sheet for sheets in known.values() for sheet in sheets if sheet not in known)]
    return f"no drawing '{name}'{nearest(name, everything)}"
