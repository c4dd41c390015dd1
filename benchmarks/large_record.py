"""Memory and time of a command on one long record: python -m benchmarks.large_record [--command diagnose] [--rows N]

The record is a CSV file of four columns: a slide with Coulomb and viscous friction and noise. The model that is
diagnosed has no viscous friction.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROWS = 10_000_000
EXPERIMENT = """schema = 1
[rig]
kind = "velocity-drive"
[model]
effects = {effects}
[[record]]
file = "long.csv"
role = "fit"
"""


EFFECTS = {"compare": '["coulomb", "viscous"]', "diagnose": '["coulomb"]'}
"""Effects of the stated model, by command."""


def write_record(folder: Path, rows: int, command: str) -> None:
    """The experiment in `folder`, its record with this many rows at 10 kHz."""
    import pyarrow as pa
    from pyarrow import csv

    t = 1e-4 * np.arange(rows)
    slow, fast = 2.0 * np.pi * 0.4, 2.0 * np.pi * 2.92
    x = 0.03 * np.sin(slow * t) + 0.004 * np.sin(fast * t)
    v = 0.03 * slow * np.cos(slow * t) + 0.004 * fast * np.cos(fast * t)
    force = 4.0 * np.sign(v) + 8.0 * v + 0.02 * np.random.default_rng(1).standard_normal(rows)
    columns = {"time [s]": (t, 4), "position [mm]": (1e3 * x, 6), "velocity [mm/s]": (1e3 * v, 4)}
    rounded = {name: np.round(values, digits) for name, (values, digits) in columns.items()}
    csv.write_csv(pa.table({**rounded, "friction_force [N]": np.round(force, 4)}), folder / "long.csv")
    (folder / "experiment.toml").write_text(EXPERIMENT.format(effects=EFFECTS[command]))


def measure(folder: Path, command: str) -> tuple[float, float, float, str]:
    """Peak memory, bytes, processor time and time, s, of a command on the experiment in `folder`; what it printed."""
    words = [sys.executable, "-m", "workbench.cli", command, str(folder), "--no-figures", "--out", str(folder)]
    start = time.perf_counter()
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1024.0 * used.ru_maxrss, used.ru_utime + used.ru_stime, time.perf_counter() - start, done.stdout


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=ROWS)
    parser.add_argument("--command", choices=list(EFFECTS), default="compare")
    given = parser.parse_args()
    rows, command = given.rows, given.command
    with tempfile.TemporaryDirectory() as name:
        write_record(Path(name), rows, command)
        size = (Path(name) / "long.csv").stat().st_size
        memory, processor, seconds, _ = measure(Path(name), command)
    print(
        f"{command} of {rows} rows, {size / 1e6:.0f} MB of CSV: {memory / 1e9:.2f} GB of memory, {seconds:.1f} s, "
        f"{processor:.1f} s of processor time"
    )


if __name__ == "__main__":
    main()
