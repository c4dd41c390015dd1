"""Physical ranges: slips of unit or decimals are refused with the reason, and the packaged design is well inside."""

import math
import re

import pytest

from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.parameters.machine import packaged_machine

EMPTY_UNITS = {"deg", "rad", "degC", "1/K"}
"""Units whose keys have bounds of their own, or none."""


@pytest.mark.parametrize(
    ("override", "said"),
    [
        (
            "stage.thickness=900 mm",
            "stage.thickness: '900 mm' must lie between 1 and 100 mm: the piezos carry the plate",
        ),
        ("threads.m3_tap_drill=250 mm", "must lie between 2.3 and 3 mm: a tap drill lies between"),
        ("threads.m3_tap_drill=5.9 mm", "must lie between 2.3 and 3 mm"),
        ("base.height=9 m", "must lie between 20 and 500 mm: the machine stands on a table"),
        ("tip.nose_radius=2 m", "must lie between 0.5 and 200 mm: a flatter nose touches with its rim"),
        ("pads.length=2.4e301 mm", "must lie between"),
        ("tip.nose_radius=2e301 mm", "must lie between"),
        ("holder.lift_radius=2.7e301 mm", "must lie between"),
        ("screws.way.head_height=952.5 mm", "must lie between 0.5 and 50 mm"),
        ("materials.invar_36.density=8100000 kg/m^3", "must lie between 1 and 23000 kg/m^3: osmium has 22 590"),
        ("materials.invar_36.youngs_modulus=141e12 Pa", "diamond has 1.2 TPa"),
        ("piezo.highest_voltage=150 kV", "no piezo bears it"),
        ("base.length=0.001 mm", "must lie between 0.05 and 1500 mm"),
    ],
)
def test_a_value_beyond_its_range_is_refused_with_the_reason(override: str, said: str) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        load_design(None, [override])


@pytest.mark.parametrize(
    "override",
    [
        "magnet.thickness=0.5 mm",
        "magnet.length=0.4 mm",
        "magnet.height=0.05 mm",
        "magnet.height=0.55 mm",
        "tooth_iron.edge_chamfer=4 mm",
        "tooth_iron.edge_chamfer=24.98 mm",
        "tooth_iron.corner_radius=60 mm",
        "tip.hub_diameter=120 mm",
        "tip.hub_diameter=220 mm",
        "height_pin_2.crown_radius=6 mm",
        "height_pin_1.end_chamfer=5 mm",
        "sea.groove_depth=30 mm",
        "holder.edge_chamfer=30 mm",
        "holder.index_depth=60 mm",
    ],
)
def test_edges_that_consume_their_faces_violate_a_rule(override: str) -> None:
    with pytest.raises(InputError, match=override.partition("=")[0]):
        load_design(None, [override])


def test_the_packaged_design_is_well_inside_every_range(design: Design) -> None:
    keys = packaged_machine().schema(tuple(sorted(design.materials)))
    for entry in design.entries:
        declared = keys[entry.key]
        if declared.kind == "number" and declared.why and "thread" not in declared.why and "pitch" not in entry.key:
            assert entry.value <= declared.high / 1.6, entry.key
            assert entry.value == 0.0 or declared.low <= 0.0 or entry.value > 1.04 * declared.low, entry.key


def test_every_number_has_a_range(design: Design) -> None:
    keys = packaged_machine().schema(tuple(sorted(design.materials)))
    for key, declared in keys.items():
        if declared.kind == "number" and declared.unit not in EMPTY_UNITS:
            assert math.isfinite(declared.high), key
