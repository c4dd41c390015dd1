"""Rows that are missing, lost or uneven: what bridges them, and what they cost."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import stagecad
from sim.numerics.record_operators import resonance
from sysid.add import add_effects
from sysid.compare import compare
from sysid.documents import comparison_json
from sysid.experiment.readers.memory import MemoryTable
from sysid.prediction.force_balance.record import EDGE_WIDTHS, ForceBalanceRecord
from sysid.prediction.problem import load_problem
from sysid.signals import longer_than
from sysid.simulate_experiment import simulate_experiment
from tests.experiments import write_rig
from tests.refusals import refused

STEP = 1e-3
MASS = 1.5
TIME = STEP * np.arange(6000)
GAP = slice(2950, 3080)
COULOMB, VISCOUS, NOISE, MEAN_STEP = 2.2, 45.0, 0.02, 5e-3
SCALE, INERTIA = 0.12, 0.02
"""Torque constant, N*m/A, and inertia, kg*m^2, of the rig."""


def _balance(folder: Path, gap: slice) -> ForceBalanceRecord:
    """A mass pushed to and fro by a sine, its position noisy by a tenth of a micrometre."""
    omega = 2 * np.pi * 2.0
    force = 3.0 * np.sin(omega * TIME)
    position = -3.0 / (MASS * omega**2) * np.sin(omega * TIME)
    position = position + 1e-7 * np.random.default_rng(8).standard_normal(TIME.size)
    position[gap] = np.nan
    log = {"time": TIME, "drive_force": force, "position": position}
    known, noise = {"mass": f"{MASS} kg"}, {"position": "0.1 um", "drive_force": "1 mN"}
    write_rig(folder, "force-drive", {"fit": log}, ["viscous"], known=known, noise=noise)
    balance = load_problem(folder).fit_records[0]
    assert isinstance(balance, ForceBalanceRecord)
    return balance


def test_a_mode_does_not_ring_with_the_bridge_over_a_gap(tmp_path: Path) -> None:
    whole, gap = (_balance(tmp_path / name, rows) for name, rows in (("whole", slice(0, 0)), ("gap", GAP)))
    rung = [resonance(np.ascontiguousarray(b.axis.acceleration), STEP, 38.0, 0.03) for b in (whole, gap)]
    after = slice(GAP.stop + 40, GAP.stop + 1000)
    own = np.std(rung[0] - whole.axis.acceleration)
    assert np.std((rung[1] - rung[0])[after]) < own
    # The line that bridges the position turns by kinks at the gap's ends, and those would have rung:
    time = whole.axis.time
    bridged = np.interp(time, *(np.delete(values, np.r_[GAP]) for values in (time, whole.axis.position)))
    kinked = resonance(np.gradient(np.gradient(bridged, STEP), STEP), STEP, 38.0, 0.03)
    assert np.std((kinked - rung[0])[after]) > 5.0 * own and gap.valid["drive_force"][after].any()
    assert not gap.valid["drive_force"][GAP].any()


def test_rows_beside_gaps_and_mixtures_follow_the_law(tmp_path: Path) -> None:
    whole, gap = (_balance(tmp_path / name, rows) for name, rows in (("whole", slice(0, 0)), ("gap", GAP)))
    far = np.r_[200 : GAP.start - 100, GAP.stop + 100 : whole.size - 200]
    assert gap.axis.acceleration[far] == pytest.approx(whole.axis.acceleration[far], abs=1e-9)
    # One row beside a reversal may be interpolated by the logger; resampling makes no further mixtures of it.
    residuals = _residuals(_record(1), _record(2), "coulomb", "viscous")
    reversals = int(np.sum(np.diff(np.sign(_record(2)["velocity [m/s]"])) != 0.0))
    assert reversals > 10 and np.sum(np.abs(residuals) > 10.0 * NOISE) <= reversals


INTERVAL, BLOCK, STIFFNESS = 1e-3, 1.2, 3000.0
TIMES = np.arange(6000) * INTERVAL
POSITION = 5e-3 * np.sin(2 * np.pi * 0.8 * TIMES)
ACCELERATION = -5e-3 * (2 * np.pi * 0.8) ** 2 * np.sin(2 * np.pi * 0.8 * TIMES)
FORCE = BLOCK * ACCELERATION + 40.0 * np.gradient(POSITION, INTERVAL)


def pulled(folder: Path, keep: np.ndarray) -> ForceBalanceRecord:
    """A mass on a spring without dry friction; the rows of `keep` (n,) are logged."""
    rng = np.random.default_rng(1)
    position, force = POSITION + rng.normal(0, 2e-7, TIMES.size), FORCE + rng.normal(0, 2e-3, TIMES.size)
    pull = POSITION + FORCE / STIFFNESS
    log = {"time": TIMES, "pull_position": pull, "position": position, "spring_force": force}
    log = {name: values[keep] for name, values in log.items()}
    known = {"mass": f"{BLOCK} kg", "pull_stiffness": f"{STIFFNESS} N/m"}
    noise = {"position": 2e-7, "spring_force": 2e-3}
    write_rig(folder, "spring-pull", {"log": log}, ["viscous"], known=known, noise=noise)
    record = load_problem(folder).fit_records[0]
    assert isinstance(record, ForceBalanceRecord)
    return record


def test_a_row_lost_here_and_there_costs_itself_only(tmp_path: Path) -> None:
    keep = np.random.default_rng(5).random(TIMES.size) > 0.07
    keep[:2] = True
    record = pulled(tmp_path, keep)
    scored = record.valid["spring_force"]
    edges = EDGE_WIDTHS * record.full_filter.width / INTERVAL
    assert scored.sum() > 0.9 * scored.size - 2.0 * edges and not scored[~keep[: scored.size]].any()
    # What is scored is as good as it was: the balance closes to the noise.
    assert record.acceleration is not None
    left = record.measured["spring_force"] - BLOCK * record.acceleration - 40.0 * record.axis.velocity
    assert np.std(left[scored]) < 1.3 * record.noise["spring_force"]


def test_long_holes_take_their_neighbourhood_and_short_stretches_go(tmp_path: Path) -> None:
    keep = np.ones(TIMES.size, dtype=bool)
    keep[3000:3100] = False
    record = pulled(tmp_path, keep)
    reach = int(EDGE_WIDTHS * record.full_filter.width / INTERVAL)
    scored = record.valid["spring_force"]
    assert not scored[3000 - reach + 2 : 3100 + reach - 2].any() and scored[3100 + reach + 5 :].any()
    mask = np.array([1, 0, 1, 1, 0, 1, 1, 1, 0], dtype=bool)
    assert longer_than(mask, 2.0).tolist() == [False] * 5 + [True] * 3 + [False]


def _record(seed: int) -> pd.DataFrame:
    """Coulomb and viscous friction of a slow multisine, sampled evenly, then interpolated to uneven times."""
    random = np.random.default_rng(seed)
    time = MEAN_STEP * np.arange(4000)
    velocity = 0.02 * np.sin(2.1 * time + 0.3) * np.sin(0.37 * time)
    force = COULOMB * np.sign(velocity) + VISCOUS * velocity + NOISE * random.standard_normal(time.size)
    uneven = time[1:-1] + MEAN_STEP * random.uniform(-0.15, 0.15, time.size - 2)
    columns = {"velocity [m/s]": velocity, "friction_force [N]": force}
    return pd.DataFrame({"time [s]": uneven, **{name: np.interp(uneven, time, y) for name, y in columns.items()}})


def _residuals(fit: pd.DataFrame, validate: pd.DataFrame, *effects: str) -> np.ndarray:
    records = {"fit": fit, "validate": validate}
    given: Any = {"model": effects, "noise": {"friction_force": "0.02 N"}, "validate": ["validate"]}
    experiment = stagecad.Experiment.from_dataframes(records, "velocity-drive", **given)
    return stagecad.compare(experiment).residuals.loc["validate"].to_numpy()


def _turning(seed: int, even: bool) -> pd.DataFrame:
    """Coulomb and viscous friction along an exact position, which turns between the rows."""
    random = np.random.default_rng(seed)
    time = MEAN_STEP * np.arange(4000)
    if not even:
        time = time + MEAN_STEP * random.uniform(-0.3, 0.3, time.size)
    position = 0.004 * np.sin(2.3 * time + seed)
    velocity = 0.004 * 2.3 * np.cos(2.3 * time + seed)
    force = COULOMB * np.sign(velocity) + VISCOUS * velocity + NOISE * random.standard_normal(time.size)
    return pd.DataFrame({"time [s]": time, "position [m]": position, "friction_force [N]": force})


@pytest.mark.parametrize("even", [True, False])
def test_direction_at_a_row_after_a_turning_point_between_two_rows(even: bool) -> None:
    """The difference to the row before has the old sign at half of the reversals; the velocity at the row has not."""
    residuals = _residuals(_turning(1, even), _turning(2, even), "coulomb", "viscous")
    assert np.sum(np.abs(residuals) > 10.0 * NOISE) == 0


def _resting(seed: int) -> pd.DataFrame:
    """Moves with half a cosine of velocity, and rests as long, at which friction keeps its last direction."""
    random = np.random.default_rng(seed)
    time = MEAN_STEP * (np.arange(4000) + random.uniform(-0.1, 0.1, 4000))
    phase = np.clip(time * 2.1 + 0.1 * seed, 0.0, None)
    k, part = np.floor(phase), np.minimum(2.0 * (phase % 1.0), 1.0)
    share = 0.5 - 0.5 * np.cos(np.pi * part)
    forth = k % 2.0 == 0.0
    position = 0.004 * np.where(forth, share, 1.0 - share)
    force = COULOMB * np.where(forth, 1.0, -1.0) + NOISE * random.standard_normal(time.size)
    return pd.DataFrame({"time [s]": time, "position [m]": position, "friction_force [N]": force})


def test_direction_at_rest_after_uneven_rows_is_that_of_the_motion_before() -> None:
    """A cubic through the rows would turn back by a nanometre where the body stops."""
    assert np.mean(np.abs(_residuals(_resting(1), _resting(2), "coulomb")) > 10.0 * NOISE) < 0.02


def _write(folder: Path, scale: str, mass: str = f"{INERTIA} kg*m^2", channel: str = "drive_force") -> Path:
    """Current of a motor that turns an inertia against Coulomb and viscous friction, by Newton's law."""
    random, records = np.random.default_rng(6), {}
    for name, phase in (("fit", 0.0), ("validate", 1.3)):
        t = np.arange(4000) * 1e-3
        angle = 0.5 * np.sin(9.0 * t + phase) + 0.1 * np.sin(23.0 * t)
        rate = 4.5 * np.cos(9.0 * t + phase) + 2.3 * np.cos(23.0 * t)
        torque = INERTIA * (-40.5 * np.sin(9.0 * t + phase) - 52.9 * np.sin(23.0 * t))
        torque += 0.15 * np.tanh(rate / 1e-4) + 0.01 * rate
        current = torque / SCALE + 0.01 * random.normal(size=t.size)
        records[name] = {"time": t, "position [rad]": angle, "current [A]": current}
    rig, known = {"kind": "force-drive", "input_hold": "linear"}, {"mass": mass} if mass else {}
    rest = f'[channels]\n{channel} = {{column = "current", scale = "{scale}"}}\n'
    noise = {"position": "1e-7 rad"}
    return write_rig(folder, rig, records, ["coulomb", "viscous"], known=known, noise=noise, rest=rest)


