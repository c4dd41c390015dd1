"""Bending of a rectangular plate on point springs, with point masses and bodies that stand on it: static compliance and
natural modes.

Kirchhoff's plate by the rectangular element of 12 degrees of freedom of Melosh, Zienkiewicz and Cheung: at each node
the deflection and its two slopes, within an element the cubic polynomial with x^3 y and x y^3. The element does not
conform in its slopes across edges; frequencies and deflections converge with the square of its size.

Stiffness and mass are those of a plate with unit rigidity and unit mass per area. Thickness, springs and point masses
only scale them and add matrices of low rank, so that what takes long, deflections under unit forces and the modes of
the free plate, is computed once.

Source: Zienkiewicz, Taylor, The Finite Element Method for Solid and Structural Mechanics (2005), section 11.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.deferred import linalg, sparse, sparse_linalg
from stagecad.parameters.errors import InputError, require

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
    """A free plate of unit rigidity and unit mass per area, `length` x `width` m, with so many elements along each."""

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

    def _assembled(self) -> tuple[sparse.csc_array, sparse.csc_array]:
        rows = np.repeat(self.numbers, 12, axis=1).ravel()
        columns = np.tile(self.numbers, (1, 12)).ravel()
        found = []
        for element in _element(*self.sides, self.poisson):
            values = np.broadcast_to(element.ravel(), (len(self.numbers), 144)).ravel()
            found.append(sparse.coo_array((values, (rows, columns)), shape=(self.size, self.size)).tocsc())
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
    def _factors(self) -> sparse_linalg.SuperLU:
        """Factors of the stiffness matrix of the plate on springs at its corners."""
        corners, k = self._supports
        held = sparse.csc_array(self.stiffness + low_rank([(self.row(corner), k) for corner in corners], self.size))
        return sparse_linalg.splu(held)

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
        self, springs: list[tuple[Place, float]], loads: list[tuple[Place, float]], weight: float = 0.0
    ) -> Array:
        """Deflections of the plate on springs under forces at places and a weight per area, shape (size,).

        The plate on its corners is that on the springs but for a matrix of low rank (Woodbury's identity). Stiffnesses
        and forces with their places, and the weight per area, are relative to the rigidity.
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
        values, vectors = [], []
        for even_x in (1.0, -1.0):
            for even_y in (1.0, -1.0):
                basis = self._symmetric(even_x, even_y)
                stiffness, mass = ((basis.T @ matrix @ basis).toarray() for matrix in (self.stiffness, self.mass))
                found = linalg.eigh(stiffness, mass)
                values.append(found[0])
                vectors.append(basis @ found[1])
        joined = np.concatenate(values)
        order = np.argsort(joined)
        return joined[order], np.ascontiguousarray(np.hstack(vectors)[:, order])

    def _symmetric(self, even_x: float, even_y: float) -> sparse.csc_array:
        """Orthonormal vectors that the mirror images about the axes multiply by `even_x` and `even_y`."""
        node = np.arange(self.size // 3).reshape(self.across + 1, self.along + 1)

        def mirrored(image: NDArray[np.int_], signs: list[float]) -> sparse.csc_array:
            rows = (3 * image.ravel()[:, None] + np.arange(3)).ravel()
            values = np.tile(signs, image.size)
            return sparse.coo_array((values, (rows, np.arange(self.size))), shape=(self.size, self.size)).tocsc()

        across_x, across_y = mirrored(node[:, ::-1], [1, -1, 1]), mirrored(node[::-1], [1, 1, -1])
        one = sparse.eye_array(self.size, format="csc")
        projector = sparse.csc_array((one + even_x * across_x) @ (one + even_y * across_y))
        first = node[: self.across // 2 + 1, : self.along // 2 + 1]
        chosen = sparse.csc_array(projector[:, (3 * first.ravel()[:, None] + np.arange(3)).ravel()])
        norms = np.sqrt(np.asarray(chosen.multiply(chosen).sum(axis=0))).ravel()
        kept = norms > 0
        return sparse.csc_array(chosen[:, kept] / norms[kept])


def low_rank(terms: list[tuple[Row, float]], size: int) -> sparse.csc_array:
    """Sum of ``factor row^T row``, shape (size, size)."""
    if not terms:
        return sparse.csc_array((size, size))
    rows = np.concatenate([np.repeat(columns, columns.size) for (columns, _), _ in terms])
    columns = np.concatenate([np.tile(columns, columns.size) for (columns, _), _ in terms])
    values = np.concatenate([factor * np.outer(row, row).ravel() for (_, row), factor in terms])
    return sparse.coo_array((values, (rows, columns)), shape=(size, size)).tocsc()


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

    Raises:
        InputError: a place outside the plate.
    """

    def __init__(
        self,
        plate: Plate,
        springs: Sequence[tuple[Place, float]] = (),  # places (x, y), m, with stiffnesses normal to the plate, N/m
        masses: Sequence[tuple[Place, float]] = (),  # places with masses, kg
        bodies: Sequence[StandingBody] = (),  # that stand on the plate
        elements: int = 20,  # number along the shorter side
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
    def _stiffness(self) -> sparse.csc_array:
        """Stiffness matrix of the plate on its springs, N/m."""
        return self.plate.rigidity * self._outline.stiffness + low_rank(self._spring_rows, self._outline.size)

    @cached_property
    def _mass(self) -> sparse.csc_array:
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
        fields = [self._deflections([(place, 1 / self.plate.rigidity)]) for place in _places(loads)]
        return self._at(loads if responses is None else responses, np.array(fields).T)

    def sag(self, gravity: float, places: ArrayLike) -> Array:
        """Deflection (n,) by the weight of plate and masses at places (n, 2), m, positive downwards, m."""
        unit = gravity / self.plate.rigidity
        loads = [(place, unit * mass) for place, mass in self._masses]
        return self._at(places, self._deflections(loads, unit * self._area_density))

    def _deflections(self, loads: list[tuple[Place, float]], weight: float = 0.0) -> Array:
        springs = [(place, k / self.plate.rigidity) for place, k in self._springs]
        return self._outline.deflections(springs, loads, weight)

    def modes(self, count: int, places: ArrayLike = ((0.0, 0.0),)) -> Modes:
        """The lowest natural modes, of a free plate with its three rigid-body modes; shapes at places (n, 2), m."""
        free, shapes = self._outline.free_modes
        kept = min(max(round(_KEPT_MODES * count), 60), free.size)
        # A spring or mass far beyond those of the plate's own modes leaves no digits for the others.
        extreme = _EXTREME * self.plate.length * self.plate.width
        stiff = any(k > extreme * free[kept - 1] * self.plate.rigidity for _, k in self._springs)
        if stiff or any(m > extreme * self._area_density for _, m in self._masses):
            frequency, vectors = self._eigenvectors(count)
            return Modes(frequency, self._at(places, vectors))
        frequency, parts = self._from_free_modes(count, kept, free, shapes)
        return Modes(frequency, self._at(places, shapes) @ parts)

    def modes_on_grid(self, count: int, loads: ArrayLike | None = None) -> Modes:
        """The lowest natural modes at the nodes of the elements: `shapes` of shape (nodes along y, along x, modes).

        With `loads` they are completed by residual modes: the static deflections under forces at those places, less
        their part in the natural modes, combined such that mass and stiffness are diagonal. The static deflection under
        such a force is then exact, which takes far more natural modes (Craig, AIAA Paper 85-0640). `count` natural
        modes have the rigid-body ones among them; `loads` are places of forces normal to the plate, m, (n, 2).
        """
        frequency, vectors = self._eigenvectors(count)
        if loads is not None:
            residual = self._residual(loads, vectors)
            frequency, vectors = np.append(frequency, residual[0]), np.hstack([vectors, residual[1]])
        return Modes(frequency, vectors[::3].reshape(self._outline.across + 1, self._outline.along + 1, -1))

    def _residual(self, loads: ArrayLike, natural: Array) -> tuple[Array, Array]:
        """Frequencies, Hz, and vectors of the residual modes of forces at places, beside the `natural` ones."""
        forces = np.zeros((self._outline.size, len(_places(loads))))
        for number, place in enumerate(_places(loads)):
            columns, values = self._outline.row(place)
            forces[columns, number] = values
        shapes = sparse_linalg.splu((self._stiffness - self._shift() * self._mass).tocsc()).solve(forces)
        for _ in range(2):
            shapes = shapes - natural @ (natural.T @ (self._mass @ shapes))
        masses, axes = np.linalg.eigh(shapes.T @ (self._mass @ shapes))
        kept = masses > _DEPENDENT * masses.max()
        shapes = shapes @ (axes[:, kept] / np.sqrt(masses[kept]))
        values, axes = linalg.eigh(shapes.T @ (self._stiffness @ shapes))
        return np.sqrt(values) / (2 * np.pi), shapes @ axes

    def _shift(self) -> float:
        """A shift of eigenvalues below zero: the stiffness of a free plate is singular."""
        plate = self.plate
        return -1e-2 * plate.rigidity / (self._area_density * (plate.length * plate.width) ** 2)

    def _eigenvectors(self, count: int) -> tuple[Array, Array]:
        """Frequencies, Hz, (count,), rising, and degrees of freedom (n, count) of the lowest modes, of unit mass."""
        first = np.ones(self._outline.size)
        values, vectors = sparse_linalg.eigsh(self._stiffness, count, self._mass, sigma=self._shift(), v0=first)
        order = np.argsort(values)
        return np.sqrt(np.maximum(values[order], 0.0)) / (2 * np.pi), vectors[:, order]

    def _from_free_modes(self, count: int, kept: int, free: Array, shapes: Array) -> tuple[Array, Array]:
        """As `_eigenvectors`, the vectors by their parts in the modes of the free plate of unit rigidity and density.

        The lowest of these, and residual vectors in the others: a mode of eigenvalue ``v`` is moved by springs and
        masses at points by ``sum_j phi_j (phi_j . f)/(v_j - v)``, whose part of high ``v_j`` is a power series in ``v``
        about the middle of the range, with one vector for each power.
        """
        springs = _projected(self._spring_rows, shapes)
        masses = _projected(self._mass_rows, shapes)
        orders = [np.vstack([springs, masses])[:, kept:].T / (free[kept:, None] - 0.5 * free[count])]
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
        values, vectors = linalg.eigh(stiffness, mass, subset_by_index=(0, count - 1))
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
