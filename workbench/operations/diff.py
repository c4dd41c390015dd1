"""`diff`: what differs between two designs: parameters, masses, margins, solids and drawing sheets."""

from __future__ import annotations

import os
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from designcalc.checks.check import Check
from designcalc.checks.report import shown, shown_margin
from designcalc.checks.run import register, run_checks
from drawings.draw_sheets import build_all_sheets, chosen_sheets
from stagecad.deferred import pd
from stagecad.parameters.atomic import atomic_path
from stagecad.parameters.design import Design as Values
from stagecad.parameters.load import Difference
from stagecad.parameters.load import diff as parameter_differences
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.units import as_json, format_quantity
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.built_machine import BuiltMachine, build_machine
from workbench.figures import Figure
from workbench.figures import design as design_figures
from workbench.operations.design import Design, as_design
from workbench.operations.drawings import procedure_values
from workbench.operations.parameters import difference_json, difference_lines
from workbench.operations.result import Line, ProgressCallback, Result, finite, frame, plain_table, silent

ROUNDING = 1e-9
"""Relative difference of two numbers that is not a difference."""
CLOSURE = 1e-6
"""Relative error of volumes beyond which the kernel's difference of two solids is not believed."""


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


Rows = list[dict[str, Any]]
COLUMNS = {
    "masses": ("name", "before", "after"),
    "volumes": ("part", "before", "after", "removed", "added"),
    "sheets": ("sheet", "change", "marked", "regions"),
    "code": ("file", "change"),
}
"""Keys of the rows of each kind of change; the first one names what differs."""
UNITS = {"masses": "kg", "volumes": "m^3"}


@dataclass(frozen=True)
class Changes:
    """What differs between two designs; None for what was not compared."""

    names: tuple[str, str]  # of the two files
    parameters: tuple[Difference, ...]
    margins: list[MarginChange] | None = None
    masses: Rows | None = None  # of parts, moving body and assembly, kg; None where a design lacks it
    # of parts, and what only one design has of them, m^3; None where the kernel's result is not consistent
    volumes: Rows | None = None
    # how each differs, the picture with the changes marked, and the number of changed regions
    sheets: Rows | None = None
    code: Rows | None = None  # files of parts and checks that differ, and how

    def as_json(self) -> dict[str, Any]:
        """As a JSON document."""
        document: dict[str, Any] = {
            "files": list(self.names),
            "parameters": [difference_json(change) for change in self.parameters],
        }
        if self.margins is not None:
            document["margins"] = [change.as_json() for change in self.margins]
        for name, (first, *_) in COLUMNS.items():
            rows, unit = getattr(self, name), UNITS.get(name)
            if rows is not None:
                document[name] = [
                    row if unit is None else {k: v if k == first else _quantity(v, unit) for k, v in row.items()}
                    for row in rows
                ]
        return document


