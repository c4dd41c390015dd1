"""`checks`: every design check; its margins over values, tolerances and chains of dimensions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from designcalc.checks.chain import Chain
from designcalc.checks.check import Check
from designcalc.checks.report import shown, shown_limit, shown_margin
from designcalc.checks.run import evaluate_proposals, register, run_checks, subjects_of
from designcalc.checks.sweep import Point, Range, changing_checks, combinations, read_range, run_points, sweep_document
from designcalc.checks.tolerance import ToleranceStudy, tolerance_study
from stagecad.blas_threads import one_thread
from stagecad.consent import give_consent
from stagecad.deferred import pd
from stagecad.parameters.errors import InputError, nearest, require
from stagecad.parameters.mass_properties import Masses
from stagecad.processes import parallel_map, processors
from stagecad.solids.assembly.built_machine import body_masses
from workbench.figures import Figure
from workbench.figures import checks as check_figures
from workbench.figures import design as design_figures
from workbench.figures import plot as drawing
from workbench.operations.design import Design, load_design
from workbench.operations.parts import masses_of_solids
from workbench.operations.result import Line, ProgressCallback, Result, counted, finite, frame, plain_table, silent

MOST_IN_PIECE = 125
"""Points of a sweep that a process is given together: between their solids masses are interpolated."""
FEW_POINTS = 30
"""Without solids so few points are quicker in one process than in several, which start first."""
MOST_COLUMNS, MOST_CURVES = 6, 8
"""Checks in the table and in the figure of a sweep."""
MOST_ROWS = 12
"""Combinations in the table of a grid of more than two ranges."""


def evaluated_checks(design: Design, masses: Masses | None) -> list[Check]:
    """Every check of a design, the changes that the failed ones propose evaluated."""
    register(design.check_files)
    return evaluate_proposals(run_checks(design.values, masses), design.values, masses, design.further_override())


def trust_checks(design: Design) -> tuple[str, ...]:
    """Consent to run the user's own checks and parts as they are now; returns their files."""
    give_consent(design.part_files)
    register(design.check_files, trust=True)
    return design.own_files


class Checks(Result):
    """Every design check with its value, limit, margin, and what would pass.

    Attributes:
        design: that is checked.
        checks: in the order of the report.
        masses: of its solids; none where they were estimated from plain volumes.
    """

    def __init__(self, design: Design, checks: Sequence[Check], masses: Masses | None = None) -> None:
        self.design, self.checks, self.masses = design, tuple(checks), masses

    def __len__(self) -> int:
        return len(self.checks)

    def __getitem__(self, name: str) -> Check:
        """The check of this name; InputError for none."""
        for check in self.checks:
            if check.name == name:
                return check
        raise InputError(f"no check '{name}'{nearest(name, [check.name for check in self.checks])}")

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that fail."""
        return tuple(check for check in self.checks if check.verdict == "fails")

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each check, SI; the margin is a part of the limit, negative where the check fails."""
        names = ("subject", "name", "value", "sense", "limit", "unit", "margin", "verdict", "proposal")
        rows = [[getattr(check, name) for name in names] for check in self.checks]
        return frame(rows, columns=names).rename(columns={"name": "check"}).set_index(["subject", "check"])

    def to_json(self) -> list[dict[str, Any]]:
        """The document of `stagecad check --json`."""
        return finite([check.as_json() for check in self.checks])

    def summary(self) -> list[tuple[str, str]]:
        return [(check.name, check.proposal) for check in self.failed if check.proposal]

    def lines(self) -> list[Line]:
        """Every check with value, limit, margin and verdict; then the proposals of those that do not pass."""
        if not self.checks:
            return ["this machine has no checks; 'stagecad new check NAME' writes one beside the parameter file"]
        rows: list[tuple[str, ...]] = []
        subject = ""
        for check in self.checks:
            if check.subject != subject:
                subject = check.subject
                rows.append((subject, "", "", "", ""))
            value, limit, margin = shown(check.value, check.unit), shown_limit(check), shown_margin(check)
            rows.append((f"  {check.name}", value, limit, margin, check.verdict))
        lines: list[Line] = [plain_table("", "check|value|limit|margin|verdict", rows, "check|limit|verdict")]
        failing = [check for check in self.checks if check.verdict != "passes"]
        if failing:
            lines.append("\nWhat would pass")
        return [*lines, *(f"- {check.name}: {check.proposal or check.note or 'see the formula'}" for check in failing)]

    def plot(self, name: str | None = None) -> Figure:
        """The margins of the failed checks or of a subject, or one of the figures of the checks by its title.

        Raises:
            InputError: no such subject and no such figure, or no check with a margin.
        """
        if name in check_figures.FIGURES:
            own = check_figures.figures_of(self.design.values)
            require(name in own, f"plot: the design has no '{name}'")
            return own[name][1](self.design.values, self.masses)
        subjects = list(dict.fromkeys(check.subject for check in self.checks))
        if name is not None and name not in subjects:
            raise InputError(f"no subject '{name}'{nearest(name, [*subjects, *check_figures.FIGURES])}")
        return design_figures.margins_figure([c for c in self.checks if c.subject == name] if name else self.failed)

    def studies(
        self, chained: bool, ranges: Sequence[Range], samples: int, scheduler: str | None, reporting: Any
    ) -> dict[str, Any]:
        """The studies that are asked for, by their key in the document: tolerance chains, sweep, and tolerances of
        `samples` machines, if any; `reporting` gives a progress callback for each."""
        found: dict[str, Any] = {"chains": chains(self.design)} if chained else {}
        if ranges:
            with reporting() as report:
                swept = sweep(self.design, ranges, self.masses is not None, scheduler, report)
            found[swept.name] = swept
        if samples:
            with reporting() as report:
                found["tolerance"] = tolerances(self.design, self.masses, samples, scheduler, report)
        return found

    def write_figures(self, folder: Path) -> dict[str, Path]:
        """Draw every figure of the checks that this design has into a folder; the files by title."""
        drawn: dict[str, Path] = {}
        for title, (name, draw) in check_figures.figures_of(self.design.values).items():
            drawn[title] = folder / f"{name}.png"
            drawing.save(draw(self.design.values, self.masses), drawn[title])
        return drawn

    def __repr__(self) -> str:
        counts = {name: sum(check.verdict == name for check in self.checks) for name in ("passes", "fails")}
        open_ones = len(self.checks) - sum(counts.values())
        rest = f", {open_ones} without a verdict" if open_ones else ""
        return f"<Checks of '{self.design.values.file}': {counts['passes']} pass, {counts['fails']} fail{rest}>"


