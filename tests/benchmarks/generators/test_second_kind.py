"""The second generator against closed forms, its records against their key, and its independence of the library."""

import ast
import itertools
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import benchmarks.generators
from benchmarks.generators.second_kind import axis, cases, hidden, loggers, machines, make_case, refit
from benchmarks.generators.second_kind.axis import Chain, Motion, Run, run_axis
from benchmarks.generators.second_kind.friction_laws import FORMS, Ageing, Bristles, Curve, Law, State
from benchmarks.generators.second_kind.machines import RIGS, Machine, draw_machine
from benchmarks.generators.second_kind.motions import MOTIONS, reference
from benchmarks.generators.second_kind.tip import creep, relays, second_order
from sysid.experiment.experiment import load_experiment
from sysid.experiment.record import load_records

COULOMB, VISCOUS, MASS = 2.0, 3.0, 1.5


def machine(rig: str, rows: int = 2000, **changes: float) -> Machine:
    m = draw_machine(np.random.default_rng(1), rig, curve=False)
    plain = {"coulomb": COULOMB, "viscous": 0.0, "mass": MASS, "rate": 1000.0, "rows": rows, "stiffness": 900.0}
    return replace(m, **(plain | changes))


def run(m: Machine, laws: list[Law], *, position=None, velocity=None, command=None, chain: Chain | None = None) -> Run:
    zero = np.zeros(m.rows)
    position, velocity = (zero if y is None else y for y in (position, velocity))
    return run_axis(m, Motion(position, velocity, zero, zero, zero, command), laws, chain or Chain())


def test_a_free_axis_moves_as_the_closed_forms() -> None:
    m = machine("force-drive")
    out = run(m, [], command=np.full(m.rows, 5.0))
    t = np.arange(m.rows) * m.step
    np.testing.assert_allclose(out.position, 0.5 * (5.0 - COULOMB) / MASS * t**2, rtol=1e-9, atol=1e-12)
    m = machine("force-drive", rows=6000, viscous=VISCOUS)
    out = run(m, [], command=np.full(m.rows, 5.0))
    t = np.arange(m.rows) * m.step
    np.testing.assert_allclose(out.velocity, -np.expm1(-t * VISCOUS / MASS) * (5.0 - COULOMB) / VISCOUS, atol=1e-3)
    m = machine("force-drive")
    assert np.all(run(m, [], command=np.full(m.rows, 0.999 * COULOMB)).position == 0.0)
    assert run(m, [], command=np.full(m.rows, 1.001 * COULOMB)).position[-1] > 0.0


def test_the_spring_releases_the_axis_with_undamped_overshoot_and_balances_its_work() -> None:
    m, speed = machine("spring-pull", rows=4000), 4e-3
    out = run(m, [], position=speed * np.arange(m.rows) * m.step, velocity=np.full(m.rows, speed))
    release, t = COULOMB / (m.stiffness * speed), np.arange(m.rows) * m.step
    assert np.all(out.position[t < release - 2e-3] == 0.0)
    # Then it follows at v0 (1 - cos w t): never faster than twice the pull.
    assert out.velocity.max() == pytest.approx(2 * speed, rel=0.01)
    m = machine("spring-pull", rows=5000, viscous=VISCOUS, stiffness=4000.0)
    _, v, _ = reference(np.random.default_rng(3), "triangle", replace(m, speed=0.05, slow=0.02, reach=0.03))
    x = np.concatenate([[0.0], np.cumsum(0.5 * m.step * (v[1:] + v[:-1]))])
    out = run(m, [], position=x, velocity=v)
    pulled = np.sum(0.5 * (out.force[1:] + out.force[:-1]) * np.diff(x))
    lost = np.sum((COULOMB * np.abs(out.velocity) + VISCOUS * out.velocity**2) * m.step)
    stored = 0.5 * m.stiffness * (x[-1] - out.position[-1]) ** 2 + 0.5 * MASS * out.velocity[-1] ** 2
    assert pulled == pytest.approx(lost + stored, rel=0.01)


