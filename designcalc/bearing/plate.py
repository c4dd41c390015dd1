"""Bending of a rectangular plate on point springs, with point masses: static compliance and natural modes.

Kirchhoff's plate by the rectangular element of 12 degrees of freedom of Melosh, Zienkiewicz and Cheung: at each node
the deflection and its two slopes, within an element the cubic polynomial with x^3 y and x y^3. The element does not
conform in its slopes across edges; frequencies and deflections converge with the square of its size.

Source: Zienkiewicz, Taylor, The Finite Element Method for Solid and Structural Mechanics (2005), section 11.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import InputError

if TYPE_CHECKING:
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import SuperLU

Array = NDArray[np.float64]
Place = tuple[float, float]

_DEPENDENT = 1e-6
"""Share of the largest modal mass below which a residual shape is one of the others."""

_POWERS = np.array([(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (3, 1), (1, 3)])


@dataclass(frozen=True)
class Plate:
    """A free rectangular plate about the origin.

    Args:
        length, width: along x and y, m.
        thickness: m.
        modulus: Young's modulus, Pa.
        poisson: Poisson's ratio.
        density: kg/m^3.
    """

    length: float
    width: float
    thickness: float
    modulus: float
    poisson: float
    density: float

    def __post_init__(self) -> None:
        for name in ("length", "width", "thickness", "modulus", "density"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise InputError(f"plate: {name}: must be above 0")
        if not -1 < self.poisson < 0.5:
            raise InputError("plate: poisson: must lie in -1 to 0.5")

    @property
    def rigidity(self) -> float:
        """``D = E t^3/(12 (1 - nu^2))``, N m."""
        return self.modulus * self.thickness**3 / (12 * (1 - self.poisson**2))


@dataclass(frozen=True)
class Modes:
    """Natural modes of a supported plate.

    Args:
        frequency: Hz, shape (modes,), rising.
        shapes: deflection at the places asked for, of modes with modal mass 1 kg, shape (places, modes).
    """

    frequency: Array
    shapes: Array


class SupportedPlate:
    """A plate with springs and masses at points, divided into equal elements.

    Args:
        plate: the plate.
        springs: places (x, y), m, with stiffnesses normal to the plate, N/m.
        masses: places with masses, kg, and their radii of gyration about axes in the plate, m.
        elements: number along the shorter side.

    Raises:
        InputError: a place outside the plate.
    """

    def __init__(
        self,
        plate: Plate,
        springs: Sequence[tuple[Place, float]] = (),
        masses: Sequence[tuple[Place, float, float]] = (),
        elements: int = 20,
    ) -> None:
        self.plate = plate
        shorter = min(plate.length, plate.width)
        self._count = (round(elements * plate.length / shorter), round(elements * plate.width / shorter))
        self._sides = (plate.length / self._count[0], plate.width / self._count[1])
        stiffness, mass = self._free()
        for place, k in springs:
            row = self._row(place)
            stiffness = stiffness + k * row.T @ row
        for place, m, radius in masses:
            row = self._row(place)
            mass = mass + m * row.T @ row
            for slope in ((1, 0), (0, 1)):
                row = self._row(place, slope)
                mass = mass + m * radius**2 * row.T @ row
        self._stiffness: csc_array = stiffness.tocsc()
        self._mass: csc_array = mass.tocsc()

    def compliance(self, loads: ArrayLike, responses: ArrayLike | None = None) -> Array:
        """Deflection at places by a unit force at others, both normal to the plate, m/N.

        Args:
            loads: m, shape (n, 2).
            responses: m, shape (k, 2); those of the loads when left out.

        Returns:
            shape (k, n). The springs must hold the plate.
        """
        forces = self._rows(loads)
        rows = forces if responses is None else self._rows(responses)
        return rows @ self._factors.solve(forces.T)

    def sag(self, gravity: float, places: ArrayLike) -> Array:
        """Deflection by the weight of plate and masses, positive downwards, m.

        Args:
            gravity: m/s^2.
            places: m, shape (n, 2).

        Returns:
            shape (n,).
        """
        lifted = np.zeros(self._size)
        lifted[::3] = 1.0
        return gravity * (self._rows(places) @ self._factors.solve(self._mass @ lifted))

    def modes(self, count: int, places: ArrayLike = ((0.0, 0.0),)) -> Modes:
        """The lowest natural modes.

        Args:
            count: of the modes; those of a free plate include its three rigid-body modes.
            places: at which the shapes are wanted, m, shape (n, 2).
        """
        frequency, vectors = self._eigenvectors(count)
        return Modes(frequency, self._rows(places) @ vectors)

    def modes_on_grid(self, count: int, loads: ArrayLike | None = None) -> Modes:
        """The lowest natural modes at the nodes of the elements: `shapes` of shape (nodes along y, along x, modes).

        With `loads` they are completed by residual modes: the static deflections under forces at those places, less
        their part in the natural modes, combined such that mass and stiffness are diagonal. The static deflection under
        such a force is then exact, which takes far more natural modes (Craig, AIAA Paper 85-0640).

        Args:
            count: of natural modes, the rigid-body ones among them.
            loads: places of forces normal to the plate, m, shape (n, 2).
        """
        frequency, vectors = self._eigenvectors(count)
        if loads is not None:
            residual = self._residual(loads, vectors)
            frequency, vectors = np.append(frequency, residual[0]), np.hstack([vectors, residual[1]])
        return Modes(frequency, vectors[::3].reshape(self._count[1] + 1, self._count[0] + 1, -1))

    def _residual(self, loads: ArrayLike, natural: Array) -> tuple[Array, Array]:
        """Frequencies, Hz, and vectors of the residual modes of forces at places, beside the `natural` ones."""
        from scipy.linalg import eigh
        from scipy.sparse.linalg import splu

        shapes = splu((self._stiffness - self._shift() * self._mass).tocsc()).solve(self._rows(loads).T)
        for _ in range(2):
            shapes = shapes - natural @ (natural.T @ (self._mass @ shapes))
        masses, axes = np.linalg.eigh(shapes.T @ (self._mass @ shapes))
        kept = masses > _DEPENDENT * masses.max()
        shapes = shapes @ (axes[:, kept] / np.sqrt(masses[kept]))
        values, axes = eigh(shapes.T @ (self._stiffness @ shapes))
        return np.sqrt(values) / (2 * np.pi), shapes @ axes

    def _shift(self) -> float:
        """A shift of eigenvalues below zero: the stiffness of a free plate is singular."""
        plate = self.plate
        return -1e-2 * plate.rigidity / (plate.density * plate.thickness * (plate.length * plate.width) ** 2)

    def _eigenvectors(self, count: int) -> tuple[Array, Array]:
        """Frequencies, Hz, (count,), rising, and degrees of freedom (n, count) of the lowest modes, of unit mass."""
        from scipy.sparse.linalg import eigsh

        values, vectors = eigsh(self._stiffness, count, self._mass, sigma=self._shift(), v0=np.ones(self._size))
        order = np.argsort(values)
        return np.sqrt(np.maximum(values[order], 0.0)) / (2 * np.pi), vectors[:, order]

    @cached_property
    def _factors(self) -> SuperLU:
        from scipy.sparse.linalg import splu

        return splu(self._stiffness)

    def _rows(self, places: ArrayLike) -> Array:
        from scipy.sparse import vstack

        return vstack([self._row((float(x), float(y))) for x, y in np.atleast_2d(np.asarray(places, float))]).toarray()

    def _row(self, place: Place, derivative: tuple[int, int] = (0, 0)) -> csc_array:
        """Deflection (or a slope) at a place as a combination of the degrees of freedom, shape (1, n)."""
        from scipy.sparse import coo_array

        (nx, ny), (a, b) = self._count, self._sides
        u, v = place[0] / a + nx / 2, place[1] / b + ny / 2
        if not (-1e-9 <= u <= nx + 1e-9 and -1e-9 <= v <= ny + 1e-9):
            raise InputError(f"plate: the place ({place[0]:g} m, {place[1]:g} m) is outside the plate")
        i, j = min(max(int(u), 0), nx - 1), min(max(int(v), 0), ny - 1)
        values = _monomials(np.array([(u - i) * a]), np.array([(v - j) * b]), derivative) @ _to_coefficients(a, b)
        columns = self._numbers()[j * nx + i]
        return coo_array((values[0], (np.zeros(12, int), columns)), shape=(1, self._size)).tocsc()

    @property
    def _size(self) -> int:
        """Number of degrees of freedom."""
        return 3 * (self._count[0] + 1) * (self._count[1] + 1)

    def _numbers(self) -> NDArray[np.int_]:
        """Degrees of freedom of each element, shape (elements, 12)."""
        nx, ny = self._count
        node = np.arange((nx + 1) * (ny + 1)).reshape(ny + 1, nx + 1)
        corners = np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]], axis=-1).reshape(-1, 4)
        return (3 * corners[:, :, None] + np.arange(3)).reshape(-1, 12)

    def _free(self) -> tuple[csc_array, csc_array]:
        """Stiffness and mass of the plate alone."""
        from scipy.sparse import coo_array

        numbers, (a, b) = self._numbers(), self._sides
        rows = np.repeat(numbers, 12, axis=1).ravel()
        columns = np.tile(numbers, (1, 12)).ravel()
        shape = (self._size, self._size)

        def assembled(element: Array) -> csc_array:
            values = np.broadcast_to(element.ravel(), (len(numbers), 144)).ravel()
            return coo_array((values, (rows, columns)), shape=shape).tocsc()

        stiffness, mass = _element(self.plate, a, b)
        return assembled(stiffness), assembled(mass)


def _element(plate: Plate, a: float, b: float) -> tuple[Array, Array]:
    """Stiffness and consistent mass of an element with sides a and b, shape (12, 12)."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    x, y = (points.ravel() for points in np.meshgrid(a * (1 + nodes) / 2, b * (1 + nodes) / 2))
    weight = (np.outer(weights, weights) * a * b / 4).ravel()
    shape = _to_coefficients(a, b)
    xx, yy, xy = (_monomials(x, y, order) @ shape for order in ((2, 0), (0, 2), (1, 1)))
    nu = plate.poisson

    def integral(first: Array, second: Array) -> Array:
        return first.T @ (weight[:, None] * second)

    bending = integral(xx, xx) + integral(yy, yy) + nu * (integral(xx, yy) + integral(yy, xx))
    stiffness = plate.rigidity * (bending + 2 * (1 - nu) * integral(xy, xy))
    deflection = _monomials(x, y, (0, 0)) @ shape
    return stiffness, plate.density * plate.thickness * integral(deflection, deflection)


def _monomials(x: Array, y: Array, derivative: tuple[int, int]) -> Array:
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
