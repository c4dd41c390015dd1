"""Put the README's pictures together, after `make`, `demo` and the pictures of the workbench.

python docs/make_picture.py [BUILD]
"""

from __future__ import annotations

import sys
from io import BytesIO
from pathlib import Path

from PIL import Image

from stagecad.parameters.atomic import atomic_write_bytes

PAGE = Path(__file__).parent / "images" / "page_diagnosis.png"
PICTURE = Path(__file__).parent / "images" / "stagecad.png"
SHEET = Path(__file__).parent / "images" / "tip_sheet.png"
SHEET_WIDTH = 1400
LADDER_WIDTH, GAP = 700, 10
COLOURS = 255


def _of_width(image: Image.Image, width: int) -> Image.Image:
    return image.resize((width, round(image.height * width / image.width)), Image.Resampling.LANCZOS)


def picture(build: Path) -> bytes:
    """The page with a diagnosis above the figure of the ladder, as a PNG of few colours."""
    page = Image.open(PAGE).convert("RGB")
    ladder = Image.open(build / "demo" / "ladder.png").convert("RGBA")
    ladder = Image.alpha_composite(Image.new("RGBA", ladder.size, "white"), ladder).convert("RGB")
    ladder = _of_width(ladder, LADDER_WIDTH)
    whole = Image.new("RGB", (page.width, page.height + GAP + ladder.height), "white")
    whole.paste(page, (0, 0))
    whole.paste(ladder, ((page.width - ladder.width) // 2, page.height + GAP))
    file = BytesIO()
    whole.quantize(COLOURS, dither=Image.Dither.FLOYDSTEINBERG).save(file, "PNG", optimize=True)
    return file.getvalue()


def sheet(build: Path) -> bytes:
    """The sheet of the tip, small, as a PNG of few greys."""
    drawn = Image.open(next(build.rglob("tip.png"))).convert("L")
    small = drawn.resize((SHEET_WIDTH, round(drawn.height * SHEET_WIDTH / drawn.width)), Image.Resampling.LANCZOS)
    file = BytesIO()
    small.quantize(16).save(file, "PNG", optimize=True)
    return file.getvalue()


if __name__ == "__main__":
    build = Path(sys.argv[1] if len(sys.argv) > 1 else "build")
    atomic_write_bytes(PICTURE, picture(build))
    atomic_write_bytes(SHEET, sheet(build))
