"""A known mass, scale or stiffness that the records contradict is named; a right one never is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sysid.diagnosis.consistency import contradicted_known
from sysid.prediction.problem import load_problem
from tests.experiments import write_rig

STEP, ROWS = 2e-3, 6000
TIME = STEP * np.arange(ROWS)


def _driven_mass(folder: Path, mass: str, scale: float = 1.0, hertz: float = 1.0) -> Path:
    """A mass of 2 kg with Coulomb and viscous friction and a spring that the model lacks."""
    random = np.random.default_rng(4)
    angle = 2.0 * np.pi * hertz * np.outer((0.7, 1.1, 1.9), TIME) + random.uniform(0.0, 6.0, (3, 1))
    rates = 2.0 * np.pi * hertz * np.array([[0.7], [1.1], [1.9]])
    position = 0.02 * np.sin(angle).sum(axis=0)
    velocity, acceleration = 0.02 * (rates * np.cos(angle)).sum(axis=0), -0.02 * (rates**2 * np.sin(angle)).sum(axis=0)
    force = 2.0 * acceleration + 1.5 * np.sign(velocity) + 4.0 * velocity + 30.0 * position
    columns = {"time [s]": TIME, "position [m]": position + 1e-6 * random.standard_normal(ROWS)}
    columns["drive_force [N]"] = scale * (force + 0.02 * random.standard_normal(ROWS))
    rig = {"kind": "force-drive", "input_hold": "linear"}
    return write_rig(folder, rig, {"fit": columns}, ["coulomb", "viscous"], known={"mass": mass})


@pytest.mark.parametrize("mass", ["2 kg", "2.1 kg", "1.9 +- 0.1 kg"])
def test_a_right_mass(tmp_path: Path, mass: str) -> None:
    assert not contradicted_known(load_problem(_driven_mass(tmp_path, mass)))


@pytest.mark.parametrize(
    ("mass", "scale", "shown"), [("3 kg", 1.0, "2 kg"), ("0.2 kg", 1.0, "2 kg"), ("2 kg", 1.6, "3.2")]
)
def test_a_wrong_mass_or_scale(tmp_path: Path, mass: str, scale: float, shown: str) -> None:
    (line,) = contradicted_known(load_problem(_driven_mass(tmp_path, mass, scale)))
    assert f"the records show {shown}" in line and "the scale of 'drive_force' is" in line


def test_a_motion_too_slow_to_show_the_mass(tmp_path: Path) -> None:
    assert not contradicted_known(load_problem(_driven_mass(tmp_path, "3 kg", hertz=0.02)))


@pytest.mark.parametrize(("stated", "wrong"), [("5000 N/m", False), ("50 N/mm", True)])
def test_the_stiffness_of_a_pulling_spring(tmp_path: Path, stated: str, wrong: bool) -> None:
    random = np.random.default_rng(5)
    pull = 0.02 * np.sin(2.0 * np.pi * 0.5 * TIME)
    stretch = 5e-4 * np.sign(np.cos(2.0 * np.pi * 0.5 * TIME))
    force = 5000.0 * stretch + 0.1 + 0.02 * random.standard_normal(ROWS)
    columns = {"time [s]": TIME, "pull_position [m]": pull}
    columns["position [m]"] = pull - stretch + 1e-6 * random.standard_normal(ROWS)
    known = {"mass": "2 kg", "pull_stiffness": stated}
    write_rig(tmp_path, "spring-pull", {"fit": columns | {"spring_force [N]": force}}, ["coulomb"], known=known)
    found = [line for line in contradicted_known(load_problem(tmp_path)) if "pull_stiffness" in line]
    assert bool(found) == wrong
