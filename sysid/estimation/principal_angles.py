"""How far apart two effects point: principal angles between what they add to a model that neither is part of yet.

    A, B: sensitivities of the residual to each effect's own values, the base model's taken out of both
    cos(angle_k) = k-th singular value of Q_A^T Q_B,   Q orthonormal

(Bjorck and Golub, Math. Comp. 27 (1973) 579). Where the angle between what one effect takes and what another could make
is small, the other could stand in its place, to first order.
"""

from __future__ import annotations

import numpy as np

from sysid.estimation.base_fit import Fitted
from sysid.estimation.score_test import orthonormal

LEAST_OWN = 1e-4
"""Part of a sensitivity that the base model does not make itself, below which it is no direction of its own."""


def principal_angles(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Angles (min(p, q),), rad, rising, between the spans of orthonormal bases (n, p) and (n, q)."""
    cosines = np.linalg.svd(one.T @ other, compute_uv=False)
    # An arc cosine loses half its digits near one: small angles come from their sines.
    small, large = (one, other) if one.shape[1] <= other.shape[1] else (other, one)
    sines = np.linalg.svd(small - large @ (large.T @ small), compute_uv=False)[::-1]
    angles = np.arccos(np.clip(cosines, -1.0, 1.0))
    return np.where(angles < 0.1, np.arcsin(np.clip(sines[: angles.size], 0.0, 1.0)), angles)


def own_directions(fitted: Fitted, base: Fitted) -> np.ndarray:
    """Orthonormal basis (n, p) of what a grown model's new values do that no value of the base model does.

    Both fits score the same samples with the same deviations.
    """
    new = np.array([key not in base.fit.keys for key in fitted.fit.keys], dtype=bool)
    columns = fitted.fit.jacobian[:, new]
    norms = np.linalg.norm(columns, axis=0)
    alive = norms > 0.0
    columns = columns[:, alive] / norms[alive]
    basis = orthonormal(base.fit.jacobian)
    free = columns - basis @ (basis.T @ columns)
    return orthonormal(free[:, np.linalg.norm(free, axis=0) > LEAST_OWN])


def stand_in_angle(effect: Fitted, other: Fitted, base: Fitted) -> float | None:
    """Angle, rad, between what an effect takes from the residual and what another could make; none where it is nothing.

    Of two effects with unlike numbers of values the one may be able to do all that the other does, and not the other
    way round: this asks whether `other` could stand in for `effect`. What `other` takes itself is among what it could
    make: far from zero a lag does more than its slope there tells.
    """
    basis = orthonormal(base.fit.jacobian)

    def taken(grown: Fitted) -> np.ndarray | None:
        whole = base.fit.residual - grown.fit.residual
        free = whole - basis @ (basis.T @ whole)
        size = float(np.linalg.norm(free))
        return None if size <= LEAST_OWN * float(np.linalg.norm(whole)) else free / size

    wanted, made = taken(effect), taken(other)
    could = own_directions(other, base)
    if made is not None:
        could = orthonormal(np.column_stack([could, made]))
    if wanted is None or could.shape[1] == 0:
        return None
    return float(principal_angles(wanted[:, None], could)[0])
