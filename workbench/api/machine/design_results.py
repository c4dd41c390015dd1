"""`checks`, `parts` and `drawings` of a design."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError, nearest
from workbench.cli.options import results_in
from workbench.operations.design import Design, load_design
from workbench.operations.result import Result, finite

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from designcalc.checks.check import Check
    from stagecad.friction_stage.assembly.machine import Machine


class Checks(Result):
    """Every design check with its value, limit, margin, and what would pass."""

    def __init__(self, design: Design, checks: Sequence[Check]) -> None:
        self.design = design
        self.checks = tuple(checks)

    def __len__(self) -> int:
        return len(self.checks)

    def __getitem__(self, name: str) -> Check:
        """The check of this name.

        Raises:
            InputError: no such check.
        """
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
        import pandas as pd

        rows = [
            {
                "subject": check.subject,
                "check": check.name,
                "value": check.value,
                "sense": "at most" if check.comparison.upper else "at least",
                "limit": check.limit,
                "unit": check.unit,
                "margin": check.margin,
                "verdict": check.verdict,
                "proposal": check.proposal,
            }
            for check in self.checks
        ]
        return pd.DataFrame(rows).set_index(["subject", "check"])

    def to_json(self) -> list[dict[str, Any]]:
        """The document of `stagecad check --json`."""
        return finite([check.as_json() for check in self.checks])

    def plot(self, subject: str | None = None) -> Figure:
        """The margins of the checks of one subject; those of the failed checks when left out.

        Raises:
            InputError: no such subject.
        """
        from workbench.figures.design import margins_figure

        subjects = list(dict.fromkeys(check.subject for check in self.checks))
        if subject is not None and subject not in subjects:
            raise InputError(f"no subject '{subject}'{nearest(subject, subjects)}")
        return margins_figure([c for c in self.checks if c.subject == subject] if subject else self.failed)

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
    from designcalc.checks.run import run_checks
    from stagecad.blas_threads import one_thread
    from workbench.cli.commands.check import masses_of_solids
    from workbench.machine.margin_studies import evaluated_checks

    design = design or load_design()
    run = results_in("build", design)
    masses = masses_of_solids(run) if solids else None
    with one_thread():
        found = evaluated_checks(run, masses) if proposals else run_checks(design.values, masses)
    return Checks(design, found)


class Parts(Result):
    """The parts of a design as solids, with their mass properties."""

    def __init__(self, design: Design, names: tuple[str, ...], machine: Machine) -> None:
        self.design = design
        self.names = names
        self.machine = machine

    @property
    def moving_body(self) -> dict[str, Any]:
        """Mass properties of the stage with irons and magnets, SI."""
        return finite(self.machine.moving_body.as_json())

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each part: mass, volume, and size along x, y, z; SI."""
        import pandas as pd

        rows = []
        for name, part in self._masses.items():
            low, high = part["bounding_box"]["value"]
            size = {f"size_{axis}": b - a for axis, a, b in zip("xyz", low, high, strict=True)}
            rows.append({"part": name, "mass": part["mass"]["value"], "volume": part["volume"]["value"], **size})
        return pd.DataFrame(rows).set_index("part")

    @cached_property
    def _masses(self) -> dict[str, Any]:
        from stagecad.solids.modelling.registry import ASSEMBLY

        machine = self.machine
        masses = {name: machine.whole if name == ASSEMBLY else machine.masses[name] for name in self.names}
        return finite({name: mass.as_json() for name, mass in masses.items()})

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad parts --json`, without files: `write` gives those."""
        from workbench.cli.commands.parts import measures_json

        parts = {name: {**part, "files": []} for name, part in self._masses.items()}
        return {"parts": parts, "moving_body": self.moving_body, "measures": finite(measures_json(self.machine))}

    def write(self, folder: str | Path) -> dict[str, Any]:
        """Write STEP, STL and GLB of the parts into a folder; the document of `stagecad parts --json`."""
        from workbench.cli.commands.parts import write_parts

        document = write_parts(results_in(folder, self.design), self.names)
        return finite({key: document[key] for key in ("parts", "moving_body", "measures")})

    def __repr__(self) -> str:
        return f"<Parts of '{self.design.values.file}': {', '.join(self.names)}>"


def parts(design: Design | None = None, names: Sequence[str] = ()) -> Parts:
    """The parts of a design as solids; they come from the cache, or are made now.

    Args:
        design: the packaged machine when left out.
        names: of parts, or `assembly`; all of them when left out.

    Raises:
        InputError: no such part.
    """
    from stagecad.solids.modelling.registry import chosen
    from workbench.machine.artefacts import built_machine

    design = design or load_design()
    return Parts(design, chosen(tuple(names), design.values), built_machine(results_in("build", design)))


class Drawings(Result):
    """The drawing sheets of a design, written to files."""

    def __init__(self, design: Design, document: dict[str, Any]) -> None:
        self.design = design
        self.document = document

    @property
    def sheets(self) -> dict[str, list[str]]:
        """Files of each sheet, by its name."""
        return {name: list(sheet["files"]) for name, sheet in self.document["sheets"].items()}

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each sheet: part, paper, scale, views, hits of the lint."""
        import pandas as pd

        rows = [
            {"sheet": name, **{key: sheet[key] for key in ("part", "paper", "scale", "views", "hits")}}
            for name, sheet in self.document["sheets"].items()
        ]
        return pd.DataFrame(rows).set_index("sheet")

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad drawings --json`."""
        return finite(self.document)

    def plot(self, sheet: str | None = None) -> Figure:
        """A sheet as a picture; the first one when left out.

        Raises:
            InputError: no such sheet.
        """
        from workbench.figures.design import sheet_figure

        name = next(iter(self.sheets)) if sheet is None else sheet
        if name not in self.sheets:
            raise InputError(f"no sheet '{name}'{nearest(name, self.sheets)}")
        return sheet_figure(Path(next(file for file in self.sheets[name] if file.endswith(".png"))))

    def __repr__(self) -> str:
        return f"<Drawings of '{self.design.values.file}': {', '.join(self.sheets)}>"


def drawings(design: Design | None = None, names: Sequence[str] = (), out: str | Path = "build") -> Drawings:
    """Draw the sheets of a design and write each as DXF, SVG, PDF and PNG, with a list of its dimensions (CSV) and its
    part with tolerances (STEP AP242).

    Args:
        design: the packaged machine when left out.
        names: of parts, or of sheets (`base_2`); all of them when left out.
        out: folder of the files.

    Raises:
        InputError: no such part or sheet.
    """
    from workbench.cli.commands.drawings import write_drawings

    design = design or load_design()
    return Drawings(design, write_drawings(results_in(out, design), tuple(names)))
