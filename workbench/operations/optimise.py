"""`optimize`: the nearest design without violated rules and failed checks, or the requirements in conflict."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from designcalc.checks.check import Check
from designcalc.checks.report import counted, shown, shown_limit, shown_margin
from designcalc.checks.run import run_checks
from designcalc.optimisation.optimise import Outcome, optimise, outcome_document, required_checks
from designcalc.optimisation.search import Best, Evaluation, Evaluator, Free, free_parameters, pareto_front, search
from stagecad.deferred import pd
from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError, require
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.rules import present_entries, violations
from stagecad.parameters.units import parse_quantity
from stagecad.processes import parallel_map
from stagecad.solids.assembly.built_machine import body_masses
from workbench.figures import Figure
from workbench.figures import design as design_figures
from workbench.figures import plot as drawing
from workbench.operations.design import Design, load_design
from workbench.operations.parts import masses_of_solids
from workbench.operations.result import (
    Line,
    Note,
    ProgressCallback,
    Result,
    Table,
    finite,
    frame,
    plain_table,
    render,
    silent,
    without_options,
)

SAFETY = 0.002
"""Part of its limit by which a check must pass in the search, for the error of the masses without solids."""
OWN_SOLIDS = 0.2
"""Part of the time of a search in which the solids of the design found are made."""
SEEDS = 8
"""Searches sent to a cluster."""


@dataclass(frozen=True)
class Search:
    """What may change, what is required, and the effort."""

    free: Sequence[str] = ()  # texts `KEY=LOW:HIGH` or `KEY=A|B`, besides the parameters that the file marks as free
    keep: Sequence[str] = ()  # required checks: names, patterns with `*`; all of them when empty
    only: bool = False  # let nothing change but the parameters of `free`
    # take the masses from the solids; of a design that violates a rule they are those of plain volumes
    solids: bool = True
    budget: int = 600  # designs of each search
    evaluations: int = 6000  # designs of all searches together
    seconds: float = math.inf  # time of all searches together
    seed: int = 1  # of the random numbers
    scheduler: str | None = None  # address of a dask cluster, which begins with searches from several seeds

    def masses(self, design: Design) -> Masses | None:
        """Masses of the design's solids; a design that violates a rule may have none."""
        values = design.values_with(rules=False)
        return masses_of_solids(values) if self.solids and not violations(values) else None

    def freed(self, design: Design) -> list[Free]:
        """The free parameters."""
        values = design.values_with(rules=False)
        parameters = free_parameters(values, self.free)
        named = [values.entry(text.partition("=")[0].strip()).key for text in self.free]
        return [one for one in parameters if not self.only or one.key in named]


@dataclass
class BestSoFar:
    """The design with the fewest violated rules and failed requirements of all that a search has evaluated."""

    evaluator: Evaluator
    required: Collection[str]
    best: Evaluation | None = None
    seen: int = 0  # designs of the archive

    def improved(self) -> bool:
        """Whether a better one was evaluated since the last call."""
        before, archive = self.best, self.evaluator.archive
        new = [one for one in archive[self.seen :] if one.complete and not one.refused]
        self.seen = len(archive)
        self.best = min([*([before] if before else []), *new], key=self._merit, default=None)
        return self.best is not before

    def _merit(self, one: Evaluation) -> tuple[int, int, float]:
        return len(one.violated), len(one.unmet.intersection(self.required)), one.distance

    def to_json(self) -> dict[str, Any]:
        """Violated rules, failed requirements, and the values that differ."""
        assert self.best is not None
        rules, failing, _ = self._merit(self.best)
        free = [one for one in self.evaluator.free if self.best.values[one.key] != one.start]
        changes = [[one.key, one.text(one.start), one.text(self.best.values[one.key])] for one in free]
        return {"rules": rules, "failing": failing, "required": len(self.required), "changes": changes}

    def words(self) -> tuple[str, str]:
        """How much it violates, and the values that differ."""
        found = self.to_json()
        counts = "{rules} rules violated, {failing} of {required} checks failed".format(**found)
        return counts, ", ".join(f"{key} = {after}" for key, _, after in found["changes"]) or "as it is"


