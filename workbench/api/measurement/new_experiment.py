"""A new experiment from record files: what their columns are taken for, and its `experiment.toml`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from workbench.operations.result import Result, finite, without_options

if TYPE_CHECKING:
    import pandas as pd

    from sysid.experiment.columns.proposal import ExperimentProposal
    from sysid.experiment.readers.open import RecordFile
    from workbench.api.measurement.experiment import Experiment
    from workbench.operations.design import Design

SHOWN_ROWS = 4
"""First values of a column in a proposal."""


def record_suffixes() -> tuple[str, ...]:
    """Suffixes of the record files that are read."""
    from sysid.experiment.readers.open import SUFFIXES

    return tuple(SUFFIXES)


def rig_kinds() -> tuple[str, ...]:
    """Names of the kinds of rig."""
    from sysid.experiment.rig_kinds.declaration import kinds

    return tuple(kinds())


def effects() -> list[dict[str, Any]]:
    """The library of effects: name, meaning, law, how it shows, source."""
    from sim.effects.catalogue import library

    names = ("name", "meaning", "equation", "shows", "source")
    return [{name: getattr(effect, name) for name in names} for effect in library().values()]


def need_record_suffix(name: str) -> None:
    """Refuse the name of a file of a format that is not read.

    Raises:
        InputError: such a name, with the formats that are.
    """
    from sysid.experiment.readers.open import record_suffix, unknown_format

    if record_suffix(name) is None:
        raise InputError(f"{name}: {unknown_format(name)}")


def record_rows(path: str | Path, name: str | None = None) -> int:
    """Number of rows of a record file, called `name` in messages.

    Raises:
        InputError: a file that cannot be read, or without numbers.
    """
    from sysid.experiment.columns.proposal import read_numbers
    from sysid.experiment.readers.open import open_record_file

    name = name or Path(path).name
    columns = read_numbers(open_record_file(Path(path), name)).columns
    if not columns:
        raise InputError(f"{name}: has no column of numbers")
    rows = int(next(iter(columns.values())).size)
    if rows == 0:
        raise InputError(f"{name}: has a header and no rows of numbers")
    return rows


class Proposal(Result):
    """What `stagecad new experiment` takes the columns of record files for, with its questions."""

    def __init__(self, opened: Sequence[RecordFile], found: ExperimentProposal) -> None:
        self.opened, self.found = tuple(opened), found

    @property
    def kind(self) -> str:
        """The kind of rig."""
        return self.found.kind

    @cached_property
    def columns(self) -> list[dict[str, Any]]:
        """Each column: channel, unit, scale, question, and its first values; None for no number."""
        from sysid.experiment.columns.proposal import read_numbers

        header, numbers = self.opened[0].header, read_numbers(self.opened[0]).columns
        return [
            {
                "column": one.number if header.numbered else one.label,
                "label": one.label,
                "channel": one.channel,
                "unit": "" if one.unit in (None, "?") else one.unit,
                "scale": one.scale and f"? {one.scale}",
                "question": one.question,
                "first": numbers[k][:SHOWN_ROWS] if k in numbers else None,
                "unit_in_file": one.unit is None,
            }
            for k, one in enumerate(self.found.columns)
        ]

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each column: channel, unit, question; index `column`."""
        import pandas as pd

        names = ["column", "channel", "unit", "question"]
        return pd.DataFrame(self.columns)[names].set_index("column")

    def to_json(self) -> dict[str, Any]:
        """Kind of rig, columns, the channels and known quantities of the kind with their units, what is missing.

        Of each group under `needed` one channel is required.
        """
        from sysid.experiment.rig_kinds.declaration import find_rig
        from workbench.identification.new_experiment import missing_channels, usual_effects

        rig, rotary = find_rig(self.found.kind, "kind"), self.found.rotary
        known = {key: one.rotary_unit if rotary else one.unit for key, one in rig.known.items()}
        known.pop("mass" if rotary else "inertia", None)
        return finite(
            {
                "kind": self.found.kind,
                "question": self.found.question,
                "read_as": list(self.opened[0].header.remarks),
                "columns": self.columns,
                "channels": {name: rig.declared(name).si_unit(rotary) for name in rig.channels},
                "needed": [list(group) for group in (("time",), *rig.inputs, *rig.measured)],
                "missing": list(missing_channels(self.found)),
                "known": known,
                "effects": usual_effects(self.found.kind),
            }
        )

    def __repr__(self) -> str:
        taken = ", ".join(one.channel for one in self.found.columns if one.channel)
        return f"<Proposal: {self.kind}, channels {taken}>"


def propose(files: Sequence[str | Path], kind: str | None = None) -> Proposal:
    """What record files are taken for: kind of rig, channels, units, and what the user should decide.

    Args:
        files: with the same columns.
        kind: of rig, where it is known.

    Raises:
        InputError: a file that cannot be read, files with different columns, or an unknown kind of rig.
    """
    from workbench.identification.new_experiment import inspect

    with without_options():
        return Proposal(*inspect([Path(file) for file in files], kind))


def write_experiment(folder: str | Path, document: Mapping[str, Any], design: Design | None = None) -> Experiment:
    """Write `experiment.toml` for the records in a folder; it is read back, and removed when it is not valid.

    Args:
        folder: with the records.
        document: tables of the file: `rig`, `model`, `channels`, `record`, `noise`; empty ones are left out.
        design: where a value is stated as `"design"`.

    Raises:
        InputError: the file exists, or one line with key, value, and what is allowed.
    """
    from workbench.api.measurement.experiment import Experiment

    path = Path(folder) / "experiment.toml"
    if path.exists():
        raise InputError(f"{path.parent.name}/{path.name}: is there already; choose another name")
    atomic_write_text(path, _text(document))
    try:
        return Experiment.load(path.parent, design)
    except InputError:
        path.unlink(missing_ok=True)
        raise


def _text(document: Mapping[str, Any]) -> str:
    import tomlkit

    text = tomlkit.document()
    text["schema"] = 1
    rig = dict(document["rig"])
    text["rig"] = {key: value for key, value in rig.items() if key != "known" or value}
    text["model"] = dict(document["model"])
    if document.get("channels"):
        table = tomlkit.table()
        for channel, given in document["channels"].items():
            entry = tomlkit.inline_table()
            entry.update(given)
            table[channel] = entry
        text["channels"] = table
    records = tomlkit.aot()
    for record in document["record"]:
        records.append(tomlkit.item(dict(record)))
    text["record"] = records
    if document.get("noise"):
        text["noise"] = dict(document["noise"])
    return tomlkit.dumps(text)


def fresh_demo(folder: str | Path) -> Path:
    """Copy the packaged demonstration to a folder, or to the next free one; returns the folder."""
    from workbench.cli.commands.demo import free_folder, fresh_copy

    return fresh_copy(free_folder(Path(folder)))
