"""Proposed sheets of parts that nobody declared, and one picture of all of them.

    python -m benchmarks.part_sheets [--out DIR] [NAME...]

Writes the sheets, prints for each part its time, its lint hits and what its dimensions leave open, and draws
`contact_sheet_N.png` with twelve sheets each, to look at.
"""

import argparse
import time
from pathlib import Path

from benchmarks.generators.undeclared_parts import PARTS
from workbench.operations.design import Design
from workbench.operations.drawings import propose_sheet

COLUMNS, ROWS = 3, 4


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", default=list(PARTS))
    parser.add_argument("--out", type=Path, default=Path("build/part_sheets"))
    arguments = parser.parse_args()
    design = Design()
    pictures: list[Path] = []
    clean = 0
    for name in arguments.names:
        begin = time.perf_counter()
        solid = PARTS[name]().solids().val()
        document = propose_sheet(name, solid, f"{name}.py", design, arguments.out)
        hits = [hit for sheet in document["sheets"] for hit in sheet["hits"]]
        clean += not hits
        print(f"{name:20} {time.perf_counter() - begin:6.1f} s  {len(hits)} hits")
        for hit in hits:
            print(f"{'':20} {hit}")
        pictures.append(arguments.out / f"{document['part']}.png")
    for number, first in enumerate(range(0, len(pictures), COLUMNS * ROWS), start=1):
        _contact_sheet(pictures[first : first + COLUMNS * ROWS], arguments.out / f"contact_sheet_{number}.png")
    print(f"{clean} of {len(pictures)} parts without a hit; pictures in {arguments.out}")


def _contact_sheet(pictures: list[Path], target: Path) -> None:
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    figure = Figure(figsize=(21, 20))
    for number, picture in enumerate(pictures, start=1):
        axes = figure.add_subplot(ROWS, COLUMNS, number)
        axes.imshow(imread(picture), cmap="gray")
        axes.set_axis_off()
    figure.tight_layout(pad=0.2)
    figure.savefig(target, dpi=110)


if __name__ == "__main__":
    main()
