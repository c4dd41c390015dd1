"""Plate on its pads, and rail bolted to its bed, against closed forms."""

import math
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from benchmarks.generators.planar_stage import free_plate
from designcalc.bearing import bolted_rail
from designcalc.bearing.plate import Plate, StandingBody, SupportedPlate
from tests.reference.tables import reference
from tests.refusals import refused

STAGE = Plate(0.230, 0.270, 0.012, 68.9e9, 0.33, 2700.0)
PADS = [((-0.025, 0.115), 73.98e6), ((0.025, 0.115), 73.98e6), ((0.0, -0.115), 93.40e6)]
"""Of the packaged machine at 33.2 N, 241 N/um together."""


def test_square_strip_and_cantilever_have_their_frequencies_and_deflections():
    """w L^2 sqrt(rho t/D) = 13.470, 19.599, 24.278 for nu = 0.3."""
    square = Plate(0.3, 0.3, 5e-3, 70e9, 0.3, 2700.0)
    unit = 2 * np.pi * 0.3**2 * np.sqrt(square.density * square.thickness / square.rigidity)
    modes = SupportedPlate(square).modes(6).frequency * unit
    np.testing.assert_allclose(modes[3:], [13.470, 19.599, 24.278], rtol=5e-4)
    assert np.all(modes[:3] < 1e-2)
    # The error falls about with the square of the element's size.
    coarse, middle, fine = (SupportedPlate(square, elements=n).modes(4).frequency[3] for n in (6, 12, 24))
    assert 3.0 < (coarse - middle) / (middle - fine) < 4.5
    beam = Plate(0.5, 0.01, 4e-3, 200e9, 0.0, 7850.0)
    inertia, mass = 0.01 * 4e-3**3 / 12, 7850 * 0.01 * 4e-3
    unit = np.sqrt(200e9 * inertia / mass) / (2 * np.pi * 0.5**2)
    plate = SupportedPlate(beam, elements=2)
    bending = plate.modes(6).frequency[3:]
    assert bending[0] / unit == pytest.approx(22.373, rel=2e-3)
    assert bending[1] / unit == pytest.approx(61.673, rel=2e-3)
    # On rigid supports at 0 and d with the overhang c: F c^2 (d + c)/(3 E I) at the end; the end mass lowers f.
    beam = Plate(0.5, 0.02, 4e-3, 200e9, 0.0, 1e-3)
    supports = [((x, y), 1e15) for x in (-0.25, -0.2) for y in (-0.01, 0.01)]
    rigidity = 200e9 * 0.02 * 4e-3**3 / 12
    exact = 0.45**2 * (0.05 + 0.45) / (3 * rigidity)
    plate = SupportedPlate(beam, supports, [((0.25, 0.0), 0.3)], elements=2)
    assert float(plate.compliance([(0.25, 0.0)])[0, 0]) == pytest.approx(exact, rel=2e-3)
    assert float(plate.modes(1).frequency[0]) == pytest.approx(np.sqrt(1 / (0.3 * exact)) / (2 * np.pi), rel=2e-3)
    assert float(plate.sag(9.81, [(0.25, 0.0)])[0]) == pytest.approx(0.3 * 9.81 * exact, rel=2e-3)


def test_modes_and_compliance_agree_and_feet_turn_a_rigid_body():
    """Sum of the modes' compliances, phi^2/w^2, is the static one."""
    plate = SupportedPlate(STAGE, PADS, elements=8)
    places = [(0.0, 0.0), (0.075, 0.1)]
    modes = plate.modes(60, places)
    summed = (modes.shapes / (2 * np.pi * modes.frequency) ** 2) @ modes.shapes.T
    np.testing.assert_allclose(summed, plate.compliance(places), rtol=5e-3, atol=2e-10)
    # Of the free stage with 1 kg, 26 mm high: against Ritz's plate in Legendre polynomials, which lie above the modes,
    # and on elements of half the size. The same inertia on the slopes under the feet had no limit: its third, fifth and
    # seventh modes fell from 1039, 1532, 2287 Hz to 1016, 1441, 1846 Hz.
    density = 2.0817639 / (0.23 * 0.27 * 0.012)
    plate = Plate(0.23, 0.27, 0.012, 68.9e9, 0.33, density)
    body = StandingBody(FEET, 1.0, 0.026)
    ritz = free_plate(0.23, 0.27, 0.012, (68.9e9, 0.33, density), [(FEET, 1.0, 0.026)], order=24).rates[3:10]
    found, fine = (SupportedPlate(plate, (), (), [body], n).modes(10).frequency[3:] for n in (20, 40))
    np.testing.assert_allclose(found, ritz / (2 * np.pi), rtol=4e-3)
    np.testing.assert_allclose(found, fine, rtol=1.5e-3)


