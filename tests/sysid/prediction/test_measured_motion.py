"""Motion from a noisy position: width of the filter, direction, free motions, and contradicting columns."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from sysid.compare import Comparison, compare
from sysid.diagnose import diagnose
from sysid.documents import both_json
from sysid.noise.estimate import Noise
from sysid.noise.repeats import find_quantisation_step
from sysid.prediction.force_balance.measured_motion import (
    known_direction,
    motion_filter_width,
    motion_warnings,
    position_noise,
    unknown_direction,
)
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.problem import load_problem
from sysid.signals import GaussianFilter
from tests.beside import beside
from tests.experiments import write_rig
from tests.refusals import refused

STEP, ROWS, LEVEL, DRAG = 0.01, 12000, 14.9, 2e5
SHEARS = [(26e-9, 166e-9, 0), (26e-9, 16e-9, 0), (5e-9, 166e-9, 0), (26e-9, 166e-9, 300)]


def _slow_shear(folder: Path, speed: float, noise: float, rest: int) -> Comparison:
    """Strokes of 1500 rows at `speed` per row and at three times that, each after `rest` rows without motion."""
    records = {}
    for seed, role in ((1, "fit"), (2, "validate")):
        rng, row = np.random.default_rng(seed), np.arange(ROWS)
        side = np.where((row // 1500) % 2 == 0, 1.0, -1.0)
        velocity = side * speed * np.where(row < ROWS // 2, 1.0, 3.0)
        velocity[(row % 1500 < rest) & (row >= 1500)] = 0.0
        moving = np.maximum.accumulate(np.where(velocity != 0.0, row, 0))
        sensor = rng.standard_normal(ROWS)
        force = LEVEL * side[moving] + DRAG * velocity / STEP + 0.05 * rng.standard_normal(ROWS)
        position = np.cumsum(velocity) + noise * sensor
        records[role] = {"time": STEP * row, "position": position, "friction_force": force}
    return compare(write_rig(folder, "velocity-drive", records, ["coulomb", "viscous"], noise={"position": noise}))


@pytest.mark.parametrize("shear", SHEARS)
def test_a_slow_motion_below_the_noise_of_a_row_has_no_false_reversals(tmp_path: Path, shear: tuple) -> None:
    found = _slow_shear(tmp_path, *shear)
    values, record = found.base.fitted.model.values, found.problem.fit_records[0]
    assert isinstance(record, ForceBalanceRecord)
    assert values["coulomb.force"] == pytest.approx(LEVEL, rel=5e-3)
    assert values["viscous.coefficient"] == pytest.approx(DRAG, rel=0.05)
    assert found.validate["friction_force"].over_noise == pytest.approx(1.0, abs=0.15)
    # Reversals every 1500 rows, and no others.
    assert np.count_nonzero(np.diff(record.velocity_sign[record.velocity_sign != 0.0])) == 7
    assert motion_warnings(found.problem.fit_records) == []


def test_a_rest_before_the_first_motion_is_not_compared_where_both_motions_jitter(tmp_path: Path) -> None:
    records, rows = {}, 4000
    for seed, role in ((5, "fit"), (6, "validate")):
        rng = np.random.default_rng(seed)
        time = 1e-3 * np.arange(rows)
        begun = np.maximum(time - 0.3, 0.0)
        position, velocity = 1e-3 * np.sin(20.0 * begun), 2e-2 * np.cos(20.0 * begun) * (begun > 0.0)
        side = np.where(begun > 0.0, np.sign(velocity), rng.choice([-1.0, 1.0], rows))
        position += 3e-7 * rng.standard_normal(rows)
        velocity += 2e-5 * rng.standard_normal(rows)
        force = 4.0 * side + 0.02 * rng.standard_normal(rows)
        records[role] = {"time": time, "position": position, "velocity": velocity, "friction_force": force}
    found = compare(write_rig(tmp_path, "velocity-drive", records, ["coulomb"], noise={"friction_force": 0.02}))
    assert all(0.9 <= one["friction_force"].over_noise <= 1.1 for one in (found.fit, found.validate))
    assert found.fit["friction_force"].rms < 0.25 and found.fit["friction_force"].size > rows - 400


def test_the_filter_is_as_wide_as_noise_and_quantisation_require() -> None:
    rng, row = np.random.default_rng(3), np.arange(4000.0)
    path = 20.0 * np.abs((row + 250.0) % 1000.0 - 500.0) / 500.0
    widths = []
    for size in (0.0, 1e-4, 0.01, 0.03, 0.1):
        noise = Noise(size, "m", "given")
        widths.append(motion_filter_width(path + size * rng.standard_normal(row.size), noise))
    assert widths[0] == widths[1] == 0.0 and np.all(np.diff(widths[1:]) > 0.0)
    # White noise s on a position leaves s / (2 pi^(1/4) w^(3/2)) on the velocity: a tenth of 0.04 per row.
    assert widths[-1] == pytest.approx((0.1 / (2.0 * np.pi**0.25 * 0.004)) ** (2.0 / 3.0), rel=0.2)
    assert position_noise(Noise(1e-7, "m", "given", quantisation_step=1e-6)) == pytest.approx(3.06e-7, rel=0.01)
    assert position_noise(Noise(3e-7, "m", "given", quantisation_step=1e-6, without_quantisation=1e-7)) == 3e-7


def test_the_filter_takes_out_noise_where_that_blurs_less_than_it_leaves() -> None:
    row, rng = np.arange(6000.0), np.random.default_rng(4)
    path = 3e-3 * np.sin(0.01 * row) + 2e-4 * np.sin(0.05 * row)
    gap = (row > 2000) & (row < 2100)
    bridged = np.where(gap, np.interp(row, row[~gap], path[~gap]), path)
    for size in (1e-6, 1e-5, 1e-4):
        noise, drawn = Noise(size, "m", "given"), size * rng.standard_normal(row.size)
        width = motion_filter_width(path + drawn, noise)
        smooth = GaussianFilter(width, 1.0, row.size)
        assert 0.2 < float(np.max(np.abs(smooth(path) - path)[100:-100])) / (size * smooth.noise_gain()) < 1.5
        # The corners of a bridge over a gap are no property of the motion.
        assert motion_filter_width(bridged + drawn, noise, gap) == pytest.approx(width, rel=0.25)
    assert motion_filter_width(path + 1e-8 * rng.standard_normal(row.size), Noise(1e-8, "m", "given")) == 0.0


@pytest.mark.parametrize("acts", [False, True])
def test_what_a_load_shows_and_friction_does_not_follow_is_noise_of_its_sensor(tmp_path: Path, acts: bool) -> None:
    """Taken for a load, its noise left a true model at 6 times the noise."""
    logs = {}
    for role, seed in (("fit", 1), ("validate", 2)):
        rng, time = np.random.default_rng(seed), 1e-3 * np.arange(5000)
        load, fluctuation = 10.0 + 2.0 * np.sin(2.0 * time + seed), 0.1 * rng.standard_normal(time.size)
        level = 0.3 * (load + (fluctuation if acts else 0.0)) * np.sign(np.cos(6.0 * time))
        log = {"time": time, "position": 2e-3 * np.sin(6.0 * time), "normal_load": load + fluctuation}
        logs[role] = log | {"friction_force": level + 5e-3 * rng.standard_normal(time.size)}
    effects, noise = ["coulomb", "load_dependent_friction"], {"friction_force": 5e-3}
    found = compare(write_rig(tmp_path, "velocity-drive", logs, effects, noise=noise))
    sensor = found.problem.noise.get("normal_load")
    assert (sensor.value if sensor else 0.0) == pytest.approx(0.0 if acts else 0.1, abs=0.01)
    assert 0.95 < found.validate["friction_force"].over_noise < 1.1


def test_a_load_of_a_few_values_is_read_without_a_noise(tmp_path: Path) -> None:
    rng, time = np.random.default_rng(2), 1e-3 * np.arange(3000)
    load = np.where(np.arange(time.size) % 1000 == 0, 10.0 + 0.1 * rng.standard_normal(time.size), np.nan)
    force = 3.0 * np.sign(np.cos(6.0 * time)) + 5e-3 * rng.standard_normal(time.size)
    log = {"time": time, "position": 2e-3 * np.sin(6.0 * time), "normal_load": load, "friction_force": force}
    found = compare(write_rig(tmp_path, "velocity-drive", {"fit": log, "validate": log}, ["coulomb"]))
    assert "normal_load" not in found.problem.noise and found.validate["friction_force"].over_noise < 1.2


def test_rows_of_unknown_direction_are_counted_and_reported(tmp_path: Path) -> None:
    rng, row = np.random.default_rng(5), np.arange(6000)
    # Fast strokes, and a creep that is slower than the noise left by the filter that they allow.
    velocity = np.where(row < 3000, 1e-5 * np.where(row % 300 < 150, 1.0, -1.0), 4e-7)
    position = np.cumsum(velocity) + 2e-6 * rng.standard_normal(row.size)
    force = np.sign(velocity) + 0.01 * rng.standard_normal(row.size)
    log = {"time": STEP * row, "position": position, "friction_force": force}
    both, noise = {"fit": log, "validate": log}, {"position": 2e-6}
    records = compare(write_rig(tmp_path, "velocity-drive", both, ["coulomb"], noise=noise)).problem.fit_records
    assert isinstance(records[0], ForceBalanceRecord)
    share = unknown_direction(records[0])
    creep = 4e-7 / (records[0].velocity_noise * STEP)
    assert share == pytest.approx(0.5 * (norm.cdf(2.0 - creep) - norm.cdf(-2.0 - creep)), abs=0.04)
    assert f"not known in {share:.0%} of the rows" in motion_warnings(records)[0]


@pytest.mark.parametrize(
    "factor,late,warned", [(1.0, 0, False), (0.5, 0, True), (-1.0, 0, True), (1.0, 12, True), (30.0 / np.pi, 0, True)]
)
def test_a_velocity_that_contradicts_the_position_is_reported(tmp_path, factor: float, late: int, warned: bool) -> None:
    rng = np.random.default_rng(6)
    time = 1e-3 * np.arange(4000)
    velocity = 0.02 * np.cos(2 * np.pi * 1.7 * time) + 0.01 * np.cos(2 * np.pi * 4.1 * time)
    position = sum(a / (2 * np.pi * f) * np.sin(2 * np.pi * f * time) for a, f in ((0.02, 1.7), (0.01, 4.1)))
    position = position + 1e-6 * rng.standard_normal(time.size)
    logged = factor * np.roll(velocity, late) + 1e-4 * rng.standard_normal(time.size)
    force = np.sign(velocity) + 0.01 * rng.standard_normal(time.size)
    columns = {"time": time, "position": position, "velocity": logged, "friction_force": force}
    # A position that does not come from this motion: a random walk.
    both = {"fit": columns, "validate": columns | {"position": 1e-4 * np.cumsum(rng.standard_normal(time.size))}}
    problem = compare(write_rig(tmp_path, "velocity-drive", both, ["coulomb"], noise={"position": 1e-6})).problem
    *lines, other = motion_warnings([*problem.fit_records, *problem.validate_records])
    assert bool(lines) is warned and "'position' does not follow 'velocity'" in other
    if warned:
        assert f"{1.0 / factor:.3g} times 'velocity'" in lines[0] or late
        assert not late or "0.012 s late" in lines[0]
        assert ("(0.105 is the factor of rpm and rad/s)" in lines[0]) is (factor > 2.0)


def _coast(folder: Path, known: dict[str, str], drive: float = 0.0) -> Path:
    """Coast-downs of a flywheel of 0.1 kg m^2 with Coulomb friction and quadratic drag, by Euler steps of a fiftieth of
    a row."""
    records = {}
    for seed, speed, role in ((1, 60.0, "fit"), (2, 45.0, "validate")):
        rng, angle, out = np.random.default_rng(seed), 0.0, []
        for _ in range(3000):
            out.append(angle)
            for _ in range(50):
                speed -= (0.05 + 4e-4 * speed**2 - drive) / 0.1 * 0.002 / 50.0
                angle += speed * 0.002 / 50.0
        time, angles = 0.002 * np.arange(3000), np.array(out) + 1e-4 * rng.normal(size=3000)
        records[role] = {"time": time, "position [rad]": angles, "drive_force [N*m]": 0.0 * time + drive}
    effects, noise = ["coulomb", "quadratic_drag"], {"position": "1e-4 rad"}
    return write_rig(folder, "force-drive", records, effects, known=known, noise=noise)


@pytest.mark.parametrize("drive", [0.0, 0.02])
def test_a_coast_down_of_known_inertia_gives_its_drag(tmp_path: Path, drive: float) -> None:
    found = compare(_coast(tmp_path, {"inertia": "0.1 kg*m^2"}, drive))
    values, error = found.base.fitted.model.values, found.validate["drive_force"]
    assert values["coulomb.force"] == pytest.approx(0.05, rel=0.1)
    assert values["quadratic_drag.coefficient"] == pytest.approx(4e-4, rel=0.01)
    assert error.over_noise == pytest.approx(1.0, abs=0.15)
    # The error is small compared with the force of the inertia, about 0.5 N m.
    assert error.rms < 0.05 and 80.0 < error.fit_percent < 100.0
    json.dumps(both_json(found.problem, found.fit, found.validate), allow_nan=False)


def test_coast_downs_of_unknown_inertia_and_pulses(tmp_path: Path) -> None:
    refused(r"'drive_force' does not change; without rig.known.inertia", compare, _coast(tmp_path, {}))
    assert find_quantisation_step([2.0944 * np.arange(50.0)]) is None
    assert find_quantisation_step([2.0944 * np.floor(0.3 * np.arange(200.0))]) == pytest.approx(2.0944)


def test_measured_coast_downs_show_quadratic_drag() -> None:
    assert diagnose(beside("data", "oartec_coast_forcedrive")).effect == "quadratic_drag"


@pytest.mark.parametrize("power", [2, 3])
def test_a_slow_start_out_of_a_rest_has_no_direction_before_it_is_seen(power: int) -> None:
    """A stroke, a rest of 2 s, and a return that takes 14 rows to leave a grid of 1 um by six deviations."""
    row = np.arange(400)
    start, rate = 300, 2e-6 / 14.0**power
    position = np.where(row < 100, 1e-4 * row, 1e-2) - rate * np.maximum(row - start, 0.0) ** power
    true = np.where(row < 100, 1.0, np.where(row > start, -1.0, 0.0))
    direction, _ = known_direction(np.round(position, 6), 1e-6 / np.sqrt(12.0), 0.0)
    known = (direction != 0.0) & (true != 0.0)
    assert np.array_equal(direction[known], true[known])
    assert (direction[150:200] == 1.0).all() and direction[390] == -1.0


def test_a_velocity_that_is_noise_at_rest_is_a_rest_without_a_change_of_direction(tmp_path: Path) -> None:
    """Strokes with rests: friction keeps the direction of the last motion, and the contact ages."""
    random = np.random.default_rng(5)
    speed = np.concatenate([np.repeat([v, 0.0], [150, 150]) for v in (0.02, -0.01, 0.015, -0.02)])
    moved = np.maximum.accumulate(np.where(speed != 0.0, np.arange(speed.size), 0))
    force = 6.0 * np.sign(speed[moved]) + 0.6 + 0.01 * random.standard_normal(speed.size)
    noisy = speed + 2e-5 * random.standard_normal(speed.size)
    position = np.cumsum(5e-3 * speed) + 2e-8 * random.standard_normal(speed.size)
    log = {"time": 5e-3 * np.arange(speed.size), "position": position, "velocity": noisy, "friction_force": force}
    effects, noise = ["coulomb", "direction_asymmetry"], {"friction_force": 0.01, "position": 2e-8}
    write_rig(tmp_path, "velocity-drive", {"log": log}, effects, noise=noise)
    (record,) = load_problem(tmp_path).fit_records
    known = record.valid["friction_force"]
    held = np.sign(record.measured["friction_force"][known] - 0.6)
    assert np.array_equal(record.axis.direction[known], held) and known.mean() > 0.8
    assert record.axis.contact_age.max() == pytest.approx(150 * 5e-3, rel=0.2)
    assert np.mean(record.axis.contact_age > 0.0) == pytest.approx(0.5, abs=0.1)
    turned = np.flatnonzero(np.diff(record.axis.direction))
    assert turned.size == 2 and record.axis.reversal_distance[turned[1]] == pytest.approx(150 * 5e-5, rel=0.02)


@pytest.mark.parametrize("known,said", [({"mass": "2 kg"}, True), ({}, False)])
def test_a_mass_that_an_imposed_motion_does_not_need_is_said_to_be_unused(
    tmp_path: Path, known: dict[str, str], said: bool
) -> None:
    time = np.arange(400) * STEP
    position = 1e-3 * np.sin(time)
    record = {"time": time, "position [m]": position, "friction_force [N]": 2.0 * np.sign(np.cos(time))}
    problem = load_problem(write_rig(tmp_path, "velocity-drive", {"fit": record}, ["coulomb"], known=known))
    assert any("rig.known.mass is not used" in note for note in problem.notes) == said
