"""The integrator against closed solutions: order, tolerance, corners, jumps, failures; and the cache of kernels."""

import math
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from sim.effects.catalogue import compose, find
from sim.integration import drive, integrator
from sim.integration.compiled import kernels, views
from sim.integration.drive import SHARE, Drive, compressed, force_at
from sim.integration.integrator import Surroundings, plan_of
from sim.integration.simulate import SimulationError, simulate
from sim.numerics import compilation
from tests.refusals import refused

NO_FORCE = drive.force([0.0, 1.0], [0.0, 0.0])
NO_SURROUNDINGS = Surroundings(np.full((1, 2), np.nan))
TIME = 1e-4 * np.arange(20_001)
MODEL = compose(["lugre", "stribeck", "viscous"])


def damped_oscillation(time, stiffness=50.0, drag=0.4):
    """From x = 1 at rest, unit mass."""
    decay = drag / 2.0
    w = math.sqrt(stiffness - decay**2)
    return np.exp(-decay * time) * (np.cos(w * time) + decay / w * np.sin(w * time))


def test_error_and_dense_output_follow_the_tolerance():
    model = compose(["viscous", "cable_spring"], {"cable_spring.stiffness": 50.0})
    time = np.linspace(0.0, 5.0, 501)
    errors, steps = [], []
    for tolerance in (1e-6, 1e-8, 1e-10, 1e-12):
        run = simulate(model, NO_FORCE, time, position=1.0, tolerance=tolerance)
        errors.append(np.abs(run.position - damped_oscillation(time)).max())
        steps.append(run.steps)
        assert errors[-1] < 30.0 * tolerance
    # A hundredth of the tolerance takes 100^(1/5) = 2.5 times the steps.
    assert steps[3] / steps[1] == pytest.approx(100.0 ** (2.0 / 5.0), rel=0.2)
    model = compose(["cable_spring"], {"cable_spring.stiffness": 50.0})
    fine = np.linspace(0.0, 2.0, 20_001)
    run = simulate(model, NO_FORCE, fine, position=1.0, tolerance=1e-9)
    assert run.steps < 600 and np.abs(run.position - np.cos(math.sqrt(50.0) * fine)).max() < 5e-8
    # Unit mass, viscous 0.4: v' = u - 0.4 v, solved piece by piece.
    pushes = drive.Drive(np.array([0.0, 0.37, 0.71]), np.array([1.0, -2.0, 0.0]), np.zeros(3))
    time = np.array([0.0, 0.37, 0.71, 1.3])
    run = simulate(compose(["viscous"]), pushes, time, tolerance=1e-10)
    v = 0.0
    for begin, end, push, found in zip(time, time[1:], [1.0, -2.0, 0.0], run.velocity[1:]):
        v = push / 0.4 + (v - push / 0.4) * math.exp(-0.4 * (end - begin))
        assert found == pytest.approx(v, abs=1e-10)


def test_sliding_to_rest_and_a_wave_of_force():
    run = simulate(compose(["coulomb"]), NO_FORCE, np.linspace(0.0, 1.0, 101), velocity=0.5)
    assert run.position[-1] == pytest.approx(0.5**2 / 2.0, abs=2e-6)  # but for the bristle's own 1e-8 m and 1e-4 s
    assert abs(run.velocity[-1]) < 1e-9
    # x'' + 50 x = cos(3 t): steady part cos(3t)/41 started on it.
    wave = Drive(np.zeros(1), np.zeros(1), np.zeros(1), wave=(1.0, 3.0, 0.0), stiffness=50.0)
    time = np.linspace(0.0, 4.0, 41)
    run = simulate(compose([]), wave, time, position=1.0 / 41.0, tolerance=1e-11)
    assert np.abs(run.position - np.cos(3.0 * time) / 41.0).max() < 1e-10


@pytest.mark.parametrize("core", ["lugre", "lugre_undamped", "lugre_causal", "dahl", "coulomb"])
def test_a_loose_tolerance_stays_near_a_tight_one_through_reversals(core):
    model = compose([core, "stribeck", "viscous"])
    push = drive.force([0.0, 0.2, 0.4, 0.6], [0.0, 2.5, -2.5, 0.0])
    time = np.linspace(0.0, 0.6, 61)
    exact = simulate(model, push, time, tolerance=1e-13)
    for tolerance in (1e-6, 1e-8, 1e-10):
        run = simulate(model, push, time, tolerance=tolerance)
        assert np.abs(run.position - exact.position).max() < 100.0 * tolerance * 1e-1 + 1e-13


