"""`optimize`: the nearest design without violated rules and failed checks, or the requirements in conflict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError
from workbench.operations.design import Design, load_design
from workbench.operations.progress import ProgressCallback
from workbench.operations.result import Result, finite, without_options

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    from matplotlib.figure import Figure

    from designcalc.checks.check import Check
    from designcalc.optimisation.evaluation import Evaluator
    from designcalc.optimisation.optimise import Outcome


@dataclass(frozen=True)
class Front:
    """Margins, in parts of the limit, of the designs evaluated in two requirements that contradict each other.

    Args:
        names: of the requirements.
        points: (n, 2), of all designs.
        front: (m, 2), of the Pareto-optimal ones.
    """

    names: tuple[str, str]
    points: np.ndarray
    front: np.ndarray


class Optimisation(Result):
    """The nearest design that violates no rule and passes the required checks, or what contradicts it.

    Attributes:
        design: that was to be improved.
        outcome, evaluator: of the search, with all designs evaluated.
        after: checks of the design found, with the masses of its own solids; none where nothing changes.
    """

    def __init__(self, design: Design, outcome: Outcome, evaluator: Evaluator, after: Sequence[Check] | None) -> None:
        self.design, self.outcome, self.evaluator, self.after = design, outcome, evaluator, after

    @property
    def feasible(self) -> bool:
        """Whether a design meets all requirements."""
        return self.outcome.feasible

    @property
    def changes(self) -> dict[str, str]:
        """Text of each value that changes, by key, as for `Design.with_values`."""
        return {change.key: change.after for change in self.outcome.changes}

    @property
    def unverified(self) -> list[str]:
        """Requirements that the search met, and that fail with the masses of the design's own solids."""
        from workbench.machine.optimisation import unverified

        return unverified(self.outcome, self.after or [])

    @cached_property
    def fronts(self) -> list[Front]:
        """The first two requirements of each conflict of several, with the margins of the designs evaluated."""
        from workbench.report.design_figures import margins_of, pareto_front

        found = []
        for conflict in self.outcome.conflicts:
            if len(conflict.names) > 1:
                points = margins_of(self.evaluator, conflict.names[:2])
                found.append(Front((conflict.names[0], conflict.names[1]), points, pareto_front(points)))
        return found

    @property
    def margins(self) -> pd.DataFrame:
        """Margin and verdict of every check before and after; index `check`."""
        import pandas as pd

        from designcalc.optimisation.optimise import margins_document

        rows = []
        for row in margins_document(self.evaluator.checks, self.after or ()):
            after = row["after"] or {"margin": None, "verdict": None}
            both = {"before": row["before"], "after": after}
            rows.append(
                {"check": row["check"]} | {f"{key}_{when}": one[key] for key in after for when, one in both.items()}
            )
        return pd.DataFrame(rows).set_index("check")

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each parameter that changes: values as text, and the reason; index `key`."""
        import pandas as pd

        columns = ("key", "before", "after", "reason")
        rows = [[getattr(one, name) for name in columns] for one in self.outcome.changes]
        return pd.DataFrame(rows, columns=list(columns)).set_index("key")

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad optimize --json`, without files."""
        from designcalc.optimisation.optimise import outcome_document

        verified = {} if self.after is None else {"verified": not self.unverified}
        return finite(outcome_document(self.outcome, self.evaluator, self.after) | verified)

    def plot(self, conflict: int | None = None) -> Figure:
        """The margins that differ, before and after; or the Pareto front of a conflict, by its position.

        Raises:
            InputError: no margin differs, or no such conflict of several requirements.
        """
        from workbench.figures.design import changed_margins_figure, pareto_plot

        if conflict is not None:
            names = [one.names for one in self.outcome.conflicts if len(one.names) > 1]
            if not 0 <= conflict < len(names):
                raise InputError(f"plot: conflict {conflict}: there are {len(names)} of several requirements")
            return pareto_plot(self.evaluator, names[conflict])
        margins = self.margins.dropna(subset=["margin_after"])
        return changed_margins_figure(margins.query("margin_before != margin_after"))

    def summary(self) -> list[tuple[str, str]]:
        conflicts = [("conflict", " · ".join(one.names)) for one in self.outcome.conflicts]
        return conflicts + [("fails with its own masses", name) for name in self.unverified]

    def __repr__(self) -> str:
        count = len(self.outcome.changes)
        found = f"{count} changes" if self.feasible else f"no design, {len(self.outcome.conflicts)} conflicts"
        return f"<Optimisation of '{self.design.values.file}': {found}, {self.outcome.evaluations} designs evaluated>"


def marked_free(design: Design) -> dict[str, str]:
    """Ranges `LOW:HIGH` and choices `A|B` of the parameters that the file marks as free."""
    return {entry.key: entry.free.replace("..", ":") for entry in design.values.entries if entry.free}


def need_free(design: Design, free: Mapping[str, str]) -> None:
    """Refuse ranges or choices that an optimisation of the design cannot use.

    Raises:
        InputError: a parameter that is not known, or a range out of its bounds.
    """
    from designcalc.optimisation.space import free_parameters

    with without_options():
        free_parameters(design.values, [f"{key}={text}" for key, text in free.items()])


def optimize(
    design: Design | None = None,
    free: Mapping[str, str] | None = None,
    keep: Sequence[str] = (),
    only: bool = False,
    solids: bool = True,
    budget: int = 600,
    evaluations: int = 6000,
    progress: ProgressCallback | None = None,
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
    from designcalc.optimisation.optimise import optimise, required_checks
    from designcalc.optimisation.space import free_parameters
    from stagecad.friction_stage.assembly.machine import body_masses
    from stagecad.parameters.rules.registry import violations
    from workbench.machine.optimisation import evaluator_of, verified_checks

    design, free, report = design or load_design(), free or {}, progress or (lambda step, done, total: None)
    values = design.values_with(rules=False)
    with without_options():
        freed = free_parameters(values, [f"{key}={text}" for key, text in free.items()])
    report("masses of the solids", 0, 0)
    # A design that violates a rule may have no solids.
    masses = body_masses(values) if solids and not violations(values) else None
    evaluator = evaluator_of(design, [one for one in freed if not only or one.key in free], masses)
    step = "search"

    def tell(words: str) -> None:
        nonlocal step
        step = words
        report(step, evaluator.count, evaluations)

    with without_options():
        required = required_checks(evaluator.checks, keep)
    outcome = optimise(
        evaluator,
        required,
        budget,
        evaluations=evaluations,
        tell=tell,
        progress=lambda count: report(step, count, evaluations),
    )
    after = None
    if outcome.design is not None and outcome.changes:
        report("masses of its own solids", 0, 0)
        after = verified_checks(evaluator, outcome, masses is not None)
    return Optimisation(design, outcome, evaluator, after)