def checks(design: Design | None = None, solids: bool = True, proposals: bool = True) -> Checks:
    """Run every check on a design.

    Args:
        design: the packaged machine when left out.
        solids: take the masses from the solids, which are made where the cache lacks them, or from plain volumes.
        proposals: evaluate the changes that failed checks propose, which takes some seconds.
    """
    design = design or load_design()
    masses = masses_of_solids(design.values) if solids else None
    with one_thread():
        run = evaluated_checks(design, masses) if proposals else run_checks(design.values, masses)
    return Checks(design, run, masses)


def ranges_of(design: Design, texts: Sequence[str]) -> list[Range]:
    """Ranges `KEY=LOW:HIGH[:N]` of a sweep, their keys and the number of combinations checked."""
    ranges = [read_range(text, design.values) for text in texts]
    if len(ranges) > 1:
        combinations(ranges)
    return ranges


class Sweep(Result):
    """The checks over the values of one parameter, or over every combination of those of several."""

    def __init__(self, ranges: Sequence[Range], points: Sequence[Point]) -> None:
        self.ranges, self.points = tuple(ranges), tuple(points)
        self.keys = [swept.key for swept in ranges]
        self.name = "sweep" if len(ranges) == 1 else "grid"

    @property
    def changing(self) -> list[str]:
        """Checks whose margin changes, those whose verdict changes first."""
        return changing_checks(self.points)

    @property
    def title(self) -> str:
        return f"{'margins' if self.name == 'sweep' else 'failed checks'} over {' and '.join(self.keys)}"

    @property
    def file(self) -> str:
        """Name of the file of the figure."""
        return f"{self.name}_{'_'.join(self.keys).replace('.', '_')}.png"

    def to_dataframe(self) -> pd.DataFrame:
        """Margin of each check (columns) at each value (SI, index); of a grid a row for each combination: its values,
        the number of failed checks, and why it is refused."""
        if self.name == "sweep":
            rows = [{check.name: check.margin for check in point.checks} for point in self.points]
            return frame(rows).set_axis([point.values[0] for point in self.points]).rename_axis(self.keys[0])
        rows = [(*one.values, None if one.refused else len(one.failing), one.refused) for one in self.points]
        return frame(rows, columns=[*self.keys, "failed", "refused"])

    def to_json(self) -> dict[str, Any]:
        """Under `sweep` or `grid` in the document of `stagecad check --sweep --json`."""
        return finite(sweep_document(self.ranges, self.points))

    def lines(self) -> list[Line]:
        """The margins that change most, or the failed checks of each combination; and the values that are refused."""
        return self._sweep_lines() if self.name == "sweep" else self._grid_lines()

    def _sweep_lines(self) -> list[Line]:
        names, (unit,), rows = self.changing, [swept.si_unit for swept in self.ranges], []
        for point in self.points:
            margins = {check.name: shown_margin(check) for check in point.checks}
            rows.append([shown(point.values[0], unit), *(margins.get(name, "-") for name in names[:MOST_COLUMNS])])
        lines: list[Line] = [plain_table(self.title, "|".join([*self.keys, *names[:MOST_COLUMNS]]), rows, "-")]
        lines += [f"- {shown(point.values[0], unit)}: {point.refused}" for point in self.points if point.refused]
        nothing = (
            f"no margin changes with {self.keys[0]}" if any(point.checks for point in self.points) else "no results"
        )
        return lines if names else [*lines, nothing]

    def _grid_lines(self) -> list[Line]:
        """The number of failed checks at every point of two ranges; the points with fewest for more ranges."""
        ranges, points, units = self.ranges, self.points, [swept.si_unit for swept in self.ranges]
        if len(ranges) == 2:
            count = len(ranges[1].values)
            columns = ["", *(shown(point.values[1], units[1]) for point in points[:count])]
            rows = []
            for start in range(0, len(points), count):
                row = points[start : start + count]
                cells = ["refused" if point.refused else str(len(point.failing)) for point in row]
                rows.append([shown(row[0].values[0], units[0]), *cells])
            title = f"failed checks over {ranges[0].key} (down) and {ranges[1].key}"
        else:
            columns = [*self.keys, "failed checks"]
            best = sorted((point for point in points if point.checks), key=lambda point: len(point.failing))
            rows = [[*map(shown, point.values, units), str(len(point.failing))] for point in best[:MOST_ROWS]]
            title = "combinations with fewest failed checks"
        lines: list[Line] = [plain_table(title, "|".join(columns), rows, "-")]
        refused = [point.refused for point in points if point.refused]
        if refused:
            lines.append(f"{len(refused)} of {len(points)} combinations are refused, the first: {refused[0]}")
        return lines

    def plot(self) -> Figure | None:
        """Margins that change most, or the number of failed checks over two parameters; None for no figure."""
        if self.name == "sweep":
            names = self.changing[:MOST_CURVES]
            return check_figures.sweep_figure(self.ranges[0], self.points, names) if names else None
        return check_figures.grid_figure(self.ranges, self.points) if len(self.ranges) == 2 else None

    def __repr__(self) -> str:
        if self.name == "grid":
            return f"<Grid of {', '.join(self.keys)}: {len(self.points)} combinations>"
        return f"<Sweep of {self.keys[0]}: {len(self.points)} values, {len(self.changing)} margins change>"


