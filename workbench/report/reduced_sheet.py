"""A drawing sheet as a small picture for an overview, in the store: making it takes longer than finding it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from stagecad.solids.artefacts.store import Artefact, ArtefactStore

SMALL = "small.png"
WIDTH = 900
"""Width of the small picture, pixels."""


def reduced_sheet(store: ArtefactStore, design: Any, path: Path, content: str) -> Artefact:
    """The small picture `SMALL` of the picture of a sheet, from the store or made now.

    Args:
        store: the cache.
        design: not read.
        path: of the picture.
        content: sha256 of the picture.
    """

    def make(tracked: Any, folder: Path) -> None:
        from PIL import Image

        with Image.open(path) as picture:
            height = round(picture.height * WIDTH / picture.width)
            small = picture.resize((WIDTH, height), Image.Resampling.BOX)
        small.quantize(16).save(folder / SMALL)

    return store.make("reduced sheet", design, (__name__,), make, (content,))
