"""Experiments that the page copies into a project: the packaged demonstration, and the folder of examples."""

from __future__ import annotations

import tomllib
from pathlib import Path

from stagecad.parameters.atomic import atomic_write_bytes
from stagecad.parameters.errors import InputError, nearest
from workbench.operations.measurement.demonstration import fresh_demo

FOLDER = Path(__file__).resolve().parents[2] / "examples"
"""Beside the packages in a checkout; an installed package has the demonstration only."""

EXAMPLES = {
    "demo": "A slide whose records contain two hidden effects; the model knows Coulomb and viscous friction",
    "own_effect": "A bellows, which the library does not contain: an effect in a Python file beside the records",
    "own_rig": "A voice coil: a kind of rig in a declaration file beside the records, logged as a spreadsheet writes",
    "emps": "A ball-screw axis in closed loop, a public benchmark",
    "reciprocating_tribometer": "Presliding and slip over 0.24 mm of stroke, a public record",
}


def available() -> list[str]:
    """Names of the examples whose records are on this computer."""
    return [name for name in EXAMPLES if name == "demo" or _files(name)]


def copied(name: str, target: Path) -> Path:
    """Copy an example to `target`, or to the next free name; returns the folder."""
    if name not in available():
        raise InputError(f"no example '{name}'{nearest(name, available())}")
    if name == "demo":
        return fresh_demo(target)
    number, free = 1, target
    while free.exists():
        number += 1
        free = target.with_name(f"{target.name}_{number}")
    for path in _files(name):
        atomic_write_bytes(free / path.name, path.read_bytes())
    return free


def _files(name: str) -> list[Path]:
    """Files of an example; none unless all of its records are there."""
    folder = FOLDER / name
    stated = folder / "experiment.toml"
    if not stated.is_file():
        return []
    records = [folder / record["file"] for record in tomllib.loads(stated.read_text("utf-8")).get("record", ())]
    if not all(record.is_file() and record.parent == folder for record in records):
        return []
    return sorted(path for path in folder.iterdir() if path.is_file() and path.name != "make_records.py")
