"""Field, attraction and stiffness of two toothed irons facing each other.

Pitch p, tooth width l, gap e, groove depth d; infinitely permeable irons at a fixed difference of magnetic potential.
Laplace's equation in one periodic cell is solved by mode matching: the potential along each groove's mouth is the
unknown, expanded in Gegenbauer functions that carry the r^(2/3) edge condition of a right-angled iron corner; gap and
grooves contribute their exact Dirichlet-to-Neumann maps (Fourier and sine modes). The discrete co-energy is a
quadratic form whose dependence on gap and lateral offset is analytic: no numerical differentiation of the field.
The value is an upper bound of the true co-energy (Dirichlet's principle) and falls to it as functions are added.
"""

from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import gamma, jv, zeta

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
    shape = (len(gap_ratios), len(width_ratios))
    lateral, normal = np.empty(shape), np.empty(shape)
    for column, width in enumerate(width_ratios):
        for row, gap in enumerate(gap_ratios):
            _, _, _, lateral[row, column], normal[row, column] = _solve(1.0, width, gap, depth_ratio, 0.0, 10)
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
