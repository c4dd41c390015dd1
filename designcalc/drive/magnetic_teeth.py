"""Field, attraction and stiffness of two toothed irons facing each other.

Pitch p, tooth width l, gap e, groove depth d; infinitely permeable irons at a fixed difference of magnetic potential.
Laplace's equation in one periodic cell is solved by mode matching: the potential along each groove's mouth is the
unknown, expanded in Gegenbauer functions that carry the r^(2/3) edge condition of a right-angled iron corner; gap and
grooves contribute their exact Dirichlet-to-Neumann maps (Fourier and sine modes). The discrete co-energy is a
quadratic form whose dependence on gap and lateral offset is analytic: no numerical differentiation of the field.
The value is an upper bound of the true co-energy (Dirichlet's principle) and falls to it as functions are added.

Field of a magnet between two toothed irons over a toothed bar, in the cross-section across the travel.

The irons and the bar are infinitely permeable, hence equipotential; everything else has the permeability of air, the
magnet that of its recoil line. Laplace's equation is solved by bilinear finite elements on a rectangular grid, refined
at the gap; leakage between the irons, from their flanks and over the magnet is part of the solution, the ends along the
travel are not.

Moving the irons by the gap or across the travel deforms only the strip of the gap. In the coordinates of the fixed grid
that is an anisotropic permeability of this strip, so that the permeances are differentiated exactly (virtual work).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import gamma, jv, zeta

from stagecad.deferred import sparse, sparse_linalg
from stagecad.parameters.errors import require

Array = NDArray[np.float64]

MU_0 = 1.25663706127e-6
"""Magnetic constant, N/A^2 (CODATA 2022)."""

_EDGE = 7 / 6  # Gegenbauer index whose weight (1 - x^2)^(index - 1/2) is the r^(2/3) of a 90-degree iron corner
_MODES = 4096
_FUNCTIONS, _FUNCTIONS_NARROW = 14, 24


Number = Any
"""A float where numbers went in, an array where arrays did."""


@dataclass(frozen=True)
class TeethField:
    """Co-energy of the toothed gap and its derivatives, per unit of iron area and of squared magnetic potential.

    Forces follow at fixed potential from F = +dW. Multiply by potential squared (A^2) and area (m^2).
    """

    coenergy: Number  # W, J/(m^2 A^2)
    lateral_force: Number  # dW/dx, N/(m^2 A^2): 0 at alignment
    attraction: Number  # -dW/de, pulling the irons together, N/(m^2 A^2)
    lateral_stiffness: Number  # K_x = -d2W/dx2, N/(m m^2 A^2): restoring at alignment
    # K_z = d2W/de2, N/(m m^2 A^2). The force falls as the gap opens: it works against the pads as a stiffness -K_z
    normal_stiffness: Number
    error: Number  # relative change of the worst of these when a quarter of the functions is taken away

    @property
    def lateral_over_normal(self) -> Number:
        """K_x / K_z."""
        return self.lateral_stiffness / self.normal_stiffness


def teeth_field(
    pitch: float | Array,
    tooth_width: float | Array,
    gap: float | Array,
    groove_depth: float | Array | None = None,
    offset: float | Array = 0.0,
    functions: int | None = None,
) -> TeethField:
    """Solve the field of one cell of two equally toothed irons; arrays broadcast, one solution an element.

    Args:
        pitch: p, m, > 0.
        tooth_width: l, m, 0 < l < p (valid range of the expansion: l/p 0.02 to 0.98).
        gap: e between tooth faces, m, e/p 0.01 to 10.
        groove_depth: d, m; half the pitch when left out; d/p 0.01 or more.
        offset: lateral shift x of one iron, m.
        functions: even and odd functions along each mouth; when left out 14, and 24 for gaps below a twentieth of the
            pitch, whose field bunches at the corners. `error` estimates the rest: 1e-7 at e/p = 0.2.

    Returns:
        `TeethField`: numbers for numbers, arrays of the common shape for arrays.

    Raises:
        InputError: outside the range.

    Source: mode matching with edge condition, Collin, Field Theory of Guided Waves (1991), chapter 8; K_x and K_z as
        the thesis's section on magnetic preload (study 36 of its references).
    """
    depth = 0.5 * np.asarray(pitch) if groove_depth is None else groove_depth
    cells = np.broadcast_arrays(*(np.asarray(v, float) for v in (pitch, tooth_width, gap, depth, offset)))
    shape = cells[0].shape
    rows = zip(*(c.ravel().tolist() for c in cells), strict=True)
    solved = [_one_cell(p, width, e, d, x, functions) for p, width, e, d, x in rows]
    if not shape:
        return solved[0]
    names = [field.name for field in fields(TeethField)]
    return TeethField(**{name: np.array([getattr(one, name) for one in solved]).reshape(shape) for name in names})


@lru_cache(maxsize=4096)
def _one_cell(
    pitch: float, tooth_width: float, gap: float, depth: float, offset: float, functions: int | None
) -> TeethField:
    """The field of one cell."""
    for name, value in (("pitch", pitch), ("tooth-width", tooth_width), ("gap", gap), ("groove-depth", depth)):
        require(value > 0 and np.isfinite(value), f"teeth: {name}: {value:g} m must be above 0")
    _within("tooth-width", "tooth width over pitch", tooth_width / pitch, 0.02, 0.98)
    _within("gap", "gap over pitch", gap / pitch, 0.01, 10)
    _within("groove-depth", "groove depth over pitch", depth / pitch, 0.01, np.inf)
    functions = functions or (_FUNCTIONS if gap / pitch >= 0.05 else _FUNCTIONS_NARROW)
    fine = _solve(pitch, tooth_width, gap, depth, offset, functions)
    coarse = _solve(pitch, tooth_width, gap, depth, offset, max(2, functions - functions // 4))
    scale = np.abs(fine)
    # The lateral force vanishes at alignment: measure its error against the co-energy over a pitch.
    scale[1] = max(scale[1], fine[0] / pitch)
    scale[3] = max(scale[3], 1e-3 * scale[4])
    error = float(np.max(np.abs(fine - coarse) / scale))
    return TeethField(*(float(v) for v in fine), error=error)


def ratio_map(width_ratios: Array, gap_ratios: Array, depth_ratio: float = 0.5) -> tuple[Array, Array, Array]:
    """K_x/K_z over tooth width and gap, both over the pitch.

    Args:
        width_ratios: l/p, shape (m,).
        gap_ratios: e/p, shape (n,).
        depth_ratio: groove depth over pitch.

    Returns:
        K_x/K_z, and K_x and K_z (per area and squared potential, for a pitch of 1 m), each of shape (n, m).
    """
    rows = [[_solve(1.0, width, gap, depth_ratio, 0.0, 10)[3:] for width in width_ratios] for gap in gap_ratios]
    lateral, normal = np.moveaxis(np.array(rows), -1, 0)
    return lateral / normal, lateral, normal


def _within(key: str, name: str, value: float, low: float, high: float) -> None:
    require(low <= value <= high, f"teeth: {key}: {name} {value:g} is outside the solution's range {low:g} to {high:g}")


@lru_cache(maxsize=256)
def _spectrum(half_width: float, functions: int) -> tuple[Array, Array, Array]:
    """Mouth functions in Fourier modes of a unit pitch: k (n,), and R of even and odd functions (functions, n)."""
    k = 2 * np.pi * np.arange(1.0, _MODES + 1)
    omega = k * half_width
    table = _bessel_table(2 * functions, omega) / omega**_EDGE
    return k, table[0::2], table[1::2]


def _bessel_table(count: int, x: Array) -> Array:
    """``J_(n + edge)(x)`` for n = 0 .. count - 1, shape (count, x.size); `x` rises.

    ``J_(v+1) = 2 v/x J_v - J_(v-1)`` is stable upwards as long as the order is below x; smaller arguments take the
    function of every order.

    Source: DLMF 10.6.1 and section 3.6.
    """
    table = np.empty((count, x.size))
    few = int(np.searchsorted(x, count + _EDGE))
    table[:, :few] = jv(np.arange(count)[:, None] + _EDGE, x[None, :few])
    large = x[few:]
    for n in range(count):
        if n < 2:
            table[n, few:] = jv(n + _EDGE, large)
        else:
            table[n, few:] = 2 * (n - 1 + _EDGE) / large * table[n - 1, few:] - table[n - 2, few:]
    return table


@lru_cache(maxsize=16)
def _slot_spectrum(functions: int) -> tuple[Array, Array]:
    """The same in the sine modes of a groove; its arguments m pi/2 do not depend on the groove."""
    m = np.arange(1, 2 * _MODES + 1)
    omega = m * np.pi / 2
    table = _bessel_table(2 * functions, omega) / omega**_EDGE
    return table[0::2][:, 0::2], table[1::2][:, 1::2]


def _gram(table: Array, weight: Array) -> Array:
    return (table * weight) @ table.T


def _diagonal(even: Array, odd: Array) -> Array:
    """Blocks of the even and the odd functions on the diagonal."""
    zero = np.zeros_like(even)
    return np.block([[even, zero], [zero, odd]])


def _self_terms(s: float, gap: float, depth: float, k: Array, even: Array, odd: Array) -> Array:
    """Energy of the functions of one mouth with each other, in its gap and its slot; lengths over the pitch."""
    h, functions = s / 2, len(even)
    coth = 1 / np.tanh(np.minimum(k * gap, 200.0))

    # Every dot product over modes of the form sum k R R' has terms falling as k^(-7/3); the rest of it beyond the last
    # mode is taken from the mean of J_mu J_nu ~ cos((mu-nu) pi/2)/(pi z). The even (and odd) functions carry the signs
    # (-1)^q already, so the mean has sign (-1)^(q-q').
    q = np.arange(functions)
    signs = (-1.0) ** (q[:, None] - q[None, :])
    gap_tail = signs * 2 * np.pi / (np.pi * (2 * np.pi * h) ** (1 + 2 * _EDGE)) * zeta(2 * _EDGE, _MODES + 1)

    slot_even, slot_odd = _slot_spectrum(functions)
    kappa = np.pi / s * np.arange(1, 2 * _MODES + 1)
    slot_coth = kappa / np.tanh(np.minimum(kappa * depth, 200.0))
    # modes m = 2j-1 or 2j beyond the last: z = m pi/2, sum of (pi/s) m /(pi z) z^(-2 edge), step 2 in m
    slot_tail = [
        signs * (np.pi / s) / np.pi * (np.pi / 2) ** (-1 - 2 * _EDGE) * 2 ** (-2 * _EDGE) * zeta(2 * _EDGE, start)
        for start in (_MODES + 0.5, _MODES + 1.0)
    ]

    def self_block(table: Array, slot: Array, slot_weight: Array, tail: Array) -> Array:
        in_gap = 2 * h**2 * (_gram(table, k * coth) + gap_tail)
        in_slot = (s / 2) * (_gram(slot, slot_weight) + tail)
        return in_gap + in_slot

    # Sign conventions: even functions have real transforms, odd ones -i times real ones.
    return _diagonal(
        self_block(even, slot_even, slot_coth[0::2], slot_tail[0]),
        self_block(odd, slot_odd, slot_coth[1::2], slot_tail[1]),
    )


def _solve(p: float, l: float, e: float, d: float, x: float, functions: int) -> Array:  # noqa: E741
    """W, dW/dx, -dW/de, -d2W/dx2, d2W/de2 per area and squared potential, in SI; lengths in m."""
    s, gap, depth, shift = 1 - l / p, e / p, d / p, x / p
    h = s / 2
    k, even, odd = _spectrum(h, functions)
    own = _self_terms(s, gap, depth, k, even, odd)
    # All that follows falls as exp(-k e): the modes beyond k e = 60 add nothing.
    near = max(1, int(np.searchsorted(k, 60 / gap)))
    k, even, odd = k[:near], even[:, :near], odd[:, :near]
    sinh, cosh = np.sinh(np.minimum(k * gap, 200.0)), np.cosh(np.minimum(k * gap, 200.0))
    own_e = 2 * h**2 * _diagonal(_gram(even, -(k**2) / sinh**2), _gram(odd, -(k**2) / sinh**2))
    own_ee = 2 * h**2 * _diagonal(_gram(even, 2 * k**3 * cosh / sinh**3), _gram(odd, 2 * k**3 * cosh / sinh**3))

    def coupling(weight: Array, order: int) -> Array:
        """Order-th derivative with respect to the shift of the block between lower and upper mouth."""
        phase = k * shift + order * np.pi / 2
        c, sn = weight * k**order * np.cos(phase), weight * k**order * np.sin(phase)
        return (
            2 * h**2 * np.block([[(even * c) @ even.T, -(even * sn) @ odd.T], [(odd * sn) @ even.T, (odd * c) @ odd.T]])
        )

    def matrix(own_part: Array, cross: Array) -> Array:
        return np.block([[own_part, cross], [cross.T, own_part]])

    mean = np.zeros(4 * functions)
    mean[[0, 2 * functions]] = h / (2**_EDGE * gamma(_EDGE + 1))
    uniform = np.outer(mean, mean)
    weight = k / sinh
    nothing = np.zeros_like(own)
    M = matrix(own, coupling(weight, 0)) + uniform / gap
    M_x, M_xx = matrix(nothing, coupling(weight, 1)), matrix(nothing, coupling(weight, 2))
    M_e = matrix(own_e, coupling(-(k**2) * cosh / sinh**2, 0)) - uniform / gap**2
    M_ee = matrix(own_ee, coupling(k**3 * (1 + cosh**2) / sinh**3, 0)) + 2 * uniform / gap**3

    scale = 1 / np.sqrt(np.diag(M))
    inverse = np.linalg.inv(M * np.outer(scale, scale)) * np.outer(scale, scale)
    v = inverse @ (mean / gap)
    energy = 0.5 / gap - 0.5 * mean @ v / gap
    energy_x = 0.5 * v @ M_x @ v
    g_x = M_x @ v
    energy_xx = 0.5 * v @ M_xx @ v - g_x @ inverse @ g_x
    energy_e = 0.5 * v @ M_e @ v + mean @ v / gap**2 - 0.5 / gap**2
    g_e = M_e @ v + mean / gap**2
    energy_ee = 0.5 * v @ M_ee @ v - 2 * mean @ v / gap**3 + 1 / gap**3 - g_e @ inverse @ g_e
    return MU_0 * np.array([energy / p, energy_x / p**2, -energy_e / p**2, -energy_xx / p**3, energy_ee / p**3])


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
    factors = sparse_linalg.splu(A[free][:, free].tocsc())
    units[free] = factors.solve(-(A[free] @ units))

    def derivatives(first: sparse.csr_array, second: sparse.csr_array) -> tuple[Array, Array]:
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

    def __call__(self, across: Array | float, along: Array | float, mixed: Array | float) -> sparse.csr_array:
        """Sum over elements of the integral of ``across v_y w_y + along v_z w_z + mixed (v_y w_z + v_z w_y)``."""
        shape = self.aspect.shape
        blocks = (
            np.broadcast_to(across * self.aspect, shape)[..., None, None] * _ACROSS
            + np.broadcast_to(along / self.aspect, shape)[..., None, None] * _ALONG
            + np.broadcast_to(mixed, shape)[..., None, None] * _MIXED
        )
        rows = np.broadcast_to(self.corners[..., :, None], blocks.shape)
        columns = np.broadcast_to(self.corners[..., None, :], blocks.shape)
        entries = (blocks.ravel(), (rows.ravel(), columns.ravel()))
        return sparse.coo_array(entries, shape=(self.size, self.size)).tocsr()


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
    return (_lines([*(-e for e in edges), *edges], step, margin, refinement), _lines(levels, step, margin, refinement))


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
