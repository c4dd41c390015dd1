"""Bending of a rectangular plate on point springs, with point masses and bodies that stand on it: static compliance and
natural modes.

Kirchhoff's plate by finite elements (`designcalc.bearing.plate_elements`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from designcalc.bearing.plate_elements import Place, Row, low_rank, outline
from stagecad.parameters.errors import require

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]

_DEPENDENT = 1e-6
"""Share of the largest modal mass below which a residual shape is one of the others."""
_KEPT_MODES, _RESIDUAL_ORDERS = 2.5, 4
"""Modes of the free plate in the basis for the modes of a supported one, per mode wanted; and orders of the residual
vectors of its springs and masses: frequencies agree with those of all degrees of freedom to 1e-10."""
_EXTREME = 1e3
"""Largest stiffness or mass at a point, over that of the plate in such a mode, for which this basis serves."""


@dataclass(frozen=True)
class Plate:
    """A free rectangular plate about the origin."""

    # length, width: along x and y, m
    length: float
    width: float
    thickness: float  # m
    modulus: float  # Young's modulus, Pa
    poisson: float  # Poisson's ratio
    density: float  # kg/m^3

    def __post_init__(self) -> None:
        for name in ("length", "width", "thickness", "modulus", "density"):
            require(np.isfinite(getattr(self, name)) and getattr(self, name) > 0, f"plate: {name}: must be above 0")
        require(-1 < self.poisson < 0.5, "plate: poisson: must lie in -1 to 0.5")

    @property
    def rigidity(self) -> float:
        """``D = E t^3/(12 (1 - nu^2))``, N m."""
        return self.modulus * self.thickness**3 / (12 * (1 - self.poisson**2))


@dataclass(frozen=True)
class Modes:
    """Natural modes of a supported plate."""

    frequency: Array  # Hz, shape (modes,), rising
    shapes: Array  # deflection at the requested places, of modes with modal mass 1 kg, shape (places, modes)


@dataclass(frozen=True)
class StandingBody:
    """A rigid body that stands on feet, which leave the plate free to bend between them.

    Each foot carries an equal share of its mass. With its centre at a height over the plate's middle plane it is moved
    along the plate as it turns: the inertia m h^2 turns by the mean slopes of the feet,
    ``sum (x_i - x_0) w_i/sum (x_i - x_0)^2``. The slope of the plate at a single point would not do: under a moment
    there it grows without bound with the number of elements.
    """

    feet: tuple[Place, ...]  # places, m
    mass: float  # m, kg
    height: float  # h, m

    def turns(self) -> list[list[tuple[Place, float]]]:
        """Mean slopes along x and y: weights of the deflections of the feet, 1/m."""
        away = np.array(self.feet) - np.mean(self.feet, axis=0)
        return [
            list(zip(self.feet, (along / (along @ along)).tolist(), strict=True)) for along in away.T if np.any(along)
        ]


class SupportedPlate:
    """A plate with springs, masses and standing bodies, divided into equal elements.

    Args:
        plate: the plate.
        springs: places (x, y), m, with stiffnesses normal to the plate, N/m.
        masses: places with masses, kg.
        bodies: that stand on the plate.
        elements: number along the shorter side.

    Raises:
        InputError: a place outside the plate.
    """

    def __init__(
        self,
        plate: Plate,
        springs: Sequence[tuple[Place, float]] = (),
        masses: Sequence[tuple[Place, float]] = (),
        bodies: Sequence[StandingBody] = (),
        elements: int = 20,
    ) -> None:
        self.plate = plate
        shorter = min(plate.length, plate.width)
        counts = (round(elements * plate.length / shorter), round(elements * plate.width / shorter))
        self._outline = outline(plate.length, plate.width, plate.poisson, *counts)
        self.bodies = tuple(bodies)
        shares = [(foot, body.mass / len(body.feet)) for body in bodies for foot in body.feet]
        self._springs, self._masses = list(springs), [*masses, *shares]
        self._spring_rows = [(self._outline.row(place), k) for place, k in springs]
        self._mass_rows = [(self._outline.row(place), m) for place, m in self._masses]
        self._mass_rows += [
            (self._combined(turn), body.mass * body.height**2)
            for body in bodies
            if body.height
            for turn in body.turns()
        ]

    def _combined(self, weights: list[tuple[Place, float]]) -> Row:
        """A weighted sum of deflections as a combination of the degrees of freedom."""
        rows = [self._outline.row(place) for place, _ in weights]
        values = [weight * row[1] for row, (_, weight) in zip(rows, weights, strict=True)]
        return np.concatenate([row[0] for row in rows]), np.concatenate(values)

    @property
    def _area_density(self) -> float:
        return self.plate.density * self.plate.thickness

    @cached_property
    def _stiffness(self) -> csc_array:
        """Stiffness matrix of the plate on its springs, N/m."""
        return self.plate.rigidity * self._outline.stiffness + low_rank(self._spring_rows, self._outline.size)

    @cached_property
    def _mass(self) -> csc_array:
        """Mass matrix of plate and masses, kg."""
        return self._area_density * self._outline.mass + low_rank(self._mass_rows, self._outline.size)

    def compliance(self, loads: ArrayLike, responses: ArrayLike | None = None) -> Array:
        """Deflection at places by a unit force at others, both normal to the plate, m/N.

        Args:
            loads: m, shape (n, 2).
            responses: m, shape (k, 2); those of the loads when left out.

        Returns:
            shape (k, n). The springs must hold the plate.
        """
        unit = 1 / self.plate.rigidity
        fields = [self._deflections([(place, unit)]) for place in _places(loads)]
        return self._at(loads if responses is None else responses, np.array(fields).T)

    def sag(self, gravity: float, places: ArrayLike) -> Array:
        """Deflection by the weight of plate and masses, positive downwards, m.

        Args:
            gravity: m/s^2.
            places: m, shape (n, 2).

        Returns:
            shape (n,).
        """
        unit = gravity / self.plate.rigidity
        loads = [(place, unit * mass) for place, mass in self._masses]
        return self._at(places, self._deflections(loads, unit * self._area_density))

    def _deflections(self, loads: list[tuple[Place, float]], weight: float = 0.0) -> Array:
        springs = [(place, k / self.plate.rigidity) for place, k in self._springs]
        return self._outline.deflections(springs, loads, weight)

    def modes(self, count: int, places: ArrayLike = ((0.0, 0.0),)) -> Modes:
        """The lowest natural modes.

        Args:
            count: of the modes; those of a free plate include its three rigid-body modes.
            places: at which the shapes are required, m, shape (n, 2).
        """
        free, shapes = self._outline.free_modes
        kept = min(max(round(_KEPT_MODES * count), 60), free.size)
        # A spring or mass far beyond those of the plate's own modes leaves no digits for the others.
        extreme = _EXTREME * self.plate.length * self.plate.width
        stiff = any(k > extreme * free[kept - 1] * self.plate.rigidity for _, k in self._springs)
        if stiff or any(m > extreme * self._area_density for _, m in self._masses):
            frequency, vectors = self._eigenvectors(count)
            return Modes(frequency, self._at(places, vectors))
        frequency, parts = self._from_free_modes(count, kept, free, shapes)
        rows = [(self._outline.row(place), 1.0) for place in _places(places)]
        return Modes(frequency, _projected(rows, shapes) @ parts)

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
        return Modes(frequency, vectors[::3].reshape(self._outline.across + 1, self._outline.along + 1, -1))

    def _residual(self, loads: ArrayLike, natural: Array) -> tuple[Array, Array]:
        """Frequencies, Hz, and vectors of the residual modes of forces at places, beside the `natural` ones."""
        from scipy.linalg import eigh
        from scipy.sparse.linalg import splu

        forces = np.zeros((self._outline.size, len(_places(loads))))
        for number, place in enumerate(_places(loads)):
            columns, values = self._outline.row(place)
            forces[columns, number] = values
        shapes = splu((self._stiffness - self._shift() * self._mass).tocsc()).solve(forces)
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
        return -1e-2 * plate.rigidity / (self._area_density * (plate.length * plate.width) ** 2)

    def _eigenvectors(self, count: int) -> tuple[Array, Array]:
        """Frequencies, Hz, (count,), rising, and degrees of freedom (n, count) of the lowest modes, of unit mass."""
        from scipy.sparse.linalg import eigsh

        first = np.ones(self._outline.size)
        values, vectors = eigsh(self._stiffness, count, self._mass, sigma=self._shift(), v0=first)
        order = np.argsort(values)
        return np.sqrt(np.maximum(values[order], 0.0)) / (2 * np.pi), vectors[:, order]

    def _from_free_modes(self, count: int, kept: int, free: Array, shapes: Array) -> tuple[Array, Array]:
        """As `_eigenvectors`, the vectors by their parts in the modes of the free plate of unit rigidity and density.

        The lowest of these, and residual vectors in the others: a mode of eigenvalue ``v`` is moved by springs and
        masses at points by ``sum_j phi_j (phi_j . f)/(v_j - v)``, whose part of high ``v_j`` is a power series in ``v``
        about the middle of the range, with one vector for each power.
        """
        from scipy.linalg import eigh

        springs = _projected(self._spring_rows, shapes)
        masses = _projected(self._mass_rows, shapes)
        tail = np.vstack([springs, masses])[:, kept:].T / (free[kept:, None] - 0.5 * free[count])
        orders = [tail]
        for _ in range(_RESIDUAL_ORDERS - 1):
            orders.append(orders[-1] * free[kept] / (free[kept:, None] - 0.5 * free[count]))
        whole = np.hstack(orders)
        residual = np.zeros((free.size - kept, 0))
        if whole.size:
            residual = np.asarray(np.linalg.qr(whole / np.linalg.norm(whole, axis=0))[0])

        def reduced(rows: Array) -> Array:
            return np.hstack([rows[:, :kept], rows[:, kept:] @ residual])

        by_springs, by_masses = reduced(springs), reduced(masses)
        k = np.array([[factor] for _, factor in self._spring_rows]).reshape(-1, 1) / self.plate.rigidity
        m = np.array([[factor] for _, factor in self._mass_rows]).reshape(-1, 1) / self._area_density
        stiffness = by_springs.T @ (k * by_springs)
        stiffness[np.arange(kept), np.arange(kept)] += free[:kept]
        stiffness[kept:, kept:] += residual.T @ (free[kept:, None] * residual)
        mass = by_masses.T @ (m * by_masses) + np.eye(len(stiffness))
        values, vectors = eigh(stiffness, mass, subset_by_index=(0, count - 1))
        values = np.maximum(values, 0.0) * self.plate.rigidity / self._area_density
        modal = np.vstack([vectors[:kept], residual @ vectors[kept:]]) / np.sqrt(self._area_density)
        return np.sqrt(values) / (2 * np.pi), modal

    def _at(self, places: ArrayLike, vectors: Array) -> Array:
        """Deflections at places, shape (n, ...), of vectors of degrees of freedom, shape (size, ...)."""
        rows = [self._outline.row(place) for place in _places(places)]
        return np.array([values @ vectors[columns] for columns, values in rows])


def _places(places: ArrayLike) -> list[Place]:
    return [(float(x), float(y)) for x, y in np.atleast_2d(np.asarray(places, float))]


def _projected(rows: Sequence[tuple[Row, float]], shapes: Array) -> Array:
    """Rows of degrees of freedom as combinations of modes, shape (rows, modes)."""
    if not rows:
        return np.zeros((0, shapes.shape[1]))
    return np.array([values @ shapes[columns] for (columns, values), _ in rows])
