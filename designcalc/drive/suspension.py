"""The suspensions the thesis considers: porous air bearing, passive magnets, ball on spring."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import require

Array = NDArray[np.float64]

_MU_0 = 1.25663706127e-6


def dipole_hessian(moment_1: ArrayLike, moment_2: ArrayLike, separation: ArrayLike) -> Array:
    """Stiffness matrix of one rigid magnet near another: second derivatives of ``U = -m2 . B1(r)``, N/m.

    ``U = mu0/(4 pi) [m1.m2/r^3 - 3 (m1.r)(m2.r)/r^5]``. Its trace is zero wherever there is no other magnet (Earnshaw):
    a stable direction implies an unstable one. Magnets of any shape are sums of such dipoles.

    Args:
        moment_1, moment_2: magnetic moments, A m^2, shape (3,), fixed in direction.
        separation: from 1 to 2, m, shape (3,), not zero.

    Returns:
        (3, 3) matrix d2U/dr_i dr_j; positive eigenvalues are stable directions.
    """
    a, b, r = (np.asarray(v, float) for v in (moment_1, moment_2, separation))
    d = float(np.linalg.norm(r))
    require(d != 0, "suspension: the magnets are in one place")
    n, unit = r / d, np.eye(3)
    ab, an, bn = a @ b, a @ n, b @ n
    nn = np.outer(n, n)
    sym_ab = np.outer(a, b) + np.outer(b, a)
    sym_an = np.outer(a, n) + np.outer(n, a)
    sym_bn = np.outer(b, n) + np.outer(n, b)
    hessian = -3 * ab * (unit - 5 * nn) - 3 * sym_ab + 15 * (an * sym_bn + bn * sym_an) + 15 * an * bn * (unit - 7 * nn)
    return _MU_0 / (4 * np.pi) * hessian / d**5


def rank_sum(columns: ArrayLike) -> Array:
    """Sum of places over several criteria, the smallest the best.

    Args:
        columns: score of each candidate, shape (candidates, criteria), small is good; equals share their mean place.

    Returns:
        shape (candidates,).
    """
    # As scipy.stats.rankdata, whose loading takes a quarter of the time of all checks.
    scores = np.asarray(columns, float)
    below = (scores[:, None] > scores).sum(axis=1)
    equal = (scores[:, None] == scores).sum(axis=1)
    return (below + 0.5 * (equal + 1)).sum(axis=1)


@dataclass(frozen=True)
class Suspension:
    """A suspension with the numbers of its rank. SI; smaller is better except for the stiffness."""

    name: str
    stiffness: float  # normal stiffness of the whole suspension, N/m
    smoothness: float  # error normal to the motion, m
    friction: float  # break-away force, N; it limits the resolution
    repeatability: float  # normal to the motion, m
    cost: int  # place by cost
    stable: bool
    fits_drive: bool  # is compatible with a friction drive and its magnets in the available space
    why: str
    places: float = 0.0  # sum of places over the criteria
