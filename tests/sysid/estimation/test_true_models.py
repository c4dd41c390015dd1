"""A true model is found, at the noise and with its true values.

`closed_loop.npz` and `stick_slip.npz` hold records of an axis with LuGre friction, integrated by scipy's Radau method
with laws of its own (1 kg; 2 N, 0.6 N more at rest, 3 mm/s, 1e5 N/m, 300 N s/m, 8 N s/m): positions in nm, with a noise
of 50 nm, forces in 0.1 mN with a noise of 5 mN. The other records are made here.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from benchmarks.generators.sliding_mass import COULOMB, SPRING, Drive, Friction, slide
from benchmarks.true_models import Case, truth_of, write_experiment
from sysid.compare import compare
from sysid.diagnose import diagnose
from sysid.estimation.covariance import intervals
from sysid.estimation.fit import fit_model
from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import (
    ReferenceFit,
    along_observer,
    fit_stated_model,
    fit_with_observer,
    initial_fit,
    reference_fit,
    reported_fit,
)
from sysid.experiment_design.detectability import minimum_detectable_effects
from sysid.prediction.observable import candidate_effects
from sysid.prediction.problem import Problem, load_problem
from tests.experiments import replace_in, write_rig

TRUTH = {
    "lugre.force": (2.0, 0.01),
    "lugre.stiffness": (1e5, 0.03),
    "lugre.damping": (300.0, 0.1),
    "viscous.coefficient": (8.0, 0.1),
    "stribeck.force": (0.6, 0.03),
    "stribeck.velocity": (3e-3, 0.03),
}
"""True values, and relative errors that the records allow."""


def _lugre(
    folder: Path,
    name: str,
    mass: str | None = None,
    parameters: dict[str, Any] | None = None,
    noise: float = 50e-9,
) -> Problem:
    """The records, with further noise of the position up to `noise`, m; the known mass is another, or none."""
    stored, random = np.load(Path(__file__).parent / f"{name}.npz"), np.random.default_rng(0)
    further = np.sqrt(noise**2 - 50e-9**2)
    records = {}
    for role in ("fit", "validate"):
        columns = {"time": 1e-3 * np.arange(stored[f"{role}_position"].size)}
        for key in stored:
            if key.startswith(role):
                channel = key.removeprefix(f"{role}_")
                columns[channel] = (1e-9 if "position" in channel else 1e-4) * stored[key]
        columns["position"] += further * random.standard_normal(columns["time"].size)
        records[role] = columns
    kind, force, known = RIGS[name]
    known = known if mass is None else {"mass": mass} if mass else {}
    stated = {"position": noise, force: 5e-3}
    effects = ["lugre", "viscous", "stribeck"]
    return load_problem(write_rig(folder, kind, records, effects, known=known, noise=stated, parameters=parameters))


RIGS: dict[str, tuple[str, str, dict[str, str]]] = {
    "closed_loop": ("force-drive", "drive_force", {"mass": "1 kg"}),
    "stick_slip": ("spring-pull", "spring_force", {"pull_stiffness": "4000 N/m"}),
}


def _over_noise(problem: Problem, base: ReferenceFit) -> tuple[float, float]:
    parts = (misfit(base.fitted.model, records) for records in (problem.fit_records, problem.validate_records))
    first, second = (next(iter(part.values())).over_noise for part in parts)
    return first, second


@pytest.mark.parametrize("mass", ["1 kg", "1 +- 0.05 kg", ""])
def test_bristles_of_a_driven_mass_are_found_whatever_is_known_of_the_mass(tmp_path: Path, mass: str) -> None:
    problem = _lugre(tmp_path, "closed_loop", mass)
    base = initial_fit(problem.start, problem.fit_records, problem.scales, ())
    for key, (value, error) in TRUTH.items():
        assert base.model.values[key] == pytest.approx(value, rel=error), key
    assert base.model.values["rig.mass"] == pytest.approx(1.0, rel=0.02)
    known = intervals(base, problem.fit_records).by_key
    assert sum(known[key].low <= value <= known[key].high for key, (value, _) in TRUTH.items()) >= len(TRUTH) - 1
    held_out = misfit(base.model, problem.validate_records)["drive_force"].over_noise
    assert 0.8 <= held_out <= 1.1


@pytest.mark.parametrize("factor", [0.01, 100.0])
def test_starts_far_from_the_truth_end_at_the_same_optimum(tmp_path: Path, factor: float) -> None:
    units = {"lugre.stiffness": "N/m", "lugre.damping": "N*s/m", "stribeck.velocity": "m/s", "stribeck.force": "N"}
    keys = tuple(units)
    stated = {key: {"start": f"{factor * TRUTH[key][0]} {units[key]}"} for key in keys}
    problem = _lugre(tmp_path, "closed_loop", parameters=stated)
    base = initial_fit(problem.start, problem.fit_records, problem.scales, keys)
    for key, (value, error) in TRUTH.items():
        assert base.model.values[key] == pytest.approx(value, rel=error), key


# A known mass has an unknown less: its correction is that of the unknown one.
@pytest.mark.parametrize("mass", [pytest.param("1 kg", marks=pytest.mark.slow), ""])
def test_a_noisy_position_does_not_shift_the_values(tmp_path: Path, mass: str) -> None:
    """A noise of 0.5 um stretches the bristles by 50 mN, ten times the noise of the force."""
    problem = _lugre(tmp_path, "closed_loop", mass, noise=0.5e-6)
    along_motion = fit_stated_model(problem)
    assert along_motion.fitted.model.values["lugre.stiffness"] != pytest.approx(1e5, rel=0.1)
    problem, base = reported_fit(problem, along_motion)
    known = intervals(base.fitted, problem.fit_records).by_key
    # The noise of the acceleration attenuates a fitted mass by 1 %.
    assert base.fitted.model.values["rig.mass"] == pytest.approx(1.0, rel=5e-3)
    for key, (value, error) in TRUTH.items():
        assert known[key].value == pytest.approx(value, rel=error), key
    assert sum(known[key].low <= value <= known[key].high for key, (value, _) in TRUTH.items()) >= len(TRUTH) - 1
    assert max(_over_noise(problem, base)) < 1.1


def test_stick_slip_on_a_spring_is_found(tmp_path: Path) -> None:
    """Protects bristles found from a record of stick-slip that another integrator made."""
    problem = _lugre(tmp_path, "stick_slip")
    problem, base = fit_with_observer(problem, fit_stated_model(problem))
    for key, (value, error) in TRUTH.items():
        assert base.fitted.model.values[key] == pytest.approx(value, rel=error), key
    assert base.fitted.model.values["rig.mass"] == pytest.approx(1.0, rel=0.01)
    found = misfit(base.fitted.model, problem.validate_records)["spring_force"]
    assert found.over_noise < 1.1
    assert found.rms < 0.01  # 0.04 N along the filtered motion.


@pytest.mark.parametrize("logged", [False, True])
def test_rests_of_an_imposed_motion_have_no_direction(tmp_path: Path, logged: bool) -> None:
    """Strokes with rests between them, at which the force stays what it was, and an encoder that jitters by 30 nm."""
    records = {}
    for seed, role in enumerate(("fit", "validate")):
        random = np.random.default_rng(seed)
        speed = np.concatenate([np.repeat([v, 0.0], [200, 40]) for v in random.uniform(-0.02, 0.02, 16)])
        moved = np.maximum.accumulate(np.where(speed != 0.0, np.arange(speed.size), 0))
        force = 6.0 * np.sign(speed[moved]) + 100.0 * speed + 0.1 * random.standard_normal(speed.size)
        position = np.cumsum(5e-3 * speed) + 30e-9 * random.standard_normal(speed.size)
        columns = {"time": 5e-3 * np.arange(speed.size), "position": position, "friction_force": force}
        if logged:
            columns["velocity"] = speed + 5e-6 * random.standard_normal(speed.size)
        records[role] = columns
    stated = {"friction_force": 0.1, "position": 30e-9}
    problem = load_problem(write_rig(tmp_path, "velocity-drive", records, ["coulomb", "viscous"], noise=stated))
    base = fit_stated_model(problem)
    assert base.fitted.model.values["coulomb.force"] == pytest.approx(6.0, rel=2e-3)
    assert base.fitted.model.values["viscous.coefficient"] == pytest.approx(100.0, rel=0.02)
    assert max(_over_noise(problem, base)) < 1.1


def _pendulum(folder: Path, seconds: float, *effects: str) -> Problem:
    """A free pendulum of 1 kg m^2, 90 N m, with dry friction and drag and a ripple of force, by Euler steps."""
    records = {}
    for start, role in ((1.2, "fit"), (1.0, "validate")):
        random, angle, speed, rows = np.random.default_rng(round(10 * start)), start, 0.0, []
        for _ in range(round(200 * seconds)):
            rows.append(angle)
            for _ in range(50):
                force = -90.0 * np.sin(angle) - 1.6 * speed - 2.0 * np.sin(12.0 * angle)
                turned = speed + 1e-4 * (force - 2.7 * np.sign(speed))
                speed = 0.0 if turned * speed < 0.0 and abs(force) < 2.7 else turned
                angle += 1e-4 * speed
        angles = np.array(rows) + 1e-4 * random.standard_normal(len(rows))
        records[role] = {"time": 5e-3 * np.arange(len(rows)), "position [rad]": angles}
    known, rest = {"inertia": "1 kg*m^2"}, "[channels]\ndrive_force = {value = '0.0 N*m'}\n"
    return load_problem(write_rig(folder, "force-drive", records, effects, known=known, rest=rest))


def test_standstills_and_unchanging_drives_of_a_pendulum(tmp_path: Path) -> None:
    problem = _pendulum(tmp_path, 10.0, "coulomb", "viscous", "gravity_torque")
    fitted = fit_stated_model(problem).fitted
    known = intervals(fitted, problem.fit_records).by_key
    gravity = known["gravity_torque.amplitude"]
    assert gravity.value == pytest.approx(90.0, rel=0.05)
    assert 0.0 < gravity.high - gravity.value < 10.0
    assert np.isfinite([known[key].std for key in ("coulomb.force", "viscous.coefficient")]).all()
    problem = _pendulum(tmp_path, 1.0, "viscous")
    names = {effect.name.partition(":")[0] for effect in candidate_effects(problem, ["viscous"])}
    assert "gravity_torque" in names
    assert not names & {"drive_delay", "drive_lag", "sensor_delay", "sensor_lag"}


def test_a_dashpot_beside_the_pulling_spring_is_found(tmp_path: Path) -> None:
    random, records = np.random.default_rng(3), {}
    for role in ("fit", "validate"):
        rates, phases = 2.0 * np.pi * np.array([0.4, 0.9, 1.7]), random.uniform(0.0, 6.0, 3)
        drive = Drive(SPRING, rates, phases, np.array([3e-3, 1.2e-3, 5e-4]), stiffness=4000.0, damping=60.0)
        x, force, pull = slide(Friction(COULOMB, 2.0, 8.0), drive, 1.0, 3000, 1e-3)
        x += 5e-7 * random.standard_normal(3000)
        force += 5e-3 * random.standard_normal(3000)
        records[role] = {"time": 1e-3 * np.arange(3000), "position": x, "pull_position": pull, "spring_force": force}
    known, noise = {"pull_stiffness": "4000 N/m", "mass": "1 kg"}, {"spring_force": 5e-3, "position": 5e-7}
    effects = ["coulomb", "viscous"]
    problem = load_problem(write_rig(tmp_path, "spring-pull", records, effects, known=known, noise=noise))
    base = fit_stated_model(problem)
    found = misfit(base.fitted.model, problem.validate_records)
    assert all(0.9 <= one.over_noise <= 1.1 for one in found.values()), found
    known = intervals(base.fitted, problem.fit_records).by_key["rig.pull_damping"]
    assert known.low <= 60.0 <= known.high and known.high - known.low < 1.2


def test_sizes_that_a_model_along_the_motion_of_an_observer_leaves_undetected(tmp_path: Path) -> None:
    """Protects a search along the motion of an observer, which leaves out the sizes that it cannot detect."""
    _lugre(tmp_path, "closed_loop", noise=200e-9)
    replace_in(tmp_path / "experiment.toml", '"lugre", "viscous", "stribeck"', '"lugre", "stribeck"')
    found = diagnose(tmp_path)
    assert found.effect == "viscous" and found.best is not None
    assert all(getattr(record, "observer", None) for record in found.best.problem.fit_records)
    # The observer integrates the model that was found, and knows no other effects.
    sizes = {one.effect: one.value for one in minimum_detectable_effects(found)}
    assert "viscous" not in sizes and 0.0 < (sizes["constant_bias"] or 0.0) < 0.1


@pytest.mark.parametrize(
    ("rig", "law", "most"),
    [
        ("force-drive, open loop", "lugre", 1.1),
        ("force-drive, open loop", "elasto_plastic", 1.1),
        ("force-drive, closed loop", "presliding", 1.1),
        # The smooth yielding of the elements is corrected, but not between rows.
        pytest.param("force-drive, open loop", "presliding", 1.25, marks=pytest.mark.slow),
        ("spring-pull", "lugre_undamped", 1.12),
    ],
)
def test_error_of_a_true_model_is_the_noise(tmp_path: Path, rig: str, law: str, most: float) -> None:
    """Protects the correction of each bristle law for the noise of the position, at true values, without a fit."""
    case = Case(rig, law, 50e-9, "stated", 1)
    truth = truth_of(case)
    problem = load_problem(write_experiment(case, truth, tmp_path))
    model = problem.start.at({key: value for key, value in truth.values.items() if key in problem.start.values})
    observed = [along_observer(along_observer(record, model), model) for record in problem.fit_records]
    for channel, found in misfit(model, observed).items():
        assert 0.9 <= found.over_noise <= most, channel


@pytest.mark.parametrize(("law", "seed"), [("lugre", 9), ("elasto_plastic", 9), ("rate_and_state", 3)])
def test_a_noise_of_half_a_micrometre_does_not_shift_the_values_of_an_imposed_motion(
    tmp_path: Path, law: str, seed: int
) -> None:
    """Protects the width of the filter of an imposed motion: unfiltered, the damping is 45 % too small, the break-away
    force 57 % too large, the direct effect of the rate 77 % too small."""
    case = Case("velocity-drive", law, 500e-9, "", seed)
    truth = truth_of(case)
    found = compare(write_experiment(case, truth, tmp_path))
    assert all(0.9 <= one["friction_force"].over_noise <= 1.1 for one in (found.fit, found.validate))
    for key, one in intervals(found.base.fitted, found.problem.fit_records).by_key.items():
        # The intervals hold in 95 % of many cases, half as wide again in 99.7 %.
        half, name = 0.75 * (one.high - one.low), key.partition(":")[0] + "." + key.rpartition(".")[2]
        true = truth.values[name if ":" in key else key]
        assert abs(one.value - true) <= half and half < (0.5 if key.endswith("memory_length") else 0.45) * true, key


@pytest.mark.parametrize(
    ("rig", "std", "places"),
    [
        ("velocity-drive", 5e-4, {}),
        ("velocity-drive", 5e-4, {"position [m]": 50e-9}),
        ("force-drive, closed loop", 2e-4, {}),
    ],
)
def test_the_noise_of_a_logged_velocity_is_a_part_of_the_floor(
    tmp_path: Path, rig: str, std: float, places: dict[str, float]
) -> None:
    """Protects the noise of a logged velocity: that of an imposed one was taken for motion (a true model was at 8.7
    times the noise), that of an integrated one for white noise of the position (2.2 times). Beside an imposed position
    with less noise the velocity is derived from that."""
    case = Case(rig, "coulomb", 50e-9, "stated", 9)
    truth = truth_of(case)
    force = "friction_force" if rig == "velocity-drive" else "drive_force"

    def columns(record: int) -> dict[str, np.ndarray]:
        exact = truth.columns(record)
        rate = CubicSpline(exact["time [s]"], exact["position [m]"])(exact["time [s]"], 1)
        logged = {name: exact[name] for name in ("time [s]", *places)}
        return logged | {"velocity [m/s]": rate, f"{force} [N]": exact[f"{force} [N]"]}

    noise = {**places, "velocity [m/s]": std, f"{force} [N]": 5e-3}
    found = compare(write_experiment(case, replace(truth, columns=columns, noise=noise), tmp_path))
    assert all(0.85 <= one[force].over_noise <= 1.1 for one in (found.fit, found.validate))
    known = intervals(found.base.fitted, found.problem.fit_records).by_key
    for key, one in ((key, known[key]) for key in truth.values if key in known):
        half = one.high - one.value
        assert abs(one.value - truth.values[key]) <= half < (0.01 if places else 0.04) * truth.values[key], key


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize(
    ("rig", "law", "inputs"),
    [
        ("spring-pull", "coulomb", {"pull_position [m]": 5e-6}),
        ("actuator-tip", "sensor_lag", {"voltage_1 [V]": 0.5, "voltage_2 [V]": 0.5}),
        ("friction-drive", "coulomb", {"voltage_1 [V]": 0.1, "voltage_2 [V]": 0.1}),
    ],
)
def test_noise_of_a_logged_input_is_a_part_of_the_floor(
    tmp_path: Path, rig: str, law: str, inputs: dict[str, float], stated: bool
) -> None:
    """That of a logged path is also estimated: a true model was at 4.2 times the noise. That of voltages is not."""
    case = Case(rig, law, 5e-9 if rig == "actuator-tip" else 50e-9, "stated", 9)
    truth = truth_of(case)
    write_experiment(case, replace(truth, noise=truth.noise | inputs), tmp_path)
    if not stated:
        lines = (tmp_path / "experiment.toml").read_text().split("\n")
        kept = [line for line in lines if line.partition(" =")[0] + " " not in "".join(inputs)]
        (tmp_path / "experiment.toml").write_text("\n".join(kept))
    found = compare(tmp_path)
    worst = max(one.over_noise for one in found.validate.values())
    assert (0.9 < worst < 1.1) == (stated or rig != "actuator-tip"), worst


def test_rounding_by_an_encoder_is_not_averaged_where_a_body_sticks(tmp_path: Path) -> None:
    """With steps of 5 um the position of a true model was at 2.9 times the noise."""
    case = Case("spring-pull", "coulomb", 10e-9, "stated", 9)
    truth = truth_of(case)
    path = write_experiment(case, truth, tmp_path)
    for file in tmp_path.glob("*.csv"):
        table = np.loadtxt(file, delimiter=",", skiprows=1)
        table[:, 1] = 5e-6 * np.round(table[:, 1] / 5e-6)
        np.savetxt(file, table, "%.12g", ",", header=file.read_text().split("\n", 1)[0], comments="")
    assert file.read_text().startswith("time [s],position [m]")
    text = (path / "experiment.toml").read_text()
    (path / "experiment.toml").write_text(text.replace('position = "1e-08 m"', 'position = "1.44e-06 m"'))
    found = compare(path)
    assert all(0.8 < one.over_noise < 1.2 for records in (found.fit, found.validate) for one in records.values())


def test_bristles_too_stiff_for_the_motion_are_no_explanation(tmp_path: Path) -> None:
    """Along a stretch of 20 nm for 45 um the least noise of the position moves the force by as much as the model errs:
    by its own deviations that fit is at the noise."""
    case = Case("spring-pull", "presliding", 0.0, "unknown", 5)
    truth = truth_of(case)
    problem = load_problem(write_experiment(case, truth, tmp_path))
    found = initial_fit(problem.start, problem.fit_records, problem.scales, ())
    for key in ("presliding.stretch", "presliding.curvature", "stribeck.velocity"):
        assert found.model.values[key] == pytest.approx(truth.values[key], rel=0.05), key


@pytest.mark.parametrize(
    ("rig", "law", "mass"),
    [
        ("force-drive, open loop", "dahl", "stated"),
        pytest.param("force-drive, closed loop", "dahl", "unknown", marks=pytest.mark.slow),
        pytest.param("force-drive, open loop", "presliding", "stated", marks=pytest.mark.slow),
    ],
)
def test_shapes_lost_in_the_blur_are_found_along_the_observer(tmp_path: Path, rig: str, law: str, mass: str) -> None:
    """With a noise of 0.5 um the Stribeck curve found along the filtered motion is 0.007 N, or a fifth too small, and
    the stretch of Maxwell-slip elements a sixth of the true one."""
    case = Case(rig, law, 500e-9, mass, 281127)
    truth = truth_of(case)
    problem = load_problem(write_experiment(case, truth, tmp_path))
    blurred = {"stribeck.force": 0.007, "stribeck.velocity": 3.3e-3, "presliding.stretch": 5.5e-6}
    start = {key: value for key, value in (truth.values | blurred).items() if key in problem.start.values}
    base = reference_fit(problem, fit_model(problem.start.at(start), problem.fit_records))
    problem, base = fit_with_observer(problem, base)
    for key in ("stribeck.force", "stribeck.velocity"):
        assert base.fitted.model.values[key] == pytest.approx(truth.values[key], rel=0.03), key
    for records in (problem.fit_records, problem.validate_records):
        assert misfit(base.fitted.model, records)["drive_force"].over_noise < 1.1
