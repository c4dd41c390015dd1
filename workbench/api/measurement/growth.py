"""`add`, `undo` and `ladder`: effects added to the model of an experiment, taken back, and the error after each."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError
from sysid.ladder import Addition as Found
from sysid.ladder import add_effects, addition_json, current_ladder
from workbench.api.measurement.experiment import Experiment, as_experiment, design_source
from workbench.api.measurement.fitted import FittedResult, document, error_frame, parameter_frame
from workbench.cli.options import results_in
from workbench.identification.undo import Undoing, undo_last
from workbench.operations.result import Result

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from workbench.operations.design import Design


class Addition(FittedResult):
    """An experiment with effects added to its model, or removed from it.

    `experiment` has the new model; its fitted values are the starts of the next fit.
    """

    found: Found

    @property
    def errors(self) -> pd.DataFrame:
        """Errors before and after; index `model`, `records`, `channel`."""
        import pandas as pd

        both = {name: error_frame(self._document[name]) for name in ("before", "after")}
        return pd.concat(both, names=["model"])

    def to_dataframe(self) -> pd.DataFrame:
        """The errors before and after."""
        return self.errors

    @cached_property
    def _document(self) -> dict[str, Any]:
        return document(addition_json(self.found))

    def plot(self, record: str | None = None, channel: str | None = None) -> Figure:
        """Measurement, prediction of the new model, and residual.

        Args:
            record: name; the one with the largest error when left out.
            channel: name; the force, or the first one measured.
        """
        from workbench.api.figures.results import model_figure

        return model_figure(self.problem, {"model": self.fitted.model}, (), "overlay", record, channel)

    def __repr__(self) -> str:
        from workbench.identification.statements import held_out_over_noise
        from workbench.identification.tables import over_noise_text

        before = over_noise_text(held_out_over_noise(self.found.before_fit, self.found.before_validate))
        after = over_noise_text(held_out_over_noise(self.found.after_fit, self.found.after_validate))
        signed = [f"+ {name}" for name in self._document["added"]] + [f"- {name}" for name in self._document["removed"]]
        change = " ".join(signed) or "no change"
        return f"<Addition to '{self.experiment.name}', {change}: {before} to {after} the noise on held-out records>"


class Undone(Result):
    """The last change of the model of an experiment, taken back."""

    def __init__(self, place: Path, design: Design | None, found: Undoing) -> None:
        self.place, self.design = place, design
        self.found = found

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment with the model that stands again."""
        return Experiment.load(self.place, self.design)

    @property
    def rung(self) -> int:
        """Number of the rung that stands again; 0 is the model before any effect was added."""
        return self.found.rung.number

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects of the model that stands again."""
        return self.found.rung.effects

    @property
    def kept(self) -> Path:
        """File of the undone rung."""
        return self.found.kept

    def to_dataframe(self) -> pd.DataFrame:
        """Errors of the model that stands again, as stored with its rung; index `records`, `channel`."""
        return error_frame(self.found.rung.document.get("before", {}))

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad add --undo --json`."""
        return document(self.found.as_json())

    def __repr__(self) -> str:
        effects = ", ".join(self.effects) or "no effects"
        return f"<Undone in '{self.place.resolve().name}': rung {self.rung}, model {effects}>"


