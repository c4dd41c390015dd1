"""No friction model returns energy over a closed cycle of position, speed, load and temperature."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.effects.catalogue import compose, find, library
from sim.effects.effect import Axis, Effect
from sim.integration import drive
from sim.integration.simulate import simulate

EVERY = [law for effect in library().values() for law in (effect, *effect.variants)]
CORES = [name for name, effect in library().items() if effect.friction_state is not None]
PASSIVE = [name for name in CORES if name not in ("lugre", "elasto_plastic", "second_order_dahl")]
FRICTION = [law for law in EVERY if law.acts_on in ("friction", "memory") and law.friction_state is None]
DAMPED_BRISTLES = [law for law in EVERY if law.name.partition(":")[0] == "bristle_damping"]


def heat(name: str, v: float, g: float, z: float, k: int = 0) -> float:
    """Power into element k of a core less the rise of its spring's energy, W; and that energy is the spring's alone."""
    core, p = find(name).friction_state, find(name).values()
    rate, force = core.law(k, z, v, math.copysign(1.0, v), g, p)
    step = 1e-3 * core.scale(p)  # the energy is quadratic: a central difference is exact
    rise = (core.stored(k, z + step, g, p) - core.stored(k, z - step, g, p)) / (2.0 * step)
    # Were it to depend on the level, a change of the level would change it without work.
    assert core.stored(k, z, g, p) == core.stored(k, z, 1.7 * g + 0.3, p)
    return force * v - rise * rate


@pytest.mark.parametrize("name", PASSIVE)
@settings(max_examples=60)
@given(v=st.floats(-1.0, 1.0), g=st.floats(0.01, 5.0) | st.just(0.0), stretch=st.floats(-5.0, 5.0))
def test_a_passive_core_gives_no_heat_back_at_any_level(name, v, g, stretch):
    """At every instant, whatever the stretch: so over any motion under any history of load and temperature."""
    core, p = find(name).friction_state, find(name).values()
    for k in range(core.elements(p)):
        assert heat(name, v, g, stretch * core.scale(p) * (1 + k), k) >= -1e-9 * (1.0 + abs(v))


@settings(max_examples=60)
@given(part=st.floats(-1.0, 1.0), g=st.floats(0.01, 5.0), stretch=st.floats(-5.0, 5.0))
def test_damped_bristles_are_passive_up_to_four_g_over_a1(part, g, stretch):
    for name in ("lugre", "elasto_plastic"):
        p = find(name).values()
        assert heat(name, part * 4.0 * g / p.damping, g, stretch * g / p.stiffness) >= -1e-9 * g


@settings(max_examples=100)
@given(over=st.floats(1.001, 100.0), g=st.floats(0.05, 5.0))
def test_lugre_gives_heat_back_above_four_g_over_a1(over, g):
    """At a stress above one, which a fall of the level leaves."""
    p = find("lugre").values()
    v = over * 4.0 * g / p.damping
    assert min(heat("lugre", v, g, stress * g / p.stiffness) for stress in np.linspace(1.0, 3.0, 201)) < 0.0


@settings(max_examples=50)
@given(v=st.floats(-50.0, 50.0), g=st.floats(0.01, 5.0), stretch=st.floats(-1.0, 1.0))
def test_elasto_plastic_bristles_are_passive_at_any_speed_unless_the_level_falls(v, g, stretch):
    p = find("elasto_plastic").values()
    assert heat("elasto_plastic", v, g, stretch * g / p.stiffness) >= -1e-9 * g * (1.0 + abs(v))


def work_of_cycles(model_effects: list[str | Effect], values: dict[str, float], axis: Axis) -> float:
    """Work on the friction, J, over the last two of three equal cycles: the first settles."""
    model = compose(model_effects, values)
    for effect, p in zip(model.effects, model.values):
        axis = effect.memory(axis, p) if effect.memory is not None else axis
    level = np.maximum(model.level(axis), 0.0)
    state, p = model.state_effect, dict(zip(model.names, model.values))
    force = state.friction_state.along_record(axis.position, axis.velocity, axis.time, level, p[state.name])
    rows = (axis.time.size - 1) // 3
    return float(np.sum(force[1 + rows :] * np.diff(axis.position)[rows:]))


def axis_of(times: np.ndarray, position: np.ndarray, load: np.ndarray, temperature: np.ndarray) -> Axis:
    """Axis along a motion whose velocity is that of the interval before each row."""
    velocity = np.diff(position) / np.diff(times)
    velocity = np.append(velocity[:1], velocity)
    direction = np.where(velocity != 0.0, np.sign(velocity), 1.0)
    gone = np.append(0.0, np.cumsum(np.abs(np.diff(position))))
    zero = np.zeros(times.size)
    return Axis(times, position, velocity, zero, load, temperature, zero, gone, gone, direction)


def random_cycle(seed: int) -> Axis:
    """Three equal cycles of position, load and temperature, from random harmonics, at random speeds."""
    random = np.random.default_rng(seed)
    rows = 1200
    phase = 2.0 * np.pi * np.arange(3 * rows + 1) / rows

    def wave(harmonics: int) -> np.ndarray:
        a, b = random.standard_normal((2, harmonics))
        n = np.arange(1, harmonics + 1)[:, None]
        found = a @ np.sin(n * phase) + b @ np.cos(n * phase)
        return found / np.max(np.abs(found))

    position = 10.0 ** random.uniform(-6.5, -4.0) * wave(5)
    pace = np.exp(2.5 * wave(3))  # time of a row over its mean: speeds over two decades
    period = 10.0 ** random.uniform(-1.5, 1.5)
    times = np.append(0.0, np.cumsum(pace[:-1])) * period / rows
    return axis_of(times, position, 1.0 + random.uniform(0.0, 1.0) * wave(3), 20.0 + 10.0 * wave(2))


WARM = "temperature_dependent_friction"
GIVEN = {f"{WARM}.coefficient": -0.03, f"{WARM}:exponential.coefficient": 0.05, f"{WARM}:lubricated.coefficient": 0.05}
GIVEN |= {"stribeck.velocity": 1e-4}


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("law", FRICTION, ids=lambda law: law.name)
def test_no_effect_on_the_level_lets_a_core_return_energy(core, law):
    for seed in range(3):
        axis = random_cycle(seed)
        values = {key: value for key, value in GIVEN.items() if key.rpartition(".")[0] == law.name}
        assert work_of_cycles([core, law], values, axis) > 0.0


@pytest.mark.parametrize("core", CORES)
def test_all_effects_on_the_level_together_let_no_core_return_energy(core):
    laws = ["stribeck", "load_dependent_friction", "temperature_dependent_friction", "position_dependent_friction"]
    for seed in range(20):
        axis = random_cycle(100 + seed)
        values = {"position_dependent_friction.pitch": 1e-5, **{k: v for k, v in GIVEN.items() if ":" not in k}}
        assert work_of_cycles([core, *laws], values, axis) > 0.0


@pytest.mark.parametrize("law", DAMPED_BRISTLES, ids=lambda law: law.name)
def test_damped_bristles_return_no_energy_over_a_cycle(law):
    """Every other force is held to this at each instant, in `test_whole_library.py`."""
    for seed in range(3):
        axis = random_cycle(200 + seed)
        rows = (axis.time.size - 1) // 3
        done = law.force(axis, law.values())[1 + rows :] * np.diff(axis.position)[rows:]
        assert np.sum(done) >= -1e-4 * np.sum(np.abs(done))


@pytest.mark.parametrize("core", CORES)
def test_an_integrated_loop_under_a_changing_load_dissipates(core):
    """A wave of 6 um under a load of twice its frequency, which is high on the way back near one end."""
    time = np.linspace(0.0, 3.0, 1201)
    load = 1.0 + 0.9 * np.sin(4.0 * np.pi * time + 0.7)
    model = compose([core, "stribeck", "load_dependent_friction"], {"stribeck.velocity": 1e-5})
    run = simulate(model, drive.sinusoidal_velocity(6e-6 * np.pi, 1.0, 0.0), time, load=load, energy=True)
    assert run.core_work[-1] - run.core_work[400] > 0.0
    rise = np.diff(run.core_work - run.stored)
    # The slow part of the second-order model returns energy just after a reversal.
    assert np.min(rise) >= -1e-6 * np.max(run.stored) or core == "second_order_dahl"


def test_every_core_and_force_states_its_dissipation():
    for law in EVERY:
        if law.friction_state is not None or (law.force is not None and law.acts_on in ("friction", "axis")):
            assert law.dissipation, law.name
