"""Limits and steady states of every law of the library, variants included, from the equations on its page."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from sim import compose, simulate
from sim.effects.catalogue import find, library
from sim.effects.effect import Axis, Effect
from sim.integration import drive
from sim.integration.compiled import kernels

EVERY = [law for effect in library().values() for law in (effect, *effect.variants)]
POINT = Axis(**{**dict.fromkeys(Axis._fields, 0.0), "load": 1.0, "temperature": 20.0, "direction": 1.0})
STANDING = [law for law in EVERY if law.signal is not None and law.acts_on in ("drive", "sensor", "structure")]


def at(name: str, law: str, p: Any = None, **where: Any) -> Any:
    """A law of an effect where the axis is, else at rest and new, at 20 degC under 1 N."""
    effect = find(name)
    return getattr(effect, law)(POINT._replace(**where), effect.values() if p is None else p)


def stribeck(name: str) -> None:
    p = find(name).values()
    curve = at(name, "level", velocity=p.velocity * np.geomspace(1e-3, 1e4, 200))
    assert at(name, "level") == p.force and curve[-1] < 1e-7 * p.force and np.all(np.diff(curve) <= 0.0)
    # At the Stribeck velocity what is left: 1/e of the Gaussian, half of the rational curve.
    left = 0.5 if name.endswith("rational") else math.exp(-1.0)
    assert at(name, "level", velocity=-p.velocity) == pytest.approx(left * p.force, rel=1e-12)


def run_in(name: str) -> None:
    p = find(name).values()
    new = 1.0 + p.excess + (p.late_excess if name.endswith("two_stages") else 0.0)
    assert at(name, "factor") == pytest.approx(new, rel=1e-14)
    assert at(name, "factor", travelled=1e3 * p.distance) == pytest.approx(1.0, abs=1e-14)
    assert np.all(np.diff(at(name, "factor", travelled=p.distance * np.linspace(0.0, 30.0, 99))) < 0.0)


def dwell(name: str) -> None:
    p = find(name).values()
    assert at(name, "level") == 0.0
    grown = at(name, "level", contact_age=np.geomspace(1e-3, 1e6, 200))
    assert np.all(np.diff(grown) >= 0.0)
    if name.endswith("kato"):
        assert grown[-1] == pytest.approx(p.force, rel=1e-12)
        assert at(name, "level", contact_age=1.0) == pytest.approx(p.force * (1.0 - math.exp(-1.66)), rel=1e-7)
    else:
        late = at(name, "level", contact_age=1e4 * p.cut_off * np.array([1.0, math.e]))
        assert np.diff(late)[0] == pytest.approx(p.force, rel=1e-3)


def load(name: str) -> None:
    assert (at(name, "factor", load=1.0), at(name, "factor", load=0.0)) == (1.0, 0.0)
    assert at(name, "factor", load=8.0) == pytest.approx(4.0 if name.endswith("power") else 8.0, rel=1e-12)


def temperature(name: str) -> None:
    assert at(name, "factor", temperature=20.0) == 1.0
    one, two = at(name, "factor", temperature=np.array([30.0, 40.0]))
    exponential = name.endswith(("exponential", "lubricated"))
    assert two == pytest.approx(one * one if exponential else 2.0 * one - 1.0, rel=1e-12)
    assert one == pytest.approx(math.exp(-0.1) if exponential else 0.9, rel=1e-12)
    if name.endswith("lubricated"):
        p = find(name).values()
        # Where it is cold as the reference no drag is gone, in great heat all of it.
        gone = at(name, "force", velocity=0.3, temperature=np.array([20.0, 20.0 - 50.0 / p.drag_coefficient]))
        assert gone == pytest.approx([0.0, -0.3 * p.drag], rel=1e-12)


def place(name: str) -> None:
    p = find(name).values()
    if name.endswith("gradient"):
        assert at(name, "factor", position=np.array([0.0, 0.1])) == pytest.approx([1.0, 1.0 + 0.1 * p.gradient])
        return
    x = p.pitch * (np.arange(64) + 0.5) / 64
    wave = at(name, "factor", position=x)
    assert wave.mean() == pytest.approx(1.0, rel=1e-12) and np.ptp(wave) == pytest.approx(2.0 * p.amplitude, rel=3e-3)
    assert at(name, "factor", position=x + 3.0 * p.pitch) == pytest.approx(wave, rel=1e-9)


def cogging(name: str) -> None:
    p = find(name).values()
    wave = at(name, "force", position=p.pitch * (np.arange(64) + 0.5) / 64)
    assert wave.sum() == pytest.approx(0.0, abs=1e-12) and np.ptp(wave) == pytest.approx(2.0 * p.amplitude, rel=3e-3)


def asymmetry(name: str) -> None:
    p = find(name).values(coulomb=0.2, viscous=0.3)
    ahead, back = (at(name, "factor", p, velocity=v, direction=v) for v in (1.0, -1.0))
    assert (ahead, back) == (pytest.approx(1.2), pytest.approx(0.8))
    # The slope of the drag differs by direction: a force that is even in the velocity.
    ahead, back = (at(name, "force", p, velocity=v, direction=math.copysign(1.0, v)) for v in (2.0, -2.0))
    assert (ahead, back) == (pytest.approx(0.6), pytest.approx(0.6))


def proportional(name: str, of: str, key: str, power: int) -> None:
    p = find(name).values(**{key: 0.7})
    assert at(name, "force", p) == 0.0
    assert at(name, "force", p, **{of: 3.0}) == pytest.approx(0.7 * 3.0**power, rel=1e-12)
    assert at(name, "force", p, **{of: -3.0}) == pytest.approx(-0.7 * 3.0**power, rel=1e-12)


def bias(name: str) -> None:
    p = find(name).values(force=0.3)
    where = at(name, "force", p, velocity=np.array([-1.0, 0.0, 1.0]), position=np.array([5.0, 0.0, -5.0]))
    assert np.all(where == 0.3)


def pendulum(name: str) -> None:
    p = find(name).values(amplitude=2.0)
    assert at(name, "force", p) == 0.0 and at(name, "force", p, position=math.pi / 2) == pytest.approx(2.0)
    assert at(name, "force", p, position=math.pi) == pytest.approx(0.0, abs=1e-12)


LIMITS: dict[str, Callable[[str], None]] = {
    "stribeck": stribeck, "run_in": run_in, "dwell_strengthening": dwell, "load_dependent_friction": load,
    "temperature_dependent_friction": temperature, "position_dependent_friction": place, "magnetic_cogging": cogging,
    "direction_asymmetry": asymmetry, "viscous": lambda name: proportional(name, "velocity", "coefficient", 1),
    "quadratic_drag": lambda name: proportional(name, "velocity", "coefficient", 2),
    "cable_spring": lambda name: proportional(name, "position", "stiffness", 1), "constant_bias": bias,
    "gravity_torque": pendulum,
}  # fmt: skip
SIMULATED = [law for law in EVERY if kernels.unsupported(law) is None and law.parallel_element is None]
AT_ONE_INSTANT = [law for law in SIMULATED if law.friction_state is None and (law.level or law.factor or law.force)]


@pytest.mark.parametrize("law", AT_ONE_INSTANT, ids=lambda law: law.name)
def test_a_law_has_the_limits_and_the_steady_sliding_of_its_equation(law: Effect):
    LIMITS[law.name.partition(":")[0]](law.name)
    # Simulated from rest at one speed; contacts are then as old as it takes to slide their memory length.
    speed, duration = 2e-3, 5.0
    zero = {q.name: 0.1 for q in law.parameters if q.default == 0.0 and q.role in ("amplitude", "level") and q.high > 0}
    p = law.values(**zero)
    model = compose(["coulomb", law.name], {f"{law.name}.{name}": value for name, value in p._asdict().items()})
    motion = drive.sinusoidal_velocity(0.0, 0.0, speed)
    run = simulate(model, motion, np.array([0.0, duration]), load=1.3, temperature=24.0, tolerance=1e-10)
    gone = speed * duration
    age = p.memory_length / speed if "memory_length" in p._fields else 0.0
    end = Axis(duration, gone, speed, 0.0, 1.3, 24.0, age, gone, gone, 1.0)
    level = 1.0 + (law.level(end, p) if law.level else 0.0)
    expected = level * (law.factor(end, p) if law.factor else 1.0) + (law.force(end, p) if law.force else 0.0)
    # The bristle of Coulomb's core stretches by 10 nm, and follows a level that changes along the way that much later.
    assert run.friction[-1] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("law", STANDING, ids=lambda law: law.name)
def test_a_signal_that_stands_comes_out_as_it_stands(law: Effect):
    """From the first row on: what a record shows first has stood there before. And in the end, after a step."""
    if law.name in ("sensor_drift", "sensor_drift:power"):
        assert law.signal(np.full(50, 0.4), 1e-3, law.values(amplitude=0.2))[0] == pytest.approx(0.4, abs=1e-9)
        return
    p = law.values(**({"step": 0.1} if law.name == "sensor_quantisation" else {}))
    standing = np.asarray(law.signal(np.full(200, 0.4), 1e-3, p))
    assert np.allclose(standing, standing[0], atol=1e-12)
    assert law.name == "sensor_nonlinearity" or np.allclose(standing, 0.4, atol=1e-9)
    step = np.where(np.arange(20_000) < 10, 0.0, 0.4)
    assert law.signal(step, 1e-2, p)[-1] == pytest.approx(standing[-1], abs=1e-6)


def test_a_load_below_break_away_does_not_creep():
    """1.6 +- 0.8 N against Coulomb friction of 3.2 N for a minute: the bristle of 10 nm moves elastically, and
    no further than at the start (it crept by 135 nm in 55 s)."""
    time = np.linspace(0.0, 60.0, 6001)
    load = np.minimum(1.6 * time, 1.6) + 0.8 * np.sin(2.0 * np.pi * time) * (time > 1.0)
    run = simulate(compose(["coulomb"], {"coulomb.force": 3.2}), drive.force(time, load), time, mass=2.0)
    late = run.position[time > 2.0]
    assert late.min() > 0.0 and late.max() < 1e-8 and np.ptp(late) == pytest.approx(1.6 / 3.2 * 1e-8, rel=1e-3)
    assert np.max(run.position[time > 59.0]) == pytest.approx(np.max(late[: late.size // 2]), abs=1e-13)
