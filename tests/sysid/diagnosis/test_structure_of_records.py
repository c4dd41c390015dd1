"""Structural modes above the filter band, and a quantised channel whose step exceeds the stated noise."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import cont2discrete

from sysid.add import add_effects
from sysid.diagnose import diagnose
from sysid.diagnosis.candidate import Reference
from sysid.diagnosis.ledger import Ledger
from sysid.diagnosis.model_search import ModelSearch
from sysid.diagnosis.quantised_channel import quantised_channel
from sysid.diagnosis.structural_modes import StructuralMode, detect_structural_mode, with_mode_above_band
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model
from sysid.experiment.experiment import load_experiment
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.problem import Problem, load_problem
from sysid.signals import BAND
from tests.experiments import change_column, write_rig
from tests.sysid.slide import NOISE, SIGN, VELOCITY, slide

STEP, ROWS = 1e-3, 9000
MASS, DRAG = 1.5, 6.0
FREQUENCY, DAMPING = 31.0, 0.02
FORCE_NOISE = 5e-3


def _position(force: np.ndarray, shaken: np.ndarray, part: float) -> np.ndarray:
    """Where a mass goes, a part of which rides on a mode: exact for forces (n,) held from row to row."""
    w, own = 2.0 * np.pi * FREQUENCY, (1.0 - part) * MASS
    ride = np.array([w**2, 0.0, -(w**2), -2.0 * DAMPING * w])
    matrix = np.array([[0, 1, 0, 0], [0, -DRAG / own, 0, 0] - part * MASS / own * ride, [0, 0, 0, 1], ride])
    held, push, *_ = cont2discrete((matrix, np.array([[0], [1 / own], [0], [0]]), np.eye(4), np.zeros((4, 1))), STEP)
    state, out = np.zeros(4), np.empty(force.size)
    for k in range(force.size):
        out[k] = state[0]
        state = held @ state + push[:, 0] * (force[k] + shaken[k])
    return out


def _write(folder: Path, part: float, vibration: float = 0.0, noise: float = 2e-6) -> Path:
    """A mass pushed by steps of force, its position with `noise`, m; the `vibration` of the floor pushes it too, N."""
    records = {}
    for seed, role in enumerate(("fit", "validate")):
        rng = np.random.default_rng([5, seed])
        time = STEP * np.arange(ROWS)
        force = np.repeat(rng.uniform(-4.0, 4.0, ROWS // 300), 300)
        shaken = vibration * np.sin(2.0 * np.pi * FREQUENCY * time + rng.uniform(0.0, 6.0))
        position = _position(force, shaken, part) + noise * rng.standard_normal(ROWS)
        logged = force + FORCE_NOISE * rng.standard_normal(ROWS)
        records[role] = {"time": time, "drive_force": logged, "position": position}
    stated = {"position": noise, "drive_force": FORCE_NOISE}
    return write_rig(folder, "force-drive", records, ["viscous"], known={"mass": f"{MASS} kg"}, noise=stated)


def _fitted(folder: Path) -> tuple[Problem, ReferenceFit]:
    problem = load_problem(folder)
    return problem, fit_stated_model(problem)


def test_modal_parameters_are_estimated(tmp_path: Path) -> None:
    problem, base = _fitted(_write(tmp_path / "rig", 0.15))
    record = problem.fit_records[0]
    assert isinstance(record, ForceBalanceRecord) and record.full_filter is not None
    assert BAND / record.full_filter.width < 0.5 * FREQUENCY
    found = detect_structural_mode(problem, base.fitted)
    assert found is not None and found.band == pytest.approx(BAND / record.full_filter.width)
    assert min(found.fit, found.held_out) > 20.0
    assert found.values["frequency"] == pytest.approx(FREQUENCY, rel=0.01)
    assert found.values["mass_ratio"] == pytest.approx(0.15, rel=0.1)
    assert found.values["damping"] == pytest.approx(DAMPING, rel=0.2)


def test_line_that_moves_no_mass_is_no_mode(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    search = ModelSearch(*_fitted(_write(tmp_path / "rig", 0.0)))
    values = {"frequency": 50.0, "damping": 0.001, "mass_ratio": 0.001}
    hum = StructuralMode(values, {name: 0.3 * value for name, value in values.items()}, 13.0, 22.0, 40.0)
    monkeypatch.setattr("sysid.diagnosis.structural_modes.detect_structural_mode", lambda *_: hum)
    ledger = Ledger((), search.stated)
    assert with_mode_above_band(search, ledger) is ledger


@pytest.mark.parametrize("vibration", [0.0, 0.05])
def test_no_mode_is_detected_without_one_on_a_vibrating_floor(tmp_path: Path, vibration: float) -> None:
    problem, base = _fitted(_write(tmp_path / "rig", 0.0, vibration))
    assert detect_structural_mode(problem, base.fitted) is None


@pytest.mark.slow
def test_mode_is_named_added_and_kept(tmp_path: Path, command) -> None:
    folder = _write(tmp_path / "rig", 0.15, noise=1e-5)
    said = " ".join(command("diagnose", folder, "--no-figures", "--out", tmp_path / "out").out.split())
    assert "missing: flexible_mode" in said
    assert "oscillates at" in said
    problem, base = _fitted(folder)
    add_effects(folder, ["flexible_mode"])
    known = load_experiment(folder).parameters["flexible_mode.frequency"]
    assert known.start == pytest.approx(FREQUENCY, rel=0.05)
    # What the ringing told, not what a fit made of it and of the balance: the balance is fitted again.
    told = detect_structural_mode(problem, base.fitted)
    assert told is not None
    assert known.start == pytest.approx(told.values["frequency"], rel=1e-5)
    assert known.std == pytest.approx(told.stds["frequency"], rel=0.05)
    after = diagnose(folder)
    assert after.verdict == "adequate"
    assert not after.replacements


FORCE = 1.5 * SIGN + 25.0 * VELOCITY


def _rounded(folder: Path, step: float, missing: np.ndarray | float = 0.0) -> Path:
    """Coulomb friction and drag; the force is written on a grid of `step` N, its noise stated as `NOISE`."""
    slide(folder, FORCE + missing, "coulomb", "viscous", held_out=True)
    for name in ("fit.csv", "validate.csv") if step else ():
        change_column(folder / name, 3, lambda force: step * np.round(force / step))
    return folder


def _reference(folder: Path) -> Reference:
    return Reference.of(*_fitted(folder))


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
    after = _reference(tmp_path)
    assert quantised_channel(after) is None
    assert after.problem.noise["friction_force"].value == pytest.approx(np.hypot(NOISE, step / np.sqrt(12.0)), rel=1e-6)


def test_a_coarse_grid_hides_the_noise_and_no_grid_explains_a_misfit(tmp_path: Path) -> None:
    slide(tmp_path, 1.5 * SIGN, "coulomb", "viscous", held_out=True)
    for name in ("fit.csv", "validate.csv"):
        change_column(tmp_path / name, 3, lambda force: np.where(force > 0.0, 1.5, -1.5))
    assert quantised_channel(_reference(tmp_path)) is not None
    folder = _rounded(tmp_path, 4.0 * NOISE, 60.0 * NOISE * np.sin(400.0 * VELOCITY))
    assert quantised_channel(_reference(folder)) is None


@pytest.mark.parametrize("step", [0.0, NOISE])
def test_fine_grid_is_not_named(tmp_path: Path, step: float) -> None:
    assert quantised_channel(_reference(_rounded(tmp_path, step))) is None