@pytest.mark.parametrize("scale", ["0.1 +- 0.03 N*m/A", "fit N*m/A"])
def test_a_known_inertia_determines_the_scale(tmp_path: Path, scale: str) -> None:
    found = compare(_write(tmp_path, scale))
    document = comparison_json(found)
    nominal = 1.0 if scale.startswith("fit") else 0.1
    ratio = document["parameters"]["rig.scale_drive_force"]
    assert ratio["unit"] == "1" and ratio["value"] * nominal == pytest.approx(SCALE, rel=0.01)
    assert ratio["low"] * nominal < SCALE < ratio["high"] * nominal
    assert document["parameters"]["coulomb.force"]["value"] == pytest.approx(0.15, rel=0.02)
    assert document["parameters"]["viscous.coefficient"]["value"] == pytest.approx(0.01, rel=0.03)
    assert any("rig.scale_drive_force is its ratio to" in note for note in found.problem.notes)


def test_a_scale_without_a_known_mass_stays_a_parameter(tmp_path: Path) -> None:
    document = comparison_json(compare(_write(tmp_path, "0.12 +- 0.006 N*m/A", mass="")))
    ratio = document["parameters"]["rig.scale_drive_force"]
    assert ratio["value"] == pytest.approx(1.0, abs=0.05) and ratio["std"] == pytest.approx(0.05, rel=0.2)
    # What is proportional to the scale carries its uncertainty of five percent.
    force = document["parameters"]["coulomb.force"]
    assert force["std"] / force["value"] == pytest.approx(0.05, rel=0.3)
    folder = _write(tmp_path, "0.1 +- 0.03 N*m/A")
    step = add_effects(folder, ["constant_bias"])
    assert step.base.fitted.model.values["rig.scale_drive_force"] == pytest.approx(1.2, rel=0.01)
    assert 'scale = "0.1 +- 0.03 N*m/A"' in (folder / "experiment.toml").read_text()