def test_travel_age_and_load_are_carried():
    # run_in: the factor falls with the distance travelled; steady sliding has a closed form.
    model = compose(["coulomb", "run_in"], {"run_in.excess": 0.5, "run_in.distance": 0.1})
    time = np.linspace(0.0, 1.0, 11)
    run = simulate(model, drive.sinusoidal_velocity(0.0, 0.0, 0.2), time, tolerance=1e-10)
    assert np.allclose(run.level, 1.0 + 0.5 * np.exp(-0.2 * time / 0.1), rtol=1e-9)
    with pytest.raises(SimulationError, match="not finite"):
        simulate(compose(["coulomb", "load_dependent_friction"]), drive.force([0, 1], [0, 2]), np.linspace(0, 1, 5))
    # Unit mass under 3 N against 1 N of friction in proportion to a load 10 + 4 sin(5 t) N over 10 N, sliding on.
    names = ["coulomb", "load_dependent_friction"]
    values = {"coulomb.force": 1.0, "coulomb.stretch": 1e-9, "load_dependent_friction.sensitivity": 1.0}
    model = compose(names, {**values, "load_dependent_friction.reference": 10.0})
    time = np.linspace(0.0, 2.0, 2001)
    load = 10.0 + 4.0 * np.sin(5.0 * time)
    run = simulate(model, drive.force([0.0, 2.0], [3.0, 3.0]), time, velocity=1.0, load=load, bristle=[1.0])
    velocity = 1.0 + 2.0 * time - 0.4 / 5.0 * (1.0 - np.cos(5.0 * time))
    # The load is linear between its instants: 25 * 0.4 (1 ms)^2 / 12 of its integral is missing.
    assert run.velocity == pytest.approx(velocity, abs=1e-6) and run.level == pytest.approx(load / 10.0, abs=1e-12)
    steady = simulate(model, drive.force([0.0, 2.0], [3.0, 3.0]), time, velocity=1.0, load=10.0, bristle=[1.0])
    assert steady.velocity == pytest.approx(1.0 + 2.0 * time, abs=1e-8)


def test_laws_that_rise_with_dwell_or_meet_in_level_and_force():
    """A mass pulled from rest after a wait: it slips once the pull exceeds the level that the age has built up."""
    names = ["coulomb", "dwell_strengthening"]
    values = {"dwell_strengthening.force": 0.1, "dwell_strengthening.cut_off": 0.05}
    slips = []
    for wait in (0.1, 10.0):
        push = drive.force([0.0, wait, wait + 4.0], [0.0, 0.0, 4.0])
        time = np.linspace(0.0, wait + 4.0, 8001)
        run = simulate(compose(names, values), push, time)
        begin = np.argmax(run.position > 1e-7)  # ten stretches of the Coulomb bristle, a hundredth of the memory length
        slips.append(float(run.drive[begin]))
        assert slips[-1] == pytest.approx(1.0 + 0.1 * math.log1p(time[begin] / 0.05), rel=0.02)
    assert slips[1] > slips[0] + 0.1
    names = ["lugre", "stribeck", "viscous", "quadratic_drag", "cable_spring", "magnetic_cogging", "constant_bias"]
    names += ["position_dependent_friction", "load_dependent_friction", "temperature_dependent_friction"]
    model = compose(names, {"temperature_dependent_friction.reference": 20.0})
    time = np.linspace(0.0, 0.5, 11)
    exact = simulate(model, drive.force([0.0, 0.5], [0.0, 6.0]), time, load=1.5, temperature=22.0, tolerance=1e-13)
    run = simulate(model, drive.force([0.0, 0.5], [0.0, 6.0]), time, load=1.5, temperature=22.0, tolerance=1e-9)
    assert np.abs(run.position - exact.position).max() < 1e-9
    # The order holds only with every slope in the Jacobian.
    finer = simulate(model, drive.force([0.0, 0.5], [0.0, 6.0]), time, load=1.5, temperature=22.0, tolerance=1e-11)
    assert finer.steps / run.steps < 1.2 * 100.0**0.2


@pytest.mark.parametrize(("arguments", "message"), [
    ({"mass": 0.0}, "mass = 0 kg; must be positive"), ({"mass": math.nan}, "must be positive"),
    ({"temperature": -300.0}, "temperature = -"), ({"load": -5.0}, "load = -"),
    ({"tolerance": 1e-20}, "tolerance = 1e-20; must lie between"),
])  # fmt: skip
def test_an_argument_out_of_range_says_so(arguments, message):
    refused(message, simulate, compose(["viscous"]), NO_FORCE, np.linspace(0.0, 1.0, 3), **arguments)
    refused("increase strictly", simulate, compose(["viscous"]), NO_FORCE, np.array([0.0, 1.0, 1.0]))