class Ladder(Result):
    """The error of a model after each effect added so far."""

    def __init__(self, experiment: Experiment, rungs: list[dict[str, Any]], edited: bool) -> None:
        self.experiment = experiment
        self.rungs = rungs
        self.edited = edited

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each rung, set of records and channel: what was added, rms (SI), over noise, fit percent."""
        import pandas as pd

        tables = [
            error_frame(rung["before"]).reset_index().assign(rung=rung["rung"], change=self._change(rung))
            for rung in self.rungs
        ]
        empty = error_frame({}).reset_index().assign(rung=[], change=[])
        return pd.concat(tables or [empty]).set_index(["rung", "change", "records", "channel"])

    @staticmethod
    def _change(rung: dict[str, Any]) -> str:
        from workbench.identification.tables import revision_text

        return revision_text(rung, "initial model")

    @property
    def parameters(self) -> pd.DataFrame:
        """Values of the last rung."""
        return parameter_frame(self.rungs[-1].get("parameters", {}) if self.rungs else {})

    def to_json(self) -> list[dict[str, Any]]:
        """The document of `stagecad ladder --json`."""
        return document(self.rungs)

    def plot(self) -> Figure:
        """Error over noise after each effect added.

        Raises:
            InputError: nothing was added yet.
        """
        from workbench.api.figures.results import ladder_figure

        if not self.rungs:
            raise InputError(f"{self.experiment.name}: nothing was added yet, so there is no ladder to draw")
        return ladder_figure(self.rungs)

    def write_report(self, out: str | Path) -> Path:
        """Write figure and report of `stagecad ladder` below the folder `out`; returns the file to open."""
        from workbench.report.page import write_ladder

        return write_ladder(results_in(out), self.experiment.name, self.rungs)

    def summary(self) -> list[tuple[str, str]]:
        return [("note", "[model] was edited by hand since the last rung")] if self.edited else []

    def __repr__(self) -> str:
        steps = max(len(self.rungs) - 1, 0)
        model = ", ".join(self.rungs[-1]["effects"]) if self.rungs else "nothing added yet"
        return f"<Ladder of '{self.experiment.name}', {steps} step{'s' if steps != 1 else ''}: {model}>"


def add(
    experiment: Experiment | str | Path,
    *effects: str,
    drop: tuple[str, ...] | list[str] = (),
    design: Design | None = None,
) -> Addition:
    """Add effects to the model of an experiment, and fit it.

    An experiment in a folder is changed there, as by `stagecad add`; one in memory is left as it is. Either way
    `add(...).experiment` has the new model.

    Args:
        experiment: the experiment, or its folder.
        effects: names of the effects to add; of the user's own effects those that the model was given.
        drop: names of effects to remove first.
        design: where the folder's file states a value as `"design"`.

    Raises:
        InputError: an effect that is unknown, present already (to drop: absent), or not observable on this rig.
    """
    if not effects and not drop:
        raise InputError("add: name at least one effect to add or to drop")
    stated = as_experiment(experiment, design)
    found = add_effects(stated.problem, effects, design_source(stated.design), drop)
    if found.experiment is None:
        return Addition(Experiment.load(stated.stated.path, stated.design), found)
    return Addition(Experiment(found.experiment, stated.design), found)


def undo(experiment: Experiment | str | Path, design: Design | None = None) -> Undone:
    """Go back one rung: take the last `add` to an experiment in a folder back. The undone rung is kept.

    Args:
        experiment: the experiment, or its folder.
        design: where the folder's file states a value as `"design"`.

    Raises:
        InputError: nothing to undo, a model edited by hand since, or an experiment in memory, where `add` changes
            nothing.
    """
    if isinstance(experiment, Experiment):
        if not experiment.in_files:
            raise InputError(
                f"{experiment.name}: is in memory, where add changes nothing; go on with the one given to add"
            )
        place, design = experiment.stated.folder, design or experiment.design
    elif isinstance(experiment, str | Path):
        place = Path(experiment)
    else:
        raise InputError(f"an Experiment or its folder is required, not {type(experiment).__name__}")
    return Undone(place, design, undo_last(place))


def ladder(experiment: Experiment | str | Path, design: Design | None = None) -> Ladder:
    """The error after each effect added so far to the model of an experiment.

    Args:
        experiment: the experiment, or its folder.
        design: where the folder's file states a value as `"design"`.

    Raises:
        InputError: a fault in a file.
    """
    found = as_experiment(experiment, design)
    return Ladder(found, *current_ladder(found.stated))
