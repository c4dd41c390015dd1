"""The page of convergence: what is used differs from the finest row by less than the digits that the program prints."""

import re
from pathlib import Path

import pytest

from designcalc.bearing.plate import SupportedPlate
from designcalc.checks.check import DesignInputs
from designcalc.friction_stage.physics.stage_plate import stage_plate
from stagecad.parameters.load import load_design

PAGE = Path(__file__).parents[2] / "docs" / "convergence.md"
LIMITS = {"elements": 1e-3, "modes": 3e-2, "step (us)": 1e-3, "tolerance": 1e-6}
"""Largest difference of the rows in use: speeds are printed with three digits, peaks of impacts with two."""


@pytest.mark.parametrize("heading", LIMITS)
def test_the_rows_in_use_have_converged(heading: str) -> None:
    rows = PAGE.read_text(encoding="utf-8").split(f"| {heading} |")[1].split("\n\n")[0]
    used = re.findall(r"^\| \*\*.*\| ([\d.e+-]+) \|$", rows, re.MULTILINE)
    assert len(used) == 1 and float(used[0]) < LIMITS[heading]


def test_the_page_has_the_modes_of_the_plate() -> None:
    """Of an estimated mass of the stage, three percent below that of the solids: within one percent of the page."""
    text = PAGE.read_text(encoding="utf-8")
    printed = re.search(r"\*\*20\*\* \| ([\d.]+) \| ([\d.]+)", text)
    assert printed is not None
    supported = stage_plate(DesignInputs(load_design()))
    fine = SupportedPlate(supported.plate, supported._springs, (), supported.bodies, 30).modes(3).frequency
    assert fine[0] == pytest.approx(float(printed[1]), rel=0.02)
    assert supported.modes(3).frequency == pytest.approx(fine, rel=1e-3)
