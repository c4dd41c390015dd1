"""A measured profile of a way from a CSV file."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.input_file import read_input
from stagecad.parameters.units import parse_quantity

COLUMNS = ("position", "height")


def read_profile(path: Path) -> tuple[NDArray[np.float64], float]:
    """Heights, m, and their spacing, m, from columns `position [UNIT]` and `height [UNIT]`, evenly spaced."""
    try:
        lines = read_input(path).decode("utf-8").splitlines()
        rows = [row for row in csv.reader(lines) if row]
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except UnicodeDecodeError:
        raise InputError(
            f"{path}: is not a text file; a CSV file with columns `position [m]`, `height [m]` is needed"
        ) from None
    if not rows:
        raise InputError(f"{path}: is empty; columns `position [m]`, `height [m]` are needed")
    scale = {}
    for index, cell in enumerate(rows[0]):
        name, _, unit = cell.strip().partition("[")
        name = name.strip()
        if name not in COLUMNS:
            raise InputError(f"{path}: row 1: no column '{name}' is known{nearest(name, COLUMNS)}")
        scale[name] = index, parse_quantity(f"1 {unit.rstrip(']').strip()}", "m", f"{path}: row 1: {name}")
    missing = [name for name in COLUMNS if name not in scale]
    if missing:
        raise InputError(f"{path}: row 1: column '{missing[0]} [m]' is missing")
    values = {name: np.empty(len(rows) - 1) for name in COLUMNS}
    for number, row in enumerate(rows[1:], start=2):
        for name, (index, size) in scale.items():
            try:
                values[name][number - 2] = float(row[index]) * size
            except (ValueError, IndexError):
                cell = row[index] if index < len(row) else ""
                raise InputError(f"{path}: row {number}: {name} '{cell}' is not a number") from None
    place, heights = values["position"], values["height"]
    if len(place) < 3 or not np.isfinite(heights).all():
        raise InputError(f"{path}: at least three heights are needed, and all of them finite")
    steps = np.diff(place)
    step = float(steps.mean())
    uneven = np.abs(steps - step) > 1e-3 * abs(step)
    if step <= 0 or uneven.any():
        row = int(np.argmax(uneven | (steps <= 0))) + 3
        raise InputError(f"{path}: row {row}: positions must rise by even steps, of {step:.4g} m on the mean")
    return heights, step
