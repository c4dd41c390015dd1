"""Manual changes of sheets, from `sheets.toml` beside the parameter file: they survive changes of parameters.

```toml
[stage]                                   # name of a sheet
paper = "A1"
scale = "1:2"
move = [{dimension = "length", by = ["10 mm", "-5 mm"]}]          # on the paper, to the right and up
note = [{text = "Engrave the serial number here.", at = ["40 mm", "60 mm"]}, {text = "Pack in foil."}]
view = [{projection = "left"}]
section = [{letter = "B", projection = "right", at = ["20 mm", "0 mm", "0 mm"]}]      # through a point of the part
# offset, through several points: at = [[...], [...]]; kind = "half": beyond the point, to the right or towards a second
# one; kind = "aligned": through two
detail = [{letter = "Z", projection = "top", at = ["75 mm", "100 mm", "12 mm"], radius = "8 mm", scale = "2:1"}]
```

What no longer applies (a dimension that is not on the sheet any more, a letter that another section has) is reported.
"""

import json
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from drawings.annotations.annotation import Annotation, Callout, Note
from drawings.annotations.annotation import MeasuredDimension as Measured
from drawings.sheets.frame import PAPERS
from drawings.sheets.plans import SheetPlan, ViewPlan
from drawings.views.view import PROJECTIONS, Point2, section_cut
from stagecad.parameters.errors import InputError, nearest, require, require_known
from stagecad.parameters.input_file import read_input
from stagecad.parameters.units import parse_quantity

FILE = "sheets.toml"
KEYS = {
    "paper": (),
    "scale": (),
    "move": ("dimension", "by"),
    "note": ("text", "at"),
    "view": ("projection",),
    "detail": ("letter", "projection", "at", "radius", "scale"),
    "section": ("letter", "projection", "at", "kind"),
}
"""Keys of a sheet, and of the tables in their lists."""
OPTIONAL = {"note": ("at",), "section": ("kind",)}


@dataclass(frozen=True)
class Overrides:
    """Changes of one sheet, lengths in mm."""

    # paper, scale: None for that of the plan
    paper: str | None = None
    scale: float | None = None
    moves: tuple[tuple[str, Point2], ...] = ()  # name of a dimension, and shift of its text and lines on the paper
    notes: tuple[tuple[str, Point2 | None], ...] = ()  # text, and place on the paper; None for a line of the notes
    views: tuple[ViewPlan, ...] = ()  # additional ones


