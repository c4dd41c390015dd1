"""Masks of samples and gaps: runs, runs of a least length, dilation, and linear interpolation across gaps."""

import numpy as np


def runs(mask: np.ndarray) -> list[tuple[int, int]]:
    """Half-open index ranges in which `mask` (n,) is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def longer_than(mask: np.ndarray, length: float) -> np.ndarray:
    """`mask` (n,) without its runs of at most `length` samples."""
    out = np.zeros_like(mask)
    for start, stop in runs(mask):
        if stop - start > length:
            out[start:stop] = True
    return out


def dilated(mask: np.ndarray, reach: int) -> np.ndarray:
    """`mask` (n,) extended by `reach` samples on both sides."""
    if reach <= 0 or not mask.any():
        return mask.copy()
    out = mask.copy()
    for start, stop in runs(mask):
        out[max(0, start - reach) : stop + reach] = True
    return out


def filled(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`values` (n,) with gaps interpolated linearly, and the mask of the gaps."""
    gap = ~np.isfinite(values)
    if not gap.any():
        return values, gap
    if gap.all():
        return np.zeros_like(values), gap
    index = np.arange(values.size)
    bridged = values.copy()
    bridged[gap] = np.interp(index[gap], index[~gap], values[~gap])
    return bridged, gap