@dataclass(frozen=True)
class Front:
    """Margins, in parts of the limit, of the designs evaluated in two requirements that contradict each other."""

    names: tuple[str, str]  # of the requirements
    points: np.ndarray  # (n, 2), of all designs that violate no rule

    @property
    def front(self) -> np.ndarray:
        """Those of the Pareto-optimal designs, (m, 2)."""
        return pareto_front(self.points)


class Optimisation(Result):
    """The nearest design that violates no rule and passes the required checks, or what contradicts it.

    Attributes:
        design: that was to be improved.
        outcome: of the search.
        before: checks of the design.
        after: checks of the design found, with the masses of its own solids; none where nothing changes.
        fronts: of each conflict of several requirements, the first two.
    """

    def __init__(self, design: Design, outcome: Outcome, evaluator: Evaluator, after: Sequence[Check] | None) -> None:
        self.design, self.outcome, self.after = design, outcome, after
        self.before = tuple(evaluator.checks)
        self.fronts = [
            _front(evaluator, (conflict.names[0], conflict.names[1]))
            for conflict in outcome.conflicts
            if len(conflict.names) > 1
        ]
        self._document = outcome_document(outcome, evaluator, after)

    @property
    def feasible(self) -> bool:
        """Whether a design meets all requirements."""
        return self.outcome.feasible

    @property
    def changes(self) -> dict[str, str]:
        """Text of each value that changes, by key, as for `Design.with_values`."""
        return {change.key: change.after for change in self.outcome.changes}

    @cached_property
    def unverified(self) -> list[str]:
        """Requirements that the search met, and that fail with the masses of the design's own solids."""
        outcome = self.outcome
        conflicting = {name for conflict in outcome.conflicts for name in conflict.names}
        met = set(outcome.required) - conflicting - set(outcome.left_out)
        failing = ("fails", "out_of_range")
        return [check.name for check in self.after or () if check.name in met and check.verdict in failing]

    @property
    def margins(self) -> pd.DataFrame:
        """Margin and verdict of every check before and after; index `check`."""
        new = {check.name: check for check in self.after or ()}
        pairs = [(check, new.get(check.name)) for check in self.before]
        rows = [(a.name, a.margin, b and b.margin, a.verdict, b and b.verdict) for a, b in pairs]
        columns = ("check", "margin_before", "margin_after", "verdict_before", "verdict_after")
        return frame(rows, "check", columns=columns)

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each parameter that changes: values as text, and the reason; index `key`."""
        columns = ("key", "before", "after", "reason")
        rows = [[getattr(change, name) for name in columns] for change in self.outcome.changes]
        return frame(rows, "key", columns=columns)

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad optimize --json`, without files."""
        verified = {} if self.after is None else {"verified": not self.unverified}
        return finite(self._document | verified)

    def plot(self, conflict: int | None = None) -> Figure:
        """The margins that differ, before and after; or the Pareto front of a conflict, by its position.

        Raises:
            InputError: no margin differs, or no such conflict of several requirements.
        """
        if conflict is not None:
            if not 0 <= conflict < len(self.fronts):
                raise InputError(f"plot: conflict {conflict}: there are {len(self.fronts)} of several requirements")
            chosen = self.fronts[conflict]
            return design_figures.pareto_figure(chosen.names, chosen.points, chosen.front)
        margins = self.margins.dropna(subset=["margin_after"])
        return design_figures.changed_margins_figure(margins.query("margin_before != margin_after"))

    def summary(self) -> list[tuple[str, str]]:
        conflicts = [("conflict", " · ".join(conflict.names)) for conflict in self.outcome.conflicts]
        return conflicts + [("fails with its own masses", name) for name in self.unverified]

    def lines(self) -> list[Line]:
        """Changes with reasons and margins before and after; conflicts and what to relax."""
        outcome, lines = self.outcome, []
        if outcome.interrupted:
            lines.append("stopped; the best design so far:")
        if not outcome.complete:
            count = outcome.evaluations
            lines.append(f"the search ended after {count} designs; more --evaluations or --time may find more")
        if not outcome.feasible:
            lines.append(f"no design within the ranges meets all {len(outcome.required)} requirements")
            lines += self._conflict_lines()
        if self.after is None:
            return [*lines, "no change is needed" if outcome.feasible else "no design was found"]
        lines.append(self._change_table())
        new, rows = {check.name: check for check in self.after}, []
        for check in self.before:
            other = new.get(check.name)
            if other is None or (other.margin == check.margin and other.verdict == check.verdict):
                continue
            verdict = " -> ".join(dict.fromkeys((check.verdict, other.verdict)))
            rows.append((check.name, shown_margin(check), shown_margin(other), verdict))
        lines.append(plain_table("margins that change", "check|before|after|verdict", rows, "check|verdict"))
        counts = f"before: {counted(self.before)}; after: {counted(self.after)}"
        return [*lines, f"{counts}; {outcome.evaluations} designs evaluated"]

    def _change_table(self) -> Table:
        rows = [(change.key, change.before, change.after, change.reason) for change in self.outcome.changes]
        return plain_table("changes", "parameter|from|to|reason", rows, "parameter|reason")

    def _conflict_lines(self) -> list[Line]:
        outcome, lines = self.outcome, []
        certain = [conflict.names[0] for conflict in outcome.conflicts if conflict.fixed]
        if certain:
            lines.append(f"\nThese checks read no free parameter, so they fail in every design ({len(certain)}):")
        lines += [f"- {name}" for name in certain]
        if outcome.left_out:
            lines.append(f"\nLeft out, since the best compromise fails them ({len(outcome.left_out)}):")
        lines += [f"- {name}" for name in outcome.left_out]
        rows = [
            (
                item.name,
                shown(item.limit, item.unit),
                shown(item.needed, item.unit),
                f"{100 * item.margin:+.3g} %",
                "; ".join(item.keeping) or "(by itself)",
            )
            for item in outcome.relax
            if item.name not in certain
        ]
        columns = "requirement|limit|reached|margin|together with"
        table = plain_table("what cannot be met", columns, rows, "requirement|together with")
        return [*lines, table] if rows else lines

    def report(self) -> str:
        """Changes with reasons, what is not met and why, margins before and after, as Markdown."""
        outcome, new = self.outcome, {check.name: check for check in self.after or ()}
        margins = [
            (one.name, shown_margin(one), shown_margin(new[one.name]), new[one.name].verdict.replace("_", " "))
            for one in self.before
            if one.name in new
        ]
        return render(
            "optimised.md",
            file=self.design.values.file,
            evaluations=outcome.evaluations,
            before=counted(self.before),
            after=counted(self.after or ()),
            changes=self._change_table().rows,
            unmet=self._unmet_rows(),
            margins=None if self.after is None else margins,
        )

    def _unmet_rows(self) -> list[tuple[str, str, str, str]]:
        """Requirements that are not met: the best value reached with the others of their conflict satisfied, or else
        the value in the design found, or in that of the beginning."""
        rows: list[tuple[str, str, str, str]] = []
        present = {check.name: check for check in (self.after if self.after is not None else self.before)}
        reached = {(item.name, item.keeping): item for item in self.outcome.relax}

        def add(name: str, why: str, others: tuple[str, ...] = ()) -> None:
            check, relaxed = present[name], reached.get((name, others))
            value = check.value if relaxed is None else relaxed.needed
            rows.append((name, shown_limit(check), shown(value, check.unit), why))

        for conflict in self.outcome.conflicts:
            for member in conflict.names:
                others = tuple(other for other in conflict.names if other != member)
                why = "reads no free parameter" if conflict.fixed else "; ".join(others) or "none: not met by itself"
                add(member, why, others)
        for name in self.outcome.left_out:
            add(name, "left out of the best compromise")
        return rows

    def write(self, target: str | Path) -> None:
        """Write the parameter file with the changes, their reasons as origins (comments are kept), and the report."""
        target, changes = Path(target), {}
        for change in self.outcome.changes:
            entry = self.design.values.entry(change.key)
            value = _written(change.after, entry.unit, entry.value)
            changes[change.key] = (value, f"assumed: optimised from {change.before}: {change.reason}")
        atomic_write_text(target, self.design.to_toml(changes, str(target)))
        atomic_write_text(target.with_suffix(".md"), self.report())

    def figures(self) -> dict[str, Figure]:
        """The Pareto fronts of the conflicts, by the names of their files."""
        return {f"conflict_{number + 1}": self.plot(number) for number in range(len(self.fronts))}

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the search."""
        return self.outcome.interrupted

    def write_results(
        self, folder: Path, figures: bool, target: Path | None, relax: bool
    ) -> tuple[dict[str, Any], list[Line], list[str]]:
        """Write report and figures into a folder, and the design to `target`; document, remarks, figures."""
        lines: list[Line] = []
        if self.unverified:
            failing = ", ".join(self.unverified)
            lines = [Note(f"with the masses of its own solids the design fails: {failing}; repeat with --params on it")]
        written = target is not None and self.after is not None and (self.feasible or relax)
        if target is not None and written:
            self.write(target)
            lines.append(Note(f"written: {target} and {target.with_suffix('.md')}"))
        elif target is not None:
            why = "no design meets all requirements (--relax leaves out those of the conflicts)"
            why = "the present design meets all requirements" if self.feasible else why
            lines.append(Note(f"{target} is not written: {why}"))
        document, drawn = write_study(self, folder, "report.md", figures, {"written": str(target)} if written else {})
        return document, lines, drawn

    def __repr__(self) -> str:
        count = len(self.outcome.changes)
        result = f"{count} changes" if self.feasible else f"no design, {len(self.outcome.conflicts)} conflicts"
        return f"<Optimisation of '{self.design.values.file}': {result}, {self.outcome.evaluations} designs evaluated>"


def write_study(
    study: Any, folder: Path, report: str, figures: bool, more: Mapping[str, Any] = {}
) -> tuple[dict[str, Any], list[str]]:
    """Write report and figures of an optimisation or of a study of levels; its document with `more`, the figures."""
    atomic_write_text(folder / report, study.report())
    document = {**study.to_json(), **more}
    if not figures:
        return document, []
    drawn = [str(path) for path in drawing.save_figures(folder, study.figures())]
    return {**document, "figures": drawn}, drawn


def best_so_far(note: Callable[[str], None]) -> Callable[[BestSoFar], None]:
    """What notes a better design, once for each number of violated rules and failed checks."""
    told: set[str] = set()

    def better(best: BestSoFar) -> None:
        counts, values = best.words()
        if counts not in told:
            told.add(counts)
            note(f"best so far: {counts}: {values}")

    return better


def time_limit(text: str | None) -> float:
    """Time of `--time`, s; infinite without it."""
    seconds = math.inf if text is None else parse_quantity(text, "s", "--time")
    require(seconds > 0, f"--time '{text}': must be above 0")
    return seconds


def _written(text: str, unit: str, present: object) -> str | float | bool:
    """The value of an entry as TOML keeps it: numbers without unit and truth values as such."""
    if isinstance(present, bool):
        return text == "true"
    if unit or isinstance(present, str) or text.startswith("="):
        return text
    number = float(text)
    return int(number) if isinstance(present, int) else number


def _front(evaluator: Evaluator, names: tuple[str, str]) -> Front:
    kept = [design for design in evaluator.archive if not design.refused and not design.violated]
    pairs = [tuple(design.margins.get(name) for name in names) for design in kept]
    return Front(names, np.array([pair for pair in pairs if None not in pair], float).reshape(-1, 2))


def marked_free(design: Design) -> dict[str, str]:
    """Ranges `LOW:HIGH` and choices `A|B` of the parameters that the file marks as free."""
    return {entry.key: entry.free.replace("..", ":") for entry in present_entries(design.values) if entry.free}


def need_free(design: Design, free: Mapping[str, str]) -> None:
    """Refuse ranges or choices that an optimisation of the design cannot use."""
    with without_options():
        Search([f"{key}={text}" for key, text in free.items()]).freed(design)


def optimize(
    design: Design | None = None,
    free: Mapping[str, str] | None = None,
    keep: Sequence[str] = (),
    only: bool = False,
    solids: bool = True,
    budget: int = 600,
    evaluations: int = 6000,
    progress: ProgressCallback = silent,
) -> Optimisation:
    """Find the design nearest to the present one that violates no rule and fails no required check.

    Args:
        design: the packaged machine when left out; one that violates rules is read with `rules=False`.
        free: range `LOW:HIGH` or choices `A|B` by key, besides those that the file marks as free.
        keep: required checks: names, patterns with `*`; all of them when left out.
        only: let nothing change but the parameters of `free`.
        solids: take the masses from the solids; of a design that violates a rule they are those of plain volumes.
        budget: designs of each search.
        evaluations: designs of all searches together.
        progress: called with the name of a step, the designs evaluated, and the most.

    Raises:
        InputError: a parameter, a range or a check that is not known.
    """
    texts = [f"{key}={text}" for key, text in (free or {}).items()]
    with without_options():
        return optimised(design or load_design(), Search(texts, keep, only, solids, budget, evaluations), progress)


def optimised(
    design: Design,
    wanted: Search,
    progress: ProgressCallback = silent,
    better: Callable[[BestSoFar], None] = lambda best: None,
) -> Optimisation:
    """The design nearest to `design` that violates no rule and fails no required check; `better` is called with the
    best one so far whenever a better one was evaluated."""
    began, free = monotonic(), wanted.freed(design)
    progress("masses of the solids", 0, 0)
    masses = wanted.masses(design)
    evaluator = _evaluator(design, free, masses)
    required = required_checks(evaluator.checks, wanted.keep)
    if wanted.scheduler is not None:
        job = partial(_seeded_search, design, free, masses, required, wanted.budget)
        for values in parallel_map(job, range(wanted.seed, wanted.seed + SEEDS), scheduler=wanted.scheduler):
            if values is not None:
                evaluator.of(values)
    step, best = "search", BestSoFar(evaluator, required)

    def count(done: int) -> None:
        progress(step, done, wanted.evaluations)
        if best.improved():
            better(best)

    def tell(words: str) -> None:
        nonlocal step
        step = words
        count(evaluator.count)

    evaluator.progress = count
    # A part of the time is kept for the solids of the design that is found.
    unlimited = masses is None or math.isinf(wanted.seconds)
    reserve = 0.0 if unlimited else min(max(OWN_SOLIDS * wanted.seconds, 10.0), 0.5 * wanted.seconds)
    outcome = optimise(
        evaluator,
        required,
        wanted.budget,
        seed=wanted.seed,
        evaluations=wanted.evaluations,
        seconds=max(wanted.seconds - reserve - (monotonic() - began), 0.0),
        tell=tell,
    )
    after = None
    if outcome.design is not None and outcome.changes:
        progress("masses of its own solids", 0, 0)
        changed = evaluator.design(outcome.design.values)
        after = run_checks(changed, body_masses(changed) if masses is not None else None)
    return Optimisation(design, outcome, evaluator, after)


def _evaluator(design: Design, free: Sequence[Free], masses: Masses | None) -> Evaluator:
    return Evaluator(design.variations(), free, masses, SAFETY if masses is not None else 0.0)


def _seeded_search(
    design: Design, free: Sequence[Free], masses: Masses | None, required: Sequence[str], budget: int, seed: int
) -> dict[str, object] | None:
    """Values of the free parameters of the nearest satisfying design found from one seed; None for none."""
    best = search(Best(_evaluator(design, free, masses), required), budget, seed=seed)
    return dict(best.found.values) if best.satisfied else None
