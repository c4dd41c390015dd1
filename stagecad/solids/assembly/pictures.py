"""Pictures of every part, of the assembly and of the exploded view, from the cache or rendered now.

Rendering needs only meshes: for a cached machine the CAD kernel is not loaded.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from stagecad.solids.artefacts.part import BuiltPart
from stagecad.solids.artefacts.store import Artefact, ArtefactStore
from stagecad.solids.assembly.built_machine import EXPLODED, BuiltMachine, meshes_of, placed_shapes, shapes_of
from stagecad.solids.modelling.frame import PlacedShape
from stagecad.solids.modelling.part import ASSEMBLY, construction

PART_SIZE = (900, 650)


def build_pictures(
    store: ArtefactStore, machine: BuiltMachine, advance: Callable[[str], None] = lambda name: None
) -> dict[str, Artefact]:
    """PNG pictures by file name (``stage.png``, ``stage_below.png``, ``assembly.png``, ``assembly_exploded.png``)."""
    found: dict[str, Artefact] = {}
    for part in machine.parts.values():
        entry = part_pictures(store, part, machine.design)
        found.update(dict.fromkeys(entry.hashes, entry))
        advance(f"{part.name}.png")
    entry = assembly_pictures(store, machine)
    found.update(dict.fromkeys(entry.hashes, entry))
    advance(f"{ASSEMBLY}.png")
    return found


def part_pictures(store: ArtefactStore, part: BuiltPart, design: Any) -> Artefact:
    """Picture of a part, and that from below of some, from the cache or rendered now."""

    def make(_: Any, folder: Path) -> None:
        from stagecad.solids.export.render import BELOW, ISOMETRIC, picture

        shapes = [PlacedShape(part.name, part.name, part.colour)]
        meshes = {part.name: part.mesh}
        (folder / f"{part.name}.png").write_bytes(picture(shapes, meshes, ISOMETRIC, PART_SIZE))
        if part.name in construction(design).below:
            (folder / f"{part.name}_below.png").write_bytes(picture(shapes, meshes, BELOW, PART_SIZE))

    return store.make(f"picture of {part.name}", design, (__name__,), make, [part.entry.content])


def assembly_pictures(store: ArtefactStore, machine: BuiltMachine) -> Artefact:
    """Pictures of the assembly and of the exploded view, from the cache or rendered now."""

    def make(_: Any, folder: Path) -> None:
        from stagecad.solids.export.render import picture

        instances, parts = machine.assembly.instances, machine.parts
        changed = [instance for instance in instances if instance.shape != instance.part]
        meshes = meshes_of(instances, parts, shapes_of(changed, parts, machine.design))
        (folder / f"{ASSEMBLY}.png").write_bytes(picture(placed_shapes(instances, parts), meshes))
        (folder / f"{EXPLODED}.png").write_bytes(picture(placed_shapes(instances, parts, exploded=True), meshes))

    depends = [machine.assembly.entry.content, *(part.entry.content for part in machine.parts.values())]
    return store.make("picture of assembly", machine.design, (__name__,), make, depends)
