"""A mass that nobody gave is read off the records, whichever columns they have."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.generators.hidden_effect import Plan, make_case
from sysid.prediction.problem import load_problem


@pytest.mark.parametrize("columns", [(), ("position",), ("spring_force",)])
def test_a_small_inertia_on_a_spring_is_no_kilogram(tmp_path: Path, columns: tuple[str, ...]) -> None:
    """A rotary axis: without its position the stretch of the spring tells it, without the force the stretch does."""
    case = make_case(Plan("spring-pull", rows=6000), np.random.default_rng(4))
    radius = 0.02
    arm = {"pull_position [m]": 1.0 / radius, "position [m]": 1.0 / radius, "spring_force [N]": radius}
    for name, table in (("fit", case.fit), ("validate", case.validate)):
        turned = pd.DataFrame({"time [s]": table["time [s]"]})
        for column, factor in arm.items():
            if column.partition(" ")[0] not in columns:
                unit = "[N*m]" if column.endswith("[N]") else "[rad]"
                turned[column.partition(" ")[0] + " " + unit] = factor * table[column]
        turned.to_csv(tmp_path / f"{name}.csv", index=False)
    truth = case.key["truth"]
    stiffness, inertia = truth["pull_stiffness"] * radius**2, truth["mass"] * radius**2
    (tmp_path / "experiment.toml").write_text(
        f'schema = 1\n[rig]\nkind = "spring-pull"\n[rig.known]\npull_stiffness = "{stiffness} N*m/rad"\n'
        '[model]\neffects = ["coulomb", "viscous"]\n[[record]]\nfile = "fit.csv"\nrole = "fit"\n'
        '[[record]]\nfile = "validate.csv"\nrole = "validate"\n'
    )
    assert load_problem(tmp_path).start.values["rig.mass"] == pytest.approx(inertia, rel=0.5)
