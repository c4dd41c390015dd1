"""A sheet as a picture in grey."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.path import Path
from matplotlib.transforms import Affine2D

from drawings.export.strokes import Outlines, Shown
from drawings.export.texts import LINE, MOVE, text_outlines
from drawings.sheets.frame import PAPERS, Paper

DPI: dict[Paper, float] = {"A4": 200, "A3": 200, "A2": 150, "A1": 110}
"""Resolution: some 3500 pixels wide, so that the smallest lettering is read."""
INCH = 25.4
POINTS = 72.0


def png(shown: Shown, paper: Paper) -> bytes:
    """Painted by matplotlib's renderer without a figure around it; on a clear ground opacity is the ink."""
    dpi = DPI[paper]
    width, height = (round(side / INCH * dpi) for side in PAPERS[paper])
    renderer = RendererAgg(width, height, dpi)
    renderer.clear()
    to_pixels = Affine2D().scale(dpi / INCH)
    for lot in shown.lots:
        pen = renderer.new_gc()
        pen.set_capstyle("round")
        pen.set_joinstyle("round")
        if lot.weight is None:
            pen.set_linewidth(0.0)
            renderer.draw_path(pen, Path(lot.points, lot.codes), to_pixels, (0.0, 0.0, 0.0))
            continue
        pen.set_linewidth(lot.weight * POINTS / INCH)
        # What is level or upright is drawn on whole pixels, or it would look grey.
        square = _square(lot)
        for snapped in (False, True):
            chosen = square == snapped
            if chosen.any():
                pen.set_snap(snapped)
                renderer.draw_path(pen, Path(lot.points[chosen], lot.codes[chosen]), to_pixels)
    pen = renderer.new_gc()
    pen.set_linewidth(0.0)
    renderer.draw_path(pen, Path(*text_outlines(shown.texts)), to_pixels, (0.0, 0.0, 0.0))
    return _grey_png(255 - np.asarray(renderer.buffer_rgba())[..., 3], dpi)


def _square(lot: Outlines) -> np.ndarray:
    """For each point, whether its outline runs level and upright only."""
    steps = np.abs(np.diff(lot.points, axis=0, prepend=lot.points[:1]))
    straight = (lot.codes == MOVE) | ((lot.codes == LINE) & (steps.min(axis=1) < 1e-6))
    begins = np.array(lot.begins)
    whole = np.logical_and.reduceat(straight, begins)
    return np.repeat(whole, np.diff((*lot.begins, len(lot.points))))


def _grey_png(pixels: np.ndarray, dpi: float) -> bytes:
    """A picture in sixteen greys, which is plenty for the edges of black lines, at half the time and bytes of 256."""
    height, width = pixels.shape
    grey = np.zeros((height, width + width % 2), dtype=np.uint8)
    grey[:, :width] = pixels >> 4
    rows = np.zeros((height, grey.shape[1] // 2 + 1), dtype=np.uint8)
    rows[:, 1:] = (grey[:, ::2] << 4) | grey[:, 1::2]

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    metre = round(dpi / INCH * 1000.0)
    return b"\x89PNG\r\n\x1a\n" + b"".join((
        chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 4, 0, 0, 0, 0)),
        chunk(b"pHYs", struct.pack(">IIB", metre, metre, 1)),
        chunk(b"IDAT", zlib.compress(rows.tobytes(), 3)),
        chunk(b"IEND", b""),
    ))  # fmt: skip
