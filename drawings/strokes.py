"""What a sheet's ink is made of, as arrays: outlines to be drawn along, one lot for each line weight, or to be filled.

Formats differ in words only. So an outline is kept as matplotlib has it, points with a code each, and all outlines of
one weight lie in one pair of arrays, which are written or painted as a whole.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from ezdxf.addons.drawing import recorder
from ezdxf.npshapes import NumpyPath2d

MOVE, LINE, QUADRATIC, CUBIC = 1, 2, 3, 4
"""Codes of points, as in matplotlib: a curve's control points have the code of its end."""
_CODES = {1: (LINE,), 2: (QUADRATIC, QUADRATIC), 3: (CUBIC, CUBIC, CUBIC), 4: (MOVE,)}
"""Codes of the points that come with each of ezdxf's commands."""


@dataclass(frozen=True)
class Outlines:
    """Outlines drawn with one pen.

    Attributes:
        points: (n, 2), mm on paper.
        codes: (n,) what each point is for.
        begins: index of the point with which each outline, or set of outlines filled together, begins.
        weight: of the line, mm; none for what is filled.
    """

    points: np.ndarray
    codes: np.ndarray
    begins: tuple[int, ...]
    weight: float | None

    def with_cubics(self) -> Outlines:
        """The same with each quadratic curve as a cubic one, which is all that some formats have."""
        first = np.flatnonzero(self.codes == QUADRATIC)[::2]
        if not len(first):
            return self
        start, control, end = (self.points[first + k] for k in (-1, 0, 1))
        repeats = np.ones(len(self.codes), dtype=np.int64)
        repeats[first] = 2
        points, codes = np.repeat(self.points, repeats, axis=0), np.repeat(self.codes, repeats)
        places = first + np.arange(len(first))
        points[places] = start + 2.0 / 3.0 * (control - start)
        points[places + 1] = end + 2.0 / 3.0 * (control - end)
        codes[codes == QUADRATIC] = CUBIC
        moved = np.cumsum(repeats) - repeats
        return Outlines(points, codes, tuple(moved[list(self.begins)].tolist()), self.weight)


def outlines(recorded: recorder.Recorder) -> list[Outlines]:
    """What was recorded, in lots of one weight, thin lines first, and what is filled last."""
    strokes: dict[float, list[_Path]] = {}
    fills: list[_Path] = []
    for record in recorded.records:
        weight = recorded.properties[record.property_hash].lineweight
        if isinstance(record, recorder.FilledPathsRecord):
            fills.append(_joined([_path(path) for path in record.paths if len(path)]))
        elif isinstance(record, recorder.PathRecord):
            strokes.setdefault(weight, []).append(_path(record.path))
        elif isinstance(record, recorder.SolidLinesRecord):
            ends = record.lines.np_vertices()
            strokes.setdefault(weight, []).append((ends, np.tile((MOVE, LINE), len(ends) // 2)))
        elif isinstance(record, recorder.PointsRecord):
            points = record.points.np_vertices()
            path = (points, np.array([MOVE] + [LINE] * (len(points) - 1)))
            if len(points) > 2:
                fills.append(path)
            else:
                strokes.setdefault(weight, []).append(path)
    lots = [_lot(paths, weight) for weight, paths in sorted(strokes.items())]
    return [lot for lot in (*lots, _lot(fills, None)) if len(lot.points)]


_Path = tuple[np.ndarray, np.ndarray]
"""Points and codes of one outline, or of a set filled together."""


def _path(path: NumpyPath2d) -> _Path:
    codes = [MOVE, *(code for command in path.command_codes() for code in _CODES[int(command)])]
    return path.np_vertices(), np.array(codes)


def _joined(paths: Sequence[_Path]) -> _Path:
    return np.concatenate([points for points, _ in paths]), np.concatenate([codes for _, codes in paths])


def _lot(paths: Iterable[_Path], weight: float | None) -> Outlines:
    whole = [path for path in paths if len(path[0])]
    if not whole:
        return Outlines(np.empty((0, 2)), np.empty(0, dtype=np.int64), (), weight)
    points, codes = _joined(whole)
    ends = np.cumsum([len(part) for part, _ in whole])
    return Outlines(points, codes, (0, *ends[:-1].tolist()), weight)
