"""Results of the calculators and of simple motions against numbers of separate programs, and closed forms by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from designcalc.checks.chain import Chain, Link
from designcalc.checks.check import DesignInputs
from designcalc.contact.hertz import (
    contact_modulus,
    line_contact,
    line_shear_peak,
    peak_mises,
    point_contact,
    point_shear_peak,
)
from designcalc.drive.height_adjustment import wedge_drive
from designcalc.drive.piezo_stack import stack_current, stack_heat
from designcalc.drive.tip_ellipse import tip_ellipse
from designcalc.errors.sensors import air_index_error
from designcalc.friction_stage.physics.pads import pads_stiffness
from sim.effects.catalogue import compose
from sim.effects.effect import Axis
from sim.experiments.friction_models import Friction
from sim.integration import drive
from sim.integration.simulate import simulate
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties

STEEL = float(contact_modulus(206e9, 0.3, 206e9, 0.3))


def test_line_contact_of_a_separate_solver() -> None:
    """10 N/mm on a cylinder of 20 mm, steel."""
    contact = line_contact(100.0, 0.01, 0.02, np.inf, STEEL)
    shear = line_shear_peak(contact)
    assert float(contact.half_width) == pytest.approx(47.432e-6, rel=1e-4)
    assert float(contact.peak_pressure) == pytest.approx(134.22e6, rel=1e-4)
    assert (float(shear.shear), float(shear.depth)) == (pytest.approx(40.30e6, rel=2e-4), pytest.approx(37.29e-6, 2e-4))


def test_elliptic_contact_of_a_separate_solver() -> None:
    """50 N on radii of 10 and 30 mm: semi-axes, pressure and approach have one modulus in common."""
    radii = 0.01, np.inf
    here = point_contact(50.0, *radii, STEEL, 0.03, np.inf)
    modulus = STEEL * (float(here.approach) / 1.8203e-6) ** 1.5
    contact = point_contact(50.0, *radii, modulus, 0.03, np.inf)
    assert float(contact.semi_axis_major) == pytest.approx(253.56e-6, rel=2e-4)
    assert float(contact.semi_axis_minor) == pytest.approx(122.37e-6, rel=2e-4)
    assert float(contact.peak_pressure) == pytest.approx(769.39e6, rel=2e-4)


def test_first_yield_below_a_round_contact_of_aluminium() -> None:
    assert float(peak_mises(1.0, 0.33)) == pytest.approx(0.60634, rel=1e-4)
    contact = point_contact(108.9, 0.02, np.inf, STEEL)
    assert float(point_shear_peak(contact, 0.33).depth) == pytest.approx(
        0.491 * float(contact.semi_axis_major), rel=0.01
    )


def test_stiffness_of_three_crowned_pads_by_an_axisymmetric_solver() -> None:
    body = MassProperties(7.1e-4, 2.08176, (0, 0, 0.0331), np.diag([0.0125, 0.0091, 0.021]), np.zeros((2, 3)))
    tip = MassProperties(8.5e-6, 0.022933, (0, 0, 0.004), np.eye(3) * 4.3e-6, np.zeros((2, 3)))
    r = DesignInputs(load_design(), BodyMasses(body, tip))
    assert pads_stiffness(r).normal == pytest.approx(361.4e6, rel=5e-3)


def test_two_uniform_dimensions_of_a_tenth_of_a_millimetre() -> None:
    """Their sum has a triangular density: 0.2 mm (1 - sqrt(0.0027)); normal ones would give 0.14 mm."""
    chain = Chain("n", tuple(Link(key, 1.0, 0.0, -1e-4, 1e-4) for key in ("a", "b")))
    assert chain.statistical[1] == pytest.approx(2e-4 * (1 - math.sqrt(0.0027)), rel=2e-3)
    assert chain.statistical[1] == pytest.approx(190e-6, rel=0.01)


def test_sizes_that_cancel_have_the_sum_zero() -> None:
    terms = (1, 0.1), (1, 0.2), (-1, 0.3)
    links = tuple(Link(f"key_{size}", factor, size, 0.0, 0.0) for factor, size in terms)
    assert 0.1 + 0.2 - 0.3 != 0.0 and Chain("n", links).nominal == 0.0
    assert Chain("n", links, 1e-12).nominal == pytest.approx(1e-12)


def test_wedge_and_ellipse_of_the_thesis() -> None:
    wedge = wedge_drive(25.4e-3 / 8, 1 / 20, 20e-3)
    assert float(wedge.lift_per_turn) == pytest.approx(158.75e-6, rel=1e-4)
    assert float(wedge.lift_per_degree) == pytest.approx(441e-9, rel=1e-3)
    path = tip_ellipse(10e-6, math.pi / 2, 46e-3, 20e-3)
    assert float(path.normal) / 2 == pytest.approx(7.071e-6, rel=1e-4)
    assert float(path.along) / 2 == pytest.approx(6.149e-6, rel=1e-4)


def test_heat_current_and_slew_rate_of_the_stacks() -> None:
    """With the capacitance at small signals, at 9.567 kHz and 150 V."""
    r = DesignInputs(load_design())
    capacitance, voltage, loss = r("piezo.capacitance"), r("piezo.highest_voltage"), r("piezo.loss_factor")
    assert 2 * float(stack_heat(capacitance, voltage, 9566.7, loss)) == pytest.approx(57.1, rel=3e-3)
    current = float(stack_current(capacitance, voltage, 9566.7))
    assert current == pytest.approx(6.31, rel=1e-3)
    assert current / capacitance == pytest.approx(4.51e6, rel=1e-3)


def _edlen(celsius: float, pascal: float, vapour: float = 0.0) -> float:
    """n - 1 of air by Edlen's equation as Birch and Downs revised it (Metrologia 30 (1993) 155, 31 (1994) 315)."""
    square = (1 / 0.633) ** 2
    standard = (8342.54 + 2406147 / (130 - square) + 15998 / (38.9 - square)) * 1e-8
    dry = pascal * standard / 96095.43 * (1 + 1e-8 * (0.601 - 0.00972 * celsius) * pascal) / (1 + 0.003661 * celsius)
    return dry - vapour * (3.7345 - 0.0401 * square) * 1e-10


