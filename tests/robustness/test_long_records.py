"""Records of two million rows: `diagnose` takes a bounded amount of memory and finds the effect."""

import json
import sys
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from tests.experiments import record_text, state
from tests.process_state import python

ROWS = 1_000_000
"""Of each of two records."""
MOST = 2 * 1024**2
"""Of memory that all processes of the command take at their largest, kB."""

PROGRAM = """
import resource, sys
from workbench.cli import run
status = run(["diagnose", "rig", "--no-figures", "--json", "found.json"])
largest = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
print(largest)
sys.exit(status)
"""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="the largest resident memory is in kB on Linux"),
]


def _record(path: Path, seed: int) -> None:
    """Coulomb friction of 1 N with a Stribeck peak of 0.8 N, noise of 10 mN."""
    time = np.arange(ROWS) * 1e-4
    velocity = 0.02 * np.sin(2.0 * time + seed) + 0.006 * np.sin(7.0 * time)
    force = np.sign(velocity) * (1.0 + 0.8 * np.exp(-((velocity / 0.004) ** 2)))
    force += 0.01 * np.random.default_rng(seed).standard_normal(ROWS)
    parquet.write_table(
        pyarrow.table({"time [s]": time, "velocity [m/s]": velocity, "friction_force [N]": force}), path
    )


def test_a_diagnosis_of_two_million_rows_is_bounded_in_memory(tmp_path: Path) -> None:
    rig = tmp_path / "rig"
    rig.mkdir()
    records = ""
    for seed, role in ((1, "fit"), (2, "validate")):
        _record(rig / f"{role}.parquet", seed)
        records += record_text(f"{role}.parquet", role=role)
    state(rig, records, effects=["coulomb"])
    assert int(python("-c", PROGRAM, folder=tmp_path).stdout.split()[-1]) < MOST
    assert json.loads((tmp_path / "found.json").read_text("utf-8"))["effect"] == "stribeck"
