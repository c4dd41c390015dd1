"""A new experiment from record files: what their columns are taken for, its `experiment.toml` with comments and
questions."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

# The page asks the operations alone.
from sim.effects.catalogue import library as library
from stagecad.deferred import pd, tomlkit
from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError, require
from sysid.experiment.channels import parse_label
from sysid.experiment.column_proposal import ExperimentProposal, read_numbers
from sysid.experiment.column_proposal import Proposal as Column
from sysid.experiment.column_proposal import propose as propose_columns
from sysid.experiment.column_settings import RATED, column_unit
from sysid.experiment.experiment import QUESTION
from sysid.experiment.model_table import inline
from sysid.experiment.readers.base import Header, shown_path
from sysid.experiment.readers.open import SUFFIXES as SUFFIXES
from sysid.experiment.readers.open import RecordFile, open_record_file
from sysid.experiment.readers.open import record_suffix as record_suffix
from sysid.experiment.readers.open import unknown_format as unknown_format
from sysid.experiment.rig_kinds.declaration import find_rig
from sysid.experiment.rig_kinds.declaration import kinds as kinds
from sysid.experiment.rigs import ALWAYS_ALLOWED
from sysid.experiment.toml_table import shown
from workbench.figures import identification as record_figures
from workbench.figures import plot as drawing
from workbench.operations.design import Design
from workbench.operations.measurement.experiment import Experiment
from workbench.operations.result import Result, finite, render, without_options

SHOWN_ROWS = 4
"""First values of a column in a proposal."""


def record_columns(path: str | Path) -> dict[str, np.ndarray]:
    """The columns (n,) of a record file that hold numbers, by label."""
    opened = open_record_file(Path(path), Path(path).name)
    return {opened.header.labels[index].strip(): values for index, values in read_numbers(opened).columns.items()}


def record_rows(path: str | Path, name: str | None = None) -> int:
    """Number of rows of a record file, called `name` in messages."""
    name = name or Path(path).name
    columns = record_columns(path)
    require(columns, f"{name}: has no column of numbers")
    rows = int(next(iter(columns.values())).size)
    require(rows, f"{name}: has a header and no rows of numbers")
    return rows


class Proposal(Result):
    """What `stagecad new experiment` takes the columns of record files for, with its questions."""

    def __init__(self, opened: Sequence[RecordFile], computed: ExperimentProposal) -> None:
        self.opened, self.computed = tuple(opened), computed

    @property
    def kind(self) -> str:
        """The kind of rig."""
        return self.computed.kind

    @cached_property
    def columns(self) -> list[dict[str, Any]]:
        """Each column: channel, unit, scale, question, and its first values; None for no number."""
        header, numbers = self.opened[0].header, read_numbers(self.opened[0]).columns
        return [
            {
                "column": one.number if header.numbered else one.label,
                "label": one.label,
                "channel": one.channel,
                "unit": "" if one.unit in (None, "?") else one.unit,
                "scale": f"{'? ' * (one.unit != 'count')}{one.scale}" if one.scale and not one.percent else None,
                "question": one.question,
                "first": numbers[one.number - 1][:SHOWN_ROWS] if one.number - 1 in numbers else None,
                "unit_in_file": one.unit is None,
                "stated": _stated_unit(header, one.number - 1),
            }
            for one in self.computed.columns
        ]

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each column: channel, unit, question; index `column`."""
        return pd.DataFrame(self.columns)[["column", "channel", "unit", "question"]].set_index("column")

    def to_json(self) -> dict[str, Any]:
        """Kind of rig, columns, the channels and known quantities of the kind with their units, what is missing.

        Of each group under `needed` one channel is required.
        """
        rig, rotary = find_rig(self.computed.kind, "kind"), self.computed.rotary
        known = known_units(self.computed)
        known |= {f"{RATED}{one.channel}": one.scale for one in self.computed.columns if one.percent}
        return finite(
            {
                "kind": self.computed.kind,
                "question": self.computed.question,
                "read_as": list(self.opened[0].header.remarks),
                "columns": self.columns,
                "channels": {name: rig.declared(name).si_unit(rotary) for name in rig.channels},
                "needed": [list(group) for group in (("time",), *rig.inputs, *rig.measured)],
                "missing": list(missing_channels(self.computed)),
                "known": known,
                "effects": usual_effects(self.computed.kind),
            }
        )

    @property
    def questions(self) -> list[str]:
        """Questions that the user should decide, one line each."""
        asked = [f"rig.kind = '{self.kind}': {self.computed.question}"] if self.computed.question else []
        columns = (one for one in self.computed.columns if one.question and one.channel is not None)
        asked += [f"column {one.number} '{one.label}': {one.question}" for one in columns]
        return [*asked, *(f"no column is taken for {name}" for name in missing_channels(self.computed))]

    def write(self, folder: str | Path) -> WrittenExperiment:
        """Write `experiment.toml` with its questions, and a picture of the columns, into a folder."""
        folder = Path(folder)
        target = folder / "experiment.toml"
        require(not target.exists(), f"{target}: exists already; remove it first, or name another folder")
        require(folder.is_dir() or not folder.exists(), f"{folder}: is a file; a folder is required")
        folder.mkdir(parents=True, exist_ok=True)
        figure = record_figures.columns_figure(read_numbers(self.opened[0]).columns, self.computed)
        (picture,) = drawing.save_figures(folder, {"columns": figure})
        # Last: that it exists says that the folder is complete.
        atomic_write_text(target, experiment_text(folder, self.opened, self.computed))
        return WrittenExperiment(self, target, picture)

    def __repr__(self) -> str:
        taken = ", ".join(one.channel for one in self.computed.columns if one.channel)
        return f"<Proposal: {self.kind}, channels {taken}>"


