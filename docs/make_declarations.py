"""Draw the part of `declarations.py` for the page on drawings: python docs/make_declarations.py"""

import tempfile
from io import BytesIO
from pathlib import Path

from PIL import Image

from stagecad.parameters.atomic import atomic_write_bytes
from workbench.operations.design import Design
from workbench.operations.drawings import draw_file

PART = Path(__file__).with_name("declarations.py")
PICTURE = Path(__file__).parent / "images" / "declarations.png"
WIDTH = 1600


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        (document,) = draw_file(PART, Design(), True, Path(folder))
        hits = [hit for sheet in document["sheets"] for hit in sheet["hits"]]
        if hits:
            raise SystemExit("\n".join(hits))
        drawn = Image.open(Path(folder) / "declarations.png").convert("L")
    # What is drawn, without the frame and its title block.
    width, height = drawn.size
    inside = drawn.crop((round(0.2 * width), round(0.18 * height), round(0.68 * width), round(0.74 * height)))
    small = inside.resize((WIDTH, round(inside.height * WIDTH / inside.width)), Image.Resampling.LANCZOS)
    file = BytesIO()
    small.quantize(8).save(file, "PNG", optimize=True)
    atomic_write_bytes(PICTURE, file.getvalue())


if __name__ == "__main__":
    main()