def test_slopes_of_the_index_of_the_air_are_edlens() -> None:
    by_temperature = _edlen(20.5, 101325.0) - _edlen(19.5, 101325.0)
    by_pressure = (_edlen(20.0, 101825.0) - _edlen(20.0, 100825.0)) / 1000.0
    assert by_temperature == pytest.approx(-0.930e-6, rel=5e-3)
    assert by_pressure == pytest.approx(0.00268e-6, rel=5e-3)
    assert float(air_index_error(1.0, 1.0, 0.0)) == pytest.approx(-by_temperature, rel=0.01)
    assert float(air_index_error(1.0, 0.0, 1.0)) == pytest.approx(by_pressure, rel=0.01)
    # Humidity, which is left out: 0.085 ppm for 10 % of the vapour that saturates air at 20 degC.
    assert _edlen(20.0, 101325.0, 233.9) - _edlen(20.0, 101325.0) == pytest.approx(-0.085e-6, rel=0.02)


def test_katos_law_at_three_dwell_times() -> None:
    effect = compose(["coulomb", "dwell_strengthening:kato"]).effects[1]
    age = np.array([0.1, 1.0, 10.0])
    axis = Axis(*[0.0 * age] * 6, age, *[0.0 * age] * 2)
    level = 1.0 + effect.level(axis, effect.values(force=0.1, rate=1.66, exponent=0.65, memory_length=1e-4))
    assert level == pytest.approx([1.031039, 1.080986, 1.099940], abs=1e-6)


def test_motions_with_a_result_by_hand() -> None:
    """1 kg at 10 m/s against 1 N; 1 nm pulled through 1 N/um onto bristles of 0.1 N/um; 0.2 m/s at 100 kHz."""
    coast = simulate(compose(["coulomb"]), drive.force([0.0, 11.0], [0.0, 0.0]), np.array([0.0, 11.0]), velocity=10.0)
    assert coast.position[-1] == pytest.approx(50.0, rel=1e-5)
    pull = drive.pulled_spring([0.0, 0.5, 1.5], [0.0, 1e-9, 1e-9], stiffness=1e6)
    model = compose(["lugre", "viscous"], {"viscous.coefficient": 200.0})
    moved = simulate(model, pull, np.array([0.0, 1.5]), mass=1.0, tolerance=1e-10).position[-1]
    assert moved == pytest.approx(1e-9 / 1.1, rel=1e-4)
    rate, zero = 2 * math.pi * 1e5, np.zeros(1)
    wave = drive.Drive(zero, zero, zero, wave=(0.2 * rate, rate, 0.0), prescribes=True)
    time = np.linspace(0.0, 5e-4, 20_001)
    run = simulate(Friction().model("lugre_causal"), wave, time, tolerance=1e-9, most_steps=2_000_000)
    assert np.abs(run.friction).max() < 1.1
    assert np.abs(run.friction[time > 4.9e-4]).max() == pytest.approx(1.064, rel=1e-3)