def sweep(
    design: Design,
    ranges: Sequence[Range],
    solids: bool = True,
    scheduler: str | None = None,
    progress: ProgressCallback = silent,
) -> Sweep:
    """The checks at every combination of the values of ranges; `solids`: with masses of solids (`masses_over`).

    `scheduler` is the address of a dask cluster; the local cores do the work when it is left out.
    """
    values = combinations(ranges)
    # Without solids a point takes a tenth of a second: for few, other processes would cost more than they save.
    workers = 1 if len(values) <= FEW_POINTS and not solids else None
    advance = counted(progress, "sweep" if len(ranges) == 1 else "grid", len(values))
    job, pieces = partial(_run_piece, design, tuple(ranges), solids), _pieces(values, len(ranges[-1].values))
    found = parallel_map(
        job, pieces, progress=lambda piece: advance(count=len(piece)), workers=workers, scheduler=scheduler
    )
    return Sweep(ranges, [point for piece in found for point in piece])


def _pieces(values: Sequence[tuple[float, ...]], row: int) -> list[Sequence[tuple[float, ...]]]:
    """Parts of the rows of a grid, of so many values each, such that every processor has two or more."""
    size = min(row, MOST_IN_PIECE, math.ceil(len(values) / (2 * processors())))
    starts = (start for first in range(0, len(values), row) for start in range(first, first + row, size))
    return [values[start : min(start + size, start - start % row + row)] for start in starts]


def _run_piece(
    design: Design, ranges: Sequence[Range], solids: bool, values: Sequence[tuple[float, ...]]
) -> list[Point]:
    return run_points(ranges, values, design.values_with, design.values, body_masses if solids else None)


