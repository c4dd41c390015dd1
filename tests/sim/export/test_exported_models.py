"""Exported models give the program's forces on motions not seen before, in each language that runs here."""

import ctypes
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim.effects.catalogue import Model, compose, find, library
from sim.effects.custom import load_custom
from sim.effects.effect import Axis, Effect
from sim.export.languages import Exported, files_of
from sim.export.program import ForceFunction, program_of
from tests.refusals import refused

COMPILER = shutil.which("cc") or shutil.which("gcc")
HISTORY = {"bristle_damping", "bristle_damping:spread", "frictional_lag", "dwell_strengthening:fading"}
HISTORY |= {"second_order_dahl"}
"""Effects that need a history of the motion, or of two parts: refused by name."""
NAMES = [law.name for effect in library().values() for law in (effect, *effect.variants)]
FORCES = [name for name in NAMES if find(name).acts_on not in ("drive", "piezo", "sensor") and not find(name).is_mode]


def _motion(seed: int, rows: int = 400) -> tuple[np.ndarray, ...]:
    """Time, position, velocity, load, temperature (n,) of strokes of micrometres to millimetres that begin at rest."""
    rng = np.random.default_rng(seed)
    time = np.arange(rows) * 1e-3
    sizes, rates = 10.0 ** rng.uniform(-6, -3, 4), rng.uniform(3.0, 40.0, 4)
    position = sum(size * (1.0 - np.cos(rate * time)) for size, rate in zip(sizes, rates))
    position[:3] = position[0]
    rest = slice(150, 180)
    position[rest] = position[150]
    velocity = np.gradient(position, time)
    velocity[rest], velocity[:2] = 0.0, 0.0
    return time, position, velocity, 10.0 + np.cos(30.0 * time), 22.0 + 4.0 * time


def _by_the_model(model: Model, motion: tuple[np.ndarray, ...]) -> np.ndarray:
    """Force (n,) of the program's own model along a motion."""
    time, position, velocity, load, temperature = motion
    moving = np.where(velocity != 0.0, np.sign(velocity), np.nan)
    direction = moving[np.maximum.accumulate(np.where(np.isnan(moving), 0, np.arange(time.size)))]
    direction = np.where(np.isnan(direction), 1.0, direction)
    gone = np.abs(np.diff(position, prepend=position[0]))
    since = np.zeros(time.size)
    for k in range(1, time.size):
        since[k] = gone[k] if direction[k] != direction[k - 1] else since[k - 1] + gone[k]
    zero = np.zeros(time.size)
    state = time, position, velocity, np.gradient(velocity, time), load, temperature
    axis = Axis(*state, zero, since, np.cumsum(gone), direction)
    for effect, p in zip(model.effects, model.values):
        axis = effect.memory(axis, p) if effect.memory is not None else axis
    level, force = model.level(axis), model.other_force(axis)
    if model.state_effect is not None:
        p = model.values[model.effects.index(model.state_effect)]
        core = model.state_effect.friction_state
        force = force + core.along_record(axis.position, axis.velocity, axis.time, level + zero, p)
    return force + zero


def _program(effects: list[Effect], values: dict[str, float]):
    return program_of("friction_model", effects, values, {})


def _of(names: list[str | Effect]) -> tuple[Model, Any]:
    """A model and its program."""
    model = compose(names)
    return model, _program(list(model.effects), model.parameters())


def _in_c(program, folder: Path, motion: tuple[np.ndarray, ...]) -> np.ndarray:
    """Force (n,) along a motion of the step function in C, compiled by the compiler of this system."""
    time, position, velocity, load, temperature = motion
    for file, text in files_of(Exported(program, 1.5, ("a test",)), "c").items():
        (folder / file).write_text(text, encoding="utf-8")
    library_file = folder / "friction_model.so"
    words = [str(COMPILER), "-std=c99", "-O2", "-fPIC", "-shared", "friction_model.c", "-o", str(library_file), "-lm"]
    subprocess.run(words, cwd=folder, check=True, capture_output=True)
    loaded = ctypes.CDLL(str(library_file))
    state = (ctypes.c_double * max(len(program.states), 1))()
    loaded.friction_model_step.restype = ctypes.c_double
    loaded.friction_model_start(state, ctypes.c_double(position[0]), ctypes.c_double(velocity[0]))
    rows = zip(np.diff(time, prepend=time[0]), position, velocity, np.gradient(velocity, time), load, temperature)
    return np.array([loaded.friction_model_step(state, *map(ctypes.c_double, row)) for row in rows])


