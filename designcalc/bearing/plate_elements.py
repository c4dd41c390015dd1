"""Elements of a free rectangular plate of one outline, kept for all plates of that outline.

Kirchhoff's plate by the rectangular element of 12 degrees of freedom of Melosh, Zienkiewicz and Cheung: at each node
the deflection and its two slopes, within an element the cubic polynomial with x^3 y and x y^3. The element does not
conform in its slopes across edges; frequencies and deflections converge with the square of its size.

Stiffness and mass are those of a plate with unit rigidity and unit mass per area. Thickness, springs and point masses
only scale them and add matrices of low rank, so that what takes long, deflections under unit forces and the modes of
the free plate, is computed once.

Source: Zienkiewicz, Taylor, The Finite Element Method for Solid and Structural Mechanics (2005), section 11.3.
"""

from __future__ import annotations

from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stagecad.parameters.errors import InputError

if TYPE_CHECKING:
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import SuperLU

Array = NDArray[np.float64]
Place = tuple[float, float]
Slope = tuple[int, int]
Row = tuple[NDArray[np.int_], Array]
"""Degrees of freedom and their factors, each of shape (n,): 12 for a place."""

DEFLECTION: Slope = (0, 0)

_POWERS = np.array([(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (3, 1), (1, 3)])
_KEPT = 1024
"""Deflections under unit forces, and rows, that are kept for one outline."""


@lru_cache(maxsize=2)
def outline(length: float, width: float, poisson: float, along: int, across: int) -> Outline:
    """The elements of a plate about the origin, kept for the outlines used last."""
    return Outline(length, width, poisson, along, across)


class Outline:
    """A free plate of unit rigidity and unit mass per area.

    Args:
        length, width: along x and y, m.
        poisson: Poisson's ratio.
        along, across: number of elements.
    """

    def __init__(self, length: float, width: float, poisson: float, along: int, across: int) -> None:
        self.length, self.width, self.poisson = length, width, poisson
        self.along, self.across = along, across
        self.sides = (length / along, width / across)
        self.size = 3 * (along + 1) * (across + 1)
        node = np.arange((along + 1) * (across + 1)).reshape(across + 1, along + 1)
        corners = np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]], axis=-1).reshape(-1, 4)
        self.numbers = (3 * corners[:, :, None] + np.arange(3)).reshape(-1, 12)
        self.stiffness, self.mass = self._assembled()
        self._held: dict[Place, Array] = {}
        self._rows: dict[Place, Row] = {}

    def _assembled(self) -> tuple[csc_array, csc_array]:
        from scipy.sparse import coo_array

        rows = np.repeat(self.numbers, 12, axis=1).ravel()
        columns = np.tile(self.numbers, (1, 12)).ravel()
        found = []
        for element in _element(*self.sides, self.poisson):
            values = np.broadcast_to(element.ravel(), (len(self.numbers), 144)).ravel()
            found.append(coo_array((values, (rows, columns)), shape=(self.size, self.size)).tocsc())
        return found[0], found[1]

    def row(self, place: Place) -> Row:
        """Deflection at a place as a combination of the degrees of freedom; kept."""
        if place not in self._rows:
            if len(self._rows) >= _KEPT:
                self._rows.clear()
            self._rows[place] = self._row(place)
        return self._rows[place]

    def _row(self, place: Place) -> Row:
        (a, b), nx, ny = self.sides, self.along, self.across
        u, v = place[0] / a + nx / 2, place[1] / b + ny / 2
        if not (-1e-9 <= u <= nx + 1e-9 and -1e-9 <= v <= ny + 1e-9):
            raise InputError(f"plate: the place ({place[0]:g} m, {place[1]:g} m) is outside the plate")
        i, j = min(max(int(u), 0), nx - 1), min(max(int(v), 0), ny - 1)
        values = _monomials(np.array([(u - i) * a]), np.array([(v - j) * b]), DEFLECTION) @ _to_coefficients(a, b)
        return self.numbers[j * nx + i], values[0]

    @cached_property
    def _supports(self) -> tuple[list[Place], float]:
        """Three corners, which hold the plate without straining it, and the stiffness of a spring at each."""
        x, y = self.length / 2, self.width / 2
        # With softer or stiffer springs the small differences of large deflections lose digits.
        return [(-x, -y), (x, -y), (-x, y)], 1e4 / (self.length * self.width)

    @cached_property
    def _factors(self) -> SuperLU:
        """Factors of the stiffness matrix of the plate on springs at its corners."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        corners, k = self._supports
        held = csc_array(self.stiffness + low_rank([(self.row(corner), k) for corner in corners], self.size))
        return splu(held)

    def _solved(self, place: Place) -> Array:
        """Deflections of the plate on its corners under a unit force at a place, shape (size,)."""
        if place not in self._held:
            if len(self._held) >= _KEPT:
                self._held.clear()
            columns, values = self.row(place)
            force = np.zeros(self.size)
            force[columns] = values
            self._held[place] = self._factors.solve(force)
        return self._held[place]

    @cached_property
    def _weight(self) -> tuple[Array, Array]:
        """Forces of a unit weight per area, and the deflections of the plate on its corners under them."""
        lifted = np.zeros(self.size)
        lifted[::3] = 1.0
        forces = self.mass @ lifted
        return forces, self._factors.solve(forces)

    def deflections(
        self,
        springs: list[tuple[Place, float]],
        loads: list[tuple[Place, float]],
        weight: float = 0.0,
    ) -> Array:
        """Deflections of the plate on springs under forces at places and a weight per area, shape (size,).

        The plate on its corners is that on the springs but for a matrix of low rank (Woodbury's identity).

        Args:
            springs: places and stiffnesses, relative to the rigidity.
            loads: places and forces, relative to the rigidity.
            weight: per area, relative to the rigidity.
        """
        corners, k = self._supports
        rows = [self.row(place) for place, _ in springs] + [self.row(corner) for corner in corners]
        held = np.array([self._solved(place) for place in (*(place for place, _ in springs), *corners)])
        bare = weight * self._weight[1] if weight else np.zeros(self.size)
        for place, force in loads:
            bare = bare + force * self._solved(place)
        inverse = np.diag([1 / stiffness for _, stiffness in springs] + [-1 / k] * len(corners))
        seen = np.array([values @ held[:, columns].T for columns, values in rows])
        moved = np.array([values @ bare[columns] for columns, values in rows])
        return bare - np.linalg.solve(inverse + seen, moved) @ held

    @cached_property
    def free_modes(self) -> tuple[Array, Array]:
        """All eigenvalues of the free plate, rising, shape (size,), and vectors of unit mass, shape (size, size).

        By the four classes of vectors that are even or odd about each axis.
        """
        from scipy.linalg import eigh

        values, vectors = [], []
        for even_x in (1.0, -1.0):
            for even_y in (1.0, -1.0):
                basis = self._symmetric(even_x, even_y)
                stiffness, mass = ((basis.T @ matrix @ basis).toarray() for matrix in (self.stiffness, self.mass))
                found = eigh(stiffness, mass)
                values.append(found[0])
                vectors.append(basis @ found[1])
        joined = np.concatenate(values)
        order = np.argsort(joined)
        return joined[order], np.ascontiguousarray(np.hstack(vectors)[:, order])

    def _symmetric(self, even_x: float, even_y: float) -> csc_array:
        """Orthonormal vectors that the mirror images about the axes multiply by `even_x` and `even_y`."""
        from scipy.sparse import coo_array, csc_array, eye_array

        node = np.arange(self.size // 3).reshape(self.across + 1, self.along + 1)

        def mirrored(image: NDArray[np.int_], signs: list[float]) -> csc_array:
            rows = (3 * image.ravel()[:, None] + np.arange(3)).ravel()
            values = np.tile(signs, image.size)
            return coo_array((values, (rows, np.arange(self.size))), shape=(self.size, self.size)).tocsc()

        across_x, across_y = mirrored(node[:, ::-1], [1, -1, 1]), mirrored(node[::-1], [1, 1, -1])
        one = eye_array(self.size, format="csc")
        projector = csc_array((one + even_x * across_x) @ (one + even_y * across_y))
        first = node[: self.across // 2 + 1, : self.along // 2 + 1]
        chosen = csc_array(projector[:, (3 * first.ravel()[:, None] + np.arange(3)).ravel()])
        norms = np.sqrt(np.asarray(chosen.multiply(chosen).sum(axis=0))).ravel()
        kept = norms > 0
        return csc_array(chosen[:, kept] / norms[kept])


def low_rank(terms: list[tuple[Row, float]], size: int) -> csc_array:
    """Sum of ``factor row^T row``, shape (size, size)."""
    from scipy.sparse import coo_array, csc_array

    if not terms:
        return csc_array((size, size))
    rows = np.concatenate([np.repeat(columns, columns.size) for (columns, _), _ in terms])
    columns = np.concatenate([np.tile(columns, columns.size) for (columns, _), _ in terms])
    values = np.concatenate([factor * np.outer(row, row).ravel() for (_, row), factor in terms])
    return coo_array((values, (rows, columns)), shape=(size, size)).tocsc()


def _element(a: float, b: float, poisson: float) -> tuple[Array, Array]:
    """Stiffness and consistent mass of an element with sides a and b, shape (12, 12)."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    x, y = (points.ravel() for points in np.meshgrid(a * (1 + nodes) / 2, b * (1 + nodes) / 2))
    weight = (np.outer(weights, weights) * a * b / 4).ravel()
    shape = _to_coefficients(a, b)
    xx, yy, xy = (_monomials(x, y, order) @ shape for order in ((2, 0), (0, 2), (1, 1)))

    def integral(first: Array, second: Array) -> Array:
        return first.T @ (weight[:, None] * second)

    bending = integral(xx, xx) + integral(yy, yy) + poisson * (integral(xx, yy) + integral(yy, xx))
    deflection = _monomials(x, y, DEFLECTION) @ shape
    return bending + 2 * (1 - poisson) * integral(xy, xy), integral(deflection, deflection)


def _monomials(x: Array, y: Array, derivative: Slope) -> Array:
    """The element's monomials, or a derivative of them, at points, shape (points, 12)."""
    found = np.ones((x.size, len(_POWERS)))
    for values, powers, order in ((x, _POWERS[:, 0], derivative[0]), (y, _POWERS[:, 1], derivative[1])):
        factor = np.ones(len(_POWERS))
        for k in range(order):
            factor = factor * np.maximum(powers - k, 0)
        found = found * factor * values[:, None] ** np.maximum(powers - order, 0)
    return found


@lru_cache(maxsize=64)
def _to_coefficients(a: float, b: float) -> Array:
    """Coefficients of the monomials from the deflections and slopes of the corners, shape (12, 12)."""
    x, y = np.array([0.0, a, a, 0.0]), np.array([0.0, 0.0, b, b])
    at_corners = np.stack([_monomials(x, y, order) for order in ((0, 0), (1, 0), (0, 1))], axis=1)
    return np.asarray(np.linalg.inv(at_corners.reshape(12, 12)), float)
