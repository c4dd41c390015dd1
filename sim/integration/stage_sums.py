"""What a stage of Rodas5P takes from those before it, and the coefficients of its dense output; compiled."""

from __future__ import annotations

from typing import Any

from sim.integration import rodas5p
from sim.integration.rodas5p import STAGES, A, C, H
from sim.numerics.compilation import INLINED, compile_function


def _stage_sums(i, size, y, K, over_h, stage, earlier):
    """Point and earlier slopes of stage `i` > 0: y + sum_j A_ij k_j, and sum_j C_ij k_j / h.

    Written out, so that the newest k is added last, and nothing is added that is zero: `size * j` is where k_j begins.
    The last three stages stand each on the one before.
    """
    if i == 1:
        for j in range(size):
            k0 = K[j]
            stage[j] = y[j] + (A[1, 0] * k0)
            earlier[j] = (C[1, 0] * k0) * over_h
    elif i == 2:
        for j in range(size):
            k0, k1 = K[j], K[size + j]
            stage[j] = y[j] + (A[2, 0] * k0 + A[2, 1] * k1)
            earlier[j] = (C[2, 0] * k0 + C[2, 1] * k1) * over_h
    elif i == 3:
        for j in range(size):
            k0, k1, k2 = K[j], K[size + j], K[2 * size + j]
            stage[j] = y[j] + (A[3, 0] * k0 + A[3, 1] * k1 + A[3, 2] * k2)
            earlier[j] = (C[3, 0] * k0 + C[3, 1] * k1 + C[3, 2] * k2) * over_h
    elif i == 4:
        for j in range(size):
            k0, k1, k2, k3 = K[j], K[size + j], K[2 * size + j], K[3 * size + j]
            stage[j] = y[j] + (A[4, 0] * k0 + A[4, 1] * k1 + A[4, 2] * k2 + A[4, 3] * k3)
            earlier[j] = (C[4, 0] * k0 + C[4, 1] * k1 + C[4, 2] * k2 + C[4, 3] * k3) * over_h
    elif i == 5:
        for j in range(size):
            k0, k1, k2, k3, k4 = K[j], K[size + j], K[2 * size + j], K[3 * size + j], K[4 * size + j]
            stage[j] = y[j] + (A[5, 0] * k0 + A[5, 1] * k1 + A[5, 2] * k2 + A[5, 3] * k3 + A[5, 4] * k4)
            earlier[j] = (C[5, 0] * k0 + C[5, 1] * k1 + C[5, 2] * k2 + C[5, 3] * k3 + C[5, 4] * k4) * over_h
    elif i == 6:
        for j in range(size):
            k0, k1, k2, k3, k4, k5 = (
                K[j],
                K[size + j],
                K[2 * size + j],
                K[3 * size + j],
                K[4 * size + j],
                K[5 * size + j],
            )
            stage[j] += k5
            earlier[j] = (
                C[6, 0] * k0 + C[6, 1] * k1 + C[6, 2] * k2 + C[6, 3] * k3 + C[6, 4] * k4 + C[6, 5] * k5
            ) * over_h
    else:
        for j in range(size):
            k0, k1, k2, k3, k4, k5, k6 = (
                K[j],
                K[size + j],
                K[2 * size + j],
                K[3 * size + j],
                K[4 * size + j],
                K[5 * size + j],
                K[6 * size + j],
            )
            stage[j] += k6
            earlier[j] = (
                C[7, 0] * k0 + C[7, 1] * k1 + C[7, 2] * k2 + C[7, 3] * k3 + C[7, 4] * k4 + C[7, 5] * k5 + C[7, 6] * k6
            ) * over_h


def _bends(K, size, j, bend):
    """The coefficients D of the dense output of state `j`."""
    for i in range(3):
        total = 0.0
        for m in range(STAGES):
            total += H[i, m] * K[m * size + j]
        bend[j, i] = total


_SOURCES = [str(rodas5p.__file__)]
stage_sums: Any = compile_function(_stage_sums, _SOURCES, **INLINED)
bends: Any = compile_function(_bends, _SOURCES, **INLINED)
