"""SVG, PDF and PNG of a sheet, all from its DXF document: what is drawn there is what every format shows.

The paper space is resolved once (`drawings.strokes`), text as outlines of the lettering font; the three formats are
written from that one set of lines, each line weight in one go.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from ezdxf.document import Drawing
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.path import Path
from matplotlib.transforms import Affine2D

from drawings.frame import PAPERS, Paper
from drawings.strokes import CUBIC, LINE, MOVE, QUADRATIC, Outlines, outlines

DPI: dict[Paper, float] = {"A4": 200, "A3": 200, "A2": 150, "A1": 110}
"""Resolution of the PNG: some 3500 pixels wide, so that the smallest lettering is read."""
INCH = 25.4
POINTS = 72.0


@dataclass(frozen=True)
class Renderings:
    """The sheet in the formats that people open."""

    svg: bytes
    pdf: bytes
    png: bytes


def render(doc: Drawing, paper: Paper) -> Renderings:
    """SVG, PDF and PNG of a document's paper space, the same bytes for the same document."""
    lots = outlines(doc)
    return Renderings(_svg(lots, paper), _pdf(lots, paper), _png(lots, paper))


def _svg(lots: Sequence[Outlines], paper: Paper) -> bytes:
    """One group for each line weight, one path for each line or text in it; the unit is the millimetre."""
    width, height = PAPERS[paper]
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
        f'viewBox="0 0 {width:g} {height:g}" stroke-linecap="round" stroke-linejoin="round">\n'
        '<rect width="100%" height="100%" fill="white"/>\n'
    ]
    for lot in lots:
        flipped = lot.points * (1.0, -1.0) + (0.0, height)
        stroke = f'<g fill="none" stroke="black" stroke-width="{lot.weight or 0.0:g}">\n'
        parts.append("<g>\n" if lot.weight is None else stroke)
        parts.append(_written(lot, flipped, _SVG_WORDS, '<path d="', '"/>\n'))
        parts.append("</g>\n")
    return "".join((*parts, "</svg>\n")).encode("ascii")


_SVG_WORDS = {
    (MOVE, 0): "M%.3f %.3f",
    (LINE, 0): "L%.3f %.3f",
    (QUADRATIC, 0): "Q%.3f %.3f",
    (QUADRATIC, 1): " %.3f %.3f",
    (CUBIC, 0): "C%.3f %.3f",
    (CUBIC, 1): " %.3f %.3f",
    (CUBIC, 2): " %.3f %.3f",
}
"""How a point is written: by its code, and its place among the points of its curve."""
_PDF_WORDS = {
    (MOVE, 0): "%.2f %.2f m\n",
    (LINE, 0): "%.2f %.2f l\n",
    (CUBIC, 0): "%.2f %.2f ",
    (CUBIC, 1): "%.2f %.2f ",
    (CUBIC, 2): "%.2f %.2f c\n",
}


def _written(lot: Outlines, points: np.ndarray, words: dict[tuple[int, int], str], before: str, after: str) -> str:
    """The outlines of a lot in the words of a format, each with something before and after it."""
    pattern: list[str] = []
    of_curve = 0
    last = 0
    for code in lot.codes.tolist():
        of_curve = of_curve + 1 if code == last and (code, of_curve + 1) in words else 0
        pattern.append(words[code, of_curve])
        last = code
    for begin in lot.begins:
        pattern[begin] = before + pattern[begin]
    for end in (*lot.begins[1:], len(pattern)):
        pattern[end - 1] += after
    return "".join(pattern) % tuple(points.ravel().tolist())


def _pdf(lots: Sequence[Outlines], paper: Paper) -> bytes:
    """One page (ISO 32000-1); the unit is the millimetre, by the matrix that its content begins with."""
    width, height = (side * POINTS / INCH for side in PAPERS[paper])
    content = ["1 J 1 j\n"]
    for lot in lots:
        lot = lot.with_cubics()
        if lot.weight is not None:
            content.append(f"{lot.weight * POINTS / INCH:.3f} w\n")
        points = lot.points * (POINTS / INCH)
        content.append(_written(lot, points, _PDF_WORDS, "", "f\n" if lot.weight is None else "S\n"))
    stream = zlib.compress("".join(content).encode("ascii"), 4)
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width:.3f} {height:.3f}] "
        "/Resources << >> /Contents 4 0 R >>".encode("ascii"),
        f"<< /Length {len(stream)} /Filter /FlateDecode >>\nstream\n".encode("ascii") + stream + b"\nendstream",
        b"<< /Producer (stagecad) >>",
    ]
    data = bytearray(b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n")
    places = []
    for number, body in enumerate(objects, start=1):
        places.append(len(data))
        data += b"%d 0 obj\n%s\nendobj\n" % (number, body)
    table = len(data)
    data += b"xref\n0 %d\n0000000000 65535 f \n" % (len(objects) + 1)
    data += b"".join(b"%010d 00000 n \n" % place for place in places)
    data += b"trailer\n<< /Size %d /Root 1 0 R /Info 5 0 R >>\n" % (len(objects) + 1)
    data += b"startxref\n%d\n%%%%EOF\n" % table
    return bytes(data)


def _png(lots: Sequence[Outlines], paper: Paper) -> bytes:
    """Painted by matplotlib's renderer without a figure around it; on a clear ground opacity is the ink."""
    dpi = DPI[paper]
    width, height = (round(side / INCH * dpi) for side in PAPERS[paper])
    renderer = RendererAgg(width, height, dpi)
    renderer.clear()
    to_pixels = Affine2D().scale(dpi / INCH)
    for lot in lots:
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
