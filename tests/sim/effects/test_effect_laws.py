"""Physics every effect has to keep: slopes, passivity, no force without cause, symmetry, limits, steady states."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from sim.effects.catalogue import compose, find, library
from sim.effects.effect import Axis
from sim.integration import drive
from sim.integration.compiled import kernels
from sim.integration.simulate import simulate

STATES = {name: effect.friction_state for name, effect in library().items()}
CORES = [name for name, state in STATES.items() if state is not None and hasattr(state, "law")]
BRISTLES = [name for name in CORES if name != "coulomb"]
EVERY = [law for effect in library().values() for law in (effect, *effect.variants)]
AT_ONE_INSTANT = [law for law in EVERY if any(kernels.instantaneous_terms(law)) and kernels.unsupported(law) is None]

speeds = st.floats(-1.0, 1.0).filter(lambda v: abs(v) > 1e-9)
levels = st.floats(0.05, 5.0)
stresses = st.floats(-0.999, 0.999)
WITHOUT_MEMORY = [effect for effect in AT_ONE_INSTANT if "contact_age" not in kernels.required_quantities(effect)]


def values(name: str, **given_values: float):
    effect = find(name)
    return effect.values(**{key: v for key, v in given_values.items() if key in [p.name for p in effect.parameters]})


def stretched(name: str, stress: float, g: float, p, k: int = 0) -> float:
    """State in which the spring of element k carries `stress` times what it can."""
    if name == "coulomb":
        return stress * g
    springs = find(name).friction_state.springs
    if springs is not None:
        stretches, _, force = springs(p)
        return stress * float(stretches[k]) * g / force
    return stress * g / p.stiffness


def difference(function, at: float, step: float) -> float:
    """Derivative by Richardson's extrapolation of central differences."""
    coarse = (function(at + step) - function(at - step)) / (2.0 * step)
    fine = (function(at + step / 2) - function(at - step / 2)) / step
    return (4.0 * fine - coarse) / 3.0


def test_every_core_of_the_library_is_among_those_held_here():
    held = {id(STATES[name]) for name in CORES}
    assert {id(law.friction_state) for law in EVERY if law.friction_state is not None} == held


@pytest.mark.parametrize("name", CORES)
@settings(max_examples=60)
@given(v=speeds, g=levels, stress=stresses)
def test_slopes_of_a_core_are_those_of_its_law(name, v, g, stress):
    core, p = find(name).friction_state, values(name)
    # At the stretch of break-away the elasto-plastic law has a kink, and its slopes differ on the two sides.
    assume(not hasattr(p, "breakaway") or abs(abs(stress) - p.breakaway) > 1e-3)
    for k in range(core.elements(p)):
        z = stretched(name, stress, g, p, k)
        slopes = core.slopes(k, z, v, math.copysign(1.0, v), g, p)
        arguments = {"z": (z, 2e-4 * min(g, 1.0) * core.scale(p)), "v": (v, 1e-3 * abs(v)), "g": (g, 1e-4 * g)}
        for i in range(2):
            for j, (quantity, (at, step)) in enumerate(arguments.items()):

                def law(x, quantity=quantity, i=i, k=k, z=z):
                    full = {"z": z, "v": v, "g": g} | {quantity: x}
                    return core.law(k, full["z"], full["v"], math.copysign(1.0, v), full["g"], p)[i]

                size = abs(law(at)) / max(abs(at), 1e-30)
                # Rounding of the law is 20 times as large in the difference over a twentieth of the step.
                slope = difference(law, at, step)
                rounding = 0.05 * abs(difference(law, at, 0.05 * step) - slope)
                wanted = pytest.approx(slope, rel=1e-4, abs=1e-6 * size + rounding + 1e-12)
                # Where an element begins to slip a law has a kink, which two steps see differently.
                assume(difference(law, at, 0.25 * step) == wanted)
                assert slopes[3 * i + j] == wanted