def test_too_many_steps_is_a_failure_with_its_place():
    with pytest.raises(SimulationError, match=r"stopped at t = .* velocity .*: too many steps"):
        simulate(compose(["lugre"]), drive.force([0, 1], [0, 2]), np.linspace(0, 1, 5), most_steps=20)


def test_a_law_called_back_in_python_gives_what_the_compiled_one_gives():
    slow = replace(find("stribeck"), name="my_stribeck", level=lambda a, p: find("stribeck").level(a, p), slopes={})
    for name in ("viscous", "stribeck", "quadratic_drag", "position_dependent_friction", "gravity_torque"):
        assert kernels.effect_kernel(find(name)).compiled
    assert not kernels.effect_kernel(slow).compiled
    time = np.linspace(0.0, 1.0, 21)
    push = drive.force([0.0, 1.0], [0.0, 2.5])
    fast = simulate(compose(["lugre", "stribeck"]), push, time)
    assert np.allclose(simulate(compose(["lugre", slow]), push, time).position, fast.position, rtol=1e-7)


OUTER = """\
from inner import law
from sim.numerics.compilation import compile_function

def _twice(x):
    return 2.0 * law(x)

twice = compile_function(_twice)
"""
INNER = """\
from sim.numerics.compilation import INLINED, compile_function

def _law(x):
    return {} * x

law = compile_function(_law, **INLINED)
"""
OF_ITS_OWN = """\
import laws
from sim.numerics.compilation import compile_function
print(compile_function(laws.outer, [laws.__file__])(2.0))
"""


@pytest.mark.parametrize(
    ("name", "text", "program"),
    [
        ("laws.py", "def outer(x):\n    return x * {}\n", OF_ITS_OWN),
        ("inner.py", INNER, "from outer import twice; print(twice(1.0))"),
    ],
    ids=["its own file", "that of a function that it calls"],
)
def test_a_function_is_compiled_anew_when_a_file_is_edited(tmp_path, name: str, text: str, program: str) -> None:
    """An edited law must not leave old machine code in use."""
    (tmp_path / "outer.py").write_text(OUTER)
    path, cache = os.pathsep.join([str(tmp_path), os.getcwd()]), str(tmp_path / "cache")
    environment = {**os.environ, "PYTHONPATH": path, "STAGECAD_CACHE": cache, "PYTHONDONTWRITEBYTECODE": "1"}
    answers = []
    for factor in (3.0, 5.0):
        (tmp_path / name).write_text(text.format(factor))
        # The same time stamp and size: numba's own key would not see the edit.
        os.utime(tmp_path / name, (1e9, 1e9))
        run = [sys.executable, "-c", program]
        answers.append(float(subprocess.run(run, env=environment, capture_output=True, text=True, check=True).stdout))
    assert answers == [6.0, 10.0]
    assert list((tmp_path / "cache").rglob("*.nbi"))


def test_kernels_long_unused_are_removed_when_new_ones_are_made(tmp_path, monkeypatch):
    monkeypatch.setenv("STAGECAD_CACHE", str(tmp_path))
    compilation.cache_folder.cache_clear()
    try:
        root = compilation.cache_folder()
        for name, age in (("old", 400), ("recent", 1)):
            (root / name).mkdir()
            stamp = (root / name).stat().st_mtime - 86400.0 * age
            os.utime(root / name, (stamp, stamp))
        kept = compilation.key_folder([__file__])
        assert sorted(folder.name for folder in root.iterdir()) == sorted([kept.name, "recent"])
    finally:
        compilation.cache_folder.cache_clear()


def test_the_cache_falls_back_where_it_cannot_be_written(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setenv("STAGECAD_CACHE", str(blocked))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "other"))
    compilation.cache_folder.cache_clear()
    try:
        assert compilation.cache_folder() == tmp_path / "other" / "stagecad" / "kernels"
    finally:
        compilation.cache_folder.cache_clear()


@pytest.mark.parametrize(
    "effects", [["lugre_causal", "stribeck"], ["coulomb", "backlash", "drive_lag", "flexible_mode"]]
)
def test_what_is_compiled_before_the_laws_are_laid_out_is_what_the_model_needs(effects, monkeypatch):
    kinds = []
    monkeypatch.setattr(integrator, "begin_compilation", lambda arguments: kinds.append(views._kind(arguments())))
    integrate = integrator.integrate

    def noted(problem, start, tolerance, output):
        kinds.append(views._kind((problem, tolerance, output)))
        integrate(problem, start, tolerance, output)

    monkeypatch.setattr(integrator, "integrate", noted)
    pull = drive.pulled_spring([0.0, 1.0], [0.0, 1e-3], 1000.0)
    for settings in ({}, {"energy": True, "forces": False}):
        simulate(compose(effects), pull, np.linspace(0.0, 0.01, 3), **settings)
    assert len(kinds) == 4 and len(set(kinds)) == 1


