"""A built part: solid, mesh, exported files, volume properties and datums, from the cache or built now.

Files of a part in the cache: ``solid.bin`` (exact, without a mesh), ``mesh.npz``, ``object.pickle`` (`PartData`), and
``NAME.step``, ``NAME.stl``, ``NAME.glb``. All but the solid are read without the CAD kernel.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Literal

from stagecad.parameters.dimension import Datum
from stagecad.parameters.errors import InputError, LostProcessError, PartError
from stagecad.parameters.mass_properties import MassProperties
from stagecad.processes import parallel_map
from stagecad.solids.artefacts.store import FILE, Artefact, ArtefactStore
from stagecad.solids.export.mesh import Mesh, glb_bytes, load, mesh_of, save, stl_bytes
from stagecad.solids.export.step import step_bytes
from stagecad.solids.modelling.frame import Colour, PlacedShape, colour_of
from stagecad.solids.modelling.kernel import cq, load_kernel, occ, unlocated
from stagecad.solids.modelling.mass import Geometry, density_of, geometry_of, mass_properties
from stagecad.solids.modelling.part import part_source

FEW = 3
"""Up to so many parts are made in one process: starting others costs more than it saves."""

Contents = Literal["data", "solid", "files"]
"""What is needed of a part: its data; its solid and mesh too; or also the files that a user receives."""
SUFFIXES: dict[Contents, str] = {"files": "", "solid": ":solid", "data": ":measured"}
"""Ends of the names in the cache, the fullest first."""
CRASHED = "the CAD kernel ended its process, twice"
"""Reason of a part whose construction crashes."""


@dataclass(frozen=True)
class PartData:
    """What a part states, and what is measured on its solid."""

    material: str  # its name in the parameter file
    description: str
    part_number: str  # of the catalogue; empty for a part made from a drawing
    geometry: Geometry
    datums: dict[str, Datum]
    face_areas: dict[str, float]  # area of the face of each pad, mm^2, by the name of its datum


@dataclass(frozen=True)
class BuiltPart(PartData):
    """One part of one design."""

    name: str
    entry: Artefact

    @classmethod
    def stored(cls, name: str, entry: Artefact) -> BuiltPart:
        """The part in an artefact."""
        return cls(**vars(entry.object()), name=name, entry=entry)

    @property
    def colour(self) -> Colour:
        return colour_of(self.material)

    @property
    def files(self) -> tuple[str, ...]:
        return tuple(f"{self.name}.{kind}" for kind in ("step", "stl", "glb"))

    @cached_property
    def mesh(self) -> Mesh:
        return load(self.entry.path("mesh.npz"))

    @cached_property
    def solid(self) -> cq.Solid:
        """The exact solid; loads the CAD kernel."""
        shape, path = occ.TopoDS_Shape(), self.entry.path("solid.bin")
        if not occ.BinTools.Read_s(shape, str(path)):
            raise OSError(f"{path}: the solid could not be read")
        return cq.Solid(shape)


def part_mass(part: BuiltPart, design: Any) -> MassProperties:
    """Mass properties of a part in its own coordinates."""
    return mass_properties(part.geometry, density_of(design, part.material))


def find_part(store: ArtefactStore, name: str, design: Any, contents: Contents = "files") -> BuiltPart | None:
    """The part from the cache with these contents or more, or None."""
    source, kinds = part_source(name, design), list(SUFFIXES)
    for kind in kinds[: kinds.index(contents) + 1]:
        entry = store.find(name + SUFFIXES[kind], source.design_of(design), (*source.modules, __name__), source.depends)
        if entry is not None:
            return BuiltPart.stored(name, entry)
    return None


def build_part(store: ArtefactStore, name: str, design: Any, contents: Contents = "files") -> BuiltPart:
    """The part from the cache, or built now."""
    if found := find_part(store, name, design, contents):
        return found
    source = part_source(name, design)

    def make(tracked: Any, folder: Path) -> None:
        part: Any = source.definition()
        with kernel_errors(name, design):
            solid = part.build(tracked)
            solid = unlocated(solid) if design.machine.declaration and hasattr(solid, "wrapped") else solid
            made = getattr(solid, "ShapeType", lambda: type(solid).__name__)()
            if made != "Solid":
                raise ValueError(f"part '{name}': the result is a {made}, not one solid")
            if not solid.isValid() or solid.Volume() <= 0.0:
                raise ValueError(f"part '{name}': the solid is not valid and closed; its dimensions are inconsistent")
        material, datums, geometry = part.material(tracked), part.datums(tracked), geometry_of(solid)
        words = part.description(tracked), part.part_number(tracked)
        at = {pad: cq.Vertex.makeVertex(*datums[pad].origin) for pad in datums if pad.startswith("pad_")}
        areas = {pad: min(solid.Faces(), key=lambda face: face.distance(at[pad])).Area() for pad in at}
        (folder / FILE).write_bytes(pickle.dumps(PartData(material, *words, geometry, datums, areas)))
        if contents == "data":
            return
        if not occ.BinTools.Write_s(solid.wrapped, str(folder / "solid.bin")):
            raise OSError(f"{folder}: the solid could not be written")
        with kernel_errors(name, design):
            mesh = mesh_of(solid, geometry.volume, exported=contents == "files")
        save(mesh, folder / "mesh.npz")
        if contents == "files":
            shapes = [PlacedShape(name, name, colour_of(material))]
            (folder / f"{name}.step").write_bytes(step_bytes(name, shapes, {name: solid.wrapped}))
            (folder / f"{name}.stl").write_bytes(stl_bytes([mesh]))
            (folder / f"{name}.glb").write_bytes(glb_bytes(name, shapes, {name: mesh}))

    stored, modules = name + SUFFIXES[contents], (*source.modules, __name__)
    return BuiltPart.stored(name, store.make(stored, source.design_of(design), modules, make, source.depends))


@contextmanager
def kernel_errors(name: str, design: Any) -> Iterator[None]:
    """Errors of the CAD kernel as PartError of `name`."""
    try:
        yield
    except (InputError, PartError, MemoryError):
        raise
    except Exception as error:  # the kernel raises a dozen kinds
        if "OutOfMemory" in type(error).__name__ or "bad_alloc" in str(error):
            raise MemoryError from error
        raise PartError(name, design, f"{type(error).__name__}: {error}") from error


def build_parts(
    store: ArtefactStore,
    names: Sequence[str],
    design: Any,
    advance: Callable[[str], None] = lambda name: None,
    isolate: bool = True,
    contents: Contents = "files",
) -> dict[str, BuiltPart]:
    """All of `names`; those that the cache lacks are built in other processes."""
    found = {name: find_part(store, name, design, contents) for name in names}
    for name in names:
        if found[name] is not None:
            advance(name)
    missing = [name for name in names if found[name] is None]
    in_processes(partial(_build, store.folder, design, contents), missing, design, advance, isolate=isolate)
    return {name: found[name] or build_part(store, name, design, contents) for name in names}


def in_processes(
    run: Callable[[str], object],
    names: Sequence[str],
    design: Any,
    advance: Callable[[str], None] = lambda name: None,
    requires: Mapping[str, Collection[str]] | None = None,
    isolate: bool = True,
) -> None:
    """`run` for each of `names` with the CAD kernel, in other processes; one is enough for few."""
    count = 1 if len(names) - len(requires or {}) <= FEW else None
    try:
        parallel_map(
            partial(_with_kernel, run), names, progress=advance, workers=count, requires=requires, isolate=isolate
        )
    except LostProcessError as error:
        raise PartError(str(error.item), design, CRASHED) from None


def _with_kernel(run: Callable[[str], object], name: str) -> object:
    load_kernel()
    return run(name)


def _build(folder: Path, design: Any, contents: Contents, name: str) -> None:
    build_part(ArtefactStore(folder), name, design, contents)
