"""Contact and dynamics of the tip on its piezos, against numbers worked out separately."""

import dataclasses

import numpy as np
import pytest

from designcalc.checks.check import DesignInputs
from designcalc.checks.run import run_checks
from designcalc.drive.friction_drive import resonance
from designcalc.friction_stage.checks.actuator import SLIP_SHARE
from designcalc.friction_stage.physics import tip_dynamics as tip
from designcalc.friction_stage.physics.loads import load, moved_mass
from designcalc.friction_stage.physics.tip_dynamics import contact_stiffness
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties

BODY = MassProperties(
    7.1e-4,
    2.08176,
    (0, 4.7e-5, 0.033128),
    np.diag([0.0125, 0.0091, 0.021]),
    ((-0.115, -0.135, 0.02), (0.115, 0.135, 0.04)),
)
# 22.93 g, and 4.694e-6 kg m^2 about the plane of the piezos' ends.
TIP = MassProperties(
    8.5e-6,
    0.022933,
    (0, 0, 0.004),
    np.diag([4.694e-6 - 0.022933 * 0.004**2] * 3),
    ((-0.03, -0.02, 0), (0.03, 0.03, 0.02)),
)


def inputs(*overrides: str) -> DesignInputs:
    return DesignInputs(load_design(None, overrides, rules=False), BodyMasses(BODY, TIP))


def test_inertia_is_the_solids_with_the_moving_part_of_the_stacks():
    r = inputs()
    assert tip.inertia_on_piezos(r) == pytest.approx(7.87e-6, rel=2e-3)
    up, rocking = tip.tip_resonances(r)
    assert up == pytest.approx(10.6e3, rel=5e-3)
    assert rocking == pytest.approx(12.7e3, rel=5e-3)
    estimated = tip.inertia_on_piezos(DesignInputs(load_design(None, ("tip.mass_limit=22.933 g",))))
    assert estimated == pytest.approx(7.87e-6, rel=0.05)


def test_the_stacks_sway_in_series_with_rocking_and_contact():
    # With a ballast of 3 N in place of the magnets, as in the separate calculation.
    r = inputs("teeth.fitted=false")
    assert load(r) == pytest.approx(33.2, rel=2e-3)
    assert tip.sway(r) == pytest.approx(0.502e6, rel=2e-3)
    assert tip.sway_resonance(r) == pytest.approx(631, rel=3e-3)
    held = tip.holding_stiffness(r)
    assert held == pytest.approx(0.484e6, rel=5e-3)
    assert 0.06 * load(r) / held == pytest.approx(4.1e-6, rel=0.01)
    first = float(resonance(tip.holding_stiffness(inputs()), moved_mass(inputs())))
    assert first == pytest.approx(63, rel=0.02)
    # One component of 25 um/s at 30 Hz moves the stage by 39 nm against the tip.
    still = 25e-6 / (2 * np.pi * 30) * (30 / first) ** 2 / (1 - (30 / first) ** 2)
    assert still == pytest.approx(39e-9, rel=0.05)


def test_slip_and_noise_of_the_tip():
    """A sinusoidal tip against a stage at 2 X f, summed over its contact; and two noisy amplifiers drawn at random."""
    X, f = 10.45e-6, 5e3
    t = np.linspace(0, 0.5 / f, 20001)
    slip = np.abs(np.pi * X * f * np.sin(2 * np.pi * f * t) - 2 * X * f)
    # Twice the mean force for half of the period, over the travel 2 X of the period.
    assert 2 * np.mean(slip) * 0.5 / f / (2 * X) == pytest.approx(SLIP_SHARE, rel=1e-3)
    volts = np.random.default_rng(3).normal(0.0, 1e-3, (2, 100_000))
    moved = 20 / 46 * (volts[1] - volts[0]) * 17e-6 / 150
    assert tip.tip_noise(inputs()) == pytest.approx(np.std(moved), rel=0.02)


def test_peak_force_covers_the_simulated_one_and_is_near_it():
    """Simulated with 33.2 N of load: 98.6 N at 2 kHz and 100.4 N at 1 kHz with the tip level with the drive surface."""
    peak = tip.peak_tip_force(inputs("teeth.fitted=false"))
    assert 100.4 < peak < 1.25 * 100.4


def test_the_stroke_is_the_piezos_in_every_check():
    checks = run_checks(load_design(None, ()), BodyMasses(BODY, TIP))
    stroke = 17e-6 * np.sqrt(2) / 2
    for name in (
        "tip stroke lost to the contact",
        "thinnest shim against the ellipse",
        "shift of the tip's height by clamping",
    ):
        check = next(c for c in checks if c.name == name)
        assert f"{1e6 * stroke:.4g} um" in check.substituted


def test_tension_is_at_the_frequency_of_heat_and_current():
    found = {c.name: c for c in run_checks(load_design(None, ()), BodyMasses(BODY, TIP), ("piezo actuator",))}
    names = [name for name in found if "full speed" in name or "tension" in name]
    assert len(names) == 3
    assert all("9.567 kHz" in found[name].substituted for name in names)
    # 104.5 N at 5 kHz.
    assert (
        "382.5 N of inertia and 32.23 N of drive"
        in found["tension of a piezo by the tip's inertia and drive force"].note
    )


def test_a_larger_side_force_does_not_turn_the_check_of_the_stack():
    for overrides in (
        (),
        ("preload.force=70.6 N",),
        ("drive.friction=0.6",),
        ("teeth.fitted=false", "preload.force=150 N"),
    ):
        checks = run_checks(dataclasses.replace(inputs(*overrides).design), BodyMasses(BODY, TIP), ("piezo actuator",))
        assert next(c for c in checks if c.name == "side load of the drive on a piezo").verdict == "fails"


def test_for_two_bodies_of_one_material_the_stiffness_ratio_is_mindlins():
    design = load_design(None, ())
    r = DesignInputs(design)
    found = contact_stiffness(r, load(r))
    aluminium = design.materials[design.value("tip.material")]
    # A sphere on a flat: F = (4/3) E* sqrt(R) d^1.5, and the slope of that at the load.
    modulus = aluminium.youngs_modulus / (2.0 * (1.0 - aluminium.poisson_ratio**2))
    assert found.rate == pytest.approx(4 / 3 * modulus * design.si("tip.nose_radius") ** 0.5, rel=1e-6)
    normal = (6.0 * modulus**2 * design.si("tip.nose_radius") * found.load) ** (1.0 / 3.0)
    assert found.normal == pytest.approx(normal, rel=1e-6)
    nu = aluminium.poisson_ratio
    assert found.tangential_ratio == pytest.approx(2.0 * (1.0 - nu) / (2.0 - nu), rel=1e-6)


def test_of_two_materials_each_has_its_own_poisson_ratio():
    """8 a G*: 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, with E and nu of silicon carbide and aluminium."""
    design = load_design(None, ("tip.material=sic",))
    found = contact_stiffness(DesignInputs(design), 10.0)
    (e1, n1), (e2, n2) = ((m.youngs_modulus, m.poisson_ratio) for m in map(design.materials.get, ("sic", "al_6061_t6")))
    shear = 1 / (2 * (1 + n1) * (2 - n1) / e1 + 2 * (1 + n2) * (2 - n2) / e2)
    normal = 1 / ((1 - n1**2) / e1 + (1 - n2**2) / e2)
    assert found.tangential_ratio == pytest.approx(4 * shear / normal, rel=1e-9)
    assert contact_stiffness(DesignInputs(design), 80.0).tangential_ratio == pytest.approx(found.tangential_ratio)