def test_a_coast_of_ten_metres_a_second_and_a_pull_of_a_nanometre():
    """v^2/(2 a) = 50 m; a spring of 1e6 N/m against bristles of 1e5 N/m moves the mass by 1e6/1.1e6 of the pull."""
    coast = simulate(compose(["coulomb"]), drive.force([0.0, 12.0], [0.0, 0.0]), [0.0, 12.0], velocity=10.0)
    assert coast.position[-1] == pytest.approx(50.0, abs=1e-3)
    pull = drive.pulled_spring([0.0, 0.1, 1.0], [0.0, 1e-9, 1e-9], 1e6)
    held = simulate(compose(["lugre"], {"lugre.stiffness": 1e5}), pull, [0.0, 1.0], tolerance=1e-9)
    assert held.position[-1] / 1e-9 == pytest.approx(0.9091, abs=1e-4)


def logged_pull(jitter: float) -> drive.Drive:
    """A pull of 0.1 m/s with a slow wander, as a noisy encoder logged it at 10 kHz."""
    noise = np.cumsum(np.random.default_rng(3).standard_normal(TIME.size)) * jitter
    return drive.pulled_spring(TIME, 0.1 * TIME + 2e-3 * np.sin(2.0 * TIME) + noise, 2.0)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("jitter", [0.0, 1e-8, 1e-5])
def test_impulse_is_kept_everywhere_within_the_share_of_the_tolerance(jitter, tolerance):
    given = logged_pull(jitter)
    found = compressed(given, 0.0, TIME[-1], 3.0, tolerance * 1e-3)
    # Midpoints of tenths of a row: both forces are linear there, but for a knot's rounding.
    fine = (np.arange(10 * (TIME.size - 1)) + 0.5) * 1e-5
    off = np.cumsum(force_at(given, fine) - force_at(found, fine)) * 1e-5
    assert np.abs(off).max() <= 1.01 * SHARE * tolerance * 1e-3 * 3.0 + 1e-14 and abs(off[-1]) < 1e-13


def test_corners_of_a_drive_are_joined_within_the_tolerance_alone():
    given = logged_pull(1e-8)
    pieces = [compressed(given, 0.0, TIME[-1], 1.0, tolerance * 1e-3).knots.size for tolerance in (1e-4, 1e-6, 1e-8)]
    assert pieces[0] < pieces[1] < pieces[2] < TIME.size and pieces[0] < TIME.size / 200
    assert compressed(given, 0.0, TIME[-1], 1.0, 1e-13 * 1e-3) is given
    # Triangles of force, logged at 10 kHz: joined between the corners alone.
    found = compressed(drive.force(TIME, np.abs((TIME / 0.25) % 2.0 - 1.0)), 0.0, TIME[-1], 1.0, 1e-9 * 1e-3)
    assert found.knots.size < 200
    corners = np.arange(1, 8) * 0.25
    assert np.abs(found.knots[:, None] - corners).min(axis=0).max() < 1.5e-4
    given = logged_pull(1e-6)
    run = simulate(MODEL, given, TIME, tolerance=1e-4)
    assert run.steps < TIME.size and run.drive == pytest.approx(force_at(given, TIME) - 2.0 * run.position, abs=1e-12)
    given = logged_pull(1e-8)
    with_play = plan_of(compose(["lugre", "backlash"]), given, 1.0, NO_SURROUNDINGS)
    assert with_play.compressed(0.0, TIME[-1], 1e-4).drive is given
    without = plan_of(compose(["lugre"]), given, 1.0, NO_SURROUNDINGS)
    assert without.compressed(0.0, TIME[-1], 1e-4).drive.knots.size < TIME.size / 100


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7])
def test_the_motion_is_that_of_the_record_and_far_cheaper(tolerance):
    given = logged_pull(1e-8)
    exact = simulate(MODEL, given, TIME, tolerance=1e-13, forces=False)
    loose = simulate(MODEL, given, TIME, tolerance=tolerance, forces=False)
    assert exact.steps > TIME.size - 2 and loose.steps < exact.steps / 5
    # A line without jitter asks for its own error: the same tolerance is allowed here.
    clean = simulate(MODEL, logged_pull(0.0), TIME, tolerance=tolerance, forces=False)
    sure = simulate(MODEL, logged_pull(0.0), TIME, tolerance=1e-13, forces=False)
    own = np.abs(clean.position - sure.position).max()
    assert np.abs(loose.position - exact.position).max() < 2.0 * own + tolerance * 0.1