def test_what_is_kept_of_an_outline_gives_the_same_modes_and_deflections():
    """Modes from those of the free plate against those of all degrees of freedom; forces on assembled matrices."""
    plate = Plate(0.231, 0.272, 0.011, 68.9e9, 0.33, 2900.0)
    body = StandingBody(tuple((x, y) for x in (-0.04, 0.04) for y in (-0.05, 0.05)), 1.2, 0.04)
    one = SupportedPlate(plate, PADS, [((0.01, 0.0), 0.2)], [body])
    places = [(0.0, 0.0), (0.03, -0.1)]
    found = one.modes(30, places)
    frequency, vectors = one._eigenvectors(30)
    np.testing.assert_allclose(found.frequency, frequency, rtol=1e-9)
    np.testing.assert_allclose(np.abs(found.shapes), np.abs(one._at(places, vectors)), atol=1e-8)
    forces = np.zeros((one._outline.size, 2))
    for number, place in enumerate(places):
        columns, values = one._outline.row(place)
        forces[columns, number] = values
    solved = one._at(places, splu(one._stiffness).solve(forces))
    np.testing.assert_allclose(one.compliance(places), solved, rtol=1e-9)


FEET = tuple((x, y) for x in (-0.05, 0.05) for y in (-0.05, 0.05))


REFERENCE = reference("bolted_rail")
RAIL = bolted_rail.Rail(**REFERENCE["rail"])


@pytest.mark.parametrize("row", REFERENCE["stiffness"]["rows"])
def test_stiffness_table_to_the_printed_digit(row):
    spacing, *printed = row
    values = bolted_rail.total_stiffness(RAIL, spacing, REFERENCE["joint"]["flange_ratio"]) / 1e6
    assert [round(float(v)) for v in values] == printed


@pytest.mark.parametrize("name", ["flange_compression", "flange_shear", "thread_shear", "bolt"])
def test_joint_springs_to_the_printed_digit(name):
    joint = REFERENCE["joint"]
    values = getattr(bolted_rail.joint_stiffness(RAIL, joint["flange_ratio"]), name) / RAIL.rail_modulus
    assert [round(float(v), 3) for v in values] == joint[name]


def test_constants_sums_and_ratios_of_the_sheet():
    joint = REFERENCE["joint"]
    springs = bolted_rail.joint_stiffness(RAIL, joint["flange_ratio"])
    assert [float(f"{v:.2e}") for v in springs.joint_per_diameter] == joint["joint_per_diameter"]
    # The column 'Total' has the shear of the bed, equal to that of the thread, as a fifth spring.
    total = 1 / (1 / springs.joint_per_diameter + 1 / springs.thread_shear) / RAIL.rail_modulus
    assert [round(float(v), 3) for v in total] == joint["total"]
    assert [float(Decimal(float(2 * v)).quantize(Decimal("0.001"))) for v in total] == joint["total_twice"]
    stiff = RAIL.joint_ratio * RAIL.bolt_diameter * float(bolted_rail.joint_stiffness(RAIL, 2.0).joint_per_diameter)
    assert float(f"{stiff:.3e}") == joint["joint_2db"]
    assert float(f"{1 / bolted_rail.bending_shear_compliance(RAIL):.2e}") == joint["A_term"]
    assert round((RAIL.overhang_a / (RAIL.overhang_a + RAIL.overhang_b)) ** 2, 3) == joint["lever"]
    thick, M = replace(RAIL, bolt_diameter=0.02), np.linspace(1.5, 10, 20)
    np.testing.assert_allclose(
        bolted_rail.total_stiffness(thick, M, 1.5), bolted_rail.total_stiffness(RAIL, M, 1.5), rtol=1e-12
    )
    mixed = replace(RAIL, rail_modulus=410e9, bed_modulus=145e9, poisson=0.2)
    for rail in (RAIL, mixed):
        bolt = float(bolted_rail.joint_stiffness(rail, 1.5).joint_per_diameter)
        lever = (rail.overhang_a / (rail.overhang_a + rail.overhang_b)) ** 2
        expected = 1 + math.sqrt(bolted_rail.bending_shear_compliance(rail) * lever * (1 + rail.joint_ratio) * bolt)
        assert bolted_rail.best_spacing_ratio(rail, 1.5) == pytest.approx(expected, rel=1e-4)


def test_a_rail_takes_each_material_s_modulus_and_says_its_range():
    base = bolted_rail.joint_stiffness(RAIL, 1.5)
    for key, moved in {
        "rail_modulus": ("flange_compression", "flange_shear"),
        "bed_modulus": ("thread_shear",),
        "bolt_modulus": ("bolt",),
    }.items():
        changed = bolted_rail.joint_stiffness(replace(RAIL, **{key: 4.14e11}), 1.5)
        for name in ("flange_compression", "flange_shear", "thread_shear", "bolt"):
            factor = 2.0 if name in moved else 1.0
            assert float(getattr(changed, name) / getattr(base, name)) == pytest.approx(factor)
    refused("overhang-a", replace, RAIL, overhang_a=0.0)
