"""Numbers of the packaged machine that were calculated separately: quadrature, plate and field solvers of their own.

Loads of 33.2 N are those with a dead weight of 3 N in place of the magnets.
"""

import dataclasses
import math
from dataclasses import replace

import numpy as np
import pytest

from designcalc.bearing.bolted_rail import total_stiffness
from designcalc.bearing.plate import StandingBody, SupportedPlate
from designcalc.checks.check import DesignInputs
from designcalc.checks.run import run_checks
from designcalc.friction_stage.calculated.chains import chains
from designcalc.friction_stage.physics import tip_dynamics as tip
from designcalc.friction_stage.physics.loads import load, tip_load
from designcalc.friction_stage.physics.pads import rail
from designcalc.friction_stage.physics.position_loop import dynamic_budget
from designcalc.friction_stage.physics.stage_plate import held_plate, payload_feet, payload_height, stage_plate
from designcalc.friction_stage.physics.tip_dynamics import bent_stack, contact_stiffness, usable_ellipse
from designcalc.friction_stage.quantities import QUANTITIES
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties
from tests.reference.tables import cases

BOX = ((-0.115, -0.135, 0.02), (0.115, 0.135, 0.04))
BODY = MassProperties(7.1e-4, 2.08176, (0, 4.7e-5, 0.033128), np.diag([0.0125, 0.0091, 0.021]), BOX)
# 22.93 g, and 4.694e-6 kg m^2 about the plane of the piezos' ends.
TIP = MassProperties(8.5e-6, 0.022933, (0, 0, 0.004), np.eye(3) * 4.327e-6, ((-0.03, -0.02, 0), (0.03, 0.03, 0.02)))


def inputs(*overrides: str) -> DesignInputs:
    return DesignInputs(load_design(None, overrides, rules=False), BodyMasses(BODY, TIP))


def values(*overrides: str) -> dict[str, float]:
    r = inputs(*overrides)
    return {check.name: check.value for check in run_checks(r.design, r.masses) if check.value is not None}


@pytest.fixture(scope="module")
def packaged():
    return values()


def test_numbers_of_the_checks_and_the_smallest_step_of_the_free_tip(packaged):
    for name, value, error in (
        ("bearing way stiffness", 308.7e6, 1e-3),
        ("slip between way and base", 0.28e-6, 0.01),
        ("heat of the piezos at full speed", 1.7 * 57.0, 0.01),
        ("smoothness against the tip's own pulsation", 20.15, 1e-3),
        ("refractive index of the air over the interferometer's travel", 186e-9 + 54e-9, 0.01),
        ("resonances of the stage on its pads against the drive", 1.116, 0.01),
    ):
        assert packaged[name] == pytest.approx(value, rel=error), name
    # 39 nm of one component at 30 Hz become 811 nm of all third octaves, one of which is the resonance of 63 Hz.
    assert packaged["floor vibration between tip and stage, along"] > 39e-9
    assert packaged["smallest step of the tip"] == pytest.approx(0.2256e-9, rel=1e-3)


def test_materials_have_data_of_their_kind_and_the_bed_its_poisson_ratio():
    """A hard anodic layer and not dense alumina, silicon carbide near 20 degC, PTFE of one grade."""
    r = inputs()
    assert 60e9 <= r("materials.anodic_layer.youngs_modulus") <= 150e9
    assert 2.2e-6 <= r("materials.sic.expansion") <= 2.6e-6
    # Pressure, pressure times speed and wear are all those of unfilled PTFE.
    assert 1e-13 <= r("bearing.wear_rate") <= r("bearing.run_in_wear_rate") <= 1e-12
    assert r("bearing.allowable_pressure") <= 7e6 and r("bearing.allowable_pv") <= 0.07e6
    assert r("piezo.loss_factor") == pytest.approx(0.1207, rel=3e-3)
    # 308.7 N/um where the ratio of the rail alone gives 310.6.
    way = rail(inputs())
    M, tau = 38.1 / 9.525, 14.3 / 9.525
    assert float(total_stiffness(way, M, tau)) == pytest.approx(308.7e6, rel=1e-3)
    assert float(total_stiffness(replace(way, bed_poisson=way.poisson), M, tau)) == pytest.approx(310.6e6, rel=1e-3)


@pytest.mark.parametrize("name, value, error", cases("separate_numbers", "check"))
def test_values_of_the_checks_by_separate_programs(packaged, name, value, error):
    assert packaged[name] == pytest.approx(value, rel=error)


@pytest.mark.parametrize("name, value, error", cases("separate_numbers", "quantity"))
def test_quantities_of_the_machine_by_separate_programs(name, value, error):
    assert QUANTITIES[name][0](inputs()) == pytest.approx(value, rel=error)


def test_a_bent_stack_and_the_held_stage_by_separate_programs():
    """34.232 um under the drive's side load; 63.4 Hz along the tip; the vibration rings down in 0.4086 and 0.421 s at
    the corners over the pads and opposite."""
    r = inputs()
    assert float(bent_stack(r, 24.71).deflection) == pytest.approx(34.232e-6, rel=1e-4)
    along, mass = (QUANTITIES[key][0](r) for key in ("stiffness.along", "load.moved_mass"))
    assert math.sqrt(along / mass) / (2 * math.pi) == pytest.approx(63.4, rel=2e-3)
    held = held_plate(r)
    corners = [replace(held, payload=held.payload[k : k + 1]) for k in (0, 1)]
    times = [one.ring_down(tip_load(r), r("requirements.smoothness")) for one in corners]
    assert times == pytest.approx([0.4086, 0.421], rel=0.035)
    assert times[1] / times[0] == pytest.approx(421 / 408, rel=5e-3)