class Tolerances(Result):
    """The margins over the tolerances of the dimensions."""

    title, file = "what the tolerances use up", "tolerance.png"

    def __init__(self, study: ToleranceStudy) -> None:
        self.study = study

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each check: nominal margin, its ends, share of the machines that fail, and leading dimension."""
        return frame([vars(spread) for spread in self.study.spreads], "name")

    def to_json(self) -> dict[str, Any]:
        """Under `tolerance` in the document of `stagecad check --tolerance --json`."""
        return finite(self.study.as_json())

    def lines(self) -> list[Line]:
        """Margins over the sampled machines, and the tolerances that matter most and least."""
        study, rows = self.study, []
        for spread in sorted(study.spreads, key=lambda s: s.low - s.high):
            if spread.leading and spread.high - spread.low > 1e-4:
                numbers = [f"{100 * value:+.2f} %" for value in (spread.nominal, spread.low, spread.high)]
                rows.append([spread.name, *numbers, f"{100 * spread.failing:.1f} %", spread.leading])
        columns = "check|nominal|5 %|95 %|failing|depends most on"
        if not rows:
            return ["no tolerance moves a margin"]
        title = f"margins of {study.samples} machines"
        lines: list[Line] = [plain_table(title, columns, rows, "check|depends most on")]
        for title, items in (("matter most", study.matter_most), ("could be loosened", study.could_be_loosened)):
            listed = "; ".join(f"{i.key} ({i.tolerance}: {100 * i.share:.2g} % of a margin, {i.check})" for i in items)
            lines.append(f"{title}: {listed or 'none'}")
        return [*lines, "(as far as the checks cover: a fit or the assembly may need a closer tolerance)"]

    def plot(self) -> Figure:
        """The dimensions whose tolerance uses up most of a margin."""
        return check_figures.tolerance_figure(self.study)

    def __repr__(self) -> str:
        return f"<Tolerances: {self.study.samples} machines, {len(self.study.influences)} dimensions>"


def tolerances(
    design: Design,
    masses: Masses | None,
    samples: int = 10_000,
    scheduler: str | None = None,
    progress: ProgressCallback = silent,
    seed: int = 1,
) -> Tolerances:
    """Monte-Carlo study of the margins over the tolerances of `samples` machines, the dimensions side by side.

    `masses` None estimates them from plain volumes; `scheduler` is the address of a dask cluster.
    """

    def in_parallel(job: Any, keys: Sequence[str]) -> Any:
        return parallel_map(job, keys, progress=counted(progress, "tolerances", len(keys)), scheduler=scheduler)

    load = partial(design.values_with, rules=False)
    return Tolerances(tolerance_study(design.values, load, masses, samples, seed, run_all=in_parallel))


class Chains(Result):
    """The tolerance chains of a design, by worst case and statistically."""

    def __init__(self, chains: Sequence[Chain]) -> None:
        self.chains = tuple(chains)

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each chain: nominal, and both ends by worst case and statistically; m."""
        rows = [(chain.name, chain.nominal, *chain.worst_case, *chain.statistical) for chain in self.chains]
        return frame(rows, "chain", columns=("chain", "nominal", "worst_low", "worst_high", "low", "high"))

    def to_json(self) -> list[dict[str, Any]]:
        """Under `chains` in the document of `stagecad check --chains --json`."""
        return finite([chain.as_json() for chain in self.chains])

    def lines(self) -> list[Line]:
        """Limits of each chain, and the share of each dimension."""
        rows = [] if self.chains else [["none is declared", "", "", ""]]
        for chain in self.chains:
            limits = [f"{shown(low, 'm')} to {shown(high, 'm')}" for low, high in (chain.worst_case, chain.statistical)]
            rows.append([chain.name, shown(chain.nominal, "m"), *limits])
            for link in chain.links:
                sign = "-" if link.coefficient < 0 else "+"
                ends = f"{shown(link.low, 'm')} / {shown(link.high, 'm')}"
                rows.append([f"  {sign} {link.key}", shown(link.nominal, "m"), ends, ""])
        return [plain_table("", "tolerance chain|nominal|worst case|99.73 %, sizes uniform", rows)]

    def __repr__(self) -> str:
        return f"<Chains: {len(self.chains)} tolerance chains>"


def chains(design: Design) -> Chains:
    """The tolerance chains of a design."""
    return Chains(subjects_of(design.values).chains(design.values))