@pytest.mark.parametrize("effect", AT_ONE_INSTANT, ids=lambda effect: effect.name)
def test_declared_slopes_of_an_effect_are_those_of_its_law(effect):
    random = np.random.default_rng(11)
    n = 40
    axis = Axis(*[random.uniform(0.2, 1.0, n) * 2e-3 for _ in range(10)])
    axis = axis._replace(direction=np.ones(n))
    p = effect.values()
    for name, slope in effect.slopes.items():
        law, by = name.split(".")
        at = getattr(axis, by)
        step = 1e-4 * at

        def value(x, law=law, by=by):
            return getattr(effect, law)(axis._replace(**{by: x}), p)

        found = np.broadcast_to(slope(axis, p), n)
        assert np.allclose(found, difference(value, at, step), rtol=1e-6, atol=1e-9 * np.abs(found).max())


@pytest.mark.parametrize("effect", WITHOUT_MEMORY, ids=lambda effect: effect.name)
def test_every_law_gives_the_same_at_one_instant_as_along_a_record(effect):
    random = np.random.default_rng(5)
    n = 6
    axis = Axis(*[random.uniform(0.1, 2.0, n) for _ in range(10)])
    p = effect.values()
    for law in (effect.level, effect.factor, effect.force):
        if law is not None:
            along = np.broadcast_to(law(axis, p), n)
            assert np.allclose(along, [law(Axis(*row), p) for row in zip(*axis)], rtol=1e-13)


@pytest.mark.parametrize("effect", AT_ONE_INSTANT, ids=lambda effect: effect.name)
def test_an_effect_of_amplitude_zero_does_nothing(effect):
    random = np.random.default_rng(6)
    axis = Axis(*[random.uniform(0.1, 2.0, 6) for _ in range(10)])
    amplitudes = {p.name: 0.0 for p in effect.parameters if p.role in ("amplitude", "level")}
    # A cable's rest position is counted as an amplitude, since the force is linear in it.
    p = effect.values(**dict.fromkeys(amplitudes, 0.0))
    for kind, nothing in (("level", 0.0), ("factor", 1.0), ("force", 0.0)):
        law = getattr(effect, kind)
        if law is not None:
            assert np.allclose(law(axis, p), nothing, atol=1e-15)


@pytest.mark.parametrize("name", CORES)
def test_a_core_gives_no_force_without_cause_and_is_odd_along_a_record(name):
    core, p = find(name).friction_state, values(name)
    for k in range(core.elements(p)):
        assert core.law(k, 0.0, 0.0, 1.0, 1.0, p) == (0.0, 0.0) and core.law(k, 0.0, 0.3, 1.0, 0.0, p)[1] == 0.0
    time = np.linspace(0.0, 1.0, 50)
    at_rest = core.along_record(np.full(50, 0.2), np.zeros(50), time, np.ones(50), p)
    moving = core.along_record(0.1 * time, np.full(50, 0.1), time, np.zeros(50), p)
    assert np.all(at_rest == 0.0) and np.all(moving == 0.0)
    still = simulate(compose([name, "stribeck", "viscous"]), drive.force([0.0, 1.0], [0.0, 0.0]), time)
    assert np.all(still.position == 0.0) and np.all(still.friction == 0.0)
    time = np.linspace(0.0, 2.0, 3000)
    x = 1e-4 * np.sin(3.0 * time) + 2e-5 * np.sin(17.0 * time)
    v = 3e-4 * np.cos(3.0 * time) + 34e-5 * np.cos(17.0 * time)
    level = 1.0 + 0.2 * np.sin(time)
    assert np.allclose(core.along_record(x, v, time, level, p), -core.along_record(-x, -v, time, level, p), rtol=1e-12)


@pytest.mark.parametrize("name", CORES)
@settings(max_examples=60)
@given(v=speeds, g=levels, stress=stresses)
def test_a_core_is_odd_in_the_motion(name, v, g, stress):
    core, p = find(name).friction_state, values(name)
    for k in range(core.elements(p)):
        z = stretched(name, stress, g, p, k)
        ahead, back = core.law(k, z, v, math.copysign(1.0, v), g, p), core.law(k, -z, -v, math.copysign(1.0, -v), g, p)
        assert ahead == pytest.approx([-x for x in back], rel=1e-12)


