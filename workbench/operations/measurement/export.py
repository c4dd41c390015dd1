"""`export`: the fitted model of an experiment for use elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sim.export.fmu import write_fmu
from sim.export.languages import Exported, files_of
from sim.export.program import ForceFunction
from stagecad.deferred import pd
from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import require_known
from stagecad.parameters.units import attributes
from workbench.operations.design import Design
from workbench.operations.measurement.compare import compare
from workbench.operations.measurement.experiment import Experiment, results_key
from workbench.operations.measurement.fitted import exported_model
from workbench.operations.result import Result, finite, frame

LANGUAGES = ("python", "c", "modelica", "fmu", "matlab", "table")


class Export(Result):
    """The files of a fitted model in one language.

    Args:
        exported: the model.
        language: it is written in.
        files: that were written.
    """

    def __init__(self, exported: Exported, language: str, files: tuple[str, ...]) -> None:
        self.exported, self.language, self.files = exported, language, files

    def function(self) -> ForceFunction:
        """The force along a motion, as the exported step computes it."""
        return ForceFunction(self.exported.program.source)

    def to_dataframe(self) -> pd.DataFrame:
        """The parameters: value in SI and comment; index `parameter`."""
        program = self.exported.program
        rows = [(key, value, program.comments[key]) for key, value in program.parameters.items()]
        return frame(rows, "parameter", columns=("parameter", "value", "comment"))

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad export --json`."""
        program = self.exported.program
        return finite(
            {
                "schema": 1,
                "language": self.language,
                "files": list(self.files),
                **attributes(program, "parameters", "states", "left_out"),
                "mass": {"value": self.exported.mass, "unit": "kg"},
            }
        )

    def lines(self) -> Iterator[str]:
        """What was written, as text."""
        yield from (f"written: {file}" for file in self.files)
        yield from (f"left out: {line}" for line in self.exported.program.left_out)

    def __repr__(self) -> str:
        return f"<Export to {self.language}: {len(self.exported.program.parameters)} parameters>"


def export(
    experiment: Experiment | str | Path, to: str = "python", out: str | Path = "build", design: Design | None = None
) -> Export:
    """Fit the model of an experiment as it stands, and write it in another language.

    Args:
        experiment: the folder, its `experiment.toml`, or an experiment.
        to: python, c, modelica, fmu, matlab or table.
        out: folder to write below.
        design: for known quantities that are taken from the design.

    Raises:
        InputError: no such language, or an effect that cannot be exported, by name.
    """
    require_known(to, LANGUAGES, f"--to: no language '{to}'")
    comparison = compare(experiment, design)
    exported = exported_model(comparison)
    folder = Path(out) / results_key(out, comparison.problem.experiment.folder) / "export"
    folder.mkdir(parents=True, exist_ok=True)
    if to == "fmu":
        return Export(exported, to, (str(write_fmu(exported, folder)),))
    written = []
    for name, text in files_of(exported, to).items():
        atomic_write_text(folder / name, text)
        written.append(str(folder / name))
    return Export(exported, to, tuple(written))