def test_simulations_use_the_fitted_scale(tmp_path: Path) -> None:
    """As if the true scale had been stated: the free run, the horizons, and the records that are simulated."""
    runs, simulated = [], []
    for scale in ("0.1 +- 0.03 N*m/A", f"{SCALE} N*m/A"):
        folder = _write(tmp_path, scale)
        document = comparison_json(compare(folder))
        runs.append([document[name] for name in ("free_run", "horizon")])
        simulated.append(simulate_experiment(folder))
    stated = runs[1][0]["validate"]["position"]
    assert runs[0][0]["validate"]["position"]["rms"]["value"] == pytest.approx(stated["rms"]["value"], rel=0.1)
    horizons = [found[1]["0.1 s"]["validate"]["position"]["rms"]["value"] for found in runs]
    assert horizons[0] == pytest.approx(horizons[1], rel=0.1)
    current = np.genfromtxt(tmp_path / "fit.csv", delimiter=",", skip_header=1)[:, 2]
    fitted, true = (found.records[0].channels for found in simulated)
    assert "rig.scale_drive_force" in simulated[0].fitted
    np.testing.assert_allclose(fitted["drive_force"], SCALE * current, rtol=0.01)
    travel = np.ptp(true["position"])
    assert np.abs(fitted["position"] - true["position"]).max() < 0.02 * travel
    # A motion of another file is in its own units.
    motion = {"time [s]": np.arange(400) * 1e-3, "drive_force [N*m]": np.full(400, 0.5)}
    other = simulate_experiment(_write(tmp_path, "0.1 +- 0.03 N*m/A"), motion=MemoryTable("motion", motion))
    assert other.records[0].channels["drive_force"] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("scale", "channel", "message"),
    [
        ("fit N*m/V", "drive_force", r"times scale = 'fit N\*m/V' is no 'N'"),
        ("fit N/X", "drive_force", r"channels\.drive_force\.scale: .*X"),
        ("fit N/A", "normal_load", r"channels\.normal_load\.scale = 'fit N/A': it can be fitted of drive_force"),
    ],
)
def test_a_scale_that_cannot_be_fitted_is_refused_in_one_line(tmp_path, scale: str, channel: str, message: str) -> None:
    folder = _write(tmp_path, scale, channel=channel)
    if channel != "drive_force":
        with (folder / "experiment.toml").open("a") as file:
            file.write('drive_force = {column = "current", scale = "0.12 N*m/A"}\n')
    refused(message, compare, folder)
