"""Jobs of the machine view: solids, drawings, optimisation."""

from __future__ import annotations

from typing import Any

from workbench.machine.design_source import DesignSource
from workbench.page.job_process import Report


def solids(text: str | None, name: str, overrides: list[str], folder: str, report: Report) -> dict[str, Any]:
    """The parts and where they stand in the machine; the mesh of a part is in the cache under its key.

    Frames are (3 x 4) rows of rotation and shift in mm, seated and in the exploded view.
    """
    from stagecad.solids.artefacts.part import build_parts
    from stagecad.solids.artefacts.store import ArtefactStore
    from stagecad.solids.assembly.assemble import assemble
    from stagecad.solids.assembly.machine import body_masses, part_mass
    from stagecad.solids.modelling.registry import part_names

    design = DesignSource(text, name, tuple(overrides)).design()
    names = part_names(design)
    count = 0

    def advance(part: str) -> None:
        nonlocal count
        count += 1
        report(part.replace("_", " "), count, len(names))

    # This process keeps the CAD kernel loaded, and a crash of it ends the job alone.
    parts = build_parts(ArtefactStore(), names, design, advance, isolate=False)
    masses = body_masses(design)
    found = {
        part: {
            "key": built.entry.key,
            "material": built.material,
            "description": built.description,
            **part_mass(built, design).as_json(),
            "reads": [path for path in built.entry.reads if "." in path],
        }
        for part, built in parts.items()
    }
    instances = [
        {"name": one.name, "part": one.part, "frame": _rows(one.frame), "exploded": _rows(one.exploded)}
        for one in assemble(parts, design)
    ]
    return {
        "digest": design.digest,
        "parts": found,
        "instances": instances,
        "moving_body": masses.moving.as_json(),
        "tip": masses.tip.as_json(),
    }


def _rows(frame: Any) -> list[list[float]]:
    return [[*row, shift] for row, shift in zip(frame.rotation, frame.shift)]


def drawings(
    text: str | None, name: str, overrides: list[str], subject: str, folder: str, report: Report
) -> dict[str, Any]:
    """The sheets of one subject: a part, the assembly, or the procedure."""
    from drawings.artefacts.names import chosen_sheets
    from drawings.artefacts.tasks import build_all_sheets
    from stagecad.solids.artefacts.store import ArtefactStore
    from workbench.machine.artefacts import procedure_values

    design = DesignSource(text, name, tuple(overrides)).design()
    wanted = chosen_sheets((subject,), design)
    report("drawing", 0, 0)
    made = build_all_sheets(ArtefactStore(), wanted, design, calculate=procedure_values)
    sheets = [
        {
            "name": sheet.name,
            "part": sheet.part,
            "paper": sheet.paper,
            "scale": sheet.scale,
            "views": list(sheet.views),
            "hits": list(sheet.hits),
            "key": sheet.artefact.key,
            "files": list(sheet.files),
        }
        for part in wanted
        for sheet in made[part]
    ]
    return {"subject": subject, "digest": design.digest, "sheets": sheets}
