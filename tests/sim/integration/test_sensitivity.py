"""Derivatives of laws and of whole motions by their parameters, against differences."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim import compose, simulate
from sim.integration import drive, kernels
from sim.integration.sensitivity import sensitivity
from sim.library.catalogue import library
from sim.library.effect import Axis, Effect, Parameter
from sim.numerics.derivative import NotDifferentiableError, derivative_text
from stagecad.parameters.errors import InputError

LAWS = [
    (effect, law, getattr(effect, law))
    for base in library().values()
    for effect in (base, *base.variants)
    for law in ("level", "factor", "force")
    if getattr(effect, law) is not None
    and not (law == "force" and effect.element is not None)
    # A law that needs a whole record is not simulated, and has no derivative in a simulation.
    and (kernels.unsupported(effect) is None or effect.acts_on == "piezo")
]
ELEMENTS = [effect for effect in library().values() if effect.core is not None or effect.element is not None]
TIME = np.linspace(0.0, 1.5, 76)
PULL = drive.pulled_spring([0.0, 0.8, 1.5], [0.0, 0.08, 0.03], 40.0)


def derivative(law, name):
    """The derivative of `law` by parameter `name`, run from its text."""
    text = derivative_text(law, ("p", name), "slope")
    names = dict(law.__globals__, np=np, math=math)
    if text is not None:
        exec(text, names)
    return names["slope"] if text is not None else None


def awake(effect):
    """Values at which nothing is absent: amplitudes that are zero by default are set to something."""
    return effect.values(**{p.name: min(max(0.7, p.low), p.high) for p in effect.parameters if p.default == 0.0})


def difference(function, at):
    step = 1e-4 * max(abs(at), 1e-9)
    coarse = (function(at + step) - function(at - step)) / (2.0 * step)
    fine = (function(at + step / 2.0) - function(at - step / 2.0)) / step
    return (4.0 * fine - coarse) / 3.0


@pytest.mark.parametrize(("effect", "name", "law"), LAWS, ids=lambda x: getattr(x, "name", x) if x else x)
def test_derivatives_of_a_law_are_those_that_differences_give(effect, name, law):
    p = awake(effect)
    random = np.random.default_rng(2)
    for parameter in effect.parameters:
        slope = derivative(law, parameter.name)
        for _ in range(5):
            axis = Axis(*(random.uniform(0.2, 1.0, 10) * 2e-3))
            at = getattr(p, parameter.name)
            expected = difference(lambda x, q=parameter.name, a=axis: law(a, p._replace(**{q: x})), at)
            found = slope(axis, p) if slope is not None else 0.0
            size = abs(law(axis, p)) / max(abs(at), 1e-9)
            assert found == pytest.approx(expected, rel=1e-6, abs=1e-9 * size)


@pytest.mark.parametrize("effect", ELEMENTS, ids=lambda effect: effect.name)
def test_derivatives_of_an_element_are_those_that_differences_give(effect):
    declared, p = effect.core or effect.element, awake(effect)
    random = np.random.default_rng(3)
    for parameter in effect.parameters:
        slope = derivative(declared.law, parameter.name)
        for _ in range(5):
            z, v = declared.scale(p) * random.uniform(-0.8, 0.8), 1e-3 * random.uniform(-1.0, 1.0)
            direction, at = math.copysign(1.0, v), getattr(p, parameter.name)
            found = slope(0, z, v, direction, 1.3, p) if slope is not None else (0.0, 0.0)
            for i in range(2):

                def value(x, i=i, q=parameter.name, z=z, v=v, direction=direction):
                    return declared.law(0, z, v, direction, 1.3, p._replace(**{q: x}))[i]

                size = abs(value(at)) / max(abs(at), 1e-9)
                assert found[i] == pytest.approx(difference(value, at), rel=1e-5, abs=1e-8 * size)


def test_what_cannot_be_differentiated_says_so():
    def loop(axis, p):
        total = 0.0
        for k in range(3):
            total += p.size * k
        return total

    def handed_on(axis, p):
        return loop(axis, p)

    for law in (loop, handed_on):
        with pytest.raises(NotDifferentiableError):
            derivative_text(law, ("p", "size"), "slope")


def column(names, values, name, share=1e-5):
    """Derivatives of position and velocity by one parameter, by central differences of tight simulations."""
    sides = []
    base = {"mass": 1.3, "pull_stiffness": 40.0}.get(name)
    if base is None:
        base = compose(names, values).parameters()[name]
    for factor in (1.0 + share, 1.0 - share):
        moved = dict(values)
        if name not in ("mass", "pull_stiffness"):
            moved[name] = base * factor
        mass = 1.3 * factor if name == "mass" else 1.3
        k = 40.0 * factor if name == "pull_stiffness" else 40.0
        pull = drive.pulled_spring([0.0, 0.8, 1.5], [0.0, 0.08, 0.03], k)
        run = simulate(
            compose(names, moved), pull, TIME, mass=mass, load=1.4, temperature=21.0, tolerance=1e-12, forces=False
        )
        sides.append(np.array([run.position, run.velocity]))
    return (sides[0] - sides[1]) / (2.0 * share * base)


@pytest.mark.parametrize(
    ("names", "values"),
    [
        (["lugre", "stribeck", "viscous"], {}),
        pytest.param(
            ["lugre_causal", "dwell_strengthening", "viscous"],
            {"dwell_strengthening.memory_length": 1e-4},
            marks=pytest.mark.slow,
        ),
        pytest.param(
            ["lugre_causal", "stribeck", "position_dependent_friction", "run_in", "direction_asymmetry"],
            {"direction_asymmetry.viscous": 0.1, "run_in.distance": 0.05},
            marks=pytest.mark.slow,
        ),
        (["coulomb", "viscous", "quadratic_drag", "cable_spring", "load_dependent_friction"], {}),
    ],
    ids=["bristles", "ageing", "factors", "forces"],
)
def test_a_motion_s_derivatives_are_those_that_differences_give(names, values):
    model = compose(names, values)
    wanted = [
        f"{effect.name}.{p.name}"
        for effect in model.effects
        for p in effect.parameters
        if p.role != "reference" and model.parameters()[f"{effect.name}.{p.name}"] != 0.0
    ]
    wanted += ["mass", "pull_stiffness"]
    run = sensitivity(model, PULL, TIME, wanted, mass=1.3, load=1.4, temperature=21.0, tolerance=1e-10)
    plain = simulate(model, PULL, TIME, mass=1.3, load=1.4, temperature=21.0, tolerance=1e-10, forces=False)
    assert np.allclose(run.position, plain.position, atol=1e-12)
    for j, name in enumerate(wanted):
        for found, expected in zip((run.position_by, run.velocity_by), column(names, values, name)):
            assert np.abs(found[:, j] - expected).max() < 1e-3 * np.abs(expected).max() + 1e-12, name


def test_a_user_s_own_law_has_its_derivative_too():
    def force(axis, p):
        return p.strength * axis.position**3

    own = Effect("cubic", "", force=force, parameters=(Parameter("strength", "N/m^3", 50.0, 0.0, 1e9, "", ""),))
    model = compose(["lugre", "viscous", own])
    run = sensitivity(model, PULL, TIME, ["cubic.strength"], tolerance=1e-9)
    sides = [
        simulate(compose(["lugre", "viscous", own], {"cubic.strength": s}), PULL, TIME, tolerance=1e-11).position
        for s in (50.01, 49.99)
    ]
    expected = (sides[0] - sides[1]) / 0.02
    assert np.abs(run.position_by[:, 0] - expected).max() < 1e-3 * np.abs(expected).max()


def test_what_has_no_derivative_here_says_so():
    with pytest.raises(InputError, match=r"no parameter 'stribeck.velocty'; did you mean 'stribeck.velocity'"):
        sensitivity(compose(["lugre", "stribeck"]), PULL, TIME, ["stribeck.velocty"])
    with pytest.raises(InputError, match="'backlash' acts through the history of the motion"):
        sensitivity(compose(["lugre", "backlash"]), PULL, TIME, ["backlash.gap"])
