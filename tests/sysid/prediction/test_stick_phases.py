"""Stick phases: displacements of a body that friction holds, at the start of a record, and on a pulling spring."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim.effects.catalogue import find
from sim.effects.effect import Effect, Parameter
from sim.effects.friction_state_model import FrictionStateModel
from sysid.estimation.misfit import misfit
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.force_balance.stick_phases import STICK_DISPLACEMENT, find_stick_phases, presliding_displacement
from sysid.prediction.model import predict, with_effect
from sysid.prediction.problem import Problem, load_problem
from tests.experiments import write_rig
from tests.sysid.slide import NOISE, STEP, slipping_spring

POSITION_NOISE = 1e-7
LEVEL = 2.0
HELD, STRETCH, RESTING = 1.5, 4e-5, 200
TIME = np.arange(2000) * STEP
MASS, STIFFNESS, BREAK = 1.5, 3000.0, 0.8
BRISTLES = 4e5
FORCE_NOISE = 5e-4


def _values(name: str, **given: float):
    effect = find(name)
    values = {p.name: p.default for p in effect.parameters} | given
    return effect, effect.values_type(*values.values())


def _held_motion() -> np.ndarray:
    """A body that slid on, stood, was let go, and is pushed to and fro without slipping through, m, (n,)."""
    slide = np.concatenate([np.linspace(-50e-6, 0.0, 200), np.zeros(80)])
    t = np.linspace(0.0, 1.0, 800)
    return np.concatenate([slide, -0.7e-6 * (1.0 - np.cos(2.0 * np.pi * 1.5 * t)) - 3e-6 * t])


@pytest.mark.parametrize(
    "name, given, tolerance",
    [
        ("presliding", {"force": LEVEL, "stretch": 9e-6, "curvature": 2.5}, 1e-12),
        ("presliding:free_maxwell_slip", {"force": LEVEL, "stretch": 9e-6, "span": 40.0}, 1e-12),
        # Dahl's loops do not close as Masing's do: after a second turn they drift, here by a fifth of the motion.
        ("presliding:dahl", {"force": LEVEL, "stiffness": 4e5}, 1.2e-6),
    ],
)
def test_a_core_gives_way_under_a_force_as_the_force_follows_the_motion(name, given, tolerance):
    effect, p = _values(name, **given)
    x = _held_motion()
    n = x.size
    level = np.full(n, LEVEL)
    force = effect.friction_state.along_record(x, np.gradient(x, STEP), STEP * np.arange(n), level, p)
    stuck = np.where(np.arange(n) >= 200, 1.0, 0.0)
    rests = find_stick_phases(x, force, stuck, np.ones(n), np.ones(n, dtype=bool), 3, POSITION_NOISE)
    assert len(rests.spans) == 1
    moved = presliding_displacement(rests, force, level, effect.friction_state, p)
    assert np.ptp(rests.displacement[rests.scored]) > 20.0 * POSITION_NOISE
    assert np.max(np.abs(moved - rests.displacement)[rests.scored]) < tolerance


def test_a_slip_too_slow_to_see_by_its_speed_is_no_rest():
    n = 1000
    rng = np.random.default_rng(4)
    force = np.full(n, 1.2) + 1e-3 * rng.standard_normal(n)
    force[:300] = np.linspace(-2.0, 1.2, 300)
    position = POSITION_NOISE * rng.standard_normal(n)
    position[400:] += 60.0 * POSITION_NOISE * np.arange(600) / 600.0
    rests = find_stick_phases(position, force, np.ones(n), np.ones(n), np.ones(n, dtype=bool), 3, POSITION_NOISE)
    assert max([stop for _, stop in rests.spans]) <= 420 and rests.scored[100:350].any()


def test_no_rest_is_found_where_the_body_always_moves():
    position, one = np.arange(500) * 1e-6, np.ones(500)
    assert find_stick_phases(position, one, 0.0 * one, one, one == 1.0, 3, POSITION_NOISE) is None


def moved(rest: int = RESTING) -> np.ndarray:
    return 3e-4 * (1.0 - np.cos(2 * np.pi * 1.5 * np.maximum(TIME - rest * STEP, 0.0))) * (rest * STEP < TIME)


def bristle(position: np.ndarray, begin: float) -> np.ndarray:
    """One ideal spring that slips: force (n,), N, from the part `begin` of the level."""
    return HELD * slipping_spring(position, STRETCH, begin)


def record(folder: Path, force: np.ndarray, position: np.ndarray) -> Problem:
    noisy = force + NOISE * np.random.default_rng(4).standard_normal(force.size)
    columns = {"time": TIME, "position": position, "friction_force": noisy}
    stated = {"friction_force": NOISE, "position": 1e-9}
    return load_problem(write_rig(folder, "velocity-drive", {"log": columns}, ["coulomb"], noise=stated))


@pytest.mark.parametrize(
    "law,more",
    [("presliding", {"stretch": STRETCH}), ("presliding:dahl", {}), ("presliding:lugre_causal", {"damping": 350.0})],
)
@pytest.mark.parametrize("begin", [-1.0, -0.4, 0.0, 0.7])
def test_the_first_force_is_the_one_that_was_measured(tmp_path, law: str, more: dict[str, float], begin: float) -> None:
    problem = record(tmp_path, bristle(moved(), begin), moved())
    model = with_effect(problem.start, find(law), problem.scales)
    values = {f"{law}.{name}": value for name, value in {"force": HELD, **more}.items()}
    predicted = predict(problem.fit_records[0], model.effects, {**model.values, **values})["friction_force"]
    # The median of two hundred noisy rows is known to a thousandth of a newton; a record is read off at one place.
    assert predicted[:RESTING] == pytest.approx(begin * HELD, abs=5e-3)


@pytest.mark.parametrize("begin", [-1.0, 0.5])
def test_with_the_right_stretch_at_the_start_only_noise_is_left(tmp_path: Path, begin: float) -> None:
    problem = record(tmp_path, bristle(moved(), begin), moved())
    model = with_effect(problem.start, find("presliding"), problem.scales)
    values = {"presliding.force": HELD, "presliding.stretch": STRETCH, "presliding.curvature": 1.0}
    found = misfit(model.at({**model.values, **values}), problem.fit_records)["friction_force"]
    assert found.rms == pytest.approx(NOISE, rel=0.1)


def test_a_record_begins_in_slip_or_holds_its_first_force(tmp_path: Path) -> None:
    position = moved(0)[250:]
    position = np.concatenate([position, np.full(TIME.size - position.size, position[-1])])
    problem = record(tmp_path, bristle(position, 1.0), position)
    model = with_effect(problem.start, find("presliding"), problem.scales)
    values = {"presliding.force": 0.99 * HELD, "presliding.stretch": STRETCH}
    predicted = predict(problem.fit_records[0], model.effects, {**model.values, **values})["friction_force"]
    assert predicted[:50] == pytest.approx(0.99 * HELD)
    problem = record(tmp_path, HELD * np.where(TIME <= RESTING * STEP, -1.0, np.sign(np.gradient(moved()))), moved())
    predicted = predict(problem.fit_records[0], problem.start.effects, {**problem.start.values, "coulomb.force": HELD})
    assert predicted["friction_force"][:RESTING] == pytest.approx(-HELD)


@pytest.mark.parametrize("begin", [-0.4, 0.0, 0.5])
def test_a_driven_mass_that_never_slips_begins_with_its_measured_stretch(tmp_path: Path, begin: float) -> None:
    rate, mass = 2.0 * np.pi * 3.0, 2.0
    position = 0.4 * STRETCH * np.sin(rate * TIME)
    force = mass * -(rate**2) * position + HELD * (begin + position / STRETCH)
    noise = 1e-3 * np.random.default_rng(4).standard_normal(TIME.size)
    columns = {"time": TIME, "position": position, "drive_force": force + noise}
    rig, stated = {"kind": "force-drive", "input_hold": "linear"}, {"drive_force": "0.001 N", "position": "1e-11 m"}
    known = {"mass": f"{mass} kg"}
    problem = load_problem(write_rig(tmp_path, rig, {"log": columns}, ["coulomb"], known=known, noise=stated))
    model = with_effect(problem.start, find("presliding"), problem.scales)
    values = {"presliding.force": HELD, "presliding.stretch": STRETCH, "presliding.curvature": 1.0}
    found = misfit(model.at({**model.values, **values}), problem.fit_records)["drive_force"]
    # The first force is known to a fifth of the noise.
    assert found.over_noise == pytest.approx(1.0, abs=0.2)


@cache
def _pulled(bristles: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, pull and spring force (n,) of a body on bristles whose pull creeps to and fro: it holds, gives way, slips.

    The bristles are ideal springs that slip at the level, followed in small steps of their own.
    """
    n, parts = 6000, 30
    time = STEP * np.arange(n)
    pull = 1.2e-3 * np.sin(2 * np.pi * 0.35 * time) + 0.5e-3 * np.sin(2 * np.pi * 0.11 * time)
    dt, most = STEP / parts, BREAK / bristles
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
    force = force + bent * force**2 / 3.0 + FORCE_NOISE * np.random.default_rng(2).standard_normal(force.size)
    log = {"time": time, "pull_position": pull, "spring_force": force}
    known, noise = {"mass": f"{MASS} kg", "pull_stiffness": stiffness}, {"spring_force": f"{FORCE_NOISE} N"}
    return load_problem(write_rig(folder, "spring-pull", {"fit": log}, effects, known=known, noise=noise))


