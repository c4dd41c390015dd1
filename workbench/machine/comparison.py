"""Two designs compared: parameters, masses, margins, solids and drawing sheets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.load import Difference, diff
from stagecad.parameters.units import as_json
from workbench.operations.parameter_json import difference_json
from workbench.operations.progress import ProgressCallback

if TYPE_CHECKING:
    from designcalc.checks.check import Check
    from stagecad.friction_stage.assembly.machine import Machine
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import MassProperties

ROUNDING = 1e-9
"""Relative difference of two numbers that is not a difference."""
CLOSURE = 1e-6
"""Relative error of volumes beyond which the kernel's difference of two solids is not believed."""


@dataclass(frozen=True)
class MassChange:
    """Mass of a part, of the moving body or of the assembly in both designs, kg; None where a design lacks it."""

    name: str
    before: float | None
    after: float | None

    def as_json(self) -> dict[str, Any]:
        """As a JSON document."""
        return {"name": self.name, "before": _quantity(self.before, "kg"), "after": _quantity(self.after, "kg")}


@dataclass(frozen=True)
class MarginChange:
    """A check whose margin or verdict differs; None where a design has no such check."""

    name: str
    before: Check | None
    after: Check | None

    @property
    def verdicts(self) -> tuple[str, str]:
        """Verdicts in both designs, `absent` for no check."""
        before, after = (check.verdict if check else "absent" for check in (self.before, self.after))
        return before, after

    def as_json(self) -> dict[str, Any]:
        """As a JSON document."""
        found: dict[str, Any] = {"name": self.name}
        for word, check in (("before", self.before), ("after", self.after)):
            found[word] = check and {
                "value": _quantity(check.value, check.unit),
                "limit": _quantity(check.limit, check.unit),
                "margin": check.margin,
                "verdict": check.verdict,
            }
        return found


@dataclass(frozen=True)
class VolumeChange:
    """Material of a part that only one of the designs has, m^3; None where the kernel's result is not consistent."""

    part: str
    before: float
    after: float
    removed: float | None
    added: float | None

    def as_json(self) -> dict[str, Any]:
        """As a JSON document."""
        numbers = {name: getattr(self, name) for name in ("before", "after", "removed", "added")}
        return {"part": self.part, **{name: _quantity(value, "m^3") for name, value in numbers.items()}}


@dataclass(frozen=True)
class SheetChange:
    """A sheet that differs, or that only one design has; `marked`: its picture with the changes marked."""

    sheet: str
    change: str
    marked: Path | None = None
    regions: int = 0

    def as_json(self) -> dict[str, Any]:
        """As a JSON document."""
        marked = str(self.marked) if self.marked else None
        return {"sheet": self.sheet, "change": self.change, "marked": marked, "regions": self.regions}


@dataclass(frozen=True)
class DesignComparison:
    """What differs between two designs; None for what was not compared.

    Args:
        names: of the two files.
    """

    names: tuple[str, str]
    parameters: tuple[Difference, ...]
    margins: list[MarginChange] | None = None
    masses: list[MassChange] | None = None
    volumes: list[VolumeChange] | None = None
    sheets: list[SheetChange] | None = None

    def as_json(self) -> dict[str, Any]:
        """As a JSON document."""
        found: dict[str, Any] = {
            "files": list(self.names),
            "parameters": [difference_json(one) for one in self.parameters],
        }
        for name in ("margins", "masses", "volumes", "sheets"):
            changes = getattr(self, name)
            if changes is not None:
                found[name] = [one.as_json() for one in changes]
        return found


def compare_designs(
    designs: tuple[Design, Design],
    names: tuple[str, str],
    folder: Path | None,
    margins: bool = True,
    progress: ProgressCallback = lambda step, done, total: None,
) -> DesignComparison:
    """What differs between two designs.

    Args:
        designs: the first and the second.
        names: of their files.
        folder: of the sheets with their changes marked; None compares neither masses and volumes nor sheets, and takes
            the masses of the checks from plain volumes.
        margins: compare the margins of the checks.
        progress: called with what is done.
    """
    from designcalc.checks.run import run_checks

    parameters = diff(*designs)
    if folder is None:
        if not margins:
            return DesignComparison(names, parameters)
        progress("margins", 0, 0)
        before, after = (run_checks(design) for design in designs)
        return DesignComparison(names, parameters, margin_changes(before, after))
    from stagecad.friction_stage.assembly.machine import build_machine
    from stagecad.parameters.mass_properties import BodyMasses

    def advance(name: str) -> None:
        progress(name, 0, 0)

    one, other = (build_machine(design, None, advance) for design in designs)
    changed = None
    if margins:
        progress("margins", 0, 0)
        bodies = [BodyMasses(machine.moving_body, machine.masses["tip"]) for machine in (one, other)]
        before, after = (run_checks(design, masses) for design, masses in zip(designs, bodies, strict=True))
        changed = margin_changes(before, after)
    progress("volumes", 0, 0)
    volumes = volume_changes(one, other)
    sheets = sheet_changes(*designs, folder, advance)
    return DesignComparison(names, parameters, changed, mass_changes(one, other), volumes, sheets)


