"""Physics that every effect and variant of the library keeps: units, symmetry, passivity, energy, neutral values."""

import re

import numpy as np
import pytest

from sim import compose, simulate
from sim.effects.catalogue import ORDER, find, library
from sim.effects.effect import Axis, Effect
from sim.integration import drive
from sim.integration.compiled import kernels
from stagecad.parameters.errors import InputError
from tests.refusals import refused

EVERY = [law for effect in library().values() for law in (effect, *effect.variants)]
PIEZO = [law for law in EVERY if law.acts_on == "piezo"]
SIGNALS = [law for law in EVERY if law.signal is not None]
INSTANT = [law for law in EVERY if any(kernels.instantaneous_terms(law)) and kernels.unsupported(law) is None]
FORCES = [law for law in INSTANT if law.force is not None]
CONSERVATIVE = {"constant_bias", "cable_spring", "gravity_torque", "gravity_torque:offset"}
CONSERVATIVE |= {"magnetic_cogging", "magnetic_cogging:overtone"}
"""Forces with a potential: what they take on the way out they give back on the way home."""
GIVES_HEAT_BACK = {"lugre", "presliding:lugre"}
"""Its constant damping of the bristle can do work on the motion above 4 g/a1 (docs/causal_friction_model.md)."""
# What holds its input from row to row is a row late, however stiff it is.
NOT_NEUTRAL = ("sensor_quantisation", "flexible_mode:of_steps")
# Within the row before, what is read off a curve leans on the row after.
ONE_ROW_AHEAD = ("sensor_delay:of_curves", "drive_delay:of_curves")
FOR_RECORDS = [law for law in EVERY if kernels.unsupported(law) is not None and law not in PIEZO]


def by_name(law: Effect) -> str:
    return law.name


def test_every_name_that_users_rely_on_is_there():
    assert set(ORDER) <= set(library())
    assert [law.name for law in EVERY] == [find(law.name).name for law in EVERY]


# Units: a law says the same whatever the units of length, time, force, temperature and voltage are.

SIZES = {"m": 7.0, "s": 0.3, "N": 11.0, "K": 1.7, "V": 3.0, "channel": 5.0}
PLAIN = {"1", "rad"}
AXIS_UNITS = ("s", "m", "m/s", "m/s^2", "N", "K", "s", "m", "m", "1")


def factor(unit: str, rotary: bool = False) -> float:
    """How a number in `unit` changes when the base units become so many times smaller; an angle does not."""
    if unit == "Hz":
        return 1.0 / SIZES["s"]
    if unit == "degC":
        return SIZES["K"]
    top, _, bottom = unit.partition("/")
    size = 1.0
    for text, sign in ((top, 1), (bottom, -1)):
        for part in filter(None, re.split(r"\*", text)):
            base, _, power = part.partition("^")
            if base not in PLAIN and not (rotary and base == "m"):
                size *= SIZES[base] ** (sign * int(power or 1))
    return size


def in_other_units(law: Effect, p):
    return law.values(**{q.name: getattr(p, q.name) * factor(q.unit) for q in law.parameters})


def shown_values(law: Effect):
    """Values at which a law does something: an amplitude that is zero by default takes a tenth."""
    zero = {q.name: 0.1 for q in law.parameters if q.default == 0.0 and q.role in ("amplitude", "level") and q.high > 0}
    return law.values(**zero)


@pytest.mark.parametrize("law", INSTANT, ids=by_name)
def test_a_law_is_the_same_in_other_units(law):
    random = np.random.default_rng(2)
    rows = [random.uniform(0.2, 2.0, 20) * 1e-2 for _ in AXIS_UNITS[:-1]]
    axis = Axis(*rows, np.ones(20))
    other = Axis(*[row * factor(unit, "rotary" in law.needs) for row, unit in zip(axis, AXIS_UNITS)])
    p = shown_values(law)
    q = in_other_units(law, p)
    for kind, unit in (("level", "N"), ("force", "N"), ("factor", "1")):
        function = getattr(law, kind)
        if function is None:
            continue
        if law.name == "dwell_strengthening:kato":
            # The rate of Kato's law is in s^-exponent, which no unit of the closed table can say.
            q = q._replace(rate=p.rate * SIZES["s"] ** -p.exponent)
        here, there = np.broadcast_to(function(axis, p), 20), np.broadcast_to(function(other, q), 20)
        assert np.allclose(there, here * factor(unit), rtol=1e-5, atol=1e-12 * np.abs(there).max())


@pytest.mark.parametrize("law", SIGNALS, ids=by_name)
def test_a_signal_s_law_is_the_same_in_other_units(law):
    p, n, step = shown_values(law), 400, 1e-3
    signal = np.sin(np.linspace(0.0, 9.0, n)) + 0.3 * np.sin(np.linspace(0.0, 40.0, n))
    size = SIZES["V"] if law.acts_on == "piezo" else SIZES["channel"]
    here = np.asarray(law.signal(signal, step, p))
    there = np.asarray(law.signal(signal * size, step * SIZES["s"], in_other_units(law, p)))
    assert np.allclose(there, here * size, rtol=1e-9, atol=1e-9 * size)


