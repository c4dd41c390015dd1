"""Quantisation is read off the values where its step exceeds the noise that was stated, and nowhere else."""

from pathlib import Path

import numpy as np
import pytest

from sysid.diagnosis.candidate import Reference
from sysid.diagnosis.quantised_channel import quantised_channel
from sysid.estimation.reference_fit import fit_stated_model
from sysid.ladder import add_effects
from sysid.prediction.problem import load_problem
from tests.sysid.slide import NOISE, SIGN, VELOCITY, slide

FORCE = 1.5 * SIGN + 25.0 * VELOCITY


def _rounded(folder: Path, step: float, missing: np.ndarray | float = 0.0) -> Path:
    """Coulomb friction and drag; the force is written on a grid of `step` N, its noise stated as `NOISE`."""
    slide(folder, FORCE + missing, '"coulomb", "viscous"', held_out=True)
    for name in ("fit.csv", "validate.csv"):
        file = folder / name
        header = file.read_text(encoding="utf-8").splitlines()[0]
        table = np.loadtxt(file, delimiter=",", skiprows=1)
        if step > 0.0:
            table[:, 3] = step * np.round(table[:, 3] / step)
        np.savetxt(file, table, "%.9g", ",", header=header, comments="")
    return folder


def _reference(folder: Path) -> Reference:
    problem = load_problem(folder)
    return Reference.of(problem, fit_stated_model(problem))


def test_grid_coarser_than_the_noise_is_named_and_explains_the_misfit(tmp_path: Path) -> None:
    step = 15.0 * NOISE
    reference = _reference(_rounded(tmp_path, step))
    # The error of rounding is even over a step: its variance is step^2/12.
    assert reference.held_out.loss == pytest.approx(1.0 + step**2 / 12.0 / NOISE**2, rel=0.25)
    found = quantised_channel(reference)
    assert found is not None
    assert (found.entry.name, found.entry.state) == ("sensor_quantisation", "established")
    assert found.candidate.held_out.loss < 1.3
    assert found.share > 0.9
    add_effects(tmp_path, ["sensor_quantisation"])
    assert quantised_channel(_reference(tmp_path)) is None


def test_grid_on_which_the_force_has_two_values_hides_the_noise(tmp_path: Path) -> None:
    slide(tmp_path, 1.5 * SIGN, '"coulomb", "viscous"', held_out=True)
    for name in ("fit.csv", "validate.csv"):
        file = tmp_path / name
        header = file.read_text(encoding="utf-8").splitlines()[0]
        table = np.loadtxt(file, delimiter=",", skiprows=1)
        table[:, 3] = np.where(table[:, 3] > 0.0, 1.5, -1.5)
        np.savetxt(file, table, "%.9g", ",", header=header, comments="")
    assert quantised_channel(_reference(tmp_path)) is not None


@pytest.mark.parametrize("step", [0.0, NOISE])
def test_fine_grid_is_not_named(tmp_path: Path, step: float) -> None:
    assert quantised_channel(_reference(_rounded(tmp_path, step))) is None


def test_misfit_that_no_grid_explains_is_not_quantisation(tmp_path: Path) -> None:
    folder = _rounded(tmp_path, 4.0 * NOISE, 60.0 * NOISE * np.sin(400.0 * VELOCITY))
    assert quantised_channel(_reference(folder)) is None
