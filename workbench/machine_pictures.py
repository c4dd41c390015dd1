"""Pictures of the machine's parts, its assembly and the exploded view, from the cache of made things."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.atomic import atomic_write_bytes

if TYPE_CHECKING:
    from stagecad.solids.cache import Store
    from stagecad.solids.machine import Machine

MODULES = ("stagecad.solids.pictures", "stagecad.solids.rasteriser")
ASSEMBLY_SIZE = (1800, 1250)
PART_SIZE = (1000, 720)


def write_pictures(
    machine: Machine, store: Store, folder: Path, advance: Callable[[str], None] = lambda name: None
) -> dict[str, Path]:
    """PNG of each part (of the stage from below too), the assembly and the exploded view.

    Args:
        machine: made.
        store: the cache that keeps them; a picture is drawn again only when its mesh changed.
        folder: written to; a file that is the same already is left alone.
        advance: called with each name as it is done.

    Returns:
        File by name: a part's, `stage_below`, `assembly`, `exploded`.
    """
    from stagecad.solids.pictures import BELOW, ISOMETRIC

    jobs: dict[str, Callable[[], bytes]] = {}
    depends: dict[str, tuple[str, ...]] = {}
    for name, part in machine.parts.items():
        views = {name: ISOMETRIC, f"{name}_below": BELOW} if name == "stage" else {name: ISOMETRIC}
        for title, viewer in views.items():
            jobs[title] = lambda name=name, viewer=viewer: _part(machine, name, viewer)
            depends[title] = (part.entry.key, title)
    whole = (machine.assembly.entry.key,)
    jobs["assembly"] = lambda: _assembly(machine, False)
    jobs["exploded"] = lambda: _assembly(machine, True)
    depends["assembly"], depends["exploded"] = (*whole, "assembly"), (*whole, "exploded")
    files = {}
    for title, draw in jobs.items():
        entry = store.make(
            f"picture_{title}", machine.design, MODULES, lambda reading, to, draw=draw: _write(to, draw), depends[title]
        )
        target = folder / f"{title}.png"
        data = entry.data("picture.png")
        if not (target.is_file() and target.read_bytes() == data):
            atomic_write_bytes(target, data)
        files[title] = target
        advance(title)
    return files


def _write(folder: Path, draw: Callable[[], bytes]) -> None:
    (folder / "picture.png").write_bytes(draw())


def _part(machine: Machine, name: str, viewer: tuple[float, float, float]) -> bytes:
    from stagecad.solids.export import Piece
    from stagecad.solids.pictures import picture

    part = machine.parts[name]
    return picture([Piece(name, name, part.colour)], {name: part.mesh}, viewer, PART_SIZE)


def _assembly(machine: Machine, exploded: bool) -> bytes:
    from stagecad.solids.made_assembly import meshes_of, pieces_of, shapes_of
    from stagecad.solids.pictures import picture

    instances = machine.assembly.instances
    shapes: dict[str, Any] = {}
    if any(instance.shape != instance.part for instance in instances):
        shapes = shapes_of(instances, machine.parts, machine.design)
    meshes = meshes_of(instances, machine.parts, shapes)
    return picture(pieces_of(instances, machine.parts, exploded=exploded), meshes, size=ASSEMBLY_SIZE)
