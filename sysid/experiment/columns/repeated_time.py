"""Rows with the time of the row before: loggers write them where their clock is coarser than their sampling."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np


class RepeatedTime(Exception):  # noqa: N818
    """Two rows have one time and different values; `row` is the later one, from 0."""

    def __init__(self, row: int) -> None:
        super().__init__(row)
        self.row = row


def without_repeats(
    time: np.ndarray, values: Mapping[str, np.ndarray], repeated: str | None, notes: list[str]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time and channels (n,) with strictly increasing time.

    A row that repeats the one before in all channels is left out. Others are treated by `repeated`: `first` keeps
    the first row of each time, `mean` takes the mean of its rows, `spread` places m rows of one time at
    t + k (t_next - t)/m, k = 0 .. m - 1, where the last group takes the step of the group before.
    """
    again = np.diff(time, prepend=-np.inf) == 0.0
    if not again.any():
        return time, dict(values)
    same = again.copy()
    for array in values.values():
        before = np.concatenate([array[:1], array[:-1]])
        same &= (array == before) | (np.isnan(array) & np.isnan(before))
    if repeated is None and not np.array_equal(same, again):
        raise RepeatedTime(int(np.flatnonzero(again & ~same)[0]))
    count = int(again.sum())
    rows = f"{count} row{'s' * (count != 1)} with the time of the row before"
    starts = np.flatnonzero(~again)
    if repeated is None or repeated == "first":
        notes.append(f"{rows}{'' if repeated else ' and the same values'} left out")
        return time[starts], {channel: array[starts] for channel, array in values.items()}
    sizes = np.diff(np.append(starts, time.size))
    if repeated == "mean":
        notes.append(f"{rows}: the mean of the rows of one time is taken")
        return time[starts], {c: np.add.reduceat(array, starts) / sizes for c, array in values.items()}
    steps = np.diff(time[starts])
    steps = np.append(steps, steps[-1] * sizes[-1] / sizes[-2] if steps.size else 0.0)
    within = np.arange(time.size) - np.repeat(starts, sizes)
    notes.append(f"{rows}: rows of one time are spread evenly up to the next")
    return time + within * np.repeat(steps / sizes, sizes), dict(values)
