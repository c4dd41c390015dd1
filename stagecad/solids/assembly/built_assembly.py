"""The built assembly: positions of all parts, STEP, STL, GLB and the exploded GLB, from the cache or built now."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.solids.artefacts.part import BuiltPart
from stagecad.solids.artefacts.store import Artefact, ArtefactStore
from stagecad.solids.modelling.frame import Frame
from stagecad.solids.modelling.instance import Instance
from stagecad.solids.modelling.placed_shape import PlacedShape
from stagecad.solids.modelling.registry import ASSEMBLY, Position, construction, part_source

if TYPE_CHECKING:
    import cadquery as cq

    from stagecad.solids.export.mesh import Mesh

EXPLODED = f"{ASSEMBLY}_exploded"


@dataclass(frozen=True)
class BuiltAssembly:
    """The whole machine at the middle of its travel and height adjustment."""

    entry: Artefact

    @cached_property
    def instances(self) -> tuple[Instance, ...]:
        return tuple(
            Instance(
                document["name"],
                document["part"],
                _frame(document["frame"]),
                _frame(document["exploded"]),
                document["compression"],
            )
            for document in self.entry.document("instances.json")
        )

    @property
    def files(self) -> tuple[str, ...]:
        return (*(f"{ASSEMBLY}.{kind}" for kind in ("step", "stl", "glb")), f"{EXPLODED}.glb")


def _frame(document: dict[str, Any]) -> Frame:
    a, b, c = (tuple(row) for row in document["rotation"])
    return Frame((a, b, c), tuple(document["shift"]))  # type: ignore[arg-type]


def find_assembly(store: ArtefactStore, parts: Mapping[str, BuiltPart], design: Any) -> BuiltAssembly | None:
    """The assembly from the cache, or None."""
    entry = store.find(ASSEMBLY, design, _modules(design), _keys(parts, design))
    return BuiltAssembly(entry) if entry is not None else None


def build_assembly(store: ArtefactStore, parts: Mapping[str, BuiltPart], design: Any) -> BuiltAssembly:
    """The assembly of `parts` (all parts of the design), from the cache or built now."""

    def make(tracked: Any, folder: Path) -> None:
        from stagecad.solids.export.step_stl_glb import glb_bytes, step_bytes, stl_bytes

        instances = assemble(parts, tracked)
        documents = [asdict(instance) for instance in instances]
        (folder / "instances.json").write_text(json.dumps(documents, indent=1), "utf-8")
        shapes = shapes_of(instances, parts, tracked)
        meshes = meshes_of(instances, parts, shapes)
        placed = placed_shapes(instances, parts)
        wrapped = {name: shape.wrapped for name, shape in shapes.items()}
        (folder / f"{ASSEMBLY}.step").write_bytes(step_bytes(ASSEMBLY, placed, wrapped))
        (folder / f"{ASSEMBLY}.glb").write_bytes(glb_bytes(ASSEMBLY, placed, meshes))
        exploded = placed_shapes(instances, parts, exploded=True)
        (folder / f"{EXPLODED}.glb").write_bytes(glb_bytes(EXPLODED, exploded, meshes))
        moved = [meshes[shape.part].placed(shape.frame) for shape in placed]
        (folder / f"{ASSEMBLY}.stl").write_bytes(stl_bytes(moved))

    return BuiltAssembly(store.make(ASSEMBLY, design, _modules(design), make, _keys(parts, design)))


def assemble(parts: Mapping[str, BuiltPart], design: Any, position: Position = (0.0, 0.0)) -> tuple[Instance, ...]:
    """All instances of the parts of a machine, at a position of travel and height adjustment."""
    return construction(design).assemble(parts, design, position)


def _modules(design: Any) -> tuple[str, ...]:
    return (__name__, *construction(design).modules)


def _keys(parts: Mapping[str, BuiltPart], design: Any) -> list[str]:
    return [*(part.entry.content for part in parts.values()), *construction(design).depends(design)]


def placed_shapes(
    instances: Sequence[Instance], parts: Mapping[str, BuiltPart], *, exploded: bool = False
) -> list[PlacedShape]:
    """The instances as shapes with position and colour, for export and pictures."""
    placed = []
    for instance in instances:
        frame = instance.exploded if exploded else instance.frame
        placed.append(PlacedShape(instance.name, instance.shape, parts[instance.part].colour, frame))
    return placed


def shapes_of(instances: Sequence[Instance], parts: Mapping[str, BuiltPart], design: Any) -> dict[str, cq.Shape]:
    """The exact solid of each `Instance.shape`: that of the part, or a spring at its length in the assembly."""
    shapes: dict[str, cq.Shape] = {}
    for instance in instances:
        if instance.shape not in shapes:
            part = instance.part
            if instance.shape == part:
                shapes[part] = parts[part].solid
            else:
                spring: Any = part_source(part, design).definition()
                shapes[instance.shape] = spring.build(design, instance.compression)
    return shapes


def meshes_of(
    instances: Sequence[Instance], parts: Mapping[str, BuiltPart], shapes: Mapping[str, cq.Shape]
) -> dict[str, Mesh]:
    """The mesh of each `Instance.shape`; `shapes` is needed only for springs off their installed length."""
    from stagecad.solids.export.mesh import mesh_of

    meshes: dict[str, Mesh] = {}
    for instance in instances:
        name = instance.shape
        if name not in meshes:
            own = name == instance.part
            meshes[name] = parts[name].mesh if own else mesh_of(shapes[name], shapes[name].Volume())
    return meshes