def test_springs_stroke_and_play_of_the_height_pin_by_hand():
    """G d^4/(8 D^3 n) with six active coils: 5.333 N/mm."""
    r = inputs()
    wire, modulus = r("spring.wire_diameter"), r("materials.steel.youngs_modulus")
    shear = modulus / (2 * (1 + r("materials.steel.poisson_ratio")))
    rate = shear * wire**4 / (8 * (r("spring.outer_diameter") - wire) ** 3 * (r("spring.coils") - 2))
    assert rate == pytest.approx(5.333e3, rel=5e-3) and r("spring.rate") == pytest.approx(rate, rel=0.015)
    low, high = next(one for one in chains(r.design) if one.name == "holder in pocket").statistical
    assert 0.5 * (high - low) == pytest.approx(19.0e-6, rel=5e-3)
    assert usable_ellipse(r) == pytest.approx((10.453e-6, 12.021e-6), rel=1e-4)
    check = next(c for c in run_checks(r.design, r.masses) if c.name == "drift of the tip against the stage")
    assert check.value == pytest.approx((254.8 - 105.6) * 1e-9, rel=1e-3)


def test_feet_with_inertia_of_their_own_have_the_modes_of_a_separate_plate_program():
    """224.2, 330.2 and 767.9 Hz on the pads, 8.023 N/um above the tip: elements of twelve degrees of freedom, a quarter
    of the payload in each foot, turning with the slope there. Without that inertia the free stage has 1180, 1698, 2332
    Hz as its third, fifth and seventh bending modes."""
    r = inputs()
    stage, feet, near = stage_plate(r), payload_feet(r), (-1e-3, 1e-3)
    bodies = [
        StandingBody(tuple((x + dx, y + dy) for dx in near for dy in near), r("payload.mass") / 4, payload_height(r))
        for x, y in feet
    ]
    on_pads = SupportedPlate(stage.plate, stage._springs, (), bodies)
    np.testing.assert_allclose(on_pads.modes(3).frequency, [224.2, 330.2, 767.9], rtol=4e-3)
    assert 1 / float(on_pads.compliance([(0.0, 0.0)])[0, 0]) == pytest.approx(8.023e6, rel=2e-3)
    free = SupportedPlate(stage.plate, (), [(foot, r("payload.mass") / 4) for foot in feet]).modes(10).frequency[3:]
    np.testing.assert_allclose(free[[2, 4, 6]], [1180, 1698, 2332], rtol=2e-3)


@pytest.mark.parametrize("name, limit, error", cases("separate_numbers", "limit"))
def test_limits_of_the_checks_by_separate_programs(name, limit, error):
    r = inputs()
    found = next(c for c in run_checks(r.design, r.masses, ("tip on stage", "bearing ways")) if c.name == name)
    assert found.limit == pytest.approx(limit, rel=error)


@pytest.mark.parametrize("sensor, name, rms, error", cases("separate_numbers", "disturbance"))
def test_disturbances_at_the_payload_by_a_separate_program(sensor, name, rms, error):
    r = inputs()
    budget = dynamic_budget(r, sensor)
    row = next(one for one in budget.rows if one.name == name)
    assert budget.rms(row, 1 / r("loop.observation")) == pytest.approx(rms, rel=error)


def test_stroke_and_peak_force_are_one_in_every_check():
    """Simulated with 33.2 N of load: 98.6 N at 2 kHz and 100.4 N at 1 kHz with the tip level with the drive surface."""
    assert 100.4 < tip.peak_tip_force(inputs("teeth.fitted=false")) < 1.25 * 100.4
    checks = run_checks(load_design(None, ()), BodyMasses(BODY, TIP))
    stroke = 17e-6 * np.sqrt(2) / 2
    for name in (
        "tip stroke lost to the contact",
        "thinnest shim against the ellipse",
        "shift of the tip's height by clamping",
    ):
        assert f"{1e6 * stroke:.4g} um" in next(c for c in checks if c.name == name).substituted


def test_tension_and_side_force_of_the_stack_checks():
    found = {c.name: c for c in run_checks(load_design(None, ()), BodyMasses(BODY, TIP), ("piezo actuator",))}
    names = [name for name in found if "full speed" in name or "tension" in name]
    assert len(names) == 3 and all("9.567 kHz" in found[name].substituted for name in names)
    # 104.5 N at 5 kHz.
    tension = found["tension of a piezo by the tip's inertia and drive force"]
    assert "382.5 N of inertia and 32.23 N of drive" in tension.note
    for overrides in (
        (),
        ("preload.force=70.6 N",),
        ("drive.friction=0.6",),
        ("teeth.fitted=false", "preload.force=150 N"),
    ):
        checks = run_checks(dataclasses.replace(inputs(*overrides).design), BodyMasses(BODY, TIP), ("piezo actuator",))
        assert next(c for c in checks if c.name == "side load of the drive on a piezo").verdict == "fails"


def test_stiffness_ratio_of_one_and_of_two_materials():
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
    # 8 a G*: 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, with E and nu of silicon carbide and aluminium.
    design = load_design(None, ("tip.material=sic",))
    found = contact_stiffness(DesignInputs(design), 10.0)
    (e1, n1), (e2, n2) = ((m.youngs_modulus, m.poisson_ratio) for m in map(design.materials.get, ("sic", "al_6061_t6")))
    shear = 1 / (2 * (1 + n1) * (2 - n1) / e1 + 2 * (1 + n2) * (2 - n2) / e2)
    normal = 1 / ((1 - n1**2) / e1 + (1 - n2**2) / e2)
    assert found.tangential_ratio == pytest.approx(4 * shear / normal, rel=1e-9)
    assert contact_stiffness(DesignInputs(design), 80.0).tangential_ratio == pytest.approx(found.tangential_ratio)