@pytest.mark.parametrize("name", ["coulomb", "lugre_causal", "lugre_undamped", "dahl", "lugre_causal_as_run"])
@settings(max_examples=100)
@given(v=speeds, g=levels, stress=stresses)
def test_the_force_of_a_core_without_free_damping_never_exceeds_the_level(name, v, g, stress):
    core, p = find(name).friction_state, values(name)
    assert abs(core.law(0, stretched(name, stress, g, p), v, math.copysign(1.0, v), g, p)[1]) <= g * (1.0 + 1e-12)


@pytest.mark.parametrize("name", CORES)
@pytest.mark.parametrize("speed", [1e-4, 1e-3, 0.05, -0.02])
def test_steady_sliding_reaches_the_curve_of_levels(name, speed):
    model = compose([name, "stribeck", "viscous"])
    motion = drive.sinusoidal_velocity(0.0, 0.0, speed)
    run = simulate(model, motion, np.array([0.0, 2e-2 / abs(speed)]), tolerance=1e-10)
    gaussian = 1.0 + 0.5 * math.exp(-((speed / 1e-3) ** 2))
    if name == "rate_and_state":
        # The direct effect, and contacts as old as the slip over their memory length.
        gaussian += 0.015 * math.log1p(1e-3 / abs(speed))
        gaussian *= 0.01 * math.asinh(abs(speed) / 2e-3 * math.exp(100.0))
    assert run.friction[-1] == pytest.approx(math.copysign(gaussian, speed) + 0.4 * speed, rel=1e-7)


def sine(n: int = 4000):
    time = np.linspace(0.0, 2.0, n)
    return time, 2e-4 * np.sin(5.0 * time), 1e-3 * np.cos(5.0 * time)


def along(name: str, **given_values: float) -> np.ndarray:
    time, x, v = sine()
    return find(name).friction_state.along_record(x, v, time, np.full(time.size, 1.3), values(name, **given_values))


def test_limits_of_lugre_and_dahl():
    undamped = along("dahl", exponent=1.0)
    assert np.allclose(along("lugre", damping=0.0), undamped, atol=1e-12)
    assert np.allclose(along("lugre_undamped"), undamped, atol=1e-12)
    assert np.allclose(along("lugre_causal", damping=0.0), undamped, atol=1e-12)
    coulomb = along("coulomb")
    away = [np.mean(np.abs(along("dahl", stiffness=a) - coulomb)) for a in (1e6, 1e7, 1e8)]
    assert away[0] > away[1] > away[2] < 2e-3


@pytest.mark.parametrize("speed", [-1e-2, 1e-5, 1e-3, 0.2])
def test_rate_and_state_friction_in_steady_sliding_is_where_its_state_rests(speed):
    core, p = find("rate_and_state").friction_state, values("rate_and_state")
    force = float(np.sign(speed) * core.sliding(np.array(1.3), np.array(speed), p))
    assert core.law(0, force / p.stiffness, speed, np.sign(speed), 1.3, p)[0] == pytest.approx(0.0, abs=1e-9)
    assert core.sliding(np.array(1.3), np.array(0.0), p) == pytest.approx(0.0, abs=1e-15)


def test_the_second_order_model_overshoots_along_the_path_at_every_speed():
    """From rest: (1 + o)(1 - exp(-x/(r s))) - o (1 - exp(-x/s)), with its peak where both slopes are equal."""
    p = values("second_order_dahl", stiffness=1e5, ratio=0.3, overshoot=0.5)
    x = np.linspace(0.0, 2e-4, 4001)
    peaks, core = [], find("second_order_dahl").friction_state
    for speed in (1e-4, 1e-2):
        force = core.along_record(x, np.full(4001, speed), x / speed, np.ones(4001), p)
        way = x - x[0] + x[1]
        expected = 1.5 * -np.expm1(-way / 3e-6) - 0.5 * -np.expm1(-way / 1e-5)
        assert np.abs(force - expected)[1:].max() < 2e-2 and force[-1] == pytest.approx(1.0, abs=1e-6)
        peaks.append(force.max())
    at = math.log(1.5 / 0.5 / 0.3) / (1 / 3e-6 - 1 / 1e-5)
    peak = 1.5 * -math.expm1(-at / 3e-6) - 0.5 * -math.expm1(-at / 1e-5)
    assert peaks == pytest.approx([peak, peak], rel=1e-3) and peak > 1.1


