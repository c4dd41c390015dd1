"""Experiments as folders: what a test states is written as `experiment.toml` and one CSV file a record."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sysid.experiment.rigs import CHANNELS

UNITS = {"time": "s"} | {name: channel.unit for name, channel in CHANNELS.items()}
"""SI units of the channels of a linear axis, and of the time."""


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(key)} = {_toml(item)}" for key, item in value.items()) + "}"
    return json.dumps(value, ensure_ascii=False)


def _table(name: str, values: Mapping[str, Any] | None) -> str:
    return f"[{name}]\n" + "".join(f"{json.dumps(k)} = {_toml(v)}\n" for k, v in values.items()) if values else ""


def write_csv(file: Path, columns: Mapping[str, Any]) -> None:
    """Write columns (n,) by header, or by channel where a column is in its SI unit; numbers with twelve digits."""
    headers = [f"{name} [{UNITS[name]}]" if name in UNITS else name for name in columns]
    table = np.column_stack(list(columns.values()))
    np.savetxt(file, table, "%.12g", ",", header=",".join(headers), comments="", encoding="utf-8")


def write_rig(
    folder: Path,
    kind: str | Mapping[str, Any],
    records: Mapping[str, Mapping[str, Any]],
    effects: Sequence[str] = (),
    *,
    known: Mapping[str, str] | None = None,
    noise: Mapping[str, str | float] | None = None,
    parameters: Mapping[str, Any] | None = None,
    rest: str = "",
) -> Path:
    """Write an experiment into `folder`, which is made where it is missing, and return it.

    Args:
        folder: of the experiment.
        kind: of the rig, or the keys of `[rig]`.
        records: columns as for `write_csv` by the name of the record; those whose name begins with `validate` are held
            out.
        effects: of the model.
        known: `[rig.known]`.
        noise: `[noise]`; a number is in the SI unit of its channel.
        parameters: `[model.parameters]`.
        rest: further tables as text.
    """
    folder.mkdir(parents=True, exist_ok=True)
    text = "schema = 1\n" + _table("rig", {"kind": kind} if isinstance(kind, str) else kind)
    text += _table("rig.known", known) + _table("model", {"effects": list(effects)})
    text += _table("model.parameters", parameters)
    for name, columns in records.items():
        write_csv(folder / f"{name}.csv", columns)
        role = "validate" if name.startswith("validate") else "fit"
        text += f'[[record]]\nfile = "{name}.csv"\nrole = "{role}"\n'
    stated = {name: f"{std} {UNITS[name]}" if isinstance(std, float) else std for name, std in (noise or {}).items()}
    (folder / "experiment.toml").write_text(f"{text}{_table('noise', stated)}{rest}", encoding="utf-8")
    return folder


def replace_in(file: Path, old: str, new: str) -> None:
    """Replace a text that occurs in a file once or more."""
    text = file.read_text(encoding="utf-8")
    assert old in text, f"{file} has no {old!r}"
    file.write_text(text.replace(old, new), encoding="utf-8")


def change_column(file: Path, column: int, change: Any, rows: int | None = None) -> None:
    """Put other values in a column of a CSV file, or what a function makes of them, and keep no more than `rows`."""
    header = file.read_text(encoding="utf-8").splitlines()[0]
    table = np.loadtxt(file, delimiter=",", skiprows=1)
    table[:, column] = change(table[:, column]) if callable(change) else change
    np.savetxt(file, table[:rows], "%.12g", ",", header=header, comments="")


def thin(folder: Path, every: int) -> None:
    """Leave each `every`-th row of the records of an experiment, where a test needs no more."""
    for record in folder.glob("*.csv"):
        header, *rows = record.read_text(encoding="utf-8").splitlines()
        record.write_text("\n".join([header, *rows[::every], ""]), encoding="utf-8")


def write_rows(file: Path, header: str, *columns: np.ndarray) -> None:
    """Write columns (n,) under a header as it stands, exactly, with an empty cell for what is no number."""
    lines = [",".join("" if np.isnan(cell) else repr(float(cell)) for cell in row) for row in zip(*columns)]
    file.write_text("\n".join([header, *lines, ""]), encoding="utf-8")


def record_text(file: str = "fit.csv", *settings: str, role: str = "fit") -> str:
    """Text of a record with further settings, one a line."""
    return "\n".join(["[[record]]", f'file = "{file}"', f'role = "{role}"', *settings, ""])


def state(folder: Path, rest: str = "", kind: str = "velocity-drive", effects: Sequence[str] = ()) -> Path:
    """Write an `experiment.toml` of a kind, effects and further text, for records that the test writes itself."""
    text = f"schema = 1\n{_table('rig', {'kind': kind})}{_table('model', {'effects': list(effects)})}{rest}\n"
    (folder / "experiment.toml").write_text(text, encoding="utf-8")
    return folder