class Differences(Result):
    """What differs between two designs: parameters, margins, masses, volumes of the solids, drawing sheets.

    Attributes:
        first, second: the designs.
        changes: as data.
    """

    def __init__(self, first: Design, second: Design, changes: Changes) -> None:
        self.first, self.second, self.changes = first, second, changes

    @property
    def parameters(self) -> pd.DataFrame:
        """Parameters that differ: text and origin in both designs (none where a design lacks it); index `key`."""
        columns = ("key", "before", "after", "origin_before", "origin_after")
        rows = [
            (c.key, *(side and getattr(side, name) for name in ("text", "origin") for side in (c.before, c.after)))
            for c in self.changes.parameters
        ]
        return frame(rows, "key", columns=columns)

    @property
    def margins(self) -> pd.DataFrame:
        """Checks whose margin or verdict differs, those with another verdict first; index `check`.

        A margin is a part of the limit, negative where the check fails.
        """
        columns = ("check", "margin_before", "margin_after", "verdict_before", "verdict_after")
        rows = [
            (c.name, c.before and c.before.margin, c.after and c.after.margin, *c.verdicts)
            for c in self.changes.margins or ()
        ]
        return frame(rows, "check", columns=columns)

    @property
    def masses(self) -> pd.DataFrame:
        """Masses that differ, kg; index `name`: of parts, `moving body`, `assembly`."""
        return self._rows("masses")

    @property
    def volumes(self) -> pd.DataFrame:
        """Parts whose solids differ: volumes, and what only one of them has, m^3; index `part`."""
        return self._rows("volumes")

    @property
    def sheets(self) -> pd.DataFrame:
        """Sheets that differ: how, picture with the changes marked, number of changed regions; index `sheet`."""
        return self._rows("sheets")

    def _rows(self, name: str) -> pd.DataFrame:
        return frame(getattr(self.changes, name) or (), COLUMNS[name][0], columns=COLUMNS[name])

    def to_dataframe(self) -> pd.DataFrame:
        """The parameters."""
        return self.parameters

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad diff --json`, of what was compared."""
        return finite(self.changes.as_json())

    def plot(self) -> Figure:
        """Margins before and after, of the checks whose margin differs."""
        return design_figures.changed_margins_figure(self.margins)

    def summary(self) -> list[tuple[str, str]]:
        verdicts = [change for change in self.changes.margins or () if len(set(change.verdicts)) == 2]
        facts = [("verdict", f"{change.name}: {change.verdicts[0]} -> {change.verdicts[1]}") for change in verdicts]
        return facts + [("sheet", f"{row['sheet']}: {row['change']}") for row in self.changes.sheets or ()]

    def lines(self) -> list[Line]:
        """One table for each kind of difference; nothing for a kind without any."""
        changes, lines = self.changes, []
        if changes.parameters or not any(
            (changes.code, changes.margins, changes.masses, changes.volumes, changes.sheets)
        ):
            lines = difference_lines(*changes.names, changes.parameters)
        lines += [f"file {row['file']}: {row['change']}" for row in changes.code or ()]
        if changes.masses:
            rows = [[row["name"], _amount(row["before"]), _amount(row["after"])] for row in changes.masses]
            lines.append(plain_table("mass", "|first|second", rows))
        if changes.volumes:
            rows = [[name, *map(_volume, numbers)] for name, *numbers in map(dict.values, changes.volumes)]
            lines.append(plain_table("solids", "part|first|second|removed|added", rows))
        if changes.margins:
            rows = [
                [item.name, _margin(item.before), _margin(item.after), " -> ".join(dict.fromkeys(item.verdicts))]
                for item in changes.margins
            ]
            lines.append(plain_table("margins", "check|first|second|verdict", rows, "check|verdict"))
        for row in changes.sheets or ():
            where = f", marked in {row['marked']} ({row['regions']} regions)" if row["marked"] else ""
            lines.append(f"sheet {row['sheet']}: {row['change']}{where}")
        return lines

    def __repr__(self) -> str:
        names = ("parameters", "margins", "masses", "sheets")
        counts = {name: getattr(self.changes, name) for name in names}
        texts = [f"{len(changes)} {name}" for name, changes in counts.items() if changes is not None]
        first, second = self.changes.names
        return f"<Differences of '{first}' and '{second}': {', '.join(texts)}>"


def diff(
    first: Design | str | Path,
    second: Design | str | Path,
    solids: bool = True,
    margins: bool = True,
    out: str | Path = "build",
    progress: ProgressCallback = silent,
    names: tuple[str, str] | None = None,
) -> Differences:
    """What differs between two designs.

    Args:
        first, second: designs, or their parameter files.
        solids: compare masses, volumes and drawing sheets too, for which solids and sheets are made where the cache
            lacks them; the margins are then those with the masses of the solids.
        margins: compare the margins of the checks.
        out: folder; the sheets that differ are written to `diff` in it, their changes marked.
        progress: called with the name of a step; the number of steps is not known.
        names: of the designs in the result; those of their files when left out.

    Raises:
        InputError: one line on the fault in a file.

    >>> import stagecad
    >>> design = stagecad.load_design()
    >>> thicker = design.with_values({"stage.thickness": "14 mm"})
    >>> diff(design, thicker, solids=False, margins=False).parameters.loc["stage.thickness", "after"]
    '14 mm'
    """
    designs = as_design(first), as_design(second)
    values = designs[0].values, designs[1].values
    names = names or (values[0].file, values[1].file)
    parameters = parameter_differences(*values)
    if not solids:
        if not margins:
            return Differences(*designs, Changes(names, parameters))
        progress("margins", 0, 0)
        changed = margin_changes(*(_checks(one, None) for one in designs))
        return Differences(*designs, Changes(names, parameters, changed, code=code_changes(*designs)))
    changes = _with_solids(designs, names, parameters, margins, Path(out) / "diff", progress)
    return Differences(*designs, changes)


def _checks(design: Design, masses: Masses | None) -> list[Check]:
    """The checks of a design, of the user's own those beside its file."""
    register(design.check_files)
    return run_checks(design.values, masses, files=design.check_files)


def _with_solids(
    designs: tuple[Design, Design],
    names: tuple[str, str],
    parameters: tuple[Difference, ...],
    margins: bool,
    folder: Path,
    progress: ProgressCallback,
) -> Changes:
    """Masses, margins, volumes and sheets of both designs; sheets that differ are written to `folder`."""

    def advance(name: str) -> None:
        progress(name, 0, 0)

    values = designs[0].values, designs[1].values
    machines = [build_machine(one, None, advance) for one in values]
    changed = None
    if margins:
        progress("margins", 0, 0)
        bodies = [machine.checked_masses for machine in machines]
        changed = margin_changes(*(_checks(one, masses) for one, masses in zip(designs, bodies, strict=True)))
    progress("volumes", 0, 0)
    volumes = volume_changes(*machines)
    sheets = sheet_changes(*values, folder, advance)
    return Changes(names, parameters, changed, mass_changes(*machines), volumes, sheets, code_changes(*designs))


def _amount(value: float | None) -> str:
    return "absent" if value is None else format_quantity(value, "kg", 6)


def _volume(value: float | None) -> str:
    return "-" if value is None else f"{value * 1e6:.4f} cm^3"


def _margin(check: Check | None) -> str:
    return "absent" if check is None else f"{shown(check.value, check.unit)} ({shown_margin(check)})"


def _quantity(value: float | None, unit: str) -> dict[str, Any] | None:
    return None if value is None else as_json(value, unit)


def _same(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return abs(one - other) <= ROUNDING * max(abs(one), abs(other))


def mass_changes(before: BuiltMachine, after: BuiltMachine) -> Rows:
    """Parts, moving body and assembly whose mass differs."""

    def masses(machine: BuiltMachine) -> dict[str, float]:
        moving = {"moving body": machine.moving_body} if machine.moving_body else {}
        return {name: one.mass for name, one in {**machine.masses, **moving, "assembly": machine.whole}.items()}

    one, other = masses(before), masses(after)
    changes = [{"name": name, "before": one.get(name), "after": other.get(name)} for name in {**one, **other}]
    return [change for change in changes if not _same(change["before"], change["after"])]


def margin_changes(before: Sequence[Check], after: Sequence[Check]) -> list[MarginChange]:
    """Checks whose margin or verdict differs; those whose verdict differs come first."""
    one, other = ({check.name: check for check in checks} for checks in (before, after))
    changes = [MarginChange(name, one.get(name), other.get(name)) for name in dict.fromkeys([*one, *other])]
    differ = [
        change
        for change in changes
        if len(set(change.verdicts)) == 2
        or not _same(change.before and change.before.margin, change.after and change.after.margin)
    ]
    return sorted(differ, key=lambda change: len(set(change.verdicts)) == 1)


def volume_changes(before: BuiltMachine, after: BuiltMachine) -> Rows:
    """Parts whose solids differ, with the volumes of the two differences of the solids, in the part's coordinates."""
    changes = []
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
        changes.append(dict(zip(COLUMNS["volumes"], (name, *volumes, *parts), strict=True)))
    return changes


def code_changes(before: Design, after: Design) -> Rows:
    """Files of the user's own parts and checks that differ, by their place beside the parameter file."""

    def contents(design: Design) -> dict[str, bytes]:
        folder = (design.path or Path()).parent
        return {os.path.relpath(file, folder): Path(file).read_bytes() for file in design.own_files}

    one, other = contents(before), contents(after)
    return [
        {"file": name, "change": _presence(name, one, other)}
        for name in {**one, **other}
        if one.get(name) != other.get(name)
    ]


def _presence(name: str, one: Container[str], other: Container[str]) -> str:
    return "changed" if name in one and name in other else f"only in the {'first' if name in one else 'second'}"


def sheet_changes(
    before: Values, after: Values, folder: Path, advance: Callable[[str], None] = lambda name: None
) -> Rows:
    """Sheets that differ; the later one of each is written to `folder` with its changes marked."""
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
    changes = []
    for name in dict.fromkeys([*one, *other]):
        change = _presence(name, one, other)
        if change != "changed":
            changes.append({"sheet": name, "change": change, "marked": None, "regions": 0})
            continue
        picture = f"{name}.png"
        first, second = one[name].artefact, other[name].artefact
        if first.hashes[picture] == second.hashes[picture]:
            continue
        target = folder / picture
        regions = mark_changes(first.path(picture), second.path(picture), target)
        changes.append({"sheet": name, "change": change, "marked": str(target), "regions": regions})
    return changes


def mark_changes(before: Path, after: Path, target: Path) -> int:
    """Write the later picture with what is new in red, what is gone in blue, and a frame around each changed region.

    Pictures of different size are compared from their lower left corners. Returns the number of regions.
    """
    from PIL import Image, ImageDraw
    from scipy import ndimage

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