def test_the_seven_parameter_model_is_a_sum_of_effects():
    """Armstrong-Helouvry's force in steady sliding, Fc + Fv |v| + Fs/(1 + (v/vs)^2), with a lag and ageing besides."""
    parts = ["presliding", "viscous", "stribeck:rational", "frictional_lag", "dwell_strengthening:kato"]
    model = compose(parts, {"stribeck:rational.exponent": 2.0, "stribeck:rational.velocity": 2e-3})
    v = np.array([1e-4, 2e-3, 0.1])
    axis = Axis(*[0.0 * v] * 2, v, *[0.0 * v] * 6, np.ones(3))
    p = model.parameters()
    slip = p["presliding.force"] + p["stribeck:rational.force"] / (1.0 + (v / 2e-3) ** 2)
    assert model.level(axis) + model.other_force(axis) == pytest.approx(slip + p["viscous.coefficient"] * v)


def test_contacts_age_while_they_only_stretch():
    """Ten seconds of 0.1 um at 10 Hz, slip from 10 um: the age of ten seconds at rest, 1 + 0.015 ln(1001), where the
    ageing by the velocity of the body would leave 1.083."""
    aged = 1.0 + 0.015 * math.log(1001.0)
    assert aged == pytest.approx(1.1036, abs=5e-5)
    model, rate = compose(["rate_and_state"]), 2.0 * math.pi * 10.0
    time, zero = np.linspace(0.0, 10.0, 20_001), np.zeros(1)
    wave = (0.1e-6 * rate**2, rate, math.pi)
    run = simulate(model, drive.Drive(zero, zero, zero, wave=wave, prescribes=True), time, position=0.1e-6)
    assert run.level[-1] == pytest.approx(aged, abs=1e-4)
    record = Axis(time, 0.1e-6 * np.cos(rate * time), *[0.0 * time] * 8)
    effect, p = model.effects[0], model.values[0]
    assert effect.level(effect.memory(record, p), p)[-1] == pytest.approx(aged, abs=1e-4)


def test_rate_and_state_friction_is_that_of_another_integrator():
    """A mass pulled through a spring, at 1 mm/s and then at 20: position, stretch and level by Radau's method."""
    pull = drive.pulled_spring([0.0, 1.0, 2.0], [0.0, 1e-3, 2.1e-2], stiffness=1e4)
    time = np.linspace(0.0, 2.0, 2001)
    run = simulate(compose(["rate_and_state"]), pull, time, mass=1.0, tolerance=1e-8)
    force, k, a, b, v_0, length = values("rate_and_state")

    def rates(t: float, y: np.ndarray) -> list[float]:
        x, v, z, age = y
        g = force * (1.0 + b * math.log(1.0 + v_0 * age / length))
        exponent = abs(k * z / (a * g)) - 1.0 / a
        slip = math.copysign(v_0 * (math.exp(exponent) - math.exp(exponent - 2.0 * abs(k * z / (a * g)))), z)
        pulled = 1e-3 * t if t <= 1.0 else 1e-3 + 2e-2 * (t - 1.0)
        return [v, 1e4 * (pulled - x) - k * z, v - slip, 1.0 - abs(slip) * age / length]

    y, found = np.zeros(4), [np.zeros((4, 1))]
    for begin, end in ((0.0, 1.0), (1.0, 2.0)):
        at = time[(time > begin) & (time <= end)]
        sol = solve_ivp(rates, (begin, end), y, "Radau", at, rtol=1e-8, atol=[1e-12, 1e-10, 1e-14, 1e-10])
        y = sol.y[:, -1]
        found.append(sol.y)
    x, _, z, age = np.hstack(found)
    assert np.abs(run.position - x).max() < 1e-10 and np.abs(run.bristle[:, 0] - z).max() < 1e-11
    assert np.abs(run.level - force * (1.0 + b * np.log(1.0 + v_0 * age / length))).max() < 1e-6