@pytest.mark.parametrize("name", FORCES)
def test_each_effect_gives_the_force_of_the_program(name: str, tmp_path: Path) -> None:
    if name in HISTORY:
        refused(f"effect '{name}'", _program, [find(name)], {})
        return
    model, program = _of([name] if find(name).friction_state is not None else ["coulomb", name])
    function = ForceFunction(program.source)
    for seed in (1, 2):
        motion = _motion(seed)
        expected = _by_the_model(model, motion)
        np.testing.assert_allclose(function(*motion), expected, rtol=1e-9, atol=1e-9 * np.max(np.abs(expected)))
    if COMPILER is not None:
        found = _in_c(program, tmp_path, motion)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.max(np.abs(expected)))
        if find(name).friction_state is not None:
            _run_c(program, tmp_path / "check")


def test_an_effect_of_a_users_file_is_exported_if_its_law_is_arithmetic(tmp_path: Path) -> None:
    text = (
        "import numpy as np\nfrom sim import Effect, Parameter\n\n"
        "def force(axis, p):\n    return {law}\n\n"
        "effect = Effect('tustin', 'm', force=force, parameters=[Parameter('rise', 'N', 2.0, 0.0, 9.0, 'm', 's')])\n"
    )
    file = tmp_path / "tustin.py"
    file.write_text(text.format(law="p.rise * np.exp(-abs(axis.velocity) / 1e-3) * np.arcsinh(axis.velocity / 1e-4)"))
    model, program = _of(["coulomb", *load_custom(file)])
    motion = _motion(1)
    expected = _by_the_model(model, motion)
    np.testing.assert_allclose(ForceFunction(program.source)(*motion), expected, rtol=1e-9, atol=1e-9)
    if COMPILER is not None:
        np.testing.assert_allclose(_in_c(program, tmp_path, motion), expected, rtol=1e-9, atol=1e-9)
    assert "asinh_of(" in files_of(Exported(program, 0.0, ()), "modelica")[f"{program.name}.mo"]
    (law,) = load_custom(file)
    # Other names of the arguments, and a lambda: alone in its lines only.
    one = [lambda a, q: q.rise * a.position]

    def stiff(where, values):
        return values.rise * where.position

    for own in (*one, stiff):
        assert "position" in _program([replace(law, force=own)], {"tustin.rise": 2.0}).source
    two = [lambda a, q: q.rise, lambda a, q: 0.0]
    refused("write it with def", _program, [replace(law, force=two[0])], {"tustin.rise": 2.0})
    file = tmp_path / "sorted.py"
    file.write_text(text.format(law="p.rise * np.interp(axis.velocity, [-1.0, 1.0], [-1.0, 1.0])"))
    refused(r"force of effect 'tustin' is not arithmetic \(np\.interp", _program, load_custom(file), {})


def _combinations() -> list[list[str]]:
    rng = np.random.default_rng(5)
    cores = [name for name in FORCES if find(name).friction_state is not None and name not in HISTORY]
    others = [name for name in FORCES if name not in {*HISTORY, *cores} and find(name).memory is None]
    drawn = []
    for _ in range(6):
        chosen = {name.partition(":")[0]: name for name in rng.choice(others, 4, replace=False)}
        drawn.append([str(rng.choice(cores)), *map(str, chosen.values())])
    return drawn


