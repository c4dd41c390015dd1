"""Field of a magnet between two toothed irons over a toothed bar, in the cross-section across the travel.

The irons and the bar are infinitely permeable, hence equipotential; everything else has the permeability of air, the
magnet that of its recoil line. Laplace's equation is solved by bilinear finite elements on a rectangular grid, refined
at the gap; leakage between the irons, from their flanks and over the magnet is part of the solution, the ends along the
travel are not.

Moving the irons by the gap or across the travel deforms only the strip of the gap. In the coordinates of the fixed grid
that is an anisotropic permeability of this strip, so that the permeances are differentiated exactly (virtual work).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from designcalc.drive.magnetic_teeth import MU_0
from stagecad.parameters.errors import require

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Array = NDArray[np.float64]

_ELEMENTS, _LEAST, _MOST = 20, 10, 60
"""Elements to a pitch; and the least and most to a length between two corners."""
_GROWTH = 1.3
"""Ratio of neighbouring elements away from the gap."""


@dataclass(frozen=True)
class MagnetSection:
    """Cross-section of one magnetic circuit, m: a magnet between two irons, and the bar below them."""

    pitch: float  # of the teeth
    tooth_width: float  # of the teeth
    gap: float  # of the teeth
    groove_depth: float  # of the teeth
    teeth: int  # on each iron
    iron_height: float  # from the top of iron and magnet to the tooth crests
    magnet_thickness: float  # along its magnetisation, between the irons
    magnet_height: float  # down from the top of the irons, at most `iron_height`
    channel_depth: float  # of the bar's channel below the magnet, from the crests

    @property
    def iron_width(self) -> float:
        """Width of one iron, the number of its teeth times their pitch, m."""
        return self.teeth * self.pitch


@dataclass(frozen=True)
class MagnetForces:
    """Working point of one magnetic circuit, SI units."""

    potential: float  # difference of the magnetic potential between an iron and the bar, A
    gap_flux_density: float  # flux from one iron into the bar over the iron's area, T
    tooth_flux_density: float  # this flux gathered in the teeth, T
    leakage: float  # share of the magnet's flux that does not reach the bar
    attraction: float  # N
    lateral_stiffness: float  # N/m, restoring
    # N/m, of the attraction that falls as the gap opens; works as a negative stiffness on the pads
    normal_stiffness: float


def magnet_forces(
    section: MagnetSection, length: float, remanence: float, recoil_permeability: float, refinement: float = 1.0
) -> MagnetForces:
    """Forces of one magnet with its irons and bar.

    A magnet of uniform remanence drives the flux ``Phi = Br h L`` into the permeances P between irons and bar, its own
    among them. At this flux the field's energy is ``E = Phi^T P^-1 Phi/2 = u^T P u/2``. The attraction is ``dE/de =
    -u^T P' u/2``, and a stiffness is the second derivative ``-u^T P'' u/2 + (P' u)^T P^-1 (P' u)``.

    Args:
        section: geometry across the travel.
        length: L of magnet and irons along the travel, m.
        remanence: Br, T.
        recoil_permeability: relative, of the magnet.
        refinement: of the grid; 1 is within 1 % of the limit of fine grids.

    Raises:
        InputError: an argument not above zero, a tooth as wide as the pitch, a magnet higher than the irons.

    Source: virtual work on finite elements: Coulomb, IEEE Trans. Magn. 19 (1983) 2514.
    """
    for name, value in (("length", length), ("remanence", remanence), ("recoil permeability", recoil_permeability)):
        require(value > 0, f"teeth: magnet {name} must be above 0")
    network = _permeances(section, recoil_permeability, refinement)
    # Row and column 0 belong to the bar, whose potential is zero.
    P = network.permeance[1:, 1:]
    flux = remanence * section.magnet_height * np.array([1.0, -1.0])
    u = np.linalg.solve(P, flux)

    def second_derivative(first: Array, second: Array) -> float:
        slope = first[1:, 1:] @ u
        return float(-0.5 * u @ second[1:, 1:] @ u + slope @ np.linalg.solve(P, slope))

    into_bar = -float(network.permeance[0, 1:] @ (u * [1.0, 0.0]))
    density = into_bar / section.iron_width
    return MagnetForces(
        potential=float(u[0]),
        gap_flux_density=density,
        tooth_flux_density=density * section.pitch / section.tooth_width,
        leakage=1.0 - into_bar / float(flux[0]),
        attraction=-0.5 * float(u @ network.by_gap[0][1:, 1:] @ u) * length,
        lateral_stiffness=second_derivative(*network.by_shift) * length,
        normal_stiffness=-second_derivative(*network.by_gap) * length,
    )


@dataclass(frozen=True)
class _Network:
    """Permeances per length of bar (0) and irons (1, 2), H/m, shape (3, 3): flux out of each body per potential."""

    permeance: Array
    by_gap: tuple[Array, Array]  # first and second derivative with respect to the gap
    by_shift: tuple[Array, Array]  # the same for a motion of the irons across the travel


@lru_cache(maxsize=64)
def _permeances(section: MagnetSection, recoil_permeability: float, refinement: float) -> _Network:
    from scipy.sparse.linalg import splu

    y, z = _grid(section, refinement)
    body, magnet = _bodies(section, y, z)
    strip = np.broadcast_to((_middles(z) > 0) & (_middles(z) < section.gap), magnet.shape)
    permeability = np.asarray(MU_0 * np.where(magnet, recoil_permeability, 1.0), float)
    assemble = _Assembly(y, z)
    A = assemble(permeability, permeability, 0.0)
    in_gap, e = np.asarray(MU_0 * strip, float), section.gap
    # Stretched by 1 + s, the strip has permeabilities 1 + s across and 1/(1 + s) along the gap; sheared by s it has
    # [[1 + s^2, -s], [-s, 1]].
    changes = {
        "gap": (assemble(in_gap / e, -in_gap / e, 0.0), assemble(0.0, 2 * in_gap / e**2, 0.0)),
        "shift": (assemble(0.0, 0.0, -in_gap / e), assemble(2 * in_gap / e**2, 0.0, 0.0)),
    }
    free = body.ravel() < 0
    units = np.stack([(body.ravel() == k).astype(float) for k in range(3)], axis=1)
    factors = splu(A[free][:, free].tocsc())
    units[free] = factors.solve(-(A[free] @ units))

    def derivatives(first: csr_array, second: csr_array) -> tuple[Array, Array]:
        driven = (first @ units)[free]
        return units.T @ (first @ units), units.T @ (second @ units) - 2 * driven.T @ factors.solve(driven)

    return _Network(units.T @ (A @ units), derivatives(*changes["gap"]), derivatives(*changes["shift"]))


class _Assembly:
    """Stiffness matrices of bilinear elements on a grid of rectangles, for permeabilities of each element."""

    def __init__(self, y: Array, z: Array) -> None:
        count = np.arange(y.size * z.size).reshape(z.size, y.size)
        self.corners = np.stack([count[:-1, :-1], count[:-1, 1:], count[1:, 1:], count[1:, :-1]], axis=-1)
        self.aspect = np.diff(z)[:, None] / np.diff(y)[None, :]
        self.size = count.size

    def __call__(self, across: Array | float, along: Array | float, mixed: Array | float) -> csr_array:
        """Sum over elements of the integral of ``across v_y w_y + along v_z w_z + mixed (v_y w_z + v_z w_y)``."""
        from scipy.sparse import coo_array

        shape = self.aspect.shape
        blocks = (
            np.broadcast_to(across * self.aspect, shape)[..., None, None] * _ACROSS
            + np.broadcast_to(along / self.aspect, shape)[..., None, None] * _ALONG
            + np.broadcast_to(mixed, shape)[..., None, None] * _MIXED
        )
        rows = np.broadcast_to(self.corners[..., :, None], blocks.shape)
        columns = np.broadcast_to(self.corners[..., None, :], blocks.shape)
        entries = (blocks.ravel(), (rows.ravel(), columns.ravel()))
        return coo_array(entries, shape=(self.size, self.size)).tocsr()


_ACROSS = np.array([[2, -2, -1, 1], [-2, 2, 1, -1], [-1, 1, 2, -2], [1, -1, -2, 2]]) / 6
_ALONG = np.array([[2, 1, -1, -2], [1, 2, -2, -1], [-1, -2, 2, 1], [-2, -1, 1, 2]]) / 6
_MIXED = np.array([[1, 0, -1, 0], [0, -1, 0, 1], [-1, 0, 1, 0], [0, 1, 0, -1]]) / 2


def _grid(s: MagnetSection, refinement: float) -> tuple[Array, Array]:
    """Grid lines across the travel (y, from the middle of the magnet) and upwards (z, from the bar's crests), m."""
    first = s.magnet_thickness / 2
    edges = [first, first + s.iron_width]
    for k in range(s.teeth):
        middle = first + (k + 0.5) * s.pitch
        edges += [middle - s.tooth_width / 2, middle + s.tooth_width / 2]
    top = s.gap + s.iron_height
    levels = [-s.channel_depth, -s.groove_depth, 0.0, s.gap, s.gap + s.groove_depth, top - s.magnet_height, top]
    step, margin = s.pitch / _ELEMENTS, s.iron_width + s.magnet_thickness
    return (
        _lines([*(-e for e in edges), *edges], step, margin, refinement),
        _lines(levels, step, margin, refinement),
    )


def _lines(breaks: list[float], step: float, margin: float, refinement: float) -> Array:
    """Lines through all breaks and over a margin on both sides.

    Between breaks they are `step` apart on the mean and denser near the breaks, where corners make the field singular;
    in the margins they are ever farther apart.
    """
    # Lengths that are equal but for rounding are one line.
    breaks = sorted({round(b / step, 6) * step for b in breaks})
    inner = []
    for low, high in pairwise(breaks):
        count = round(refinement * min(max((high - low) / step, _LEAST), _MOST))
        inner.append(low + (high - low) * 0.5 * (1 - np.cos(np.pi * np.arange(count) / count)))
    count = math.ceil(refinement * math.log1p(margin * (_GROWTH - 1) / step) / math.log(_GROWTH))
    ratio = _GROWTH ** (1 / refinement)
    growing = margin * (ratio ** np.arange(1, count + 1) - 1) / (ratio**count - 1)
    return np.concatenate([breaks[0] - growing[::-1], *inner, [breaks[-1]], breaks[-1] + growing])


def _middles(lines: Array) -> Array:
    return 0.5 * (lines[1:] + lines[:-1])[:, None]


def _bodies(s: MagnetSection, y: Array, z: Array) -> tuple[NDArray[np.int_], NDArray[np.bool_]]:
    """Body of each node (0 bar, 1 and 2 irons, -1 none), shape (z, y), and whether an element is magnet."""
    side, up = np.abs(_middles(y).T) - s.magnet_thickness / 2, _middles(z)
    in_tooth = np.abs((side % s.pitch) - s.pitch / 2) < s.tooth_width / 2
    below_iron = (side > 0) & (side < s.iron_width)
    top = s.gap + s.iron_height
    iron = below_iron & (up > s.gap) & (up < top) & (in_tooth | (up > s.gap + s.groove_depth))
    channel = (side < 0) & (up > -s.channel_depth)
    bar = (side < s.iron_width) & (up < 0) & ~channel & (in_tooth & below_iron | (up < -s.groove_depth))
    magnet = (side < 0) & (up > top - s.magnet_height) & (up < top)
    body = np.full((z.size, y.size), -1)
    right = _middles(y).T > 0
    for number, elements in ((0, bar), (1, iron & right), (2, iron & ~right)):
        for rows in (slice(None, -1), slice(1, None)):
            for columns in (slice(None, -1), slice(1, None)):
                body[rows, columns][elements] = number
    return body, magnet
