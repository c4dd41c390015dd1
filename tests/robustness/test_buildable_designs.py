"""Random designs that satisfy the rules: every part of each can be made, or one line names the parameters."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError, PartError
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import build_part
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.modelling.registry import part_names
from tests.robustness.mutation import count
from workbench.machine.refusal import refusal_line

pytestmark = pytest.mark.slow
PACKAGED = load_design()
LENGTHS = [entry.key for entry in PACKAGED.entries if entry.unit == "mm"]


def _random(random: np.random.Generator) -> Design | None:
    """A design with one to six lengths changed, seldom by much; None if a rule forbids it."""
    keys = random.choice(LENGTHS, int(random.integers(1, 7)), replace=False)
    factors = np.exp(random.normal(0.0, 0.3 if random.random() < 0.8 else 1.2, keys.size))
    try:
        return load_design(
            None, [f"{key}={PACKAGED.value(key) * factor:.6g} mm" for key, factor in zip(keys, factors, strict=True)]
        )
    except InputError:
        return None


def test_parts_of_random_designs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    random, found, store = np.random.default_rng(5), Counter[str](), ArtefactStore(tmp_path)
    while found["designs"] < count(200):
        design = _random(random)
        found["drawn"] += 1
        if design is None:
            continue
        found["designs"] += 1
        for name in part_names(design):
            try:
                build_part(store, name, design)
                found["parts"] += 1
            except PartError as error:
                line = refusal_line(error)
                assert line is not None and f"'{name}'" in line and " = " in line
                found["refused by the kernel"] += 1
    with capsys.disabled():
        print(f"\nrandom designs: {dict(found)}")  # noqa: T201