def test_presliding_of_three_cores_by_closed_form_another_integrator_and_many_elements():
    """Out and back: Dahl's curve, the elasto-plastic law by Radau's method, 400 elements in place of twelve."""
    time, rate = np.linspace(0.0, math.pi / 2.0, 2001), 4.0
    motion = drive.sinusoidal_velocity(1e-4, rate, 0.0)
    cores = ("dahl", "elasto_plastic", "maxwell_slip")
    runs = {name: simulate(compose([name]), motion, time, tolerance=1e-11) for name in cores}
    x = 1e-4 / rate * (1.0 - np.cos(rate * time))
    out = x[: time.size // 2]
    assert np.abs(runs["dahl"].core_force[: out.size] - (1.0 - np.exp(-1e5 * out))).max() < 1e-9
    p = values("elasto_plastic")

    def flow(t: float, z: np.ndarray) -> np.ndarray:
        v = 1e-4 * math.sin(rate * t)
        u = p.stiffness * z * math.copysign(1.0, v)
        part = np.clip((u - p.breakaway) / (1.0 - p.breakaway), 0.0, 1.0)
        return v * (1.0 - 0.5 * (1.0 - np.cos(math.pi * part)) * u)

    sol = solve_ivp(flow, (0.0, time[-1]), [0.0], "Radau", time, rtol=1e-9, atol=1e-14, max_step=5e-3)
    bristles = [p.stiffness * z + p.damping * float(flow(t, z)) for t, z in zip(time, sol.y[0], strict=True)]
    assert np.abs(runs["elasto_plastic"].core_force - bristles).max() < 2e-3
    # Of 1 - (1 - x/s)^2 each element yields at its own share of s, all of one stiffness.
    yields, force = 1e-5 * (np.arange(400) + 0.5) / 400, np.zeros(time.size)
    stretch, stiffness = np.zeros(400), 2.0 / 1e-5 / 400
    for n, step in enumerate(np.diff(x), 1):
        stretch = np.clip(stretch + step, -yields, yields)
        force[n] = stiffness * stretch.sum()
    assert np.abs(runs["maxwell_slip"].core_force - force).max() < 5e-3


def test_coulomb_holds_its_last_force_in_a_dwell():
    time = np.linspace(0.0, 3.0, 3001)
    x = np.clip(time, None, 1.0) * 1e-3
    noisy = x + 3e-10 * np.random.default_rng(3).standard_normal(3001)
    core, p = find("coulomb").friction_state, values("coulomb")
    force = core.along_record(noisy, np.gradient(x, time), time, np.ones(3001), p)
    assert force[1100:].min() > 0.7 and force[:1000].min() > 0.99
    # Under a drive below the level the mass stays, and friction balances the drive.
    run = simulate(compose(["coulomb"]), drive.force([0.0, 1.0, 2.0], [0.0, 0.8, 0.8]), np.linspace(0.0, 2.0, 21))
    assert abs(run.position[-1]) < 2e-8 and run.friction[-1] == pytest.approx(0.8, rel=1e-6)


@pytest.mark.parametrize("name", BRISTLES)
def test_the_operator_along_a_record_agrees_with_the_integrated_core(name):
    time, _, _ = sine(20_001)
    core, p = find(name).friction_state, values(name)
    motion = drive.sinusoidal_velocity(1e-3, 5.0, 0.0)
    run = simulate(compose([name]), motion, time, tolerance=1e-10)
    found = core.along_record(run.position, run.velocity, time, run.level, p)
    # After the first reversal, which wipes out what each assumes of the time before the record.
    # Maxwell-slip is rounded where it is integrated.
    yields = 2e-3 if find(name).friction_state.springs is None else 2e-2
    assert np.abs(found - run.core_force)[time > 1.0].max() < yields
