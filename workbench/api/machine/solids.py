"""`solids`: the parts of a design and where they stand in the machine, kept in the cache alone."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from workbench.operations.design import Design, load_design
from workbench.operations.progress import ProgressCallback
from workbench.operations.result import Result, finite

if TYPE_CHECKING:
    import pandas as pd

    from stagecad.friction_stage.assembly.assemble import Instance
    from stagecad.parameters.mass_properties import BodyMasses
    from stagecad.solids.artefacts.part import BuiltPart


class Solids(Result):
    """The parts with their mass properties, and every instance of them in the machine.

    Attributes:
        parts: by name.
        instances: of the parts, with their frames seated and in the exploded view.
        masses: of the moving body and of the tip.
    """

    def __init__(
        self, design: Design, parts: dict[str, BuiltPart], instances: Sequence[Instance], masses: BodyMasses
    ) -> None:
        self.design, self.parts, self.instances, self.masses = design, parts, tuple(instances), masses

    @cached_property
    def _masses(self) -> dict[str, Any]:
        from stagecad.friction_stage.assembly.machine import part_mass

        return {name: part_mass(part, self.design.values).as_json() for name, part in self.parts.items()}

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each part: mass (kg), volume (m^3), material, and how many there are; index `part`."""
        import pandas as pd

        rows = [
            {
                "part": name,
                "mass": self._masses[name]["mass"]["value"],
                "volume": self._masses[name]["volume"]["value"],
                "material": part.material,
                "count": sum(one.part == name for one in self.instances),
            }
            for name, part in self.parts.items()
        ]
        return pd.DataFrame(rows).set_index("part")

    def to_json(self) -> dict[str, Any]:
        """The parts as in `stagecad parts --json`, each with the key of its mesh in the cache and what it reads.

        Frames are (3 x 4) rows of rotation and shift in mm, seated and in the exploded view.
        """
        more = {
            name: {
                "key": part.entry.key,
                "material": part.material,
                "description": part.description,
                "reads": [path for path in part.entry.reads if "." in path],
            }
            for name, part in self.parts.items()
        }
        return finite(
            {
                "digest": self.design.values.digest,
                "parts": {name: {**self._masses[name], **more[name]} for name in self.parts},
                "instances": [
                    {"name": one.name, "part": one.part, "frame": _rows(one.frame), "exploded": _rows(one.exploded)}
                    for one in self.instances
                ],
                "moving_body": self.masses.moving.as_json(),
                "tip": self.masses.tip.as_json(),
            }
        )

    def __repr__(self) -> str:
        return f"<Solids of '{self.design.values.file}': {len(self.parts)} parts, {len(self.instances)} instances>"


def _rows(frame: Any) -> list[list[float]]:
    return [[*row, shift] for row, shift in zip(frame.rotation, frame.shift)]


def solids(design: Design | None = None, progress: ProgressCallback | None = None) -> Solids:
    """The parts of a design, from the cache or made now in this process, which keeps the CAD kernel loaded.

    Args:
        design: the packaged machine when left out.
        progress: called with the name of a part, the parts done, and their number.

    Raises:
        InputError: a part that the CAD kernel cannot make.
    """
    from stagecad.friction_stage.assembly.assemble import assemble
    from stagecad.friction_stage.assembly.machine import body_masses
    from stagecad.solids.artefacts.part import build_parts
    from stagecad.solids.artefacts.store import ArtefactStore
    from stagecad.solids.modelling.registry import part_names

    design = design or load_design()
    names, count = part_names(design.values), 0

    def advance(part: str) -> None:
        nonlocal count
        count += 1
        if progress is not None:
            progress(part.replace("_", " "), count, len(names))

    parts = build_parts(ArtefactStore(), names, design.values, advance, isolate=False)
    return Solids(design, parts, assemble(parts, design.values), body_masses(design.values))