def read_overrides(path: Path, sheets: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """The changes in a file, by sheet, as JSON texts for `Design.sheets`."""
    try:
        document = tomllib.loads(read_input(path).decode("utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from None
    for name, changes in document.items():
        require_known(name, sheets, f"{path}: no sheet '{name}' of a part")
        require(isinstance(changes, dict), f"{path}: {name}: write a table like [{name}]")
        _parsed(changes, f"{path}: [{name}]")
    return tuple((name, json.dumps(changes, sort_keys=True)) for name, changes in document.items())


def overrides_of(design: Any, sheet: str) -> Overrides:
    """The changes of one sheet of a design."""
    text = design.sheet_settings(sheet)
    return _parsed(json.loads(text), f"{FILE}: [{sheet}]") if text else Overrides()


def _parsed(changes: Mapping[str, Any], place: str) -> Overrides:
    for key in changes:
        require_known(key, KEYS, f"{place}: no key '{key}'")
    paper = changes.get("paper")
    require(paper is None or paper in PAPERS, f"{place}: paper = '{paper}'; allowed: {', '.join(PAPERS)}")
    lists = {key: _tables(changes, key, place) for key in ("move", "note", "view", "detail", "section")}
    names = [_projection(one["projection"], f"{place}: view") for one in lists["view"]]
    return Overrides(
        paper,
        _scale(changes["scale"], f"{place}: scale") if "scale" in changes else None,
        tuple((str(one["dimension"]), _point(one["by"], 2, f"{place}: move")) for one in lists["move"]),
        tuple(
            (str(one["text"]), _point(one["at"], 2, f"{place}: note") if "at" in one else None) for one in lists["note"]
        ),
        (
            *(ViewPlan(name, name) for name in names),
            *(_detail(one, f"{place}: detail") for one in lists["detail"]),
            *(_section(one, f"{place}: section") for one in lists["section"]),
        ),
    )


def _tables(changes: Mapping[str, Any], key: str, place: str) -> list[dict[str, Any]]:
    found = changes.get(key, [])
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        raise InputError(f"{place}: {key} is a list of tables, like {key} = [{{{KEYS[key][0]} = ...}}]")
    for one in found:
        for name in one:
            require_known(name, KEYS[key], f"{place}: {key} has no '{name}'")
        optional = OPTIONAL.get(key, ())
        for name in KEYS[key]:
            require(name in one or name in optional, f"{place}: {key} without '{name}'")
    return found


def _point(values: Any, count: int, place: str) -> Any:
    if not isinstance(values, list) or len(values) != count:
        raise InputError(f"{place}: write {count} lengths, like {['10 mm'] * count}")
    return tuple(_length(value, place) for value in values)


def _length(value: Any, place: str) -> float:
    return 1e3 * parse_quantity(value, "m", place)


def _scale(text: Any, place: str) -> float:
    over, colon, under = str(text).partition(":")
    if not (colon and over.strip().isdigit() and under.strip().isdigit() and int(over) and int(under)):
        raise InputError(f"{place} = '{text}'; write it like 1:2 or 5:1")
    return int(over) / int(under)


def _projection(name: Any, place: str) -> str:
    if name not in PROJECTIONS:
        raise InputError(f"{place}: projection = '{name}'{nearest(str(name), list(PROJECTIONS))}")
    return name


def _detail(table: Mapping[str, Any], place: str) -> ViewPlan:
    letter = str(table["letter"])
    at = _point(table["at"], 3, place)
    radius = _length(table["radius"], place)
    return ViewPlan(
        f"detail {letter}",
        _projection(table["projection"], place),
        detail=(at, radius),
        letter=letter,
        scale=_scale(table["scale"], f"{place}: scale"),
    )


def _section(table: Mapping[str, Any], place: str) -> ViewPlan:
    """A section through a point or along several, seen as a view from outside is."""
    letter, projection = str(table["letter"]), _projection(table["projection"], place)
    several = isinstance(table["at"], list) and all(isinstance(one, list) for one in table["at"])
    points = [_point(one, 3, place) for one in (table["at"] if several else [table["at"]])]
    try:
        cut = section_cut(projection, points, letter, table.get("kind", "offset"))
    except ValueError as error:
        raise InputError(f"{place}: {error}") from None
    return ViewPlan(f"section {letter}-{letter}", projection, "front", cut=cut)


def changed_plan(plan: SheetPlan, overrides: Overrides) -> tuple[SheetPlan, list[str]]:
    """The plan of a sheet with paper, scale and views changed, and what does not apply."""
    problems = []
    views = list(plan.views)
    for view in overrides.views:
        if any(view.name == other.name and (other.cut or other.detail) for other in views):
            problems.append(f"{FILE}: [{plan.name}] the sheet has a view '{view.name}' already")
        elif all(view.name != other.name for other in views):
            views.append(view)
    papers = (overrides.paper,) if overrides.paper else plan.papers
    return replace(plan, papers=papers, scale=overrides.scale or plan.scale, views=tuple(views)), problems  # type: ignore[arg-type]


def moved(
    annotations: Sequence[Annotation], overrides: Overrides, sheet: str
) -> tuple[tuple[Annotation, ...], list[str]]:
    """The annotations of a sheet with those moved that the file names, and what does not apply."""

    names = [name for one in annotations for name in _names(one)]
    problems = [
        f"{FILE}: [{sheet}] no dimension '{name}' on the sheet{nearest(name, names)}"
        for name, _ in overrides.moves
        if name not in names
    ]
    found = []
    for annotation in annotations:
        for name, by in overrides.moves:
            if name in _names(annotation):
                annotation = annotation.translated(by)
        found.append(annotation)
    return tuple(found), problems


def _names(annotation: Annotation) -> tuple[str, ...]:
    return annotation.names if isinstance(annotation, Measured | Callout) else ()


def placed_notes(overrides: Overrides) -> tuple[Note, ...]:
    """The notes with a place of their own."""
    return tuple(Note(at, (text,)) for text, at in overrides.notes if at is not None)


def listed_notes(overrides: Overrides) -> tuple[str, ...]:
    """The notes that are lines of the sheet's notes."""
    return tuple(f"- {text}" for text, at in overrides.notes if at is None)
