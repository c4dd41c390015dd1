"""Sheets of random valid designs are complete, true, and free of hits; their solids are valid and fully defined."""

import random
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from drawings.dimensions.definition import definition, notes_on_shape
from drawings.draw_sheets import PICTURES, build_sheets
from drawings.lint import lint
from drawings.sheets.part import part_sheets
from stagecad.friction_stage.construction import MADE, part_definition
from stagecad.friction_stage.parameters.derived import COMPUTED
from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.parameters.tracking import TrackedDesign, value_at
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.modelling.verification import DimensionVerifier
from tests.drawings.drawn import described, thesis
from workbench.operations.drawings import procedure_values

DESIGNS, AT_ONCE = 200, 10
SEEN: dict[str, list[dict[Any, str]]] = {}
"""What the good sheets of each part were drawn from: a design that reads the same gives the same sheets."""


@cache
def shaping() -> tuple[str, ...]:
    """Lengths and angles that shape some part, threads and computed ones left out."""
    notes: dict[Any, str] = {}
    for name in MADE:
        part_definition(name).build(TrackedDesign(thesis(), notes))
    keys = {".".join(str(step[1]) for step in way) for way in notes} - set(COMPUTED)
    return tuple(sorted(k for k in keys if thesis().entry(k).unit in ("mm", "deg") and not k.startswith("threads.")))


def random_design(seed: int) -> tuple[Design, list[str]]:
    """A design the rules accept: one to eight lengths anywhere within 30 %, some of them with odd decimals."""
    rng = random.Random(seed)
    while True:
        overrides = []
        for key in rng.sample(shaping(), rng.randint(1, 8)):
            entry, decimals = thesis().entry(key), rng.choice((0, 1, 1, 2, 3))
            overrides.append(f"{key}={entry.value * rng.uniform(0.7, 1.3):.{decimals}f} {entry.unit}")
        overrides += [f"teeth.per_iron={rng.randint(1, 3)}"] if rng.random() < 0.1 else []
        overrides += ["pads.count=4"] if rng.random() < 0.1 else []
        try:
            return load_design(overrides=overrides), overrides
        except InputError:
            continue


def faults(design: Design) -> list[str]:
    """Hits on the sheets of all parts, faces that are not defined, invalid solids, and those that measure otherwise.

    A part that reads what it did before is not drawn again.
    """
    found = []
    for name in MADE:
        if any(all(value_at(design, way) == value for way, value in notes.items()) for notes in SEEN.get(name, [])):
            continue
        notes: dict[Any, str] = {}
        reading = TrackedDesign(design, notes)
        part = described(name, reading)
        sheets = part_sheets(part, reading)
        hits = [f"{sheet.name}: {hit}" for sheet in sheets for hit in lint(sheet)]
        views = [view for sheet in sheets for view in sheet.views if view.projection.name != "iso"]
        shape, gauge = notes_on_shape(part_definition(name), reading), DimensionVerifier(part.solid)
        hits += [
            f"{name}: {one.name} measures {there}"
            for one in part.dimensions
            if (there := gauge.measure(one)) is not None and abs(there - one.value) > 1e-6
        ]
        defined = definition(gauge, part.dimensions, part.requirements, shape, views)
        hits += [f"{name}: {problem}" for problem in defined.problems]
        hits += [] if part.solid.isValid() else [f"{name}: the solid is not valid"]
        if not hits:
            SEEN.setdefault(name, []).append(notes)
        found += hits
    return found


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, DESIGNS, AT_ONCE))
def test_sheets_of_random_designs_are_free_of_hits(first: int) -> None:
    wrong = {}
    for seed in range(first, first + AT_ONCE):
        design, overrides = random_design(seed)
        if hits := faults(design):
            wrong[seed] = (overrides, hits)
    assert wrong == {}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_the_machine_s_sheets_of_some_random_designs_are_free_of_hits(seed: int, tmp_path: Path) -> None:
    design, overrides = random_design(seed)
    store = ArtefactStore(tmp_path)
    sheets = [sheet for whole in PICTURES for sheet in build_sheets(store, whole, design, procedure_values)]
    assert [sheet.name for sheet in sheets] == ["assembly", "procedure"]
    assert [hit for sheet in sheets for hit in sheet.hits] == [], overrides
