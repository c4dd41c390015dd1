"""`add`, `undo` and `ladder`: effects added to the model of an experiment, taken back, and the error after each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

from stagecad.deferred import pd
from stagecad.parameters.errors import InputError, require
from sysid import add as identification
from sysid.diagnosis.candidate_screening import Progress
from sysid.documents import parameters_json
from sysid.estimation.covariance import public_key
from sysid.estimation.reference_fit import fit_stated_model
from sysid.experiment import ladder as history
from sysid.experiment.experiment import find_experiment
from workbench.figures.identification import ladder_figure
from workbench.figures.plot import Plot
from workbench.operations.design import Design
from workbench.operations.measurement import tables
from workbench.operations.measurement.design_values import as_design_values
from workbench.operations.measurement.experiment import Experiment, as_experiment
from workbench.operations.measurement.fitted import FittedResult, error_frame, error_frames, parameter_frame
from workbench.operations.measurement.statements import decision_line, held_out_over_noise, in_command
from workbench.operations.measurement.write_back import WriteBack, WrittenBack
from workbench.operations.result import Line, Note, Reported, finite


class Addition(FittedResult):
    """An experiment with effects added to its model, or removed from it.

    `experiment` has the new model; its fitted values are the starts of the next fit.
    """

    computed: identification.Addition

    def __init__(
        self, experiment: Experiment, computed: identification.Addition, written: WrittenBack | None = None
    ) -> None:
        super().__init__(experiment, computed)
        self.written = written

    @property
    def errors(self) -> pd.DataFrame:
        """Errors before and after; index `model`, `records`, `channel`."""
        return error_frames({name: self.document[name] for name in ("before", "after")})

    def to_dataframe(self) -> pd.DataFrame:
        """The errors before and after."""
        return self.errors

    @cached_property
    def document(self) -> dict[str, Any]:
        """The document of `stagecad add --json`."""
        written = {} if self.written is None else self.written.to_json()
        return finite({**identification.addition_json(self.computed), **written})

    def plot(self, record: str | None = None, channel: str | None = None) -> Plot:
        """Measurement, prediction of the new model, and residual.

        Args:
            record: name; the one with the largest error when left out.
            channel: name; the force, or the first one measured.
        """
        return self._figure("overlay", {"model": self.fitted.model}, record, channel)

    def lines(self) -> Iterator[Line]:
        """What `stagecad add` prints: tables and sentences."""
        document, revision = self.document, self.computed.revision
        parts = [
            f"{sign} {', '.join(document[key])}" for sign, key in (("+", "added"), ("-", "removed")) if document[key]
        ]
        yield tables.error_table(
            f"Rung {revision.number:03d}: {' '.join(parts)}", document["before"], document["after"]
        )
        parameters = document["parameters"]
        yield tables.parameter_table(parameters)
        for key, (old, new) in self.computed.changed.items():
            unit = parameters.get(public_key(key), {}).get("unit", "")
            before, after = (tables.quantity_text(value, unit) for value in (old, new))
            yield f"{public_key(key)} changed from {before} to {after}"
        yield f"wrote {revision.path} and {self.problem.experiment.path}"
        yield from () if self.written is None else self.written.lines()

    def __repr__(self) -> str:
        computed, document = self.computed, self.document
        before = tables.over_noise_text(held_out_over_noise(computed.before_fit, computed.before_validate))
        after = tables.over_noise_text(held_out_over_noise(computed.after_fit, computed.after_validate))
        signed = [f"+ {name}" for name in document["added"]] + [f"- {name}" for name in document["removed"]]
        change = " ".join(signed) or "no change"
        return f"<Addition to '{self.experiment.name}', {change}: {before} to {after} the noise on held-out records>"


class Restoration(Reported):
    """The model of an experiment before its last change, which stands again.

    Attributes:
        rung: number of the rung that stands again; 0 is the model before any effect was added.
        effects: of the model that stands again.
        kept: file of the undone rung.
    """

    def __init__(self, place: Path, design: Design | None, revision: history.Revision, kept: Path) -> None:
        self.place, self.design, self.revision, self.kept = place, design, revision, kept
        self.rung, self.effects = revision.number, tuple(revision.effects)

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment with the model that stands again."""
        return Experiment.load(self.place, self.design)

    def to_dataframe(self) -> pd.DataFrame:
        """Errors of the model that stands again, as stored with its rung; index `records`, `channel`."""
        return error_frame(self.revision.document.get("before", {}))

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad add --undo --json`."""
        return {"schema": 1, "rung": self.rung, "effects": list(self.effects), "kept": str(self.kept)}

    def lines(self) -> Iterator[Line]:
        """What `stagecad add --undo` prints."""
        effects = ", ".join(self.effects) or "no effects"
        yield f"back on rung {self.rung:03d}: {effects}; the undone rung is kept in {self.kept}"

    def __repr__(self) -> str:
        effects = ", ".join(self.effects) or "no effects"
        return f"<Restoration in '{self.place.resolve().name}': rung {self.rung}, model {effects}>"


class Ladder(Reported):
    """The error of a model after each effect added so far."""

    def __init__(self, experiment: Experiment, rungs: list[dict[str, Any]], edited: bool) -> None:
        self.experiment = experiment
        self.rungs = rungs
        self.edited = edited

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each rung, set of records and channel: what was added, rms (SI), over noise, fit percent."""
        frames = [
            error_frame(rung["before"]).reset_index().assign(rung=rung["rung"], change=change)
            for rung, change in zip(self.rungs, self.changes, strict=True)
        ]
        empty = error_frame({}).reset_index().assign(rung=[], change=[])
        return pd.concat(frames or [empty]).set_index(["rung", "change", "records", "channel"])

    @property
    def changes(self) -> list[str]:
        """What was added and removed on each rung, in words."""
        return [tables.revision_text(rung, "initial model") for rung in self.rungs]

    @property
    def parameters(self) -> pd.DataFrame:
        """Values of the last rung."""
        return parameter_frame(self.rungs[-1].get("parameters", {}) if self.rungs else {})

    def to_json(self) -> list[dict[str, Any]]:
        """The document of `stagecad ladder --json`."""
        return finite(self.rungs)

    def plot(self) -> Plot:
        """Error over noise after each effect added.

        Raises:
            InputError: nothing was added yet.
        """
        require(self.rungs, f"{self.experiment.name}: nothing was added yet, so there is no ladder to draw")
        fit, held = (
            [tables.worst_over_noise(rung["before"].get(part, {})) for rung in self.rungs] for part in tables.PARTS
        )
        return ladder_figure(self.changes, fit, held)

    def lines(self) -> Iterator[Line]:
        """What `stagecad ladder` prints: a table, or how to begin."""
        if not self.rungs:
            folder = self.experiment.stated.folder
            yield f"{folder}: nothing added yet; 'stagecad diagnose {in_command(folder)}' finds what is missing"
            return
        yield tables.ladder_table(self.rungs)
        if self.edited:
            yield Note("note: [model] was edited by hand since the last rung")

    def summary(self) -> list[tuple[str, str]]:
        return [("note", "[model] was edited by hand since the last rung")] if self.edited else []

    def __repr__(self) -> str:
        steps = max(len(self.rungs) - 1, 0)
        model = ", ".join(self.rungs[-1]["effects"]) if self.rungs else "nothing added yet"
        return f"<Ladder of '{self.experiment.name}', {steps} step{'s' if steps != 1 else ''}: {model}>"


def add(
    experiment: Experiment | str | Path,
    *effects: str,
    drop: Sequence[str] = (),
    design: Design | None = None,
    write_back: WriteBack | None = None,
) -> Addition:
    """Add effects to the model of an experiment, and fit it.

    An experiment in a folder is changed there, as by `stagecad add`; one in memory is left as it is. Either way
    `add(...).experiment` has the new model.

    Args:
        experiment: the experiment, or its folder.
        effects: names of the effects to add; of the user's own effects those that the model was given.
        drop: names of effects to remove first.
        design: where the folder's file states a value as `"design"`.
        write_back: fitted values that are written to the parameter file; nothing is added where they cannot be.

    Raises:
        InputError: an effect that is unknown, present already (to drop: absent), or not observable on this rig.
    """
    require(effects or drop, "add: name at least one effect to add or to drop")
    stated = as_experiment(experiment, design)
    # Checked before the rung is written: values that cannot be written back stop the addition with nothing done.
    accept: dict[str, Any] = {} if write_back is None else {"accept": write_back.check}
    computed = identification.add_effects(stated.problem, effects, as_design_values(stated.design), drop, **accept)
    grown = _grown(stated, computed)
    if write_back is None:
        return Addition(grown, computed)
    number = computed.revision.number
    try:
        written = write_back.write(computed.problem, computed.base.fitted, number)
    except (InputError, OSError) as error:
        raise InputError(f"{error}; rung {number:03d} was added all the same") from None
    return Addition(grown, computed, written)


class AllAdditions:
    """A diagnosis, and one rung for each effect that it established, in the order of its ledger."""

    def __init__(self, found: identification.Diagnosis, steps: Sequence[Addition]) -> None:
        self.found = found
        self.steps = tuple(steps)

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad add --all --json`."""
        return finite(identification.additions_json(self.found, [step.computed for step in self.steps]))

    def lines(self) -> Iterator[Line]:
        """What `stagecad add --all` prints: the finding, and tables of each rung."""
        yield decision_line(self.found)
        for step in self.steps:
            yield from step.lines()
        if not self.steps:
            yield "nothing was added: no effect is certain"


def add_all(
    experiment: Experiment | str | Path, design: Design | None = None, progress: Progress | None = None
) -> AllAdditions:
    """Diagnose an experiment, and add every effect that certainly acts, each on a rung of its own."""
    stated = as_experiment(experiment, design)
    found, steps = identification.add_all(stated.problem, as_design_values(stated.design), progress)
    return AllAdditions(found, [Addition(_grown(stated, step), step) for step in steps])


def _grown(before: Experiment, step: identification.Addition) -> Experiment:
    """The experiment with the model of a step: read again from its folder, or in memory."""
    design = before.design
    return Experiment(step.experiment, design) if step.experiment else Experiment.load(before.stated.path, design)


def write_fitted(experiment: str | Path, write_back: WriteBack) -> WrittenBack:
    """Fit the model of an experiment as it stands, and write values back."""
    problem = Experiment.load(experiment, write_back.design).problem
    fitted = fit_stated_model(problem).fitted
    rungs = history.read_history(problem.experiment)
    rung = rungs[-1].number if rungs and not history.edited_by_hand(problem.experiment, rungs) else None
    document = {"schema": 1, "form": problem.form, "effects": [e.name for e in fitted.model.effects]}
    document["parameters"] = parameters_json(problem, fitted)
    return replace(write_back.write(problem, fitted, rung), document=document)


def undo(experiment: Experiment | str | Path, design: Design | None = None) -> Restoration:
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
    # The experiment is not loaded, since a [model] edited by hand may be invalid.
    return Restoration(place, design, *history.undo(find_experiment(place)))


def ladder(experiment: Experiment | str | Path, design: Design | None = None) -> Ladder:
    """The error after each effect added so far to the model of an experiment.

    Args:
        experiment: the experiment, or its folder.
        design: where the folder's file states a value as `"design"`.

    Raises:
        InputError: a fault in a file.
    """
    own = as_experiment(experiment, design)
    edited = history.edited_by_hand(own.stated, history.read_history(own.stated))
    return Ladder(own, identification.ladder_json(own.stated), edited)
