"""Draw the parts of the page on drawings, `declarations.py` and a block with a slanting face in an auxiliary view:
python docs/make_declarations.py"""

import tempfile
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image

from benchmarks.generators.undeclared_parts.prismatic import wedge_block
from stagecad.parameters.atomic import atomic_write_bytes
from workbench.operations.design import Design
from workbench.operations.drawings import draw_file, propose_sheet

PART = Path(__file__).with_name("declarations.py")
IMAGES = Path(__file__).parent / "images"
WIDTH = 1600


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        (document,) = draw_file(PART, Design(), True, Path(folder))
        write(document, Path(folder) / "declarations.png", "declarations", (0.2, 0.18, 0.68, 0.74))
        document = propose_sheet("block", wedge_block().solids().val(), "block.py", Design(), Path(folder))
        write(document, Path(folder) / "block.png", "auxiliary_view", (0.24, 0.06, 0.955, 0.6))


def write(document: dict[str, Any], sheet: Path, name: str, part: tuple[float, float, float, float]) -> None:
    """Write what is drawn on a sheet without hits, without its title block: the part of the sheet from left and top to
    right and bottom."""
    hits = [hit for one in document["sheets"] for hit in one["hits"]]
    if hits:
        raise SystemExit("\n".join(hits))
    drawn = Image.open(sheet).convert("L")
    inside = drawn.crop(tuple(round(p * size) for p, size in zip(part, drawn.size * 2, strict=True)))  # type: ignore[arg-type]
    small = inside.resize((WIDTH, round(inside.height * WIDTH / inside.width)), Image.Resampling.LANCZOS)
    file = BytesIO()
    small.quantize(8).save(file, "PNG", optimize=True)
    atomic_write_bytes(IMAGES / f"{name}.png", file.getvalue())


if __name__ == "__main__":
    main()
