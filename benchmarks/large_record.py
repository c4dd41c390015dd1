"""Memory and time of `stagecad compare` on one long record: python -m benchmarks.large_record [--rows 10000000]

The record is a CSV file of four columns: a slide with Coulomb and viscous friction and noise.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROWS = 10_000_000
EXPERIMENT = """schema = 1
[rig]
kind = "velocity-drive"
[model]
effects = ["coulomb", "viscous"]
[[record]]
file = "long.csv"
role = "fit"
"""


def write_record(folder: Path, rows: int) -> None:
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
    (folder / "experiment.toml").write_text(EXPERIMENT)


def measure(folder: Path) -> tuple[float, float, str]:
    """Peak memory, bytes, and processor time, s, of a comparison of the experiment in `folder`; what it printed."""
    words = [sys.executable, "-m", "workbench.cli", "compare", str(folder), "--no-figures", "--out", str(folder)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1024.0 * used.ru_maxrss, used.ru_utime + used.ru_stime, done.stdout


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=ROWS)
    rows = parser.parse_args().rows
    with tempfile.TemporaryDirectory() as name:
        write_record(Path(name), rows)
        size = (Path(name) / "long.csv").stat().st_size
        memory, seconds, _ = measure(Path(name))
    print(
        f"{rows} rows, {size / 1e6:.0f} MB of CSV: {memory / 1e9:.2f} GB of memory, {seconds:.0f} s of processor time"
    )


if __name__ == "__main__":
    main()
