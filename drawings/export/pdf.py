"""A sheet as a page of PDF (ISO 32000-1), with its texts as text: a reader can search and copy them.

The lettering comes along as a font of outlines (Type 3), those of the signs that the sheet has, so that it looks the
same everywhere; a table says which letter each sign is.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence

from drawings.annotations.font import glyph
from drawings.export.outline_words import written
from drawings.export.strokes import Shown
from drawings.export.texts import CUBIC, LINE, MOVE, PaperText, with_cubics
from drawings.sheets.frame import PAPERS, Paper

INCH = 25.4
POINTS = 72.0
EM = 1000
"""Units of the font to the height of capitals."""
PER_FONT = 255
"""Signs of one font: a code is a byte, and none is zero."""
_WORDS = {
    (MOVE, 0): "%d %d m\n",
    (LINE, 0): "%d %d l\n",
    (CUBIC, 0): "%d %d ",
    (CUBIC, 1): "%d %d ",
    (CUBIC, 2): "%d %d c\n",
}
FINE = 1000.0
"""Units of the page to the millimetre: its numbers are whole, which are the quickest to write and to read."""


def pdf(shown: Shown, paper: Paper) -> bytes:
    """The page; the same bytes for the same sheet."""
    signs = sorted({sign for text in shown.texts for sign in text.words})
    groups = [signs[start : start + PER_FONT] for start in range(0, len(signs), PER_FONT)]
    objects = _Objects()
    catalog, pages, page, content = (objects.room() for _ in range(4))
    fonts = "".join(f"/F{number} {_font(objects, group)} 0 R " for number, group in enumerate(groups))
    width, height = (side * POINTS / INCH for side in PAPERS[paper])
    objects.put(catalog, f"<< /Type /Catalog /Pages {pages} 0 R >>")
    objects.put(pages, f"<< /Type /Pages /Kids [{page} 0 R] /Count 1 >>")
    resources = f"<< /Font << {fonts}>> >>"
    box = f"[0 0 {width:.3f} {height:.3f}]"
    objects.put(
        page,
        f"<< /Type /Page /Parent {pages} 0 R /MediaBox {box} /Resources {resources} /Contents {content} 0 R >>",
    )
    objects.put_stream(content, "".join(_content(shown, groups)))
    return objects.file(catalog)


class _Objects:
    """The numbered objects of a file."""

    def __init__(self) -> None:
        self._bodies: list[bytes] = []

    def room(self) -> int:
        """Number of an object that is put in later."""
        self._bodies.append(b"")
        return len(self._bodies)

    def put(self, number: int, body: str) -> int:
        self._bodies[number - 1] = body.encode("ascii")
        return number

    def put_stream(self, number: int, text: str) -> int:
        data = zlib.compress(text.encode("ascii"), 4)
        head = f"<< /Length {len(data)} /Filter /FlateDecode >>\nstream\n".encode("ascii")
        self._bodies[number - 1] = head + data + b"\nendstream"
        return number

    def file(self, catalog: int) -> bytes:
        information = self.put(self.room(), "<< /Producer (stagecad) >>")
        data = bytearray(b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n")
        places = []
        for number, body in enumerate(self._bodies, start=1):
            places.append(len(data))
            data += b"%d 0 obj\n%s\nendobj\n" % (number, body)
        table = len(data)
        data += b"xref\n0 %d\n0000000000 65535 f \n" % (len(places) + 1)
        data += b"".join(b"%010d 00000 n \n" % place for place in places)
        data += b"trailer\n<< /Size %d /Root %d 0 R /Info %d 0 R >>\n" % (len(places) + 1, catalog, information)
        data += b"startxref\n%d\n%%%%EOF\n" % table
        return bytes(data)


def _content(shown: Shown, groups: Sequence[Sequence[str]]) -> Iterator[str]:
    """What the page draws, in units of its own."""
    unit = POINTS / INCH / FINE
    yield f"{unit:.9f} 0 0 {unit:.9f} 0 0 cm\n1 J 1 j\n"
    for lot in shown.lots:
        if lot.weight is not None:
            yield f"{lot.weight * FINE:.0f} w\n"
        after = "f\n" if lot.weight is None else "S\n"
        yield written(lot.points * FINE, lot.codes, _WORDS, lot.begins, "", after)
    codes = {sign: (number, code) for number, group in enumerate(groups) for code, sign in enumerate(group, start=1)}
    yield "BT\n"
    used = -1
    for text in shown.texts:
        for number, string, at in _runs(text, codes):
            if number != used:
                yield f"/F{number} 1 Tf\n"
                used = number
            a, b, c, d = (FINE * value for value in text.matrix)
            yield f"{a:.1f} {c:.1f} {b:.1f} {d:.1f} {at[0] * FINE:.0f} {at[1] * FINE:.0f} Tm <{string}> Tj\n"
    yield "ET\n"


def _runs(text: PaperText, codes: dict[str, tuple[int, int]]) -> Iterator[tuple[int, str, tuple[float, float]]]:
    """Stretches of a text in one font each: its number, codes, and where it begins."""
    a, _, c, _ = text.matrix
    along = 0.0
    run: list[str] = []
    begin, font = along, -1
    for sign in text.words:
        number, code = codes[sign]
        if number != font and run:
            yield font, "".join(run), (text.start[0] + a * begin, text.start[1] + c * begin)
            run, begin = [], along
        font = number
        run.append(f"{code:02x}")
        along += glyph(sign).advance
    if run:
        yield font, "".join(run), (text.start[0] + a * begin, text.start[1] + c * begin)


def _font(objects: _Objects, signs: Sequence[str]) -> int:
    """Number of a font with these signs, their codes counted from one."""
    widths = " ".join(f"{glyph(sign).advance * EM:.1f}" for sign in signs)
    names = [f"s{ord(sign):x}" for sign in signs]
    shapes = " ".join(
        f"/{name} {objects.put_stream(objects.room(), _shape(sign))} 0 R"
        for name, sign in zip(names, signs, strict=True)
    )
    letters = objects.put_stream(objects.room(), _letters(signs))
    return objects.put(
        objects.room(),
        f"<< /Type /Font /Subtype /Type3 /FontBBox [0 0 0 0] /FontMatrix [{1 / EM:g} 0 0 {1 / EM:g} 0 0] "
        f"/FirstChar 1 /LastChar {len(signs)} /Widths [{widths}] "
        f"/Encoding << /Type /Encoding /Differences [1 /{' /'.join(names)}] >> "
        f"/CharProcs << {shapes} >> /Resources << >> /ToUnicode {letters} 0 R >>",
    )


def _shape(sign: str) -> str:
    """A sign as its font has it: width, box, outlines to be filled."""
    own = glyph(sign)
    if not len(own.points):
        return f"{own.advance * EM:.1f} 0 0 0 0 0 d1"
    points, codes = with_cubics(own.points * EM, own.codes)
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    box = f"{left - 1:.0f} {low - 1:.0f} {right + 1:.0f} {high + 1:.0f}"
    return f"{own.advance * EM:.1f} 0 {box} d1\n{written(points, codes, _WORDS, (0,), '', 'f')}"


def _letters(signs: Sequence[str]) -> str:
    """Which letters the codes stand for (9.10.3)."""
    rows = [f"<{code:02x}> <{sign.encode('utf-16-be').hex()}>\n" for code, sign in enumerate(signs, start=1)]
    blocks = "".join(
        f"{len(block)} beginbfchar\n{''.join(block)}endbfchar\n"
        for block in (rows[start : start + 100] for start in range(0, len(rows), 100))
    )
    return (
        "/CIDInit /ProcSet findresource begin\n12 dict begin\nbegincmap\n"
        "/CIDSystemInfo << /Registry (Adobe) /Ordering (UCS) /Supplement 0 >> def\n"
        "/CMapName /Adobe-Identity-UCS def\n/CMapType 2 def\n"
        f"1 begincodespacerange\n<00> <ff>\nendcodespacerange\n{blocks}"
        "endcmap\nCMapName currentdict /CMap defineresource pop\nend\nend\n"
    )