@pytest.mark.parametrize("law", [law for law in EVERY if law.friction_state is not None], ids=by_name)
def test_a_core_is_the_same_in_other_units(law):
    time = np.linspace(0.0, 2.0, 800)
    x, v = 2e-4 * np.sin(5.0 * time), 1e-3 * np.cos(5.0 * time)
    p, level = law.values(), np.full(time.size, 1.3)
    here = law.friction_state.along_record(x, v, time, level, p)
    units = (x, "m"), (v, "m/s"), (time, "s"), (level, "N")
    there = law.friction_state.along_record(*[row * factor(unit) for row, unit in units], in_other_units(law, p))
    assert np.allclose(there, here * SIZES["N"], rtol=1e-6, atol=1e-6 * SIZES["N"])


# Symmetry: an axis turned end for end has its forces turned, levels and factors alike.


@pytest.mark.parametrize("law", [law for law in INSTANT if law.name not in CONSERVATIVE], ids=by_name)
def test_friction_does_not_know_left_from_right(law):
    if law.name.startswith(("direction_asymmetry", "position_dependent_friction")):
        pytest.skip("is the difference of the two directions, or of places")
    random = np.random.default_rng(4)
    axis = Axis(*[random.uniform(0.1, 1.0, 12) * 1e-2 for _ in range(9)], np.ones(12))
    turned = axis._replace(**{k: -getattr(axis, k) for k in ("position", "velocity", "acceleration", "direction")})
    p = shown_values(law)
    for kind, sign in (("level", 1.0), ("factor", 1.0), ("force", -1.0)):
        function = getattr(law, kind)
        if function is not None:
            assert np.allclose(function(turned, p), sign * np.asarray(function(axis, p)), rtol=1e-12)


# Passivity.


@pytest.mark.parametrize("law", FORCES, ids=by_name)
def test_a_force_takes_energy_or_gives_back_what_it_took(law):
    """Over a path there and home, under any load and temperature: nothing where there is a potential, else never less
    than nothing at any instant."""
    time = np.linspace(0.0, 2.0 * np.pi, 20_001)
    x = 4e-3 * (1.0 - np.cos(time)) + 1e-3 * np.sin(3.0 * time) ** 2
    v = 4e-3 * np.sin(time) + 6e-3 * np.sin(3.0 * time) * np.cos(3.0 * time)
    zero = np.zeros_like(time)
    load, temperature = 1.0 + 0.9 * np.sin(2.0 * time + 0.7), 20.0 + 100.0 * np.cos(time + 0.3)
    axis = Axis(time, x, v, zero, load, temperature, zero, zero, zero, np.sign(v))
    p = shown_values(law)
    power = np.broadcast_to(law.force(axis, p), time.shape) * v
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time))])
    if law.name in CONSERVATIVE:
        assert abs(work[-1]) < 1e-6 * np.abs(work).max()
    elif law.name.startswith("direction_asymmetry"):
        # By itself a bias at speed; with as much viscous friction under it, a drag that is never negative.
        assert np.all(power + p.viscous * v * v >= 0.0)
    elif law.name.endswith(":lubricated"):
        # Takes off the viscous friction what warmth does: with that under it, never negative.
        assert np.all(power + p.drag * v * v >= 0.0)
    else:
        assert np.all(power >= 0.0) and work[-1] > 0.0


@pytest.mark.parametrize("law", INSTANT, ids=by_name)
def test_levels_and_factors_at_their_defaults_never_turn_friction_round(law):
    random = np.random.default_rng(9)
    n = 2000
    v = random.uniform(-0.2, 0.2, n)
    age, travelled = random.uniform(0.0, 100.0, n), random.uniform(0.0, 10.0, n)
    load, temperature = random.uniform(0.0, 3.0, n), random.uniform(10.0, 40.0, n)
    x = random.uniform(-0.1, 0.1, n)
    axis = Axis(age, x, v, 0.0 * v, load, temperature, age, np.abs(x), travelled, np.sign(v))
    for function in (law.level, law.factor):
        if function is not None:
            assert np.all(np.asarray(function(axis, shown_values(law))) >= 0.0)


# Energy: what the drive puts in is heat, store and motion, to a millionth of the work.

PUSH = drive.force([0.0, 0.1, 0.3, 0.4, 0.8], [0.0, 3.0, 3.0, -3.0, -3.0])
PULL = drive.pulled_spring([0.0, 0.2, 0.5, 0.8], [0.0, 0.03, 0.03, -0.01], 200.0)
TIME = np.linspace(0.0, 0.8, 401)