@pytest.mark.parametrize(
    ("name", "rig"),
    [("flexible_mode", "spring-pull"), ("magnetic_cogging", "force-drive"), ("stribeck", "force-drive"),
     ("drive_lag", "force-drive"), ("presliding", "spring-pull"), ("backlash", "spring-pull")],
)  # fmt: skip
def test_a_tenth_of_the_time_step_changes_little_of_what_the_effect_does(name: str, rig: str, monkeypatch) -> None:
    effect = next(h for h in hidden.NAMED if h.name == name and rig in h.rigs)
    rng = np.random.default_rng(1)
    m = replace(draw_machine(rng, rig, curve=False), rows=1500)
    x, v, a = reference(rng, "random_steps", m)
    build, positions = effect.draw(rng, m), []
    for hide, finest in ((False, axis.FINEST), (True, axis.FINEST), (True, 0.1 * axis.FINEST)):
        monkeypatch.setattr(axis, "FINEST", finest)
        setting = build(1.0) if hide else hidden.Setting()
        zero = np.zeros(m.rows)
        positions.append(run_axis(m, Motion(x, v, a, zero, zero), setting.laws, setting.chain).position)
    plain, usual, finer = positions
    assert np.std(usual - finer) < 0.05 * np.std(usual - plain)


@pytest.mark.parametrize("form", FORMS)
def test_steady_speeds_give_the_static_curve(form: str) -> None:
    m = machine("velocity-drive", viscous=VISCOUS)
    speeds = np.repeat([1e-4, 1e-3, 4e-3, 2e-2], m.rows // 4)
    out = run(m, [Curve(0.8, 2e-3, form)], position=np.cumsum(speeds) * m.step, velocity=speeds)
    a = speeds / 2e-3
    shape = {
        "power_2": np.exp(-(a**2)), "power_1": np.exp(-a), "lorentzian": 1 / (1 + a**2),
        "power_law": (1 + a) ** -1.5, "hyperbolic": 2 / (np.exp(a) + np.exp(-a)),
    }[form]  # fmt: skip
    np.testing.assert_allclose(out.force, COULOMB + 0.8 * shape + VISCOUS * speeds, rtol=1e-9)


def test_memory_age_bristles_and_relays_have_their_closed_forms() -> None:
    state, h = State(), 1e-3
    late, far = Curve(1.0, 1e-3, "power_1", delay=0.02), Curve(1.0, 1e-3, "power_1", way=1e-4)
    state.v = 2e-3
    for _ in range(30):
        late.advance(state, h)
        far.advance(state, h)
    assert late.seen == pytest.approx(2e-3 * -np.expm1(-0.03 / 0.02))
    assert far.seen == pytest.approx(2e-3 * -np.expm1(-30 * h * 2e-3 / 1e-4))
    law, state = Ageing(1.0, 0.1, 1e-4), State()
    for _ in range(1000):
        law.advance(state, 1e-3)
    assert law.value(state) == pytest.approx(np.log1p(1.0 / 0.1))
    state.v = 1e-2
    for _ in range(1000):
        law.advance(state, 1e-3)
    assert law.age == pytest.approx(1e-4 / 1e-2)
    u = np.concatenate([np.zeros(5), np.ones(4000)])
    out = creep([0.02, 0.03], [0.01, 0.2])(u, 1e-3)
    assert out[5] == 1.0 and out[-1] == pytest.approx(1.05)
    assert out[5 + 200] == pytest.approx(1.02 + 0.03 * -np.expm1(-1.0), abs=1e-3)
    ramp = np.arange(3000) * 1e-3
    out = second_order(0.02, 0.8)(ramp, 1e-3)
    assert ramp[-1] - out[-1] == pytest.approx(0.02, rel=1e-3)
    first, again = Bristles(1e-3), Bristles(1e-3)
    again.moved(1.0)
    assert again.value(State()) == pytest.approx(1.0)
    for way in (1e-4, 5e-4, 2e-3):
        first.moved(way)
        again.moved(-2 * way)
        assert 1.0 - again.value(State()) == pytest.approx(2 * first.value(State()))

    def steps(*levels: float) -> np.ndarray:
        points = np.concatenate([np.linspace(a, b, 200) for a, b in itertools.pairwise(levels)])
        return relays(24, 0.0, 100.0, 7.0)(points, 1e-3) - points

    out = steps(-10.0, 110.0, -10.0)
    assert (out[0], out[199], out[-1]) == pytest.approx((-7.0, 7.0, -7.0))
    inner = steps(-10.0, 80.0, 30.0, 60.0, 30.0, 80.0)
    assert inner[-1] == pytest.approx(inner[199]) and inner[399] == pytest.approx(inner[799])
    assert inner[499] != pytest.approx(inner[699], abs=1e-3)


@pytest.mark.parametrize("colour", ["white", "ar", "pink"])
def test_the_stated_noise_is_the_rms_at_standstill_with_everything_in_it(colour: str) -> None:
    rng = np.random.default_rng(5)
    how = replace(
        loggers.draw_logger(rng, machine("velocity-drive")),
        colour=colour, rho=0.7, hum=0.5, outliers=1e-3, lsb=1.5, mains=50.0,
    )  # fmt: skip
    rms = [np.std(loggers.logged_noise(rng, np.zeros(20_000), 3.0, how, 1000.0)) for _ in range(10)]
    assert np.mean(rms) == pytest.approx(3.0, rel=0.03)


@pytest.mark.parametrize("kind", MOTIONS)
def test_references_begin_at_rest_and_stay_within_their_bounds(kind: str) -> None:
    rng = np.random.default_rng(6)
    for rig in ("velocity-drive", "force-drive"):
        m = draw_machine(rng, rig)
        x, v, a = reference(rng, kind, m)
        assert x[0] == v[0] == 0.0 and np.ptp(x) < 2.0 * m.reach and np.abs(v).max() > 0.2 * m.speed
        np.testing.assert_allclose(np.diff(x), 0.5 * m.step * (v[1:] + v[:-1]), atol=1e-12)
        assert np.abs(a).max() < 1.5 * m.acceleration


def test_the_same_seed_gives_the_same_case_and_the_classes_their_shares() -> None:
    one, two, other = make_case(3, 1, "none"), make_case(3, 1, "none"), make_case(4, 1, "none")
    assert (one.toml, one.csv, one.key) == (two.toml, two.csv, two.key) and one.csv != other.csv
    listed = cases.classes(9, 50)
    assert {name: listed.count(name) for name in cases.CLASSES} == {"named": 30, "two": 6, "none": 7, "unknown": 7}


@pytest.mark.parametrize(("rig", "style"), [(RIGS[0], 1), (RIGS[1], 2), (RIGS[2], 2), (RIGS[3], 0)])
def test_the_projects_reader_accepts_the_files_and_finds_the_stated_noise(rig, style, tmp_path, monkeypatch) -> None:
    effect = next(h for h in hidden.NAMED if h.name in ("constant_bias", "gain_mismatch") and rig in h.rigs)
    monkeypatch.setitem(machines.MOST_ROWS, rig, 4000)
    draw = cases.draw_logger
    monkeypatch.setattr(cases, "draw_logger", lambda rng, m: replace(draw(rng, m), style=style, given=True))
    case = _drawn(rig, effect)
    case.write(tmp_path)
    experiment = load_experiment(tmp_path)
    assert experiment.rig.kind == rig
    for record in load_records(experiment):
        assert record.time.size == case.key["rows"] and record.noise.keys() == case.key["noise"].keys()
        for name, sigma in record.noise.items():
            assert sigma == pytest.approx(case.key["noise"][name], rel=5e-3)


def _drawn(rig: str, effect: hidden.Hidden) -> cases.Case:
    for attempt in range(30):
        try:
            return cases.draw_case(np.random.default_rng([2, attempt]), "named", rig, [effect])
        except cases.UnfitError:
            continue
    raise AssertionError("no case")


def test_what_is_visible_is_what_a_refit_of_the_logged_record_leaves() -> None:
    """A constant force on a prescribed motion: the rms residual of a refit is sqrt(1 + visible^2) times the noise."""
    effect = next(h for h in hidden.NAMED if h.name == "constant_bias")
    rng = np.random.default_rng(8)
    m = machine("velocity-drive", rows=8000, viscous=VISCOUS, speed=0.05, slow=0.01, reach=0.03)
    x, v, _ = reference(rng, "triangle", m)
    moving = np.flatnonzero(v != 0.0)
    force = run(m, effect.draw(rng, m)(1.0).laws, position=x, velocity=v).force
    logged = {"force": force, "position": x, "velocity": v, "side": np.sign(v), "normal_load": x, "temperature": x}
    sigma = 0.02
    (seen,) = refit.left([refit.axis_problem(m, logged, sigma, 0.0, False)])
    noisy = force[moving] + sigma * rng.standard_normal(moving.size)
    columns = np.column_stack([np.sign(v), v])[moving]
    rest = noisy - columns @ np.linalg.lstsq(columns, noisy, rcond=None)[0]
    assert seen > 3.0 and np.sqrt(np.mean(rest**2)) / sigma == pytest.approx(np.hypot(1.0, seen), rel=0.05)


def test_no_generator_imports_the_program_and_this_one_numpy_and_scipy_alone() -> None:
    paths = list(Path(benchmarks.generators.__file__).parent.rglob("*.py"))
    assert len(paths) > 30
    for path in paths:
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
        names |= {node.module or "" for node in nodes if isinstance(node, ast.ImportFrom) and node.level == 0}
        packages = {name.split(".")[0] for name in names}
        assert not packages & {"stagecad", "designcalc", "drawings", "sim", "sysid", "workbench"}, path
        if path.parent.name == "second_kind":
            assert packages - sys.stdlib_module_names <= {"numpy", "scipy"}, path
