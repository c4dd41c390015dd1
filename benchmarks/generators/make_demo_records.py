"""The records of `stagecad demo`, made by the independent generator with a fixed seed.

    python -m benchmarks.generators.make_demo_records FOLDER

A slide is driven back and forth by a servo, and its friction is measured. Hidden in it are a Stribeck curve (a
Lorentzian here) and the cogging of magnetic teeth; the model starts with Coulomb and viscous friction.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

SEED = 1
ROWS = 8000
SHOWN = {
    "time [s]": ("time [s]", 1.0, "%.3f"),
    "velocity [m/s]": ("velocity [mm/s]", 1e3, "%.6g"),
    "position [m]": ("position [mm]", 1e3, "%.4f"),
    "friction_force [N]": ("friction_force [N]", 1.0, "%.4f"),
}
EXPERIMENT = """\
# A slide on its bearing way, driven back and forth; the force that friction holds against the motion is measured.
# The model knows Coulomb and viscous friction. Something is missing from it.
schema = 1

[rig]
kind = "velocity-drive"

[model]
effects = ["coulomb", "viscous"]

[[record]]
file = "fit.csv"
role = "fit"

[[record]]
file = "validate.csv"
role = "validate"

[noise]
friction_force = "NOISE"
"""


def demo_records() -> dict[str, str]:
    """Text by file name."""
    from benchmarks.generators.hidden_effect import Plan, make_case

    plan = Plan("velocity-drive", ("stribeck", "magnetic_cogging"), "strong", rows=ROWS)
    case = make_case(plan, np.random.default_rng(SEED))
    noise = case.toml.partition('friction_force = "')[2].partition('"')[0]
    files = {"experiment.toml": EXPERIMENT.replace("NOISE", noise)}
    for name, frame in (("fit.csv", case.fit), ("validate.csv", case.validate)):
        columns = {
            shown: [style % (value * factor) for value in frame[column]]
            for column, (shown, factor, style) in SHOWN.items()
        }
        files[name] = pd.DataFrame(columns).to_csv(index=False, lineterminator="\n")
    return files


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in demo_records().items():
        (folder / name).write_text(text, encoding="utf-8")
