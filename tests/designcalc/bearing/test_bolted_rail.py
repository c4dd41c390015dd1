"""The bolted rail against every number the thesis's spreadsheet prints."""

import math
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest

from designcalc.bearing.bolted_rail import (
    Rail,
    bending_shear_compliance,
    best_spacing_ratio,
    joint_stiffness,
    total_stiffness,
)
from stagecad.parameters.errors import InputError
from tests.reference.tables import reference

REFERENCE = reference("bolted_rail")
RAIL = Rail(**REFERENCE["rail"])


@pytest.mark.parametrize("row", REFERENCE["stiffness"]["rows"])
def test_stiffness_table_to_the_printed_digit(row):
    spacing, *printed = row
    values = total_stiffness(RAIL, spacing, REFERENCE["joint"]["flange_ratio"]) / 1e6
    assert [round(float(v)) for v in values] == printed


@pytest.mark.parametrize("name", ["flange_compression", "flange_shear", "thread_shear", "bolt"])
def test_joint_springs_to_the_printed_digit(name):
    joint = REFERENCE["joint"]
    values = getattr(joint_stiffness(RAIL, joint["flange_ratio"]), name) / RAIL.rail_modulus
    assert [round(float(v), 3) for v in values] == joint[name]


def test_joint_sums_to_the_printed_digit():
    joint = REFERENCE["joint"]
    springs = joint_stiffness(RAIL, joint["flange_ratio"])
    assert [float(f"{v:.2e}") for v in springs.joint_per_diameter] == joint["joint_per_diameter"]
    # The column 'Total' has the shear of the bed, equal to that of the thread, as a fifth spring.
    total = 1 / (1 / springs.joint_per_diameter + 1 / springs.thread_shear) / RAIL.rail_modulus
    assert [round(float(v), 3) for v in total] == joint["total"]
    assert [float(Decimal(float(2 * v)).quantize(Decimal("0.001"))) for v in total] == joint["total_twice"]


def test_constants_of_the_sheet():
    joint = REFERENCE["joint"]
    stiff = RAIL.joint_ratio * RAIL.bolt_diameter * float(joint_stiffness(RAIL, 2.0).joint_per_diameter)
    assert float(f"{stiff:.3e}") == joint["joint_2db"]
    assert float(f"{1 / bending_shear_compliance(RAIL):.2e}") == joint["A_term"]
    assert round((RAIL.overhang_a / (RAIL.overhang_a + RAIL.overhang_b)) ** 2, 3) == joint["lever"]


def test_stiffness_over_spacing_ratio_does_not_depend_on_the_diameter():
    thick = replace(RAIL, bolt_diameter=0.02)
    M = np.linspace(1.5, 10, 20)
    np.testing.assert_allclose(total_stiffness(thick, M, 1.5), total_stiffness(RAIL, M, 1.5), rtol=1e-12)


def test_best_spacing_is_where_its_closed_form_puts_it():
    mixed = replace(RAIL, rail_modulus=410e9, bed_modulus=145e9, poisson=0.2)
    for rail in (RAIL, mixed):
        bolt = float(joint_stiffness(rail, 1.5).joint_per_diameter)
        lever = (rail.overhang_a / (rail.overhang_a + rail.overhang_b)) ** 2
        expected = 1 + math.sqrt(bending_shear_compliance(rail) * lever * (1 + rail.joint_ratio) * bolt)
        assert best_spacing_ratio(rail, 1.5) == pytest.approx(expected, rel=1e-4)


def test_each_spring_takes_the_modulus_of_its_own_material():
    base = joint_stiffness(RAIL, 1.5)
    for key, moved in {
        "rail_modulus": ("flange_compression", "flange_shear"),
        "bed_modulus": ("thread_shear",),
        "bolt_modulus": ("bolt",),
    }.items():
        changed = joint_stiffness(replace(RAIL, **{key: 4.14e11}), 1.5)
        for name in ("flange_compression", "flange_shear", "thread_shear", "bolt"):
            factor = 2.0 if name in moved else 1.0
            assert float(getattr(changed, name) / getattr(base, name)) == pytest.approx(factor)


def test_outside_the_range_is_said():
    with pytest.raises(InputError, match="spacing-ratio: must be above 1"):
        total_stiffness(RAIL, 1.0, 1.5)
    with pytest.raises(InputError, match="flange-ratio: must be above 0"):
        joint_stiffness(RAIL, 0.0)
    with pytest.raises(InputError, match="overhang-a"):
        replace(RAIL, overhang_a=0.0)
