"""Records that make no sense, but are read: no traceback, and a warning above the verdict."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.sysid.slide import SIGN, TIME, VELOCITY, slide
from workbench.cli import run

FORCE = 1.5 * SIGN + 20.0 * VELOCITY


def _spikes() -> np.ndarray:
    force = FORCE.copy()
    force[np.random.default_rng(1).choice(force.size, force.size // 100, replace=False)] = 1e6
    return force


CASES = {
    "saturated": (np.clip(FORCE, -1.55, 1.55), 0.0, None),
    "saturated at the level": (np.clip(FORCE, -1.5, 1.5), 0.0, None),
    "dead": (np.zeros(TIME.size), 0.0, "in every row"),
    "dead at 1 N": (np.ones(TIME.size), 0.0, "in every row"),
    "spikes": (_spikes(), 0.01, "rows have values of 'friction_force' more than 100 times as far"),
    "noise a hundred times less than stated": (FORCE, 1e-4, "of the stated noise"),
    "huge": (1e9 + FORCE, 0.01, None),
    "tiny": (1e-12 * FORCE, 1e-14, None),
}


@pytest.mark.parametrize("name", CASES)
def test_a_comparison_ends_in_a_document_with_its_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    force, noise, said = CASES[name]
    slide(tmp_path / "rig", force, '"coulomb", "viscous"', held_out=True, noise=noise)
    assert run(["compare", str(tmp_path / "rig"), "--no-figures", "--json"]) == 0
    captured = capsys.readouterr()
    warnings = json.loads(captured.out)["warnings"]
    if said is not None:
        assert any(said in line for line in warnings), warnings
        # Above the verdict, which is the last line.
        assert captured.err.index("warning: ") < len(captured.err.rstrip().rpartition("\n")[0])