@dataclass(frozen=True)
class WrittenExperiment:
    """A new `experiment.toml`, and the picture of the columns beside it."""

    proposal: Proposal
    path: Path
    picture: Path

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad new experiment --json`."""
        proposal = self.proposal
        return {
            "experiment": str(self.path),
            "picture": str(self.picture),
            "read_as": list(proposal.opened[0].header.remarks),
            "kind": proposal.kind,
            "channels": {c.channel: c.label for c in proposal.computed.columns if c.channel is not None},
            "questions": proposal.questions,
        }

    def lines(self) -> Iterator[str]:
        """What `stagecad new experiment` prints."""
        from workbench.operations.measurement.statements import in_command

        proposal = self.proposal
        if proposal.opened[0].header.remarks:
            yield f"read as: {', '.join(proposal.opened[0].header.remarks)}"
        for c in proposal.computed.columns:
            yield f"column {c.number} '{c.label}': {c.channel or ': '.join(filter(None, ('left out', c.reason)))}"
        yield from (f"question: {question}" for question in proposal.questions)
        then = "answer its questions, then" if proposal.questions else "then"
        yield f"written: {self.path} and {self.picture}; {then}: stagecad compare {in_command(self.path.parent)}"


def propose(files: Sequence[str | Path], kind: str | None = None) -> Proposal:
    """What record files are taken for: kind of rig, channels, units, and what the user should decide."""
    with without_options():
        return Proposal(*inspect([Path(file) for file in files], kind))


def write_experiment(folder: str | Path, document: Mapping[str, Any], design: Design | None = None) -> Experiment:
    """Write `experiment.toml` for the records in a folder; it is read back, and removed when it is not valid."""
    path = Path(folder) / "experiment.toml"
    require(not path.exists(), f"{path.parent.name}/{path.name}: is there already; choose another name")
    made = not path.parent.exists()
    try:
        atomic_write_text(path, _text(document))
        return Experiment.load(path.parent, design)
    except BaseException:
        path.unlink(missing_ok=True)
        if made:
            with suppress(OSError):
                path.parent.rmdir()
        raise


def _text(document: Mapping[str, Any]) -> str:
    rig = {key: value for key, value in document["rig"].items() if key != "known" or value}
    channels = {channel: inline(given) for channel, given in document.get("channels", {}).items()}
    tables = {"schema": 1, **document, "rig": rig, "channels": channels}
    return tomlkit.dumps({key: value for key, value in tables.items() if value})


def inspect(files: Sequence[Path], kind: str | None) -> tuple[list[RecordFile], ExperimentProposal]:
    """The files, and the experiment proposed from the first of them."""
    if kind is not None:
        find_rig(kind, "--kind")
    opened = [open_record_file(file, shown_path(str(file))) for file in files]
    for other in opened[1:]:
        pairs = zip_longest(other.header.labels, opened[0].header.labels, fillvalue="")
        for number, (own, first) in [(k, pair) for k, pair in enumerate(pairs, start=1) if pair[0] != pair[1]]:
            raise InputError(
                f"{other.name}: has other columns than {opened[0].name} (column {number}: {shown(own)} and "
                f"{shown(first)}); make an experiment of each, or give the columns of one under [[record]] by hand"
            )
    numbers = read_numbers(opened[0])
    if not any(values.size > 1 for values in numbers.columns.values()):
        single = any(values.size for values in numbers.columns.values())
        few = "has 1 row of numbers; more are required" if single else "has a header and no rows of numbers"
        raise InputError(f"{opened[0].name}: {next(iter(numbers.reasons.values()), few)}")
    header = replace(opened[0].header, remarks=(*opened[0].header.remarks, *numbers.notes))
    return [replace(opened[0], header=header), *opened[1:]], propose_columns(opened[0], numbers, kind)


def experiment_text(folder: Path, opened: Sequence[RecordFile], proposal: ExperimentProposal) -> str:
    """The text of `experiment.toml`."""
    rig, rotary, header = find_rig(proposal.kind, "--kind"), proposal.rotary, opened[0].header
    measured = [column.channel for column in proposal.columns if column.channel in rig.measured_channels]
    paths = [os.path.relpath(Path(str(file.path)).resolve(), folder.resolve()) for file in opened]
    return render(
        "experiment.toml.txt",
        mark=QUESTION,
        rated=RATED,
        proposal=proposal,
        known=known_units(proposal),
        effects=json.dumps(usual_effects(proposal.kind)),
        remarks=header.remarks,
        missing=json.dumps(list(proposal.missing)),
        channels=[_channel_line(column, header.numbered) for column in proposal.columns if column.channel],
        needed=missing_channels(proposal),
        pulses=any(column.increments for column in proposal.columns),
        left=[column for column in proposal.columns if not column.channel][:30],
        files=[Path(path).as_posix() for path in paths],
        noise=[(channel, rig.declared(channel).si_unit(rotary)) for channel in measured],
    )


def _channel_line(column: Column, numbered: bool) -> str:
    name = str(column.number) if numbered else '"' + column.label.replace("\\", "\\\\").replace('"', '\\"') + '"'
    entries = [f"column = {name}"]
    entries += [f'unit = "{column.unit}"'] if column.unit else []
    scale = f"{'? ' * (column.unit != 'count')}{column.scale}"
    entries += [f'scale = "{scale}"'] if column.scale and not column.percent else []
    entries += ["increments = true"] if column.increments else []
    value = name if len(entries) == 1 else "{" + ", ".join(entries) + "}"
    if column.fraction is not None:
        key, unit = column.fraction
        value = f'[{value}, {{column = {json.dumps(key, ensure_ascii=False)}, unit = "{unit}"}}]'
    # A load or temperature of unknown unit is left out until the question is answered; no fit needs it.
    optional = column.channel in ALWAYS_ALLOWED and column.channel != "time"
    left = "# " if optional and (column.unit == "?" or column.scale) else ""
    return f"{left}{column.channel} = {value}" + (f"    # {QUESTION} {column.question}" if column.question else "")


def _stated_unit(header: Header, index: int) -> str | None:
    """The unit of a column in the file, if it names one."""
    column = parse_label(index, header.labels[index])
    stated = header.units.get(column.label, column.unit)
    return column_unit(stated) if stated else None


def missing_channels(proposal: ExperimentProposal) -> dict[str, str]:
    """Channels that the kind of rig needs and no column is taken for, with their units."""
    rig = find_rig(proposal.kind, "--kind")
    found = {column.channel for column in proposal.columns}
    groups = (("time",), *rig.inputs, *rig.measured)
    return {
        " or ".join(group): rig.declared(group[0]).si_unit(proposal.rotary)
        for group in groups
        if not found & set(group)
    }


def known_units(proposal: ExperimentProposal) -> dict[str, str]:
    """What may be known of the kind of rig, with its units."""
    units = {name: one.si_unit(proposal.rotary) for name, one in find_rig(proposal.kind, "--kind").known.items()}
    units.pop("mass" if proposal.rotary else "inertia", None)
    return units


def usual_effects(kind: str) -> list[str]:
    """Effects of a first model of a kind of rig."""
    rig = find_rig(kind, "--kind")
    return [] if "actuator-tip" in (rig.name, rig.base) else ["coulomb", "viscous"]
