"""`diff`: what differs between two designs: parameters, masses, margins, solids and drawing sheets."""

from __future__ import annotations

import os
from collections.abc import Callable, Container, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from designcalc.checks.check import Check
from designcalc.checks.report import shown, shown_margin
from designcalc.checks.run import register, run_checks
from drawings.draw_sheets import BuiltSheet, build_all_sheets, chosen_sheets
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


Rows = list[dict[str, Any]]
Margins = dict[str, tuple[Check | None, Check | None]]
"""Checks before and after by name; None where a design has no such check."""
COLUMNS = {
    "masses": ("name", "before", "after"),
    "volumes": ("part", "before", "after", "removed", "added"),
    "sheets": ("sheet", "change", "marked", "regions"),
    "code": ("file", "change"),
}
"""Keys of the rows of each kind of change; the first one names what differs."""
UNITS = {"masses": "kg", "volumes": "m^3"}


class Differences(Result):
    """What differs between two designs: parameters, margins, masses, volumes of the solids, drawing sheets.

    Attributes:
        first, second: the designs.
        names: of the two files.
        changed: parameters that differ.
        checks: whose margin or verdict differs; None where they were not compared.
        rows: of each kind of change (`COLUMNS`) that was compared: masses of parts, moving body and assembly, kg, None
            where a design lacks it; volumes of parts, and what only one design has of them, m^3, None where the
            kernel's result is not consistent; how sheets differ, the picture with the changes marked, and the number of
            changed regions; files of parts and checks, and how they differ.
    """

    def __init__(
        self,
        designs: tuple[Design, Design],
        names: tuple[str, str],
        changed: Sequence[Difference],
        checks: Margins | None,
        rows: Mapping[str, Rows],
    ) -> None:
        self.first, self.second = designs
        self.names, self.changed, self.checks, self.rows = names, changed, checks, rows

    @property
    def parameters(self) -> pd.DataFrame:
        """Parameters that differ: text and origin in both designs (none where a design lacks it); index `key`."""
        columns = ("key", "before", "after", "origin_before", "origin_after")
        rows = [
            (c.key, *(side and getattr(side, name) for name in ("text", "origin") for side in (c.before, c.after)))
            for c in self.changed
        ]
        return frame(rows, "key", columns=columns)

    @property
    def margins(self) -> pd.DataFrame:
        """Checks whose margin or verdict differs, those with another verdict first; index `check`.

        A margin is a part of the limit, negative where the check fails.
        """
        columns = ("check", "margin_before", "margin_after", "verdict_before", "verdict_after")
        pairs = (self.checks or {}).items()
        rows = [(name, *(check and check.margin for check in pair), *_verdicts(*pair)) for name, pair in pairs]
        return frame(rows, "check", columns=columns)

    @property
    def masses(self) -> pd.DataFrame:
        """Masses that differ, kg; index `name`: of parts, `moving body`, `assembly`."""
        return self._frame("masses")

    @property
    def volumes(self) -> pd.DataFrame:
        """Parts whose solids differ: volumes, and what only one of them has, m^3; index `part`."""
        return self._frame("volumes")

    @property
    def sheets(self) -> pd.DataFrame:
        """Sheets that differ: how, picture with the changes marked, number of changed regions; index `sheet`."""
        return self._frame("sheets")

    def _frame(self, name: str) -> pd.DataFrame:
        return frame(self.rows.get(name, ()), COLUMNS[name][0], columns=COLUMNS[name])

    def to_dataframe(self) -> pd.DataFrame:
        """The parameters."""
        return self.parameters

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad diff --json`, of what was compared."""
        document: dict[str, Any] = {
            "files": list(self.names),
            "parameters": [difference_json(change) for change in self.changed],
        }
        if self.checks is not None:
            document["margins"] = [
                {"name": name, "before": _check_json(before), "after": _check_json(after)}
                for name, (before, after) in self.checks.items()
            ]
        for name, (first, *_) in COLUMNS.items():
            unit = UNITS.get(name)
            if name in self.rows:
                document[name] = [
                    row if unit is None else {k: v if k == first else _quantity(v, unit) for k, v in row.items()}
                    for row in self.rows[name]
                ]
        return finite(document)

    def plot(self) -> Figure:
        """Margins before and after, of the checks whose margin differs."""
        return design_figures.changed_margins_figure(self.margins)

    def summary(self) -> list[tuple[str, str]]:
        verdicts = {name: _verdicts(*pair) for name, pair in (self.checks or {}).items()}
        facts = [("verdict", f"{name}: {one} -> {other}") for name, (one, other) in verdicts.items() if one != other]
        return facts + [("sheet", f"{row['sheet']}: {row['change']}") for row in self.rows.get("sheets", ())]

    def lines(self) -> list[Line]:
        """One table for each kind of difference; nothing for a kind without any."""
        lines: list[Line] = []
        if self.changed or not (self.checks or any(self.rows.values())):
            lines = difference_lines(*self.names, self.changed)
        lines += [f"file {row['file']}: {row['change']}" for row in self.rows.get("code", ())]
        if masses := self.rows.get("masses"):
            rows = [[row["name"], _amount(row["before"]), _amount(row["after"])] for row in masses]
            lines.append(plain_table("mass", "|first|second", rows))
        if volumes := self.rows.get("volumes"):
            rows = [
                [name, *("-" if one is None else f"{one * 1e6:.4f} cm^3" for one in numbers)]
                for name, *numbers in map(dict.values, volumes)
            ]
            lines.append(plain_table("solids", "part|first|second|removed|added", rows))
        if self.checks:
            rows = [
                [name, *map(_margin, pair), " -> ".join(dict.fromkeys(_verdicts(*pair)))]
                for name, pair in self.checks.items()
            ]
            lines.append(plain_table("margins", "check|first|second|verdict", rows, "check|verdict"))
        for row in self.rows.get("sheets", ()):
            where = f", marked in {row['marked']} ({row['regions']} regions)" if row["marked"] else ""
            lines.append(f"sheet {row['sheet']}: {row['change']}{where}")
        return lines

    def __repr__(self) -> str:
        counts = {"parameters": self.changed, "margins": self.checks}
        counts |= {name: self.rows.get(name) for name in ("masses", "sheets")}
        texts = [f"{len(changes)} {name}" for name, changes in counts.items() if changes is not None]
        first, second = self.names
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

    def advance(step: str) -> None:
        progress(step, 0, 0)

    machines = [build_machine(one, None, advance) for one in values] if solids else []
    checks, rows = None, dict[str, Rows]()
    if margins:
        advance("margins")
        bodies = [machine.checked_masses for machine in machines] or [None, None]
        checks = margin_changes(*(_checks(one, masses) for one, masses in zip(designs, bodies, strict=True)))
    if solids:
        advance("volumes")
        rows = {"masses": mass_changes(*machines), "volumes": volume_changes(*machines)}
        rows["sheets"] = sheet_changes(*values, Path(out) / "diff", advance)
    if solids or margins:
        rows["code"] = code_changes(*designs)
    names = names or (values[0].file, values[1].file)
    return Differences(designs, names, parameter_differences(*values), checks, rows)


def _checks(design: Design, masses: Masses | None) -> list[Check]:
    """The checks of a design, of the user's own those beside its file."""
    register(design.check_files)
    return run_checks(design.values, masses, files=design.check_files)


def _verdicts(before: Check | None, after: Check | None) -> tuple[str, str]:
    """Verdicts in both designs, `absent` for no check."""
    return before.verdict if before else "absent", after.verdict if after else "absent"


def _check_json(check: Check | None) -> dict[str, Any] | None:
    if check is None:
        return None
    value, limit = (_quantity(number, check.unit) for number in (check.value, check.limit))
    return {"value": value, "limit": limit, "margin": check.margin, "verdict": check.verdict}


def _amount(value: float | None) -> str:
    return "absent" if value is None else format_quantity(value, "kg", 6)


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


def margin_changes(before: Sequence[Check], after: Sequence[Check]) -> Margins:
    """Checks whose margin or verdict differs; those whose verdict differs come first."""
    one, other = ({check.name: check for check in checks} for checks in (before, after))
    pairs = {name: (one.get(name), other.get(name)) for name in {**one, **other}}
    alike = {name: len(set(_verdicts(*pair))) == 1 for name, pair in pairs.items()}
    kept = [
        name for name, pair in pairs.items() if not (alike[name] and _same(*(check and check.margin for check in pair)))
    ]
    return {name: pairs[name] for name in sorted(kept, key=alike.__getitem__)}


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

    def drawn(design: Values) -> dict[str, BuiltSheet]:
        made = build_all_sheets(ArtefactStore(), chosen_sheets((), design), design, advance, calculate=procedure_values)
        return {sheet.name: sheet for sheets in made.values() for sheet in sheets}

    one, other, changes = drawn(before), drawn(after), []
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
    labelled: Any = ndimage.label(ndimage.binary_dilation(changed, iterations=max(width // 120, 1)))
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
