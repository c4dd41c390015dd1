"""A record that begins at rest begins with the stretch that its force shows."""

from pathlib import Path

import numpy as np
import pytest

from sim.effects.catalogue import find
from sysid.estimation.misfit import misfit
from sysid.prediction.model import predict, with_effect
from sysid.prediction.problem import Problem, load_problem
from tests.experiments import write_rig
from tests.sysid.slide import NOISE, STEP

LEVEL, STRETCH, STICK_DISPLACEMENT = 1.5, 4e-5, 200
TIME = np.arange(2000) * STEP


def moved(rest: int = STICK_DISPLACEMENT) -> np.ndarray:
    t = np.maximum(TIME - rest * STEP, 0.0)
    return 3e-4 * (1.0 - np.cos(2 * np.pi * 1.5 * t)) * (rest * STEP < TIME)


def bristle(position: np.ndarray, begin: float) -> np.ndarray:
    """One ideal spring that slips: force (n,), N, from the part `begin` of the level."""
    z, out = begin * STRETCH, np.empty(position.size)
    for k, dx in enumerate(np.diff(position, prepend=position[0])):
        z = float(np.clip(z + dx, -STRETCH, STRETCH))
        out[k] = LEVEL * z / STRETCH
    return out


def record(folder: Path, force: np.ndarray, position: np.ndarray) -> Problem:
    noisy = force + NOISE * np.random.default_rng(4).standard_normal(force.size)
    columns = {"time [s]": TIME, "position [m]": position, "friction_force [N]": noisy}
    stated = {"friction_force": f"{NOISE} N", "position": "1e-9 m"}
    return load_problem(write_rig(folder, "velocity-drive", {"log": columns}, ["coulomb"], noise=stated))


@pytest.mark.parametrize("law,stretch", [("presliding", "stretch"), ("presliding:dahl", None)])
@pytest.mark.parametrize("begin", [-1.0, -0.4, 0.0, 0.7])
def test_the_first_force_is_the_one_that_was_measured(tmp_path, law: str, stretch: str | None, begin: float) -> None:
    problem = record(tmp_path, bristle(moved(), begin), moved())
    model = with_effect(problem.start, find(law), problem.scales)
    values = {f"{law}.force": LEVEL, **({f"{law}.stretch": STRETCH} if stretch else {})}
    predicted = predict(problem.fit_records[0], model.effects, {**model.values, **values})["friction_force"]
    # The median of two hundred noisy rows is known to a thousandth of a newton; a record is read off at one place.
    assert predicted[:STICK_DISPLACEMENT] == pytest.approx(begin * LEVEL, abs=5e-3)


@pytest.mark.parametrize("begin", [-1.0, 0.5])
def test_with_the_right_stretch_at_the_start_only_noise_is_left(tmp_path: Path, begin: float) -> None:
    problem = record(tmp_path, bristle(moved(), begin), moved())
    model = with_effect(problem.start, find("presliding"), problem.scales)
    values = {"presliding.force": LEVEL, "presliding.stretch": STRETCH, "presliding.curvature": 1.0}
    found = misfit(model.at({**model.values, **values}), problem.fit_records)["friction_force"]
    assert found.rms == pytest.approx(NOISE, rel=0.1)


def test_a_record_that_begins_in_motion_begins_in_slip(tmp_path: Path) -> None:
    position = moved(0)[250:]
    position = np.concatenate([position, np.full(TIME.size - position.size, position[-1])])
    problem = record(tmp_path, bristle(position, 1.0), position)
    model = with_effect(problem.start, find("presliding"), problem.scales)
    values = {"presliding.force": 0.99 * LEVEL, "presliding.stretch": STRETCH}
    predicted = predict(problem.fit_records[0], model.effects, {**model.values, **values})["friction_force"]
    assert predicted[:50] == pytest.approx(0.99 * LEVEL)


def test_plain_friction_holds_its_first_force_too(tmp_path: Path) -> None:
    problem = record(
        tmp_path, LEVEL * np.where(TIME <= STICK_DISPLACEMENT * STEP, -1.0, np.sign(np.gradient(moved()))), moved()
    )
    predicted = predict(problem.fit_records[0], problem.start.effects, {**problem.start.values, "coulomb.force": LEVEL})
    assert predicted["friction_force"][:STICK_DISPLACEMENT] == pytest.approx(-LEVEL)


@pytest.mark.parametrize("begin", [-0.4, 0.0, 0.5])
def test_a_driven_mass_that_never_slips_begins_with_its_measured_stretch(tmp_path: Path, begin: float) -> None:
    rate, mass = 2.0 * np.pi * 3.0, 2.0
    position = 0.4 * STRETCH * np.sin(rate * TIME)
    force = mass * -(rate**2) * position + LEVEL * (begin + position / STRETCH)
    noise = 1e-3 * np.random.default_rng(4).standard_normal(TIME.size)
    columns = {"time [s]": TIME, "position [m]": position, "drive_force [N]": force + noise}
    rig, stated = {"kind": "force-drive", "input_hold": "linear"}, {"drive_force": "0.001 N", "position": "1e-11 m"}
    known = {"mass": f"{mass} kg"}
    problem = load_problem(write_rig(tmp_path, rig, {"log": columns}, ["coulomb"], known=known, noise=stated))
    model = with_effect(problem.start, find("presliding"), problem.scales)
    values = {"presliding.force": LEVEL, "presliding.stretch": STRETCH, "presliding.curvature": 1.0}
    found = misfit(model.at({**model.values, **values}), problem.fit_records)["drive_force"]
    # The first force is known to a fifth of the noise.
    assert found.over_noise == pytest.approx(1.0, abs=0.2)