@pytest.mark.parametrize("law", [law for law in EVERY if kernels.unsupported(law) is None], ids=by_name)
def test_energy_balances_to_a_millionth_of_the_work(law):
    if law.name == "backlash":
        push, names = PULL, ["lugre_causal", "viscous", law.name]
    else:
        push, names = PUSH, ([law.name] if law.friction_state is not None else ["lugre_causal", law.name])
    values = {} if law.friction_state is not None else _given(law)
    model = compose(names, values)
    run = simulate(model, push, TIME, mass=0.7, load=1.3, temperature=24.0, tolerance=1e-10, energy=True)
    left = run.drive_work - run.core_work - run.other_work - run.kinetic
    work = max(np.abs(run.drive_work).max(), np.abs(run.core_work).max())
    assert np.abs(left).max() <= 1e-6 * work
    core = model.state_effect and model.state_effect.friction_state
    if core is not None and core.stored is not None and law.name not in GIVES_HEAT_BACK:
        heat = run.core_work - (run.stored - run.stored[0])
        assert np.diff(heat).min() >= -1e-7 * heat[-1]


def _given(law: Effect) -> dict[str, float]:
    p = shown_values(law)
    return {f"{law.name}.{name}": value for name, value in p._asdict().items()}


# Neutral values of what acts on a signal, and what it does to a signal that stands.


def still(law: Effect):
    nothing = {q.name: 0.0 for q in law.parameters if q.role == "amplitude" and q.low <= 0.0}
    shortest = {q.name: 1e-9 for q in law.parameters if q.name in ("time_constant", "delay") and q.low <= 1e-9}
    stiff = {"frequency": 1e6, "damping": 0.35} if law.name == "flexible_mode" else {}
    return law.values(**(stiff or nothing or shortest))


@pytest.mark.parametrize("law", [law for law in SIGNALS if law.name not in NOT_NEUTRAL], ids=by_name)
def test_a_signal_passes_unchanged_at_neutral_values(law):
    signal = np.sin(np.linspace(0.0, 9.0, 300))
    assert np.allclose(law.signal(signal, 1e-2, still(law)), signal, atol=1e-6)


@pytest.mark.parametrize("law", SIGNALS, ids=by_name)
def test_what_acts_on_a_signal_looks_back_only(law):
    """Two signals that are the same up to a row are the same after the law, up to that row."""
    same = 199 if law.name in ONE_ROW_AHEAD else 200
    random = np.random.default_rng(3)
    first, second = random.standard_normal(300), random.standard_normal(300)
    second[:200] = first[:200]
    p = shown_values(law)
    one, other = (np.asarray(law.signal(np.ascontiguousarray(s), 1e-2, p)) for s in (first, second))
    assert np.array_equal(one[:same], other[:same]) and not np.array_equal(one[200:], other[200:])


@pytest.mark.parametrize("name", ["piezo_hysteresis", "piezo_hysteresis:bouc_wen", "piezo_hysteresis:free_plays"])
def test_the_hysteresis_of_a_piezo_is_by_path_and_takes_energy(name):
    law = find(name)
    p = law.values(**{"width": 0.8, "strength": 0.3} if "strength" in law.values()._fields else {"width": 0.8})
    time = np.linspace(0.0, 6.0 * np.pi, 6001)
    u = np.sin(time)
    d = law.signal(u, time[1], p)
    # Twice as fast along the same path: the same loop.
    assert np.allclose(law.signal(u, 0.5 * time[1], p), d, atol=1e-15)
    once = slice(4000, 6001)
    assert np.sum(0.5 * (u[once][1:] + u[once][:-1]) * np.diff(d[once])) > 0.0


@pytest.mark.parametrize("name", ["piezo_creep", "piezo_creep:exponential", "piezo_creep:three_exponentials"])
def test_creep_after_a_step_only_grows_and_adds_up(name):
    law, step = find(name), 0.01
    p = law.values()
    early, late = np.zeros(3000), np.zeros(3000)
    early[10:], late[500:] = 1.0, 1.0
    one, other = law.signal(early, step, p), law.signal(late, step, p)
    assert np.all(np.diff(one[10:]) >= 0.0) and one[-1] > 1.0
    assert np.allclose(law.signal(early - 0.5 * late, step, p), one - 0.5 * other, atol=1e-12)


def test_logarithmic_creep_gains_its_strength_in_each_decade():
    law = find("piezo_creep")
    p = law.values(start=0.01, decades=4.0)
    step = 1e-3
    u = np.ones(20_000)
    u[0] = 0.0
    d = law.signal(u, step, p)
    for early in (0.1, 0.3, 1.0):
        gained = np.interp(10.0 * early, step * np.arange(u.size), d) - np.interp(early, step * np.arange(u.size), d)
        assert gained == pytest.approx(p.strength, rel=0.05)


# What cannot be simulated on one axis says where it can be.


@pytest.mark.parametrize("law", PIEZO, ids=by_name)
def test_an_effect_of_a_piezo_says_where_it_is_simulated(law):
    with pytest.raises(InputError, match=rf"'{law.name}' acts on the signal of a piezo.*stagecad simulate stage"):
        simulate(compose(["lugre", law.name]), PUSH, TIME)


@pytest.mark.parametrize("law", FOR_RECORDS, ids=by_name)
def test_a_law_for_records_alone_says_so_and_its_effect_has_one_in_time(law):
    base, _, variant = law.name.partition(":")
    assert variant and kernels.unsupported(find(base)) is None
    refused(f"effect '{law.name}' (changes|has|depends)", simulate, compose(["lugre", law.name]), PUSH, TIME)
