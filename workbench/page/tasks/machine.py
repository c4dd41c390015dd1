"""Jobs of the machine view: solids and drawings."""

from pathlib import Path
from typing import Any

from workbench.operations.design import Design, load_design
from workbench.operations.drawings import sheets as sheets_of
from workbench.operations.parts import solids as solids_of
from workbench.page.job_process import Report


def design_of(text: str | None, name: str, overrides: dict[str, str], rules: bool = True) -> Design:
    """The design of the page: a parameter file by its text (None: the packaged one), and the changes made to it."""
    return load_design(Path(name) if name else None, overrides, text, rules)


def solids(text: str | None, name: str, overrides: dict[str, str], folder: str, report: Report) -> dict[str, Any]:
    """The parts and where they stand in the machine; the mesh of a part is in the cache under its key."""
    return solids_of(design_of(text, name, overrides), report)


def drawings(
    text: str | None, name: str, overrides: dict[str, str], subject: str, folder: str, report: Report
) -> dict[str, Any]:
    """The sheets of one subject: a part, the assembly, or the procedure."""
    design = design_of(text, name, overrides)
    report("drawing", 0, 0)
    return {"subject": subject, "digest": design.values.digest, "sheets": sheets_of(design, [subject])}
