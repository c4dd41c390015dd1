"""Pictures of the whole machine (hidden-line removal) as artefacts: each is drawn once for all sheets that show it.

A picture depends on the solids that it shows and on their positions; a parameter that changes neither leaves it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from drawings.sheets.plans import sheets_of
from stagecad.solids.artefacts.part import BuiltPart
from stagecad.solids.artefacts.store import ArtefactStore, stored_object
from stagecad.solids.modelling.part import Instance

if TYPE_CHECKING:
    from drawings.pictures.picture import Picture

FROM_BELOW = "from below"
"""Shows the moving parts alone."""


def stored_picture(
    store: ArtefactStore,
    name: str,
    instances: Sequence[Instance],
    parts: Mapping[str, BuiltPart],
    design: Any,
    *,
    exact: bool = True,
) -> Picture | None:
    """One picture of the machine from the store, or drawn now; None as of `machine_picture`."""
    views = sheets_of(design).views(design, instances, parts)
    moving = views.moving if name == FROM_BELOW else tuple(parts)
    shown = [instance for instance in instances if instance.part in moving]

    def draw(tracked: Any) -> Picture | None:
        from drawings.pictures.machine import machine_picture
        from drawings.pictures.scene import scene_of
        from stagecad.solids.assembly.built_machine import shapes_of

        shapes = {shape: solid.wrapped for shape, solid in shapes_of(shown, parts, tracked).items()}
        scene = scene_of(shapes, {part.name: part.mesh for part in parts.values() if part.name in shapes})
        return machine_picture(name, shown, scene, views, exact=exact)

    kinds = dict.fromkeys(instance.part for instance in shown)
    depends = [repr(tuple(shown)), repr(views), *(f"{kind} {parts[kind].entry.content}" for kind in kinds)]
    return stored_object(store, f"{name} of the machine", design, (__name__,), draw, depends)
