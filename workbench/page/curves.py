"""Curves of results: kept as arrays of full length, handed to the page as the extremes of each pixel column."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.parameters.atomic import atomic_path
from stagecad.parameters.errors import InputError, require

MOST_COLUMNS = 8000


def write_curves(folder: Path, number: int, series: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Write series (n,) over a first one that increases, as an array (k, n); returns what the page needs to ask."""
    names = list(series)
    array = np.vstack([np.asarray(values, float) for values in series.values()])
    with atomic_path(folder / f"curves_{number}.npy") as temporary, temporary.open("wb") as stream:
        np.save(stream, array)
    first = array[0]
    return {"curves": number, "series": names, "rows": int(first.size), "from": float(first[0]), "to": float(first[-1])}


def read_curves(folder: Path, number: int) -> np.ndarray:
    """The array (k, n) that `write_curves` wrote, mapped into memory."""
    path = folder / f"curves_{number}.npy"
    require(path.is_file(), f"curves {number}: there are none")
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except ValueError:
        array = np.empty(0)
    if array.ndim != 2 or array.dtype.kind != "f" or not array.size:
        raise InputError(f"curves {number}: are damaged; start the job again")
    return array


def extremes(
    curves: np.ndarray, rows: Sequence[int], start: float | None, stop: float | None, columns: int
) -> np.ndarray:
    """The least and the largest value of each series, `rows` of `curves` (k, n) over its increasing first row, in each
    of `columns` equal stretches of a window on that row (None: all of it); fewer than two rows each stay as they are.

    Shape (1 + len(rows), m): the first row of the window, and the series; a stretch gives two columns, the least value
    at its first row and the largest at its middle. NaN where a stretch holds no number."""
    x = curves[0]
    columns = int(min(max(columns, 2), MOST_COLUMNS))
    # One row more on either side, so that lines reach the edges of the window.
    low = 0 if start is None else max(int(np.searchsorted(x, start, "left")) - 1, 0)
    high = x.size if stop is None else min(int(np.searchsorted(x, stop, "right")) + 1, x.size)
    n = high - low
    if n <= 2 * columns:
        return np.vstack([x[low:high], *(curves[row, low:high] for row in rows)])
    edges = low + np.linspace(0, n, columns + 1).astype(int)
    begins, middles = edges[:-1], (edges[:-1] + edges[1:]) // 2
    found = np.empty((1 + len(rows), 2 * columns))
    found[0, 0::2], found[0, 1::2] = x[begins], x[middles]
    for place, row in enumerate(rows, start=1):
        # fmin and fmax pass over NaN.
        values = np.asarray(curves[row, low:high])
        found[place, 0::2], found[place, 1::2] = (f.reduceat(values, begins - low) for f in (np.fmin, np.fmax))
    return found


def sampled(
    curves: np.ndarray, rows: Sequence[int], start: float | None, stop: float | None, points: int
) -> np.ndarray:
    """Evenly spaced rows of a window (1 + len(rows), m), m at most `points`: for one series over another."""
    x = curves[0]
    low = 0 if start is None else int(np.searchsorted(x, start, "left"))
    high = x.size if stop is None else int(np.searchsorted(x, stop, "right"))
    taken = np.unique(np.linspace(low, max(high - 1, low), min(max(points, 2), 2 * MOST_COLUMNS)).astype(int))
    return np.vstack([x[taken], *(curves[row, taken] for row in rows)])
