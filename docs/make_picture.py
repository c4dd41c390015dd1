"""Put the README's picture together: python docs/make_picture.py [BUILD], after `stagecad make` and `stagecad demo`."""

from __future__ import annotations

import sys
from io import BytesIO
from pathlib import Path

from PIL import Image

from stagecad.parameters.atomic import atomic_write_bytes

PICTURE = Path(__file__).parent / "images" / "stagecad.png"
HEIGHT = 480
COLOURS = 255


def picture(build: Path) -> bytes:
    """The exploded view beside the figure of the ladder, as a PNG of few colours."""
    machine = Image.open(build / "pictures" / "exploded.png").convert("RGB")
    # The machine stands in the middle of a wide view.
    width, height = machine.size
    machine = machine.crop((int(0.18 * width), 0, int(0.82 * width), height))
    ladder = Image.open(build / "demo" / "ladder.png").convert("RGBA")
    ladder = Image.alpha_composite(Image.new("RGBA", ladder.size, "white"), ladder).convert("RGB")
    parts = [
        im.resize((round(im.width * HEIGHT / im.height), HEIGHT), Image.Resampling.LANCZOS) for im in (machine, ladder)
    ]
    whole = Image.new("RGB", (sum(im.width for im in parts) + 10, HEIGHT), "white")
    left = 0
    for im in parts:
        whole.paste(im, (left, 0))
        left += im.width + 10
    file = BytesIO()
    whole.quantize(COLOURS, dither=Image.Dither.FLOYDSTEINBERG).save(file, "PNG", optimize=True)
    return file.getvalue()


def _as_high(image: Image.Image) -> Image.Image:
    return image.resize((round(image.width * HEIGHT / image.height), HEIGHT), Image.Resampling.LANCZOS)


if __name__ == "__main__":
    atomic_write_bytes(PICTURE, picture(Path(sys.argv[1] if len(sys.argv) > 1 else "build")))
