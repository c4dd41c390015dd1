"""Where only the spring's force is logged, the position it tells shows how the body gives way at rest."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.force_balance.stick_phases import STICK_DISPLACEMENT
from sysid.prediction.model import predict
from sysid.prediction.problem import Problem, load_problem
from tests.experiments import write_rig

STEP = 1e-3
MASS, STIFFNESS, LEVEL = 1.5, 3000.0, 0.8
BRISTLES = 4e5
NOISE = 5e-4


@cache
def _pulled(bristles: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, pull and spring force (n,) of a body on bristles whose pull creeps to and fro: it holds, gives way, slips.

    The bristles are ideal springs that slip at the level, followed in small steps of their own.
    """
    n, parts = 6000, 30
    time = STEP * np.arange(n)
    pull = 1.2e-3 * np.sin(2 * np.pi * 0.35 * time) + 0.5e-3 * np.sin(2 * np.pi * 0.11 * time)
    dt, most = STEP / parts, LEVEL / bristles
    x = v = z = 0.0
    force = np.empty(n)
    for i, drawn in enumerate(pull.tolist()):
        force[i] = STIFFNESS * (drawn - x)
        for _ in range(parts):
            v += dt * (STIFFNESS * (drawn - x) - bristles * z - 60.0 * v) / MASS
            x += dt * v
            z = min(max(z + dt * v, -most), most)
    return time, pull, force


def _written(folder: Path, stiffness: str, *effects: str, bristles: float = BRISTLES, bent: float = 0.0) -> Problem:
    """An experiment on that body, in which its own position is not logged."""
    time, pull, force = _pulled(bristles)
    force = force + bent * force**2 / 3.0 + NOISE * np.random.default_rng(2).standard_normal(force.size)
    log = {"time [s]": time, "pull_position [m]": pull, "spring_force [N]": force}
    known, noise = {"mass": f"{MASS} kg", "pull_stiffness": stiffness}, {"spring_force": f"{NOISE} N"}
    return load_problem(write_rig(folder, "spring-pull", {"fit": log}, effects, known=known, noise=noise))


def _at_rest(problem: Problem, **values: float) -> tuple[ForceBalanceRecord, np.ndarray, np.ndarray]:
    balance = problem.fit_records[0]
    assert isinstance(balance, ForceBalanceRecord)
    assert balance.stick_phases is not None
    predicted = predict(balance, problem.start.effects, {**problem.start.values, **values})[STICK_DISPLACEMENT]
    return (
        balance,
        balance.stick_phases.displacement[balance.stick_phases.scored],
        predicted[balance.stick_phases.scored],
    )


def test_rigid_friction_leaves_what_bristles_explain(tmp_path: Path) -> None:
    told = f"{STIFFNESS:g} N/m"
    rigid, shift, held = _at_rest(_written(tmp_path / "rigid", told, "coulomb", "viscous"))
    assert rigid.stick_phases is not None
    assert rigid.stick_phases.compliance == pytest.approx(1.0 / STIFFNESS)
    assert np.std(shift) > 5.0 * rigid.stick_phases.noise
    assert not held.any()
    core = {"presliding.force": LEVEL, "presliding.stretch": LEVEL / BRISTLES, "presliding.curvature": 1.0}
    problem = _written(tmp_path / "bristles", told, "presliding", "viscous")
    assert set(core) <= set(problem.start.values)
    _, shift, moved = _at_rest(problem, **core)
    assert np.std(shift - moved) < 0.3 * np.std(shift)


def test_a_stiffness_error_of_the_spring_is_fitted_if_its_deviation_is_given(tmp_path: Path) -> None:
    exact = _written(tmp_path / "exact", f"{1.005 * STIFFNESS:g} N/m", "coulomb", "viscous", bristles=4e6)
    assert any("pull_stiffness" in note and "exact" in note for note in exact.notes)
    unsure = f"{1.005 * STIFFNESS:g} +- {0.01 * STIFFNESS:g} N/m"
    problem = _written(tmp_path / "unsure", unsure, "coulomb", bristles=4e6)
    assert not any("pull_stiffness" in note for note in problem.notes)
    _, shift, _ = _at_rest(problem)
    _, _, of_spring = _at_rest(problem, **{"rig.pull_stiffness": STIFFNESS})
    # A spring half a hundredth too stiff makes of a body that holds: the force times the compliance that is missing.
    assert np.std(of_spring) == pytest.approx(np.std(shift), rel=0.3)
    assert np.corrcoef(shift, of_spring)[0, 1] > 0.9


def test_a_bent_sensor_of_the_force_bends_the_position_it_tells(tmp_path: Path) -> None:
    effects = "presliding", "viscous", "sensor_nonlinearity@spring_force"
    problem = _written(tmp_path / "bent", f"{STIFFNESS:g} N/m", *effects, bent=0.05)
    scale = problem.start.values["sensor_nonlinearity@spring_force.full_scale"]
    core = {"presliding.force": LEVEL, "presliding.stretch": LEVEL / BRISTLES, "presliding.curvature": 1.0}
    bend = {"sensor_nonlinearity@spring_force.second_order": 0.05 * scale / 3.0}
    _, shift, straight = _at_rest(problem, **core)
    _, _, moved = _at_rest(problem, **core, **bend)
    assert np.std(shift - moved) < 0.5 * np.std(shift - straight)
