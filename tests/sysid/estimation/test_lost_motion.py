"""Lost motion between an imposed motion and a friction: the model, the search of its width, its interval."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from sysid.diagnose import diagnose
from sysid.estimation.covariance import identifiability_report, intervals
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.problem import load_problem
from tests.experiments import write_rig

FORCE, VISCOUS, NOISE, RATE = 2.5, 12.0, 0.01, 500.0
SIZES = np.array([0.010, 0.004, 0.0015])


class Body(NamedTuple):
    """A body behind a gap of full width `gap`, m, of which a part `start` is crossed first, on a spring, N/m."""

    gap: float
    start: float = 0.5
    spring: float = 0.0


def _write(folder: Path, body: Body, *further: str) -> Path:
    """Records of a body that is moved in three waves, without force in the gap; further effects of the model."""
    rng = np.random.default_rng(1)
    records = {}
    for role, duration in (("fit", 8.0), ("validate", 6.0)):
        time = np.arange(0.0, duration, 1.0 / RATE)
        rates, phases = rng.uniform([0.2, 0.6, 1.2], [0.4, 1.0, 2.0]), rng.uniform(0.0, 6.0, 3)
        x = np.sin(2.0 * np.pi * time[:, None] * rates + phases) @ SIZES
        velocity, force, at = np.gradient(x, time), np.zeros(time.size), x[0] + (0.5 - body.start) * body.gap
        for i in range(1, time.size):
            before, at = at, min(max(at, x[i] - 0.5 * body.gap), x[i] + 0.5 * body.gap)
            whole = FORCE * np.sign(velocity[i]) + VISCOUS * velocity[i] + body.spring * at
            force[i] = whole if at != before else 0.0
        x += rng.normal(0.0, 1e-7, x.size)
        records[role] = {"time": time, "position": x, "friction_force": force + rng.normal(0.0, NOISE, x.size)}
    return write_rig(folder, "velocity-drive", records, ["coulomb", "viscous", *further])


def test_lost_motion_of_an_imposed_motion_is_named_alone_at_the_noise(tmp_path: Path) -> None:
    found = diagnose(_write(tmp_path, Body(2e-3)))
    assert [entry.name for entry in found.ledger.established] == ["backlash"]
    assert found.ledger.model.held_out.loss < 1.1**2
    assert found.ledger.model.fitted.model.values["backlash.gap"] == pytest.approx(2e-3, rel=0.01)


def test_lost_motion_and_a_spring_are_not_taken_for_presliding(tmp_path: Path) -> None:
    """Presliding with many elements gains more than either of them alone, but both together leave the noise."""
    found = diagnose(_write(tmp_path, Body(1.5e-3, spring=120.0)))
    assert {entry.name for entry in found.ledger.established} == {"backlash", "cable_spring"}
    assert found.ledger.model.held_out.loss < 1.1**2


@pytest.mark.parametrize("start", [0.1, 0.9])
def test_width_of_a_stated_gap_is_found_from_any_start_with_its_interval(tmp_path: Path, start: float) -> None:
    """Its interval is that of the likelihood ratio: a row is all or nothing as the gap closes."""
    gap = 1.3e-3
    problem = load_problem(_write(tmp_path, Body(gap, start), "backlash"))
    base = fit_stated_model(problem)
    known = intervals(base.fitted, problem.fit_records)
    width = known.by_key["backlash.gap"]
    assert width.low <= gap <= width.high
    assert width.high - width.low < 0.02 * gap
    assert known.by_key["coulomb.force"].value == pytest.approx(FORCE, rel=0.01)
    assert not any("backlash.gap" in line for line in identifiability_report(base.fitted, known))
