"""Errors of the stage gathered at the payload by homogeneous transforms, each named, the largest first."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Contribution:
    """One cause of error, as a small displacement and rotation about a point of the parts it carries."""

    name: str
    source: str
    translation: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m, x along, y across, z normal
    rotation: tuple[float, float, float] = (0.0, 0.0, 0.0)  # rad
    about: tuple[float, float, float] = (0.0, 0.0, 0.0)  # point the rotation turns about, m
    random: bool = True  # adds by squares with the other random ones; else its size adds directly


def transform(translation: ArrayLike, rotation: ArrayLike, about: ArrayLike) -> Array:
    """Homogeneous transform (4, 4): rotation vector (rad) about a point, then translation (m).

    The rotation is exact (Rodrigues), not linearised.
    """
    w, c = np.asarray(rotation, float), np.asarray(about, float)
    angle = float(np.linalg.norm(w))
    turn = np.eye(3)
    if angle > 0:
        x, y, z = w / angle
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = turn + np.sin(angle) * cross + 2 * np.sin(angle / 2) ** 2 * cross @ cross
    matrix = np.eye(4)
    matrix[:3, :3] = turn
    matrix[:3, 3] = c - turn @ c + np.asarray(translation, float)
    return matrix


def error_at(contribution: Contribution, point: ArrayLike) -> Array:
    """Displacement of a point (m, shape (3,)) by one contribution, m, shape (3,)."""
    r = np.asarray(point, float)
    moved = transform(contribution.translation, contribution.rotation, contribution.about) @ np.append(r, 1.0)
    return moved[:3] - r


def budget(contributions: Sequence[Contribution], point: ArrayLike) -> tuple[list[tuple[Contribution, Array]], Array]:
    """Every contribution at the point, largest first, and the total.

    Returns:
        rows (contribution, displacement (3,)), and the total per direction: root sum of squares of the random ones plus
        the plain sum of sizes of the others, m, shape (3,).
    """
    rows = [(c, error_at(c, point)) for c in contributions]
    rows.sort(key=lambda row: -float(np.linalg.norm(row[1])))
    zero = np.zeros(3)
    random = np.sqrt(sum((e**2 for c, e in rows if c.random), zero))
    fixed = sum((np.abs(e) for c, e in rows if not c.random), zero)
    return rows, random + fixed


AXES = {"along": 0, "across": 1, "normal": 2}


@dataclass(frozen=True)
class Budget:
    """One budget: its subject, the direction in which it is judged, and its contributions."""

    name: str
    direction: str
    key: str  # of its limit
    requirement: str
    # contributions with the displacement of the payload by each, m, the largest in the direction first
    rows: tuple[tuple[Contribution, Array], ...]
    total: Array  # per direction, m
    point: tuple[float, float, float]  # of the payload with the largest error, from the middle of the stage, m

    @property
    def axis(self) -> int:
        return AXES[self.direction]
