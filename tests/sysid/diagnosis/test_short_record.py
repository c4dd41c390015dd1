"""One record that is too short to hold out a part of it: parts are left out of the fit in turn."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stagecad.parameters.errors import InputError
from sysid.diagnose import diagnose
from sysid.diagnosis.held_out import held_out
from sysid.estimation.fit import fit_model
from sysid.prediction.problem import PARTS, load_problem
from tests.experiments import write_rig

INERTIA, GRAVITY, VISCOUS, COULOMB = 0.016, 0.85, 0.04, 0.02
TIME = np.arange(0.0, 2.1, 1.0 / 64.0)


def _pendulum(folder: Path, gravity: float, angle: float, speed: float) -> Path:
    """A pendulum that swings without drive, measured at 64 Hz."""

    def slope(_: float, state: np.ndarray) -> list[float]:
        friction = VISCOUS * state[1] + COULOMB * np.tanh(state[1] / 1e-3)
        return [state[1], -(gravity * np.sin(state[0]) + friction) / INERTIA]

    found = solve_ivp(slope, (0.0, 2.2), [angle, speed], "Radau", TIME, rtol=1e-8, atol=1e-9, max_step=5e-3)
    random = np.random.default_rng(1)
    position, velocity = (y + random.normal(0.0, std, TIME.size) for y, std in zip(found.y, (7e-4, 0.02)))
    columns = {"time": TIME, "position [rad]": position, "velocity [rad/s]": velocity, "drive_force [N*m]": 0.0 * TIME}
    known = {"inertia": f"{INERTIA} kg*m^2"}
    return write_rig(folder, "force-drive", {"fit": columns}, ["coulomb", "viscous"], known=known)


def test_one_short_swing_shows_its_gravity_and_none_where_there_is_none(tmp_path: Path) -> None:
    found = diagnose(_pendulum(tmp_path, GRAVITY, -1.5, 0.0))
    assert found.problem.crossed and any("left out in turn" in note for note in found.problem.notes)
    (entry,) = found.ledger.established
    assert entry.name == "gravity_torque"
    values = found.ledger.model.fitted.model.values
    assert values["gravity_torque.amplitude"] == pytest.approx(GRAVITY, rel=0.03)
    found = diagnose(_pendulum(tmp_path, 0.0, -3.0, 6.0))
    assert found.problem.crossed
    assert (found.verdict, found.ledger.entries) == ("adequate", ())
    with pytest.raises(InputError, match=r"nothing moves: no change of position or velocity exceeds its noise"):
        load_problem(_pendulum(tmp_path, 0.0, -1.5, 0.0))


def test_error_of_a_part_left_out_is_that_of_a_fit_to_the_others(tmp_path: Path) -> None:
    problem = load_problem(_pendulum(tmp_path, 0.0, -3.0, 6.0))
    keys = {"coulomb.force", "viscous.coefficient"}
    model = replace(problem.start, unknowns=tuple(u for u in problem.start.unknowns if u.key in keys))
    fitted = fit_model(fit_model(model, problem.fit_records).model, problem.fit_records)
    assert not fitted.fit.at_bound
    whole, root = held_out(fitted, problem.fit_records, fitted.weights), np.sqrt(fitted.fit.weights)
    columns, target = fitted.fit.jacobian * root[:, None], fitted.fit.residual * root
    assert len(np.unique(whole.block)) == PARTS
    for part in np.unique(whole.block):
        others = whole.block != part
        step = np.linalg.lstsq(columns[others], target[others], rcond=None)[0]
        expected = fitted.fit.residual[~others] - fitted.fit.jacobian[~others] @ step
        # The fit ends within a thousandth of a standard deviation of its minimum.
        assert whole.residual[~others] == pytest.approx(expected, abs=1e-3)
