"""The pictures of the machine as they were made, from the cache when it has them.

They are most of the work on the machine's sheets, two of them stand on both sheets, and each can be worked out in a
process of its own.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.solids.artefacts.part import BuiltPart
from stagecad.solids.artefacts.store import Artefact, ArtefactStore
from stagecad.solids.assembly.assemble import assemble
from stagecad.solids.modelling.registry import ASSEMBLY

if TYPE_CHECKING:
    from drawings.pictures.picture import Picture

PROCEDURE = "procedure"
"""The sheet that tells how the machine is put together."""
PICTURES = {
    ASSEMBLY: ("section A-A", "exploded", "from below", "top"),
    PROCEDURE: ("exploded", "from below"),
}
"""What each sheet of the whole machine shows, the slowest first."""
_FILE = "picture.json"
_MODULES = ("drawings.pictures.machine", "stagecad.solids.assembly.assemble", __name__)


def find_picture(store: ArtefactStore, name: str, parts: Mapping[str, BuiltPart], design: Any) -> Artefact | None:
    """A picture in the cache, or None where it has to be made."""
    return store.find(_named(name), design, _MODULES, _keys(parts))


def make_picture(
    store: ArtefactStore, name: str, parts: Mapping[str, BuiltPart], design: Any, *, exact: bool = True
) -> Picture | None:
    """A picture from the cache, worked out now when it lacks it; none where the machine has nothing to show there.

    Args:
        name: as in `drawings.pictures.machine`.
        parts: all of the machine's.
        exact: how lines are hidden (`drawings.views.projection.project`).
    """
    from drawings.pictures.picture import picture_document, picture_of

    def make(reading: Any, folder: Path) -> None:
        from drawings.pictures.machine import machine_picture
        from drawings.pictures.scene import scene_of
        from stagecad.solids.assembly.built_assembly import shapes_of

        instances = assemble(dict(parts), reading)
        shapes = {shape: solid.wrapped for shape, solid in shapes_of(instances, parts, reading).items()}
        scene = scene_of(shapes, {part: made.mesh for part, made in parts.items()})
        picture = machine_picture(name, instances, scene, exact=exact)
        (folder / _FILE).write_text(json.dumps(picture_document(picture) if picture else None), "utf-8")

    entry = store.make(_named(name), design, _MODULES, make, _keys(parts))
    document = entry.document(_FILE)
    return picture_of(document) if document else None


def _named(picture: str) -> str:
    return f"picture {picture} of the machine"


def _keys(parts: Mapping[str, BuiltPart]) -> list[str]:
    return [made.entry.key for made in parts.values()]
