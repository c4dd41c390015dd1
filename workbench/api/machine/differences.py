"""`diff`: what differs between two designs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.machine.comparison import DesignComparison, compare_designs
from workbench.operations.design import Design, as_design
from workbench.operations.progress import ProgressCallback
from workbench.operations.result import Result, finite

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from designcalc.checks.check import Check


class Differences(Result):
    """What differs between two designs: parameters, margins, masses, volumes of the solids, drawing sheets.

    Attributes:
        first, second: the designs.
    """

    def __init__(self, first: Design, second: Design, found: DesignComparison) -> None:
        self.first, self.second = first, second
        self.found = found

    @property
    def parameters(self) -> pd.DataFrame:
        """Parameters that differ: text and origin in both designs (none where a design lacks it); index `key`."""
        rows = [
            {
                "key": one.key,
                "before": one.before and one.before.text,
                "after": one.after and one.after.text,
                "origin_before": one.before and one.before.origin,
                "origin_after": one.after and one.after.origin,
            }
            for one in self.found.parameters
        ]
        return _frame(rows, ("key", "before", "after", "origin_before", "origin_after"))

    @property
    def margins(self) -> pd.DataFrame:
        """Checks whose margin or verdict differs, those with another verdict first; index `check`.

        A margin is a part of the limit, negative where the check fails.
        """

        def of(check: Check | None, when: str) -> dict[str, Any]:
            return {f"margin_{when}": check and check.margin, f"verdict_{when}": check.verdict if check else "absent"}

        changes = self.found.margins or ()
        rows = [{"check": one.name, **of(one.before, "before"), **of(one.after, "after")} for one in changes]
        return _frame(rows, ("check", "margin_before", "margin_after", "verdict_before", "verdict_after"))

    @property
    def masses(self) -> pd.DataFrame:
        """Masses that differ, kg; index `name`: of parts, `moving body`, `assembly`."""
        changes = self.found.masses or ()
        rows = [{"name": one.name, "before": one.before, "after": one.after} for one in changes]
        return _frame(rows, ("name", "before", "after"))

    @property
    def volumes(self) -> pd.DataFrame:
        """Parts whose solids differ: volumes, and what only one of them has, m^3; index `part`."""
        names = ("part", "before", "after", "removed", "added")
        rows = [{name: getattr(one, name) for name in names} for one in self.found.volumes or ()]
        return _frame(rows, names)

    @property
    def sheets(self) -> pd.DataFrame:
        """Sheets that differ: how, picture with the changes marked, number of changed regions; index `sheet`."""
        names = ("sheet", "change", "marked", "regions")
        rows = [{name: getattr(one, name) for name in names} for one in self.found.sheets or ()]
        return _frame(rows, names)

    def to_dataframe(self) -> pd.DataFrame:
        """The parameters."""
        return self.parameters

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad diff --json`, of what was compared."""
        return finite(self.found.as_json())

    def plot(self) -> Figure:
        """Margins before and after, of the checks whose margin differs."""
        from workbench.figures.design import changed_margins_figure

        return changed_margins_figure(self.margins)

    def summary(self) -> list[tuple[str, str]]:
        verdicts = [one for one in self.found.margins or () if len(set(one.verdicts)) == 2]
        facts = [("verdict", f"{one.name}: {one.verdicts[0]} -> {one.verdicts[1]}") for one in verdicts]
        return facts + [("sheet", f"{one.sheet}: {one.change}") for one in self.found.sheets or ()]

    def __repr__(self) -> str:
        counts = {
            "parameters": self.found.parameters,
            "margins": self.found.margins,
            "masses": self.found.masses,
            "sheets": self.found.sheets,
        }
        texts = [f"{len(found)} {name}" for name, found in counts.items() if found is not None]
        first, second = self.found.names
        return f"<Differences of '{first}' and '{second}': {', '.join(texts)}>"


def diff(
    first: Design | str | Path,
    second: Design | str | Path,
    solids: bool = True,
    margins: bool = True,
    out: str | Path = "build",
    progress: ProgressCallback | None = None,
) -> Differences:
    """What differs between two designs.

    Args:
        first, second: designs, or their parameter files.
        solids: compare masses, volumes and drawing sheets too, for which solids and sheets are made where the cache
            lacks them; the margins are then those with the masses of the solids.
        margins: compare the margins of the checks.
        out: folder; the sheets that differ are written to `diff` in it, their changes marked.
        progress: called with the name of a step; the number of steps is not known.

    Raises:
        InputError: one line on the fault in a file.

    >>> import stagecad
    >>> design = stagecad.load_design()
    >>> thicker = design.with_values({"stage.thickness": "14 mm"})
    >>> diff(design, thicker, solids=False, margins=False).parameters.loc["stage.thickness", "after"]
    '14 mm'
    """
    designs = as_design(first), as_design(second)
    names = designs[0].values.file, designs[1].values.file
    values = designs[0].values, designs[1].values
    folder = Path(out) / "diff" if solids else None
    found = compare_designs(values, names, folder, margins, progress or (lambda step, done, total: None))
    return Differences(*designs, found)


def _frame(rows: Sequence[dict[str, Any]], columns: Sequence[str]) -> pd.DataFrame:
    """A table whose first column is its index."""
    import pandas as pd

    return pd.DataFrame(rows, columns=list(columns)).set_index(columns[0])
