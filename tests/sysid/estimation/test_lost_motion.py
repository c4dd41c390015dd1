"""Lost motion between an imposed motion and a friction: the model, the search of its width, its interval."""

from pathlib import Path

import numpy as np
import pytest

from sysid.diagnose import diagnose
from sysid.estimation.covariance import identifiability_report, intervals
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.problem import load_problem

FORCE, VISCOUS, NOISE = 3.0, 20.0, 0.05
HEAD = """schema = 1
[rig]
kind = "velocity-drive"
[model]
effects = [{effects}]
{records}"""
RECORD = """[[record]]
file = "{role}.csv"
role = "{role}"
"""


def write_rig(folder: Path, gap: float, effects: str = '"coulomb", "viscous"', start: float = 0.5) -> Path:
    """Records of a body behind a gap, which begins with a part `start` of it crossed; without force in the gap."""
    rng = np.random.default_rng(3)
    for role, size, rate in (("fit", 4e-3, 0.5), ("validate", 5e-3, 0.7)):
        time = np.arange(0.0, 8.0, 2e-3)
        x = size * np.sin(2 * np.pi * rate * time) + 0.4 * size * np.sin(3.4 * np.pi * rate * time + 1.0)
        velocity, force, body = np.gradient(x, time), np.zeros(time.size), x[0] + (0.5 - start) * gap
        for i in range(1, time.size):
            before, body = body, min(max(body, x[i] - 0.5 * gap), x[i] + 0.5 * gap)
            force[i] = FORCE * np.sign(velocity[i]) + VISCOUS * velocity[i] if body != before else 0.0
        logged = np.c_[time, x + rng.normal(0.0, 2e-7, x.size), force + rng.normal(0.0, NOISE, x.size)]
        header = "time [s],position [m],friction_force [N]"
        np.savetxt(folder / f"{role}.csv", logged, delimiter=",", header=header, comments="", fmt="%.9g")
    records = "".join(RECORD.format(role=role) for role in ("fit", "validate"))
    (folder / "experiment.toml").write_text(HEAD.format(effects=effects, records=records), "utf-8")
    return folder


@pytest.mark.parametrize("gap", [7e-4, 2.1e-3])
def test_lost_motion_of_an_imposed_motion_is_named_alone_at_the_noise(tmp_path: Path, gap: float) -> None:
    found = diagnose(write_rig(tmp_path, gap))
    assert [entry.name for entry in found.ledger.established] == ["backlash"]
    assert found.ledger.model.held_out.loss < 1.1**2
    assert found.ledger.model.fitted.model.values["backlash.gap"] == pytest.approx(gap, rel=0.01)


@pytest.mark.parametrize("start", [0.1, 0.9])
def test_width_of_a_stated_gap_is_found_from_any_start_with_its_interval(tmp_path: Path, start: float) -> None:
    """Its interval is that of the likelihood ratio: a row is all or nothing as the gap closes."""
    gap, effects = 1.3e-3, '"coulomb", "viscous", "backlash"'
    problem = load_problem(write_rig(tmp_path, gap, effects, start))
    base = fit_stated_model(problem)
    known = intervals(base.fitted, problem.fit_records)
    width = known.by_key["backlash.gap"]
    assert width.low <= gap <= width.high
    assert width.high - width.low < 0.02 * gap
    assert known.by_key["coulomb.force"].value == pytest.approx(FORCE, rel=0.01)
    assert not any("backlash.gap" in line for line in identifiability_report(base.fitted, known))
