"""The thesis's friction experiments against printed reference numbers and against another integrator."""

import math
from decimal import Decimal

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from sim.experiments.friction_models import MODELS, Friction
from sim.experiments.hysteresis import CASES, hysteresis
from sim.experiments.presliding import presliding
from sim.experiments.stick_slip import stick_slip
from tests.reference.tables import reference

REFERENCE = reference("thesis_friction")
FRICTION = Friction()
A0, A2, FC, FS, VS = (REFERENCE["parameters"][key] for key in ("a0", "a2", "Fc", "Fs", "vs"))
MODEL = {"lugre": 1, "lugre_undamped": 2, "lugre_causal": 3, "lugre_causal_as_run": 3}


def agrees(value: float, reference: dict) -> bool:
    digit = float(Decimal(1).scaleb(Decimal(reference["printed"]).as_tuple().exponent)) * reference["scale"]
    return abs(value - float(reference["printed"]) * reference["scale"]) <= digit


@pytest.mark.parametrize("core", REFERENCE["presliding"])
def test_presliding_agrees_with_the_reference(core):
    result = presliding(FRICTION, core)
    for feature, expected in REFERENCE["presliding"][core].items():
        assert agrees(getattr(result, feature), expected), (feature, getattr(result, feature))


@pytest.mark.parametrize("case", REFERENCE["hysteresis"]["lugre"])
def test_hysteresis_agrees_with_the_reference(case):
    result = hysteresis(FRICTION, "lugre", case)
    for feature, expected in REFERENCE["hysteresis"]["lugre"][case].items():
        assert agrees(getattr(result, feature), expected), (feature, getattr(result, feature))


def test_stick_slip_and_absent_widths_agree_with_the_reference():
    features = stick_slip(FRICTION, "lugre").features()
    for feature, expected in REFERENCE["stick-slip"]["lugre"].items():
        assert agrees(features[feature][0], expected), (feature, features[feature])
    assert hysteresis(FRICTION, "lugre", "w25_v0_0").width_at_1mm_s is None


# The second integrator works on the equations as the thesis prints them, with no code of the effect library.


def thesis_equations(model: int, a1: float):
    @njit
    def friction(v, z):
        g = (FC + (FS - FC) * math.exp(-((v / VS) ** 2))) / A0
        rate = v - abs(v) / g * z
        if model == 3:
            rate = rate / (1.0 + a1 * abs(v) / (A0 * g))
        force = A0 * z + A2 * v
        if model != 2:
            force += a1 * rate
        return force, rate

    return friction


def solve(right, start, times, relative=1e-12, absolute=1e-16, further=()):
    found = solve_ivp(right, (times[0], times[-1]), start, "LSODA", times, rtol=relative, atol=absolute, args=further)
    assert found.success
    return found.y


def damping(core: str) -> float:
    return 0.0 if core == "lugre_causal_as_run" else math.sqrt(A0)


@pytest.mark.parametrize("core", MODELS)
def test_hysteresis_agrees_with_another_integrator(core):
    case, friction = "w25_v0_1.5mm_s", thesis_equations(MODEL[core], damping(core))
    frequency, mean = CASES[case]
    result = hysteresis(FRICTION, core, case)
    run = result.simulation

    @njit
    def right(t, y):
        _, rate = friction(mean + 1e-3 * math.sin(frequency * t), y[0])
        return np.array([rate])

    found = solve(right, np.zeros(1), run.time)
    force = np.array([friction(v, z)[0] for v, z in zip(mean + 1e-3 * np.sin(frequency * run.time), found[0])])
    assert np.abs(force - run.friction).max() < 2e-8
    assert force[run.time >= 2.0 * math.pi / frequency].max() == pytest.approx(result.peak_force, abs=2e-7)


@pytest.mark.parametrize("core", MODELS[:3])
def test_stick_slip_agrees_with_another_integrator(core):
    friction = thesis_equations(MODEL[core], damping(core))
    run = stick_slip(FRICTION, core).simulation

    @njit
    def right(t, y):
        force, rate = friction(y[1], y[2])
        return np.array([y[1], 2.0 * (0.1 * t - y[0]) - force, rate])

    shown = slice(0, 60_001, 20)  # 15 s: the first slip whole, and the second begun
    found = solve(right, np.zeros(3), run.time[shown])
    assert np.abs(found[0] - run.position[shown]).max() < 1e-7 and np.abs(found[1] - run.velocity[shown]).max() < 2e-6


def test_the_undamped_model_rings_at_the_contact_s_frequency():
    for case in CASES:
        as_run = hysteresis(FRICTION, "lugre_causal_as_run", case).simulation.friction
        assert np.abs(as_run - hysteresis(FRICTION, "lugre_undamped", case).simulation.friction).max() < 1e-8
    force, step = landing_of("lugre_undamped")
    assert 0.4 < np.ptp(window(force, step, 0.0, 0.05)[0]) < 0.6
    assert np.ptp(window(force, step, 2.0, 0.1)[0]) == pytest.approx(0.009, abs=0.002)
    for core in ("lugre", "lugre_causal"):
        damped, step = landing_of(core)
        assert np.ptp(window(damped, step, 0.1, 0.1)[0]) < 1e-3
    # Near a preload of r times the level a bristle is softer forward, a0 (1 - r), and stiffer back, a0 (1 + r): one
    # cycle takes half a period of each. Unloaded, that is sqrt(a0/m) = 316 rad/s, the reference's figure.
    free = float(REFERENCE["ringing"]["frequency"]["printed"])
    assert math.sqrt(A0) == pytest.approx(free, abs=0.5)
    force, step = landing_of("lugre_undamped")
    for begin in (0.2, 0.4):  # before the pull's own creep outruns the ringing
        ring, mean = window(force, step, begin, 0.3)
        spectrum = np.abs(np.fft.rfft(ring * np.hanning(ring.size), 16 * ring.size))
        found = 2.0 * math.pi * spectrum.argmax() / (16 * ring.size * step)
        r = mean / FS
        assert found == pytest.approx(2.0 * free / ((1.0 - r) ** -0.5 + (1.0 + r) ** -0.5), rel=0.02)


def landing_of(core: str):
    """Friction force from the first landing on, and the sampling time."""
    result = stick_slip(FRICTION, core)
    run = result.simulation
    slip = np.searchsorted(run.time, result.slips[0])
    landing = slip + int(np.argmax(run.velocity[slip + 4000 :] < 0.0)) + 4000
    return run.friction[landing:], run.time[1]


def window(force: np.ndarray, step: float, begin: float, length: float) -> tuple[np.ndarray, float]:
    """Force from `begin` on, s, less its trend; and its mean."""
    rows = slice(round(begin / step), round((begin + length) / step))
    time = np.arange(rows.stop - rows.start) * step
    return force[rows] - np.polyval(np.polyfit(time, force[rows], 3), time), float(force[rows].mean())
