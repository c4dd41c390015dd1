"""Random designs that satisfy the rules: every part of each can be made, or one line names the parameters."""

import time
from collections import Counter

import numpy as np
import pytest

from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError, PartError
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import build_part, find_part
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.modelling.part import part_names
from tests.robustness.mutation import count
from workbench.operations.parts import refusal_line

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


@pytest.fixture(scope="module")
def own_store(tmp_path_factory: pytest.TempPathFactory) -> ArtefactStore:
    """For all designs: a part that reads the values it had before is not made again."""
    return ArtefactStore(tmp_path_factory.mktemp("designs"))


@pytest.mark.parametrize("seed", range(5, 15))
def test_parts_of_random_designs(own_store: ArtefactStore, capsys: pytest.CaptureFixture[str], seed: int) -> None:
    random, found, began = np.random.default_rng(seed), Counter[str](), time.process_time()
    while found["designs"] < count(20):
        design = _random(random)
        found["drawn"] += 1
        if design is None:
            continue
        found["designs"] += 1
        for name in part_names(design):
            known = find_part(own_store, name, design) is not None
            try:
                build_part(own_store, name, design)
                found["as before" if known else "made"] += 1
            except PartError as error:
                line = refusal_line(error)
                assert line is not None and f"'{name}'" in line and " = " in line
                found["refused by the kernel"] += 1
    with capsys.disabled():
        print(f"\nseed {seed}: {dict(found)}, {time.process_time() - began:.0f} s of processor time")  # noqa: T201