def _quantity(value: float | None, unit: str) -> dict[str, Any] | None:
    return None if value is None else as_json(value, unit)


def _same(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return abs(one - other) <= ROUNDING * max(abs(one), abs(other))


def mass_changes(before: Machine, after: Machine) -> list[MassChange]:
    """Parts, moving body and assembly whose mass differs."""

    def masses(machine: Machine) -> dict[str, MassProperties]:
        return {**machine.masses, "moving body": machine.moving_body, "assembly": machine.whole}

    one, other = masses(before), masses(after)
    names = list(dict.fromkeys([*one, *other]))
    found = [
        MassChange(name, one[name].mass if name in one else None, other[name].mass if name in other else None)
        for name in names
    ]
    return [change for change in found if not _same(change.before, change.after)]


def margin_changes(before: Sequence[Check], after: Sequence[Check]) -> list[MarginChange]:
    """Checks whose margin or verdict differs; those whose verdict differs come first."""
    one, other = ({check.name: check for check in checks} for checks in (before, after))
    found = [MarginChange(name, one.get(name), other.get(name)) for name in dict.fromkeys([*one, *other])]
    differ = [
        change
        for change in found
        if len(set(change.verdicts)) == 2
        or not _same(change.before and change.before.margin, change.after and change.after.margin)
    ]
    return sorted(differ, key=lambda change: len(set(change.verdicts)) == 1)


def volume_changes(before: Machine, after: Machine) -> list[VolumeChange]:
    """Parts whose solids differ, with the volumes of the two differences of the solids, in the part's coordinates."""
    found = []
    for name, one in before.parts.items():
        other = after.parts.get(name)
        if other is None or one.entry.hashes["solid.bin"] == other.entry.hashes["solid.bin"]:
            continue
        volumes = [machine.masses[name].volume for machine in (before, after)]
        removed, added = (
            first.solid.cut(second.solid).Volume() * 1e-9 for first, second in ((one, other), (other, one))
        )
        consistent = abs(volumes[0] - removed + added - volumes[1]) <= CLOSURE * max(volumes)
        if consistent and max(removed, added) <= ROUNDING * max(volumes):
            continue
        parts = (removed, added) if consistent else (None, None)
        found.append(VolumeChange(name, volumes[0], volumes[1], *parts))
    return found


def sheet_changes(before: Design, after: Design, folder: Path, advance: Any = lambda name: None) -> list[SheetChange]:
    """Sheets that differ; the later one of each is written to `folder` with its changes marked."""
    from drawings.artefacts.names import chosen_sheets
    from drawings.artefacts.tasks import build_all_sheets
    from stagecad.solids.artefacts.store import ArtefactStore
    from workbench.machine.artefacts import procedure_values

    store = ArtefactStore()
    one, other = (
        {
            sheet.name: sheet
            for sheets in build_all_sheets(
                store, chosen_sheets((), design), design, advance, calculate=procedure_values
            ).values()
            for sheet in sheets
        }
        for design in (before, after)
    )
    found = []
    for name in dict.fromkeys([*one, *other]):
        if name not in one or name not in other:
            found.append(SheetChange(name, "only in the first" if name in one else "only in the second"))
            continue
        picture = f"{name}.png"
        first, second = one[name].artefact, other[name].artefact
        if first.hashes[picture] == second.hashes[picture]:
            continue
        target = folder / picture
        regions = mark_changes(first.path(picture), second.path(picture), target)
        found.append(SheetChange(name, "changed", target, regions))
    return found


def mark_changes(before: Path, after: Path, target: Path) -> int:
    """Write the later picture with what is new in red, what is gone in blue, and a frame around each changed region.

    Pictures of different size are compared from their lower left corners. Returns the number of regions.
    """
    import numpy as np
    from PIL import Image, ImageDraw
    from scipy import ndimage

    from stagecad.parameters.atomic import atomic_path

    arrays = [np.asarray(Image.open(path).convert("L"), float) for path in (before, after)]
    height, width = (max(array.shape[axis] for array in arrays) for axis in (0, 1))
    one, other = (
        np.pad(array, ((height - array.shape[0], 0), (0, width - array.shape[1])), constant_values=255.0)
        for array in arrays
    )
    changed = np.abs(one - other) > 64
    picture = np.stack([other] * 3, axis=-1)
    picture[changed & (other < one)] = (200, 0, 0)
    picture[changed & (other >= one)] = (120, 160, 255)
    reach = max(width // 120, 1)
    labelled: Any = ndimage.label(ndimage.binary_dilation(changed, iterations=reach))
    boxes = ndimage.find_objects(labelled[0])
    image = Image.fromarray(picture.astype(np.uint8))
    draw = ImageDraw.Draw(image)
    for rows, columns in boxes:
        draw.rectangle(
            (columns.start, rows.start, columns.stop, rows.stop), outline=(230, 120, 0), width=max(width // 900, 1)
        )
    target.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(target) as temporary:
        image.save(temporary, format="PNG")
    return len(boxes)
