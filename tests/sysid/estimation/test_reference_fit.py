"""Fit of the stated model: selection of the free Maxwell-slip variant of presliding."""

import numpy as np
import pytest

from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.problem import load_problem

N, STEP, NOISE = 6000, 1e-3, 0.004
STRETCHES = np.array([0.4e-6, 0.9e-6, 4e-6, 30e-6])
LEVELS = np.array([0.5, 0.1, 0.3, 0.7])
VISCOUS = 12.0


def _record(seed: int, path) -> None:
    """Four ideal springs side by side that slip one after another, and a viscous drag, N."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(N)
    size = 10.0 ** rng.uniform(-6.0, -4.0, 12)
    frequency, phase = rng.uniform(0.2, 3.0, 12), rng.uniform(0.0, 6.28, 12)
    position = size @ np.sin(2.0 * np.pi * np.outer(frequency, t) + phase[:, None])
    velocity = np.gradient(position, STEP)
    stretched = -STRETCHES.copy() if position[1] < position[0] else STRETCHES.copy()
    force = np.empty(N)
    for i in range(N):
        stretched = np.clip(stretched + (position[i] - position[i - 1] if i else 0.0), -STRETCHES, STRETCHES)
        force[i] = LEVELS @ (stretched / STRETCHES) + VISCOUS * velocity[i]
    table = np.column_stack([t, position, velocity, force + NOISE * rng.standard_normal(N)])
    header = "time [s],position [m],velocity [m/s],friction_force [N]"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.12g")


@pytest.fixture
def rig(tmp_path):
    _record(1, tmp_path / "fit.csv")
    _record(2, tmp_path / "validate.csv")
    (tmp_path / "experiment.toml").write_text(
        'schema = 1\n[rig]\nkind = "velocity-drive"\n[model]\neffects = ["presliding", "viscous"]\n'
        '[noise]\nfriction_force = "0.004 N"\n'
        '[[record]]\nfile = "fit.csv"\nrole = "fit"\n[[record]]\nfile = "validate.csv"\nrole = "validate"\n'
    )
    return tmp_path


def test_free_maxwell_slip_fits_a_curve_that_a_power_law_does_not(rig):
    problem = load_problem(rig)
    base = fit_stated_model(problem)
    assert base.laws == ("presliding:free_maxwell_slip",)
    values = base.fitted.model.values
    assert values["viscous.coefficient"] == pytest.approx(VISCOUS, rel=0.05)
    assert values["presliding:free_maxwell_slip.force"] == pytest.approx(LEVELS.sum(), rel=0.03)
    over = misfit(base.fitted.model, problem.validate_records)["friction_force"].over_noise
    assert over < 3.0


def test_variant_named_by_the_user_is_kept(rig):
    text = (rig / "experiment.toml").read_text()
    (rig / "experiment.toml").write_text(text.replace('"presliding"', '"presliding:maxwell_slip"'))
    base = fit_stated_model(load_problem(rig))
    assert base.laws == ()