def _at_rest(problem: Problem, **values: float) -> tuple[ForceBalanceRecord, np.ndarray, np.ndarray]:
    balance = problem.fit_records[0]
    assert isinstance(balance, ForceBalanceRecord)
    predicted = predict(balance, problem.start.effects, {**problem.start.values, **values})[STICK_DISPLACEMENT]
    return (
        balance,
        balance.stick_phases.displacement[balance.stick_phases.scored],
        predicted[balance.stick_phases.scored],
    )


def test_rigid_friction_leaves_what_bristles_explain(tmp_path: Path) -> None:
    told = f"{STIFFNESS:g} N/m"
    rigid, shift, held = _at_rest(_written(tmp_path / "rigid", told, "coulomb", "viscous"))
    assert rigid.stick_phases.compliance == pytest.approx(1.0 / STIFFNESS)
    assert np.std(shift) > 5.0 * rigid.stick_phases.noise
    assert not held.any()
    core = {"presliding.force": BREAK, "presliding.stretch": BREAK / BRISTLES, "presliding.curvature": 1.0}
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
    assert np.std(of_spring) == pytest.approx(np.std(shift), rel=0.3) and np.corrcoef(shift, of_spring)[0, 1] > 0.9


def test_a_bent_sensor_of_the_force_bends_the_position_it_tells(tmp_path: Path) -> None:
    effects = "presliding", "viscous", "sensor_nonlinearity@spring_force"
    problem = _written(tmp_path / "bent", f"{STIFFNESS:g} N/m", *effects, bent=0.05)
    scale = problem.start.values["sensor_nonlinearity@spring_force.full_scale"]
    core = {"presliding.force": BREAK, "presliding.stretch": BREAK / BRISTLES, "presliding.curvature": 1.0}
    bend = {"sensor_nonlinearity@spring_force.second_order": 0.05 * scale / 3.0}
    _, shift, straight = _at_rest(problem, **core)
    _, _, moved = _at_rest(problem, **core, **bend)
    assert np.std(shift - moved) < 0.5 * np.std(shift - straight)