def test_combinations_in_c_and_python_and_the_module_s_own_check(tmp_path: Path) -> None:
    for number, names in enumerate(_combinations()):
        model, program = _of(names)
        motion = _motion(number)
        expected = _by_the_model(model, motion)
        found = ForceFunction(program.source)(*motion)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.max(np.abs(expected)), err_msg=str(names))
        if COMPILER is not None:
            _run_c(program, tmp_path / str(number))
            found = _in_c(program, tmp_path / str(number), motion)
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.max(np.abs(expected)))
    model = compose(["lugre", "stribeck", "viscous", "magnetic_cogging"])
    exported = Exported(_program(list(model.effects), model.parameters()), 2.0, ("a test",))
    file = tmp_path / "friction_model.py"
    file.write_text(files_of(exported, "python")["friction_model.py"], encoding="utf-8")
    done = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, check=False)
    assert done.stdout == "self-test passed\n", done.stderr


def _run_c(program, folder: Path) -> None:
    folder.mkdir()
    for file, text in files_of(Exported(program, 1.5, ("a test",)), "c").items():
        (folder / file).write_text(text, encoding="utf-8")
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-Wno-unused", "-DFRICTION_MODEL_SELF_TEST"]
    words = [str(COMPILER), *flags, "friction_model.c", "-o", "check", "-lm"]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    ran = subprocess.run([str(folder / "check")], capture_output=True, text=True, check=False)
    assert ran.returncode == 0 and "passed" in ran.stdout, ran.stdout


@pytest.mark.parametrize("language", ["matlab", "modelica", "table"])
def test_other_languages_name_every_parameter(language: str) -> None:
    program = _of(["lugre", "stribeck", "viscous"])[1]
    text = "".join(files_of(Exported(program, 2.0, ("a test",)), language).values())
    if language == "table":
        rows = np.array([list(map(float, line.split(","))) for line in text.splitlines() if line[0] in "-0123456789"])
        level = 1.0 + 0.5 * np.exp(-((rows[:, 0] / 1e-3) ** 2)) + 0.4 * np.abs(rows[:, 0])
        np.testing.assert_allclose(np.abs(rows[:, 1]), level, rtol=2e-3)
    else:
        assert all(key in text for key in program.parameters)


def test_matlab_source_runs_in_octave(tmp_path: Path) -> None:
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None:
        pytest.skip("Octave is not at hand")
    exported = Exported(_of(["elasto_plastic", "stribeck", "viscous"])[1], 2.0, ("a test",))
    (tmp_path / "friction_model.m").write_text(files_of(exported, "matlab")["friction_model.m"], encoding="utf-8")
    words = [octave, "--no-gui", "--eval", "friction_model('test');"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "self-test passed" in done.stdout, done.stderr


def test_the_unit_runs_in_fmpy(tmp_path: Path) -> None:
    fmpy = pytest.importorskip("fmpy", reason="fmpy is not installed")
    from sim.export.fmu import write_fmu

    model = compose(["lugre", "stribeck", "viscous", "magnetic_cogging"])
    program = _program(list(model.effects), model.parameters())
    file = write_fmu(Exported(program, 2.0, ("a test",)), tmp_path)
    from fmpy.validation import validate_fmu

    assert list(validate_fmu(str(file))) == []
    time, position, velocity, load, temperature = _motion(3)
    names = ["time", "position", "velocity", "acceleration", "load", "temperature"]
    values = [time, position, velocity, np.gradient(velocity, time), load, temperature]
    inputs = np.rec.fromarrays(values, names=names)
    from fmpy.fmi2 import FMU2Slave

    description = fmpy.read_model_description(str(file))
    folder = fmpy.extract(str(file))
    unit = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier="friction_model", instanceName="one")
    unit.instantiate()
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    found = []
    for k in range(time.size):
        unit.setReal(list(range(5)), [float(inputs[name][k]) for name in names[1:]])
        if k == 0:
            unit.exitInitializationMode()
        else:
            unit.doStep(float(time[k - 1]), float(time[k] - time[k - 1]))
        found.append(unit.getReal([5])[0])
    unit.terminate()
    unit.freeInstance()
    shutil.rmtree(folder)
    expected = ForceFunction(program.source)(time, position, velocity, load, temperature)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