def _force(k: int, z: Any, v: Any, direction: Any, g: Any, p: Any) -> tuple[Any, Any]:
    return v - p.rise * direction * v * z / g, p.rise * z


def _slopes(k: int, z: Any, v: Any, direction: Any, g: Any, p: Any) -> tuple[Any, ...]:
    rise = p.rise * direction
    return -rise * v / g, 1.0 - rise * z / g, rise * v * z / g**2, p.rise, 0, 0


def _along(x: np.ndarray, v: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
    z = np.zeros(x.size)
    for i in range(1, x.size):
        end = np.sign(x[i] - x[i - 1]) * level[i] / p.rise
        z[i] = end + (z[i - 1] - end) * np.exp(-abs(x[i] - x[i - 1]) * p.rise / level[i])
    return p.rise * z


def test_bristles_of_a_user_have_names_of_their_own(tmp_path: Path) -> None:
    """Dahl's model; behind lost motion it acts as the library's."""
    model = FrictionStateModel("own", _force, _slopes, _along, lambda p: p.level / p.rise)
    values = [Parameter(name, unit, 1.0, 0.0, 1e9, name, "assumed") for name, unit in (("level", "N"), ("rise", "N/m"))]
    place = ("distance_since_reversal",)
    own = Effect("own", "", level=lambda a, p: p.level, friction_state=model, coordinates=place, parameters=values)
    problem = record(tmp_path, HELD * slipping_spring(moved(), STRETCH, 0.5), moved())
    found = []
    for core, names in ((own, ("level", "rise")), (find("dahl"), ("force", "stiffness"))):
        with_gap = with_effect(with_effect(problem.start, core, problem.scales), find("backlash"), problem.scales)
        numbers = dict(zip(names, (HELD, 1e5))) | {"gap": 1e-5}
        given = {key: numbers.get(key.rpartition(".")[2], value) for key, value in with_gap.values.items()}
        found.append(predict(problem.fit_records[0], with_gap.effects, given)["friction_force"])
    np.testing.assert_allclose(found[0], found[1], atol=0.02 * HELD)
